/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Temperature and stress of a wire from its enthalpy and the load's force, solved together: musclewire.wire._step. */
#include "mw_wire.h"

/* Newton's last step may be this long: it is applied linearly, and the error that remains is of second order in it. */
#define SOLVED_K 1e-3
/* After so many plain Newton steps the safe method begins, and after so many evaluations a step counts as unsolved. */
#define PLAIN_STEPS 4
#define MAX_EVALUATIONS 200
/* From here on the safe method halves its bracket instead of trusting slopes. */
#define BISECT_AFTER 60
/* Bend of the load within the last Newton step that may be left. */
#define SMALL_BEND_N 1e-6
/* No temperature and no stress is beyond it: the end of a bracket that is still open. */
#define OPEN DBL_MAX

static double magnitude(double value)
{
    return value < 0.0 ? -value : value;
}

/* Friction after a motion: elastic first, then Coulomb. */
static double friction_at(double limit_n, double limit_per_contraction_n, double per_presliding, double before_n,
                          double moved, double *slope_n)
{
    const double per_contraction = limit_n * per_presliding;
    const double elastic = before_n + per_contraction * moved;
    if (elastic > limit_n) {
        *slope_n = limit_per_contraction_n;
        return limit_n;
    }
    if (elastic < -limit_n) {
        *slope_n = -limit_per_contraction_n;
        return -limit_n;
    }
    *slope_n = per_contraction;
    return elastic;
}

mw_load_point mw_load_at(const mw_step_constants *k, double contraction, double connector_before,
                         double friction_before_n, const mw_push *push)
{
    mw_load_point at;
    double force_n = k->pretension_n + k->spring_n * contraction;
    double slope_n = k->spring_n + push->per_contraction_n;
    double limit_slope_n = 0.0, friction_slope_n;
    force_n += push->force_n + push->per_contraction_n * (contraction - push->contraction);
    at.limit_n = k->friction_n;
#if MW_LOAD_POINTS > 2
    {
        const int last = MW_LOAD_POINTS - 1;
        const double place = contraction * k->load_points_per_contraction;
        const double inside = place > 0.0 ? place : 0.0;
        const int low = inside < last ? (int)inside : last - 1;
        const double rise_n = mw_load_table_n[0][low + 1] - mw_load_table_n[0][low];
        const double rub_n = mw_load_table_n[1][low + 1] - mw_load_table_n[1][low];
        const double part = inside < last ? inside - low : 1.0;
        force_n += mw_load_table_n[0][low] + rise_n * (inside - low);
        slope_n += place > 0.0 ? rise_n * k->load_points_per_contraction : 0.0;
        at.limit_n += mw_load_table_n[1][low] + rub_n * part;
        limit_slope_n = place > 0.0 && place < last ? rub_n * k->load_points_per_contraction : 0.0;
    }
#endif
    at.friction_n = friction_at(at.limit_n, limit_slope_n, k->per_presliding, friction_before_n,
                                contraction - connector_before, &friction_slope_n);
    at.force_n = force_n + at.friction_n;
    at.per_contraction_n = slope_n + friction_slope_n;
    at.friction_per_contraction_n = friction_slope_n;
    return at;
}

mw_phases mw_phases_at(mw_wire_state *state, const mw_step_constants *k, const mw_shakedown *shakedown,
                       double temperature_k, double stress_pa)
{
    mw_phases found = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    int row;
    for (row = 0; row < MW_CLASSES; row++) {
        const mw_thresholds at =
            mw_thresholds_at(k, temperature_k, stress_pa, shakedown->barrier_factor, k->class_barrier_k[row]);
        const mw_fronts after = mw_moved_fronts(&at, state->front_austenite[row], state->front_martensite[row]);
        const double weight = k->class_weight[row];
        double martensite_density, austenite_density;
        const double to_martensite = mw_cumulative_at(k, row, after.martensite, &martensite_density);
        const double to_austenite = mw_cumulative_at(k, row, after.austenite, &austenite_density);
        const double loss_per_k = weight * martensite_density * after.martensite_per_k;
        const double loss_per_pa = weight * martensite_density * after.martensite_per_pa;
        double *trial = state->front_trial + 6 * row;
        found.martensite += weight * (1.0 - to_martensite);
        found.r_phase += weight * (to_martensite - to_austenite);
        found.martensite_per_k -= loss_per_k;
        found.martensite_per_pa -= loss_per_pa;
        found.r_phase_per_k += loss_per_k - weight * austenite_density * after.austenite_per_k;
        found.r_phase_per_pa += loss_per_pa - weight * austenite_density * after.austenite_per_pa;
        trial[0] = after.austenite;
        trial[1] = after.martensite;
        trial[2] = after.austenite_per_k;
        trial[3] = after.austenite_per_pa;
        trial[4] = after.martensite_per_k;
        trial[5] = after.martensite_per_pa;
    }
    return found;
}

static mw_trial trial_at(mw_wire_state *state, const mw_step_constants *k, const mw_shakedown *shakedown,
                         const mw_push *push, double temperature_k, double stress_pa, double enthalpy_j)
{
    mw_trial point;
    point.phases = mw_phases_at(state, k, shakedown, temperature_k, stress_pa);
    point.strain = mw_strain_at(k, temperature_k, stress_pa, point.phases.martensite, point.phases.r_phase);
    point.load = mw_load_at(k, mw_contraction_of(k, shakedown, &point.strain), state->connector_contraction,
                            state->friction_n, push);
    point.balance = mw_balance_at(k, shakedown, &point, temperature_k, stress_pa, enthalpy_j);
    return point;
}

/* How far the load after a motion is from its straight continuation [N]: 0 for a spring without friction. */
static double bend_n(const mw_wire_state *state, const mw_step_constants *k, const mw_trial *point, const mw_push *push,
                     double moved)
{
    mw_load_point after;
    if (MW_LOAD_POINTS == 2 && k->friction_n == 0.0)
        return 0.0;
    after = mw_load_at(k, point->balance.contraction + moved, state->connector_contraction, state->friction_n, push);
    return magnitude(after.force_n - (point->load.force_n + point->load.per_contraction_n * moved));
}

/* Whether the force is balanced at the trial's temperature, or the wire is slack. */
static int stress_balanced(const mw_step_constants *k, const mw_balance *balance, double stress_pa, double bracket_pa)
{
    const double only_pa = balance->excess_pa / balance->excess_per_pa;
    if (magnitude(only_pa) * k->martensite_k_per_pa < 0.1 * SOLVED_K || bracket_pa < 1.0)
        return 1;
    return stress_pa <= 0.0 && balance->excess_pa > 0.0;
}

/* The next trial stress at constant temperature, within its bracket. */
static double next_stress_pa(const mw_balance *balance, double stress_pa, double low_pa, double high_pa)
{
    const double new_pa = stress_pa - balance->excess_pa / balance->excess_per_pa;
    if (balance->excess_per_pa > 0.0 && low_pa < new_pa && new_pa < high_pa)
        return new_pa;
    if (balance->excess_per_pa > 0.0 && new_pa <= 0.0 && low_pa == 0.0)
        return 0.0;
    return high_pa < OPEN ? 0.5 * (low_pa + high_pa) : 2.0 * stress_pa + 1e7;
}

/* The next trial temperature by the equation reduced to it, within its bracket. */
static double next_temperature_k(const mw_step_constants *k, const mw_balance *balance, double temperature_k,
                                 double low_k, double high_k, int evaluations)
{
    const double slope =
        balance->heat_per_k - balance->heat_per_pa * balance->excess_per_k / balance->excess_per_pa;
    const double new_k = temperature_k - balance->heat_j / slope;
    if (low_k < new_k && new_k < high_k && evaluations <= BISECT_AFTER)
        return new_k;
    if (low_k > -OPEN && high_k < OPEN)
        return 0.5 * (low_k + high_k);
    /* The capacity without latent heat never falls short of the root: it closes the bracket at once. */
    return temperature_k - balance->heat_j * k->per_capacity_k_per_j;
}

/* A solution with its slopes over heat; a slack wire has those of temperature alone. */
static mw_equilibrium equilibrium_of(const mw_balance *balance, mw_settled after, int evaluations, int solved)
{
    const int taut = after.stress_pa > 0.0;
    mw_equilibrium found;
    found.wire = after;
    found.temperature_slope_k_per_j =
        taut ? balance->excess_per_pa * balance->per_determinant : 1.0 / balance->heat_per_k;
    found.stress_slope_pa_per_j = taut ? -balance->excess_per_k * balance->per_determinant : 0.0;
    found.contraction_slope_per_j = balance->contraction_per_k * found.temperature_slope_k_per_j
                                    + balance->contraction_per_pa * found.stress_slope_pa_per_j;
    found.evaluations = evaluations;
    found.solved = solved;
    return found;
}

/* Newton's method in both unknowns, one evaluation a step as a rule. If four steps do not suffice, stress is balanced at
 * constant temperature in a bracket, and temperature by the reduced equation in another. */
mw_equilibrium mw_solve(mw_wire_state *state, const mw_step_constants *k, const mw_shakedown *shakedown,
                        double enthalpy_j, double temperature_k, double stress_pa, const mw_push *push)
{
    double low_k = -OPEN, high_k = OPEN, low_pa = 0.0, high_pa = OPEN;
    double rise_k, rise_pa;
    int evaluations = 0, solved = 0;
    mw_trial point;
    const mw_balance *balance = &point.balance;
    for (;;) {
        int slack;
        evaluations++;
        point = trial_at(state, k, shakedown, push, temperature_k, stress_pa, enthalpy_j);
        rise_k = balance->rise_k;
        rise_pa = balance->rise_pa;
        slack = stress_pa <= 0.0 && rise_pa < 0.0;
        if (slack) { /* temperature alone meets the enthalpy */
            rise_k = -balance->heat_j / balance->heat_per_k;
            rise_pa = 0.0;
        }
        if (magnitude(rise_k) < SOLVED_K && magnitude(rise_pa) * k->martensite_k_per_pa < SOLVED_K) {
            const double moved = balance->contraction_per_k * rise_k + balance->contraction_per_pa * rise_pa;
            solved = slack || bend_n(state, k, &point, push, moved) < SMALL_BEND_N;
        }
        if (solved || evaluations >= MAX_EVALUATIONS)
            break;
        if (evaluations <= PLAIN_STEPS) {
            temperature_k += rise_k;
            stress_pa = stress_pa + rise_pa > 0.0 ? stress_pa + rise_pa : 0.0;
            continue;
        }
        if (balance->excess_pa > 0.0)
            high_pa = stress_pa < high_pa ? stress_pa : high_pa;
        else
            low_pa = stress_pa > low_pa ? stress_pa : low_pa;
        if (!stress_balanced(k, balance, stress_pa, high_pa - low_pa)) {
            stress_pa = next_stress_pa(balance, stress_pa, low_pa, high_pa);
            continue;
        }
        low_pa = 0.0;
        high_pa = OPEN;
        if (balance->heat_j > 0.0)
            high_k = temperature_k < high_k ? temperature_k : high_k;
        else
            low_k = temperature_k > low_k ? temperature_k : low_k;
        if (high_k - low_k < 1e-3 * SOLVED_K) {
            solved = 1;
            rise_k = rise_pa = 0.0;
            break;
        }
        temperature_k = next_temperature_k(k, balance, temperature_k, low_k, high_k, evaluations);
    }
    if (!solved)
        rise_k = rise_pa = 0.0;
    return equilibrium_of(balance, mw_settled_at(k, shakedown, &point, rise_k, rise_pa, stress_pa, enthalpy_j),
                          evaluations, solved);
}
