/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The filter: a Kalman filter on a wire's heat balance with a play behind it, by eight points about its mean. The
 * arithmetic is that of musclewire.sensing._filter_estimator, operation by operation; what each function does is said
 * there. */
#include "mw_branches.h"

#if defined(MW_FILTER)

#define STATES 4
#define TRIANGLE (STATES * (STATES + 1) / 2)
#define POINTS 8
#define AWAY 2 /* deviations of a point from the mean */

/* Steady powers and resistances, heating branch first, a row for each place. */
enum { HEATING_W, COOLING_W, HEATING, COOLING, COLUMNS };
MW_TABLE mw_real table[MW_PLACES][COLUMNS] = MW_PLACE_TABLE;

typedef struct {
    mw_real heating_w, cooling_w, heating_slope_w, cooling_slope_w, heating, cooling;
} branch_edges;

static branch_edges edges_at(mw_real place)
{
    const mw_real at = (place - MW_FIRST_PLACE) * MW_PER_PLACE;
    const uint8_t left = (uint8_t)mw_within(at, 0, MW_PLACES - 2);
    const mw_real part = at - (mw_real)left;
    const MW_FLASH mw_real *row = table[left], *following = table[left + 1];
    const mw_real rise_w = following[HEATING_W] - row[HEATING_W], fall_w = following[COOLING_W] - row[COOLING_W];
    branch_edges edges;
    edges.heating_w = row[HEATING_W] + part * rise_w;
    edges.cooling_w = row[COOLING_W] + part * fall_w;
    edges.heating_slope_w = rise_w * MW_PER_PLACE;
    edges.cooling_slope_w = fall_w * MW_PER_PLACE;
    edges.heating = row[HEATING] + part * (following[HEATING] - row[HEATING]);
    edges.cooling = row[COOLING] + part * (following[COOLING] - row[COOLING]);
    return edges;
}

static mw_real part_between(mw_real steady_w, const branch_edges *edges)
{
    return mw_within((steady_w - edges->cooling_w) / (edges->heating_w - edges->cooling_w), 0, 1);
}

static mw_real sag(mw_real part)
{
    return MW_PHASE_LAG * MW_PHASE_RESISTANCE * part * (1 - part);
}

static mw_real modelled(mw_real steady_w, mw_real place)
{
    const branch_edges edges = edges_at(place);
    const mw_real part = part_between(steady_w, &edges);
    const mw_real line = edges.cooling + part * (edges.heating - edges.cooling);
    return place > MW_SENSED_FROM ? line - sag(part) : line;
}

static uint8_t is_sensed(const mw_follower *filter)
{
    return filter->place - AWAY * mw_root(filter->covariance[2]) > MW_SENSED_FROM;
}

static mw_real lengthened(mw_real dt_s, mw_real loss, mw_real heat_s)
{
    return dt_s * (1 + MW_R(0.5) * dt_s * loss / heat_s);
}

static mw_real at_least(mw_real number, mw_real least)
{
    return number < least ? least : number;
}

static mw_real at_most(mw_real number, mw_real most)
{
    return number < most ? number : most;
}

static mw_real square(mw_real number)
{
    return number * number;
}

static mw_real loose_per_watt(const branch_edges *edges, mw_real steady_w, mw_real toward_w)
{
    mw_real part = part_between(steady_w, edges), ahead_w = edges->heating_slope_w;
    if (toward_w < steady_w) {
        part = 1 - part;
        ahead_w = edges->cooling_slope_w;
    }
    return MW_LOOSENESS * part / at_least(ahead_w, MW_LEAST_SLOPE_W);
}

/* The steady power after a time, where a watt of it takes this heat. */
static mw_real warmed(mw_real steady_w, mw_real heat_s, mw_real given_w, mw_real loss, mw_real dt_s)
{
    const mw_real step_s = lengthened(dt_s, loss, heat_s);
    return (heat_s * steady_w + step_s * given_w) / (heat_s + step_s * loss);
}

/* One point through the heat balance and the play, in place. */
static void advance(mw_real *steady_w, mw_real *place, mw_real shift_w, mw_real loss, mw_real power_w, mw_real dt_s)
{
    mw_real given_w, step_s, given_j, per_w, free_w, takes_j = 0, at = *place;
    branch_edges edges = edges_at(at);
    uint8_t rises, turn;
    loss = at_least(loss, MW_MIN_LOSS);
    given_w = power_w + loss * shift_w;
    free_w = warmed(*steady_w, MW_TIME_CONSTANT_S, given_w, loss, dt_s);
    if (edges.cooling_w <= free_w && free_w <= edges.heating_w) {
        const mw_real per_watt = loose_per_watt(&edges, *steady_w, free_w);
        const mw_real heat_s = MW_TIME_CONSTANT_S + (at > MW_SENSED_FROM ? MW_TRANSFORMATION_HEAT_J : 0) * per_watt;
        const mw_real reached_w = warmed(*steady_w, heat_s, given_w, loss, dt_s);
        *place = mw_within(at + per_watt * (reached_w - *steady_w), MW_FIRST_PLACE, MW_LAST_PLACE);
        *steady_w = reached_w;
        return;
    }
    rises = free_w > edges.heating_w;
    for (turn = 0; turn < 2; turn++) { /* with the slope here, then with that of the cell where it led */
        const mw_real branch_w = rises ? edges.heating_w : edges.cooling_w;
        const mw_real slope_w = at_least(rises ? edges.heating_slope_w : edges.cooling_slope_w, MW_LEAST_SLOPE_W);
        mw_real found;
        takes_j = at > MW_SENSED_FROM ? MW_TRANSFORMATION_HEAT_J : 0;
        step_s = lengthened(dt_s, loss, MW_TIME_CONSTANT_S + takes_j / slope_w);
        given_j = MW_TIME_CONSTANT_S * *steady_w + step_s * given_w;
        per_w = MW_TIME_CONSTANT_S + step_s * loss;
        found = (given_j + takes_j * *place - per_w * (branch_w - slope_w * at)) / (takes_j + per_w * slope_w);
        if (rises ? found < *place : found > *place)
            found = *place;
        at = mw_within(found, MW_FIRST_PLACE, MW_LAST_PLACE);
        if (turn == 0)
            edges = edges_at(at);
    }
    *steady_w = (given_j - takes_j * (at - *place)) / per_w;
    *place = at;
}

/* An entry of a lower triangle, which is 0 above it. */
static mw_real entry(const mw_real *triangle, uint8_t row, uint8_t column)
{
    return column > row ? 0 : triangle[row * (row + 1) / 2 + column];
}

static void factor(const mw_real *covariance, mw_real *root)
{
    uint8_t row, column, before;
    mw_real *of_row = root;
    for (row = 0; row < STATES; row++) {
        const mw_real *of_column = root;
        for (column = 0; column <= row; column++) {
            mw_real left = *covariance++;
            for (before = 0; before < column; before++)
                left -= of_row[before] * of_column[before];
            of_row[column] = row == column ? mw_root(at_least(left, MW_MIN_VARIANCE)) : left / of_column[column];
            of_column += column + 1;
        }
        of_row += row + 1;
    }
}

static void begin(mw_follower *filter, mw_real read, mw_real power_w)
{
    const mw_real walk_w = MW_POWER_WALK * MW_MIDDLE_W, shift_w = MW_SHIFT_STD * MW_MIDDLE_W;
    const mw_follower fresh = {.value = filter->value, .loss = 1, .learnt_s = 1, .followed = 1};
    mw_real there, gap_w = 0, way = 0;
    uint8_t row = MW_PLACES - 1;
    *filter = fresh;
    while (row > 0 && table[row][HEATING] + table[row][COOLING] < 2 * read)
        row--;
    there = MW_FIRST_PLACE + (mw_real)row / MW_PER_PLACE;
    if (read > MW_COLD_FROM * table[0][HEATING]) {
        filter->steady_w = power_w;
        if (power_w >= edges_at(MW_SENSED_FROM).cooling_w) {
            way = at_least(there, MW_SENSED_FROM) - MW_FIRST_PLACE;
            gap_w = edges_at(MW_FIRST_PLACE + way).heating_w;
            filter->steady_w = (mw_real)0.5 * gap_w;
        }
        for (row = 0; row < MW_PLACES - 1 && table[row][HEATING_W] <= filter->steady_w;)
            row++;
    } else {
        const branch_edges edges = edges_at(there), further = edges_at(there + 1 / (mw_real)MW_PER_PLACE);
        const mw_real fall = (mw_real)0.5 * (edges.heating + edges.cooling - further.heating - further.cooling) * MW_PER_PLACE;
        gap_w = edges.heating_w - edges.cooling_w;
        way = (edges.heating - edges.cooling) / at_least(fall, MW_MIN_FALL);
        filter->steady_w = mw_within(power_w, edges.cooling_w, edges.heating_w);
    }
    filter->covariance[0] = walk_w * walk_w * MW_WALKED_S + gap_w * gap_w / 12;
    filter->covariance[1] = gap_w * way / 12;
    filter->covariance[2] = MW_PLACE_WALK * MW_PLACE_WALK * MW_WALKED_S + way * way / 12;
    filter->covariance[5] = shift_w * shift_w;
    filter->covariance[9] = MW_LOSS_WALK * MW_LOSS_WALK * MW_WALKED_S;
    filter->place = MW_FIRST_PLACE + (mw_real)row / MW_PER_PLACE;
    filter->before = filter->before_last = read;
    filter->noise_v2 = MW_LEAST_NOISE_V2;
}

/* The variance of a reading. */
static mw_real learnt_noise(mw_follower *filter, mw_real read, mw_real dt_s, mw_real per_volt)
{
    const mw_real bend_v = (read - 2 * filter->before + filter->before_last) / per_volt;
    mw_real new_v2 = bend_v * bend_v / 6, weight;
    filter->before_last = filter->before;
    filter->before = read;
    if (dt_s > 0) {
        filter->learnt_s = at_most(filter->learnt_s + dt_s, MW_WALKED_S);
        new_v2 = at_most(new_v2, MW_SURPRISE * filter->noise_v2);
        weight = at_most(dt_s / filter->learnt_s, 1);
        filter->noise_v2 += (new_v2 - filter->noise_v2) * weight;
        filter->noise_v2 = at_least(filter->noise_v2, MW_R(0.25) * MW_LEAST_NOISE_V2);
    }
    return filter->noise_v2 * per_volt * per_volt;
}

static mw_real predict(mw_follower *filter, mw_real power_w, mw_real dt_s)
{
    const mw_real walk_w = MW_POWER_WALK * MW_MIDDLE_W;
    mw_real root[TRIANGLE], powers[POINTS], places[POINTS], mean_w = 0, mean_place = 0, change_w, part_w;
    mw_real *covariance = filter->covariance;
    uint8_t point;
    factor(covariance, root);
    for (point = 0; point < POINTS; point++) {
        const uint8_t column = point / 2;
        const mw_real away = (mw_real)(point % 2 ? -AWAY : AWAY);
        powers[point] = filter->steady_w + away * entry(root, 0, column);
        places[point] = filter->place + away * entry(root, 1, column);
        advance(&powers[point], &places[point], filter->shift_w + away * entry(root, 2, column),
                filter->loss + away * entry(root, 3, column), power_w, dt_s);
        mean_w += powers[point] / POINTS;
        mean_place += places[point] / POINTS;
    }
    change_w = mean_w - filter->steady_w;
    part_w = MW_POWER_PART * change_w;
    filter->steady_w = mean_w;
    filter->place = mean_place;
    covariance[0] = covariance[1] = covariance[2] = covariance[3] = covariance[4] = covariance[6] = covariance[7] = 0;
    for (point = 0; point < POINTS; point++) {
        const uint8_t column = point / 2;
        const mw_real away = (mw_real)(point % 2 ? -AWAY : AWAY) / POINTS;
        const mw_real off_w = powers[point] - mean_w, off_place = places[point] - mean_place;
        const mw_real by_w = off_w * away, by_place = off_place * away;
        const mw_real of_shift = entry(root, 2, column), of_loss = entry(root, 3, column);
        covariance[0] += off_w * off_w / POINTS;
        covariance[1] += off_w * off_place / POINTS;
        covariance[2] += off_place * off_place / POINTS;
        covariance[3] += by_w * of_shift;
        covariance[4] += by_place * of_shift;
        covariance[6] += by_w * of_loss;
        covariance[7] += by_place * of_loss;
    }
    covariance[0] += walk_w * walk_w * dt_s + part_w * part_w;
    covariance[2] += MW_PLACE_WALK * MW_PLACE_WALK * dt_s;
    if (covariance[9] < 1)
        covariance[9] += square(MW_LOSS_WALK * filter->unrest) * dt_s;
    return change_w;
}

/* By how much a deviation is wider, if its variance is by this and no wider than what is known. */
static mw_real widened(mw_real wider, mw_real known)
{
    return mw_root(at_most(wider, at_least(known, 1)));
}

static void correct(mw_follower *filter, mw_real read, mw_real noise, mw_real dt_s, mw_real change_w)
{
    const mw_real own = MW_RESISTANCE_STD * MW_RESISTANCE_STD;
    const mw_real steady_w = filter->steady_w, place = filter->place, middle = modelled(steady_w, place);
    mw_real root[TRIANGLE], gains[STATES], *covariance = filter->covariance;
    mw_real variance = 1, surprise = 0, by_w = 0, by_place = 0;
    branch_edges edges;
    const uint8_t sensed = is_sensed(filter);
    uint8_t turn, row, column, at = 0;
    factor(covariance, root);
    for (turn = 0; turn < 3; turn++) {
        const mw_real hotter = modelled(steady_w + AWAY * root[0], place + AWAY * root[1]);
        const mw_real colder = modelled(steady_w - AWAY * root[0], place - AWAY * root[1]);
        const mw_real farther = modelled(steady_w, place + AWAY * root[2]);
        const mw_real nearer = modelled(steady_w, place - AWAY * root[2]);
        const mw_real mean = (4 * middle + hotter + colder + farther + nearer) / POINTS;
        mw_real spread = 4 * square(middle - mean) + square(hotter - mean) + square(colder - mean), wider;
        mw_real wide[STATES] = {1, 1, 1, 1};
        spread = (spread + square(farther - mean) + square(nearer - mean)) / POINTS;
        variance = spread + noise + own;
        surprise = read - mean;
        by_w = AWAY * (hotter - colder) / POINTS;
        by_place = AWAY * (farther - nearer) / POINTS;
        if (turn == 0)
            filter->unrest += (at_most(surprise * surprise / variance, MW_SURPRISE) - filter->unrest)
                              * at_most(dt_s / MW_UNREST_S, MW_MAX_WEIGHT);
        wider = surprise * surprise / (MW_SURPRISE * variance);
        if (wider <= 1)
            break;
        /* No wider than if nothing were known: of the power its middle, of the place the whole way. */
        wide[0] = widened(wider, MW_MIDDLE_W * MW_MIDDLE_W / square(root[0]));
        wide[1] = widened(wider, 1 / (square(root[1]) + square(root[2])));
        /* A play follows its power: against it, the heat balance does not hold. Before B resistance goes either way. */
        if (sensed && surprise * (root[1] * by_w + root[2] * by_place) * change_w < 0)
            wide[3] = widened(wider, 1 / covariance[9]);
        for (row = 0, at = 0; row < STATES; row++)
            for (column = 0; column <= row; column++, at++) {
                root[at] *= wide[row];
                covariance[at] *= wide[row] * wide[column];
            }
    }
    gains[0] = root[0] * by_w;
    gains[1] = root[1] * by_w + root[2] * by_place;
    gains[2] = root[3] * by_w + root[4] * by_place;
    gains[3] = root[6] * by_w + root[7] * by_place;
    surprise /= variance;
    filter->place = mw_within(place + gains[1] * surprise, MW_FIRST_PLACE, MW_LAST_PLACE);
    edges = edges_at(filter->place);
    filter->steady_w = mw_within(steady_w + gains[0] * surprise, edges.cooling_w, edges.heating_w);
    filter->shift_w += gains[2] * surprise;
    filter->loss = at_least(filter->loss + gains[3] * surprise, MW_MIN_LOSS);
    for (row = 0, at = 0; row < STATES; row++)
        for (column = 0; column <= row; column++, at++)
            covariance[at] -= gains[row] * gains[column] / variance;
}

/* Quantity and standard deviation of the state and a reading. */
static void answer(mw_follower *filter, mw_real read, mw_real noise)
{
    const branch_edges edges = edges_at(filter->place);
    const mw_real part = part_between(filter->steady_w, &edges), own = MW_RESISTANCE_STD * MW_RESISTANCE_STD;
    const mw_real error = modelled(filter->steady_w, filter->place) - read;
    const mw_real on_line = read + error * noise / (own + noise) + sag(part);
    const mw_real inside = mw_within(on_line, MW_NORMALISED_MIN, MW_NORMALISED_MAX);
    const mw_branches at = mw_branches_at(inside);
    const mw_real gap = at.heating - at.cooling, per_w = gap / (edges.heating_w - edges.cooling_w);
    const mw_real per_place = -per_w * (edges.cooling_slope_w + part * (edges.heating_slope_w - edges.cooling_slope_w));
    const mw_real off = on_line - inside, slope = MW_R(0.5) * at.slope, range_std = MW_RANGE_STD * MW_QUANTITY_SPAN;
    mw_real of_part = per_w * per_w * filter->covariance[0] + per_place * per_place * filter->covariance[2], variance;
    of_part = mw_within(of_part + 2 * per_w * per_place * filter->covariance[1], 0, gap * gap / 12);
    variance = of_part + slope * slope * (noise * own / (own + noise) + off * off) + MW_RESIDUAL_VARIANCE +
               range_std * range_std;
    filter->value = part * at.heating + (1 - part) * at.cooling;
    filter->std = mw_root(variance + MW_SCALE_VARIANCE * filter->value * filter->value);
    if (!(filter->std < MW_QUANTITY_SPAN))
        filter->std = MW_QUANTITY_SPAN;
#if defined(MW_INVERSE_MODEL)
    filter->part = part;
#endif
}

mw_estimation mw_follow(mw_follower *filter, mw_real resistance_ohm, mw_real wire_voltage_v, mw_real shunt_voltage_v,
                        mw_real dt_s)
{
    mw_estimation result = {filter->value, 0};
    mw_real read, per_volt, power_w, noise, outside;
    if (!(dt_s > 0 && dt_s <= MW_LARGEST))
        return result;
    filter->std = MW_QUANTITY_SPAN;
    filter->waited_s += dt_s;
#if defined(MW_INVERSE_MODEL)
    filter->measured_w = 0;
    filter->cold = 0;
#endif
    /* No current, or a wire that this model never has: the time until the next reading is predicted then. */
    if (!(resistance_ohm > 0 && resistance_ohm >= MW_OWN_LOW_OHM && resistance_ohm <= MW_OWN_HIGH_OHM))
        return result;
    power_w = wire_voltage_v * wire_voltage_v / resistance_ohm;
    read = (resistance_ohm - MW_RESISTANCE_MIN_OHM) * MW_SHARE_PER_OHM;
    per_volt = resistance_ohm * MW_SHARE_PER_OHM / shunt_voltage_v;
    if (!filter->followed)
        begin(filter, read, power_w);
    dt_s = filter->waited_s;
    filter->waited_s = 0;
    noise = learnt_noise(filter, read, dt_s, per_volt);
    correct(filter, read, noise, dt_s, dt_s > 0 ? predict(filter, power_w, dt_s) : 0);
    answer(filter, read, noise);
    outside = MW_VALID_FROM - read;
    if (read - 1 - MW_MARGIN > outside)
        outside = read - 1 - MW_MARGIN;
    result.value = filter->value;
    result.valid = is_sensed(filter) && !(outside > 0 && outside * outside > 9 * noise);
#if defined(MW_INVERSE_MODEL)
    filter->measured_w = power_w;
    filter->cold = !is_sensed(filter) && !(outside > 0 && outside * outside > 9 * noise);
#endif
    return result;
}

#else
typedef int mw_no_filter; /* the library was exported with another estimator */
#endif
