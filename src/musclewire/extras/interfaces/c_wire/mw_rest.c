/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* What a step reads, derived from a wire's constants, and the wire at rest: musclewire.wire._row and ._building. */
#include <string.h>

#include "mw_wire.h"

static void derive_body(const mw_wire_constants *of, mw_step_constants *to)
{
    int wears;
    to->leg_length_m = of->leg_length_m;
    to->section_m2 = of->legs * of->area_m2;
    to->per_section_m2 = 1.0 / to->section_m2;
    to->per_stretch = 1.0 / (1.0 + of->cold_strain);
    to->cold_strain = of->cold_strain;
    to->length_over_area_per_m = of->austenite_length_m / of->area_m2;
    to->capacity_j_per_k = of->heat_capacity_j_per_k;
    to->per_capacity_k_per_j = 1.0 / of->heat_capacity_j_per_k;
    to->latent_heat_j = of->latent_heat_j;
    to->series_resistance_ohm = of->series_resistance_ohm;
    to->shunt_resistance_ohm = of->shunt_resistance_ohm;
    to->ambient_temperature_k = of->ambient_temperature_k;
    to->surface_factor_m2 = of->surface_m2 * of->convection_factor;
    to->convection_start_k = of->convection_table_start_k;
    to->convection_per_k = 1.0 / of->convection_table_step_k;
    to->pretension_n = of->pretension_n;
    to->spring_n = of->spring_stiffness_n_per_m * of->leg_length_m;
    to->friction_n = of->friction_n;
    to->per_presliding = of->leg_length_m / of->friction_presliding_m;
    to->load_points_per_contraction = of->leg_length_m / of->load_step_m;
    wears = of->shakedown_strain != 0.0 || of->shakedown_resistivity != 0.0 || of->shakedown_barrier != 0.0;
    to->shakedown_cycles = wears ? of->shakedown_cycles : 0.0;
    to->shakedown_strain = of->shakedown_strain;
    to->shakedown_resistivity = of->shakedown_resistivity;
    to->shakedown_barrier = of->shakedown_barrier;
}

static void derive_transformation(const mw_wire_constants *of, mw_step_constants *to)
{
    to->martensite_temperature_k = of->martensite_temperature_k;
    to->martensite_k_per_pa = 1.0 / of->martensite_stress_rate_pa_per_k;
    to->martensite_barrier_k = of->martensite_barrier_k;
    to->martensite_barrier_per_pa = of->martensite_barrier_per_pa;
    to->martensite_spread_k = of->martensite_spread_k;
    to->martensite_spread_per_pa = of->martensite_spread_per_pa;
    to->r_phase_temperature_k = of->r_phase_temperature_k;
    to->r_phase_k_per_pa = 1.0 / of->r_phase_stress_rate_pa_per_k;
    to->r_phase_entropy_ratio = of->r_phase_entropy_ratio;
    to->r_phase_barrier_k = of->r_phase_barrier_k;
    to->r_to_m_barrier_k = of->r_to_m_barrier_k;
    to->r_phase_spread_k = of->r_phase_entropy_ratio * of->r_phase_spread_k;
    to->per_r_phase_spread = 1.0 / to->r_phase_spread_k;
    to->strain_at_no_stress = of->strain_at_no_stress;
    to->strain_saturated = of->strain_saturated;
    to->per_strain_scale_per_pa = 1.0 / of->strain_stress_scale_pa;
    to->r_phase_strain = of->r_phase_strain;
    to->austenite_compliance_per_pa = 1.0 / of->austenite_modulus_pa;
    to->added_compliance_per_pa = 1.0 / of->martensite_modulus_pa - 1.0 / of->austenite_modulus_pa;
    to->austenite_expansion_per_k = of->austenite_expansion_per_k;
    to->added_expansion_per_k = of->martensite_expansion_per_k - of->austenite_expansion_per_k;
    to->austenite_resistivity_ohm_m = of->austenite_resistivity_ohm_m;
    to->austenite_resistivity_per_k = of->austenite_resistivity_per_k;
    to->r_phase_resistivity_ohm_m = of->r_phase_resistivity_ohm_m;
    to->r_phase_resistivity_per_k = of->r_phase_resistivity_per_k;
    to->martensite_resistivity_ohm_m = of->martensite_resistivity_ohm_m;
    to->martensite_resistivity_per_k = of->martensite_resistivity_per_k;
    to->distribution_core_start = of->distribution_core_start;
    to->distribution_core_end = of->distribution_core_end;
    to->distribution_per_core_step = 1.0 / of->distribution_core_step;
    to->distribution_per_step = 1.0 / of->distribution_step;
    to->distribution_core_place = (of->distribution_core_start - of->distribution_start) * to->distribution_per_step;
    memcpy(to->class_weight, of->class_weight, sizeof to->class_weight);
    memcpy(to->class_barrier_k, of->class_barrier_k, sizeof to->class_barrier_k);
}

void mw_derive(const mw_wire_constants *of, mw_step_constants *to)
{
    derive_body(of, to);
    derive_transformation(of, to);
}

/* The phases after cooling from full austenite at constant stress. Fronts then only move down, to thresholds that fall:
 * the path does not matter, and its end is enough. */
static void cool_from_hot(mw_wire_state *state, const mw_step_constants *k, double temperature_k, double stress_pa)
{
    const mw_shakedown over = {1.0, 0.0, 1.0};
    mw_phases phases;
    int row;
    for (row = 0; row < MW_CLASSES; row++)
        state->front_austenite[row] = state->front_martensite[row] = DBL_MAX;
    phases = mw_phases_at(state, k, &over, temperature_k, stress_pa);
    for (row = 0; row < MW_CLASSES; row++) {
        state->front_austenite[row] = state->front_trial[6 * row];
        state->front_martensite[row] = state->front_trial[6 * row + 1];
    }
    state->martensite_fraction = phases.martensite;
    state->r_phase_fraction = phases.r_phase;
}

void mw_at_rest(mw_wire_constants *constants, mw_step_constants *k, mw_wire_state *state)
{
    const double temperature_k = constants->ambient_temperature_k;
    double stress_pa = constants->pretension_n / (constants->legs * constants->area_m2);
    mw_shakedown shakedown;
    mw_strain strain;
    memset(state, 0, sizeof *state);
    mw_derive(constants, k);
    cool_from_hot(state, k, temperature_k, stress_pa);
    strain = mw_strain_at(k, temperature_k, stress_pa, state->martensite_fraction, state->r_phase_fraction);
    constants->cold_strain = strain.transformation + strain.elastic + strain.thermal;
    constants->austenite_length_m = constants->wire_length_m / (1.0 + constants->cold_strain);
    mw_derive(constants, k);

    stress_pa = k->pretension_n * k->per_section_m2;
    cool_from_hot(state, k, temperature_k, stress_pa);
    state->temperature_k = temperature_k;
    state->stress_pa = stress_pa;
    state->enthalpy_j = k->capacity_j_per_k * (temperature_k - MW_REFERENCE_TEMPERATURE_K)
                        - k->latent_heat_j * (state->martensite_fraction
                                              + k->r_phase_entropy_ratio * state->r_phase_fraction);
    shakedown = mw_shakedown_of(k, 0.0);
    strain = mw_strain_at(k, temperature_k, stress_pa, state->martensite_fraction, state->r_phase_fraction);
    state->resistance_ohm = mw_resistance_at(k, &shakedown, &strain, temperature_k, state->martensite_fraction,
                                             state->r_phase_fraction);
    state->temperature_slope_k_per_j = k->per_capacity_k_per_j;
}
