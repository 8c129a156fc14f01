/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Phases of a wire as two fronts in the distribution of its grains: musclewire.wire._fronts.
 *
 * Austenite lies below the front q_F, martensite above q_M >= q_F, R-phase between them, after any history. */
#include "mw_wire.h"

/* A spread that stress made smaller than this is a switch rather than a ramp. */
#define MIN_SPREAD_K 1e-6

mw_thresholds mw_thresholds_at(const mw_step_constants *k, double temperature_k, double stress_pa,
                               double barrier_factor, double barrier_k)
{
    const double ratio = k->r_phase_entropy_ratio;
    const double force_m = k->martensite_temperature_k + stress_pa * k->martensite_k_per_pa - temperature_k;
    const double force_r = ratio * (k->r_phase_temperature_k + stress_pa * k->r_phase_k_per_pa - temperature_k);
    const double preference = force_m - force_r;
    const double stress_barrier_k =
        barrier_factor * (k->martensite_barrier_k + barrier_k + k->martensite_barrier_per_pa * stress_pa);
    const double stress_barrier_per_pa = barrier_factor * k->martensite_barrier_per_pa;
    const double barrier = stress_barrier_k > 0.0 ? stress_barrier_k : 0.0;
    const double barrier_per_pa = stress_barrier_k > 0.0 ? stress_barrier_per_pa : 0.0;
    const double detour_k = barrier + k->r_phase_barrier_k;
    const double direct_k = k->r_to_m_barrier_k;
    const double preference_barrier = direct_k < detour_k ? direct_k : detour_k;
    const double preference_barrier_per_pa = direct_k < detour_k ? 0.0 : barrier_per_pa;
    const double spread_m = k->martensite_spread_k + k->martensite_spread_per_pa * stress_pa;
    const double gap = spread_m - k->r_phase_spread_k;
    const double spread_p = gap > MIN_SPREAD_K ? gap : MIN_SPREAD_K;
    const double per_m = 1.0 / spread_m, per_r = k->per_r_phase_spread, per_p = 1.0 / spread_p;
    const double widening = k->martensite_spread_per_pa;
    const double force_m_per_pa = k->martensite_k_per_pa;
    const double preference_per_pa = k->martensite_k_per_pa - ratio * k->r_phase_k_per_pa;
    mw_thresholds at;
    at.a_to_m = (barrier - force_m) * per_m;
    at.a_to_r = (k->r_phase_barrier_k - force_r) * per_r;
    at.r_to_m = (preference_barrier - preference) * per_p;
    at.m_to_a = (-force_m - barrier) * per_m;
    at.r_to_a = (-force_r - k->r_phase_barrier_k) * per_r;
    at.m_to_r = (-preference - preference_barrier) * per_p;
    at.a_to_m_per_pa = (barrier_per_pa - force_m_per_pa - at.a_to_m * widening) * per_m;
    at.a_to_r_per_pa = -ratio * k->r_phase_k_per_pa * per_r;
    at.r_to_m_per_pa = (preference_barrier_per_pa - preference_per_pa - at.r_to_m * widening) * per_p;
    at.m_to_a_per_pa = (-barrier_per_pa - force_m_per_pa - at.m_to_a * widening) * per_m;
    at.m_to_r_per_pa = (-preference_barrier_per_pa - preference_per_pa - at.m_to_r * widening) * per_p;
    at.m_per_k = per_m;
    at.r_per_k = ratio * per_r;
    at.p_per_k = (1.0 - ratio) * per_p;
    return at;
}

/* Cooling: q_F = min(q_F, z_AM, z_AR), then q_M = min(q_M, max(q_F, z_RM)). Heating: q_M = max(q_M, z_MA, z_MR), then
 * q_F = max(q_F, min(q_M, z_RA)). A front that no threshold has reached keeps its place, with slopes of 0. */
mw_fronts mw_moved_fronts(const mw_thresholds *at, double front_austenite, double front_martensite)
{
    mw_fronts found = {front_austenite, front_martensite, 0.0, 0.0, 0.0, 0.0};
    int direct = at->a_to_m < at->a_to_r;
    int follows;
    double place = direct ? at->a_to_m : at->a_to_r;
    if (place < found.austenite) {
        found.austenite = place;
        found.austenite_per_k = direct ? at->m_per_k : at->r_per_k;
        found.austenite_per_pa = direct ? at->a_to_m_per_pa : at->a_to_r_per_pa;
    }
    follows = found.austenite > at->r_to_m;
    place = follows ? found.austenite : at->r_to_m;
    if (place < found.martensite) {
        found.martensite = place;
        found.martensite_per_k = follows ? found.austenite_per_k : at->p_per_k;
        found.martensite_per_pa = follows ? found.austenite_per_pa : at->r_to_m_per_pa;
    }
    direct = at->m_to_a > at->m_to_r;
    place = direct ? at->m_to_a : at->m_to_r;
    if (place > found.martensite) {
        found.martensite = place;
        found.martensite_per_k = direct ? at->m_per_k : at->p_per_k;
        found.martensite_per_pa = direct ? at->m_to_a_per_pa : at->m_to_r_per_pa;
    }
    follows = found.martensite < at->r_to_a;
    place = follows ? found.martensite : at->r_to_a;
    if (place > found.austenite) {
        found.austenite = place;
        found.austenite_per_k = follows ? found.martensite_per_k : at->r_per_k;
        found.austenite_per_pa = follows ? found.martensite_per_pa : at->a_to_r_per_pa;
    }
    return found;
}

double mw_cumulative_at(const mw_step_constants *k, int row, double offset, double *density)
{
    double core = offset > k->distribution_core_start ? offset : k->distribution_core_start;
    double per_offset, place, inside, part;
    const double *of;
    int cell;
    core = core < k->distribution_core_end ? core : k->distribution_core_end;
    per_offset = core == offset ? k->distribution_per_core_step : k->distribution_per_step;
    place = k->distribution_core_place + (core - k->distribution_core_start) * k->distribution_per_core_step;
    place += (offset - core) * k->distribution_per_step;
    inside = place > 0.0 ? place : 0.0;
    inside = inside < MW_CELLS ? inside : (double)MW_CELLS;
    cell = (int)inside;
    cell = cell < MW_CELLS ? cell : MW_CELLS - 1;
    part = inside - cell;
    of = mw_cells[row][cell];
    *density = (of[1] + part * (2.0 * of[2] + part * (3.0 * of[3]))) * per_offset;
    if (!(place > 0.0 && place < MW_CELLS))
        *density = 0.0;
    return of[0] + part * (of[1] + part * (of[2] + part * of[3]));
}
