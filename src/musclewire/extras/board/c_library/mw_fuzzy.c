/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* From the error and its change to the three gain ratios of Eq. 6. Only the inference that the rule base uses is
 * compiled. */
#include "musclewire.h"

#if !defined(MW_INVERSE_MODEL)

#define SETS 7
#define UNIVERSE_END 3

static mw_real within(mw_real value, mw_real minimum, mw_real maximum)
{
    return value < minimum ? minimum : value > maximum ? maximum : value;
}

#if MW_INFERENCE != MW_CONSTANT

/* shape and three points: triangle (foot, peak, foot), falling or rising between the first two */
typedef struct {
    mw_real shape, first, second, third;
} fuzzy_set;

MW_TABLE fuzzy_set input_sets[SETS] = MW_INPUT_SETS;

#if MW_HAS_SMOOTH_SETS
static mw_real smooth_step(mw_real first, mw_real second, mw_real x)
{
    mw_real part;
    if (x <= first)
        return 0;
    if (x >= second)
        return 1;
    if (x <= (first + second) / 2) {
        part = (x - first) / (second - first);
        return 2 * (part * part);
    }
    part = (x - second) / (second - first);
    return 1 - 2 * (part * part);
}
#endif

static mw_real triangle(mw_real first, mw_real second, mw_real third, mw_real x)
{
    if (x <= first || x >= third)
        return 0;
    if (x <= second)
        return (x - first) / (second - first);
    return (third - x) / (third - second);
}

static void grade(mw_real ratio, mw_real *grades)
{
    const mw_real x = within(ratio, -1, 1) * UNIVERSE_END;
    uint8_t index;
    for (index = 0; index < SETS; index++) {
        const MW_FLASH fuzzy_set *set = &input_sets[index];
#if MW_HAS_SMOOTH_SETS
        if (set->shape != MW_TRIANGLE) {
            const mw_real rising = smooth_step(set->first, set->second, x);
            grades[index] = set->shape == MW_RISING ? rising : 1 - rising;
            continue;
        }
#endif
        grades[index] = triangle(set->first, set->second, set->third, x);
    }
}

#endif

#if MW_INFERENCE == MW_PRODUCT_WEIGHTED_SUM

MW_TABLE uint8_t kp_is_big[SETS * SETS] = MW_KP_TABLE;
MW_TABLE mw_real ki_ratio[SETS * SETS] = MW_KI_TABLE;
MW_TABLE uint8_t kd_is_big[SETS * SETS] = MW_KD_TABLE;

static mw_ratios combine(const mw_real *error_grades, const mw_real *change_grades)
{
    mw_ratios sum = {0, 0, 0};
    uint8_t row, column;
    for (row = 0; row < SETS; row++) {
        if (error_grades[row] == 0)
            continue;
        for (column = 0; column < SETS; column++) {
            /* a rule fires with the product of its grades */
            const mw_real mu = error_grades[row] * change_grades[column];
            const uint8_t at = (uint8_t)(SETS * row + column);
            mw_real small, big;
            if (mu == 0)
                continue;
            small = mw_exponential(-4 * mu);
            big = 1 - small;
            sum.kp += mu * (kp_is_big[at] ? big : small);
            sum.ki += mu * ki_ratio[at];
            sum.kd += mu * (kd_is_big[at] ? big : small);
        }
    }
    sum.kp = within(sum.kp, 0, 1);
    sum.ki = within(sum.ki, 0, 1);
    sum.kd = within(sum.kd, 0, 1);
    return sum;
}

#elif MW_INFERENCE == MW_MIN_MAX_CENTROID

#define POINTS 101

MW_TABLE uint8_t labels[3][SETS * SETS] = {MW_KP_TABLE, MW_KI_TABLE, MW_KD_TABLE};
MW_TABLE mw_real output_sets[SETS][POINTS] = MW_OUTPUT_SETS;

static void fire(uint8_t table, const mw_real *error_grades, const mw_real *change_grades, mw_real *fired)
{
    uint8_t row, column;
    for (row = 0; row < SETS; row++)
        fired[row] = 0;
    for (row = 0; row < SETS; row++) {
        if (error_grades[row] == 0)
            continue;
        for (column = 0; column < SETS; column++) {
            const uint8_t label = labels[table][SETS * row + column];
            const mw_real strength =
                change_grades[column] < error_grades[row] ? change_grades[column] : error_grades[row];
            if (strength > fired[label])
                fired[label] = strength;
        }
    }
}

/* The height of the union of all output sets at one point, each clipped at its firing strength. */
static mw_real joined(const mw_real *fired, uint8_t point)
{
    mw_real highest = 0;
    uint8_t label;
    for (label = 0; label < SETS; label++) {
        mw_real height, cut;
        if (fired[label] <= highest)
            continue; /* a set that is clipped here cannot be higher */
        height = output_sets[label][point];
        cut = height < fired[label] ? height : fired[label];
        if (cut > highest)
            highest = cut;
    }
    return highest;
}

/* (1 + x) / 2 for the centroid x of the union; the end points carry half a cell. */
static mw_real centroid_ratio(const mw_real *fired)
{
    const mw_real spacing = MW_R(2.0) / (POINTS - 1);
    const mw_real left = MW_R(0.5) * joined(fired, 0), right = MW_R(0.5) * joined(fired, POINTS - 1);
    mw_real area = left + right;
    mw_real moment = (right - left) * (1 - spacing / 3);
    uint8_t point;
    for (point = 1; point < POINTS - 1; point++) {
        const mw_real height = joined(fired, point);
        area += height;
        moment += height * (spacing * (mw_real)((int)point - POINTS / 2));
    }
    return within(area == 0 ? MW_R(0.5) : (1 + moment / area) / 2, 0, 1);
}

static mw_ratios combine(const mw_real *error_grades, const mw_real *change_grades)
{
    mw_real fired[SETS];
    mw_ratios ratios;
    fire(0, error_grades, change_grades, fired);
    ratios.kp = centroid_ratio(fired);
    fire(1, error_grades, change_grades, fired);
    ratios.ki = centroid_ratio(fired);
    fire(2, error_grades, change_grades, fired);
    ratios.kd = centroid_ratio(fired);
    return ratios;
}

#endif

mw_ratios mw_infer(mw_real error_ratio, mw_real change_ratio)
{
#if MW_INFERENCE == MW_CONSTANT
    const mw_ratios ratios = {MW_KP_RATIO, MW_KI_RATIO, MW_KD_RATIO};
    (void)error_ratio;
    (void)change_ratio;
    (void)within;
    return ratios;
#else
    mw_real error_grades[SETS], change_grades[SETS];
#if MW_MIRRORED != 0
    /* one half of the tables is read for both directions */
    const mw_real sign = error_ratio > 0 ? MW_MIRRORED : error_ratio < 0 ? -(MW_MIRRORED) : 0;
    error_ratio = sign * error_ratio;
    change_ratio = sign * change_ratio;
#endif
    grade(error_ratio, error_grades);
    grade(change_ratio, change_grades);
    return combine(error_grades, change_grades);
#endif
}

#else
typedef int mw_no_fuzzy; /* the library was exported with the inverse of the wire's model */
#endif
