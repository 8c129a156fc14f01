/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* A bench made of integers: what drives the library in same_bits.c and tick_cost.c, the same on every target.
 *
 * The resistance walks between the ends of the model's range, the target likewise. All choices are made by xorshift32 (Marsaglia 2003, shifts 13, 17, 5), from
 * the seed 2463534242; only the voltages are computed in mw_real.
 */
#ifndef BENCH_H
#define BENCH_H

#include "musclewire.h"

#define TICK_S MW_R(0.05)
#define WALK 4096

typedef struct {
    uint32_t random;
    int32_t resistance, target; /* 0..WALK */
} bench_state;

static uint32_t drawn(bench_state *bench)
{
    bench->random ^= bench->random << 13;
    bench->random ^= bench->random >> 17;
    bench->random ^= bench->random << 5;
    return bench->random;
}

static void bench_start(bench_state *bench)
{
    const bench_state fresh = {2463534242u, WALK, WALK / 2};
    *bench = fresh;
}

static int32_t walked(int32_t at, uint32_t random, int32_t step)
{
    at += (int32_t)(random % (uint32_t)(2 * step + 1)) - step;
    return at < 0 ? 0 : at > WALK ? WALK : at;
}

static mw_real part_of(int32_t place, mw_real from, mw_real to)
{
    return from + (to - from) * ((mw_real)place / WALK);
}

typedef struct {
    mw_real wire_v, shunt_v, target;
} bench_inputs;

/* The voltages of this drive, and the target, without faults. */
static bench_inputs bench_next(bench_state *bench, mw_real drive_v)
{
    const uint32_t random = drawn(bench);
    bench_inputs inputs;
    mw_real resistance_ohm, current_a;
    bench->resistance = walked(bench->resistance, random & 0xff, 60);
    bench->target = walked(bench->target, random >> 8 & 0xff, 40);
    resistance_ohm = part_of(bench->resistance, MW_RESISTANCE_MIN_OHM, MW_RESISTANCE_MAX_OHM);
    current_a = drive_v / (resistance_ohm + MW_SHUNT_RESISTANCE_OHM);
    /* noise like the last digits of a converter */
    inputs.wire_v = current_a * resistance_ohm + MW_R(0.000125) * (mw_real)((int32_t)(random >> 24 & 3) - 1);
    inputs.shunt_v = current_a * MW_SHUNT_RESISTANCE_OHM + MW_R(0.000125) * (mw_real)((int32_t)(random >> 26 & 3) - 1);
    inputs.target = part_of(bench->target, MW_QUANTITY_MIN, MW_QUANTITY_MAX);
    return inputs;
}

#endif
