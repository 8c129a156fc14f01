/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The two balances of a wire, of enthalpy and of force, at a trial temperature and stress: musclewire.wire._balance. */
#include "mw_wire.h"

#define REFERENCE_TEMPERATURE_K MW_REFERENCE_TEMPERATURE_K
/* Beyond this exponent martensite is oriented to 13 digits. */
#define MAX_EXPONENT 32.0

/* exp(-exponent) for 0 to 32: Taylor's series of a 128th of the exponent, squared seven times. */
double mw_decay(double exponent)
{
    const double limited = exponent < MAX_EXPONENT ? exponent : MAX_EXPONENT;
    const double y = -limited * (1.0 / 128.0);
    const double square = y * y;
    const double fourth = square * square;
    const double low = (1.0 + y) + square * (1.0 / 2.0 + y * (1.0 / 6.0));
    const double middle = (1.0 / 24.0 + y * (1.0 / 120.0)) + square * (1.0 / 720.0 + y * (1.0 / 5040.0));
    const double high = (1.0 / 40320.0 + y * (1.0 / 362880.0)) + square * (1.0 / 3628800.0);
    double part = low + fourth * (middle + fourth * high);
    int halving;
    for (halving = 0; halving < 6; halving++)
        part *= part;
    return part * part;
}

mw_strain mw_strain_at(const mw_step_constants *k, double temperature_k, double stress_pa, double martensite,
                       double r_phase)
{
    const double unoriented =
        (k->strain_saturated - k->strain_at_no_stress) * mw_decay(stress_pa * k->per_strain_scale_per_pa);
    const double oriented = k->strain_saturated - unoriented;
    mw_strain strain;
    strain.transformation = oriented * martensite + k->r_phase_strain * r_phase;
    strain.elastic = stress_pa * (k->austenite_compliance_per_pa + martensite * k->added_compliance_per_pa);
    strain.thermal = (k->austenite_expansion_per_k + martensite * k->added_expansion_per_k)
                     * (temperature_k - REFERENCE_TEMPERATURE_K);
    strain.oriented = oriented;
    strain.oriented_per_pa = unoriented * k->per_strain_scale_per_pa;
    return strain;
}

double mw_contraction_of(const mw_step_constants *k, const mw_shakedown *shakedown, const mw_strain *strain)
{
    const double total = strain->transformation + strain->elastic + strain->thermal + shakedown->residual_strain;
    return (k->cold_strain - total) * k->per_stretch;
}

/* Phases mixed by volume, then the change of shape. */
double mw_resistance_at(const mw_step_constants *k, const mw_shakedown *shakedown, const mw_strain *strain,
                        double temperature_k, double martensite, double r_phase)
{
    const double warm_k = temperature_k - REFERENCE_TEMPERATURE_K;
    const double martensite_ohm_m = k->martensite_resistivity_ohm_m * shakedown->resistivity_factor;
    const double resistivity =
        martensite * martensite_ohm_m * (1.0 + k->martensite_resistivity_per_k * warm_k)
        + r_phase * k->r_phase_resistivity_ohm_m * (1.0 + k->r_phase_resistivity_per_k * warm_k)
        + (1.0 - martensite - r_phase) * k->austenite_resistivity_ohm_m
              * (1.0 + k->austenite_resistivity_per_k * warm_k);
    const double stretch = 1.0 + strain->transformation;
    const double thinning = 1.0 - MW_ELASTIC_POISSON_RATIO * strain->elastic;
    return resistivity * k->length_over_area_per_m * (stretch * stretch * (1.0 + strain->elastic))
           / (thinning * thinning * (1.0 + strain->thermal));
}

/* Enthalpy: C (T - 20 C) - L (x_M + r x_R) = H. Force: sigma = load over section. */
mw_balance mw_balance_at(const mw_step_constants *k, const mw_shakedown *shakedown, const mw_trial *point,
                         double temperature_k, double stress_pa, double enthalpy_j)
{
    const mw_phases *phases = &point->phases;
    const mw_strain *strain = &point->strain;
    const double warm_k = temperature_k - REFERENCE_TEMPERATURE_K;
    const double ratio = k->r_phase_entropy_ratio, latent = k->latent_heat_j, capacity = k->capacity_j_per_k;
    const double compliance = k->austenite_compliance_per_pa + phases->martensite * k->added_compliance_per_pa;
    const double expansion = k->austenite_expansion_per_k + phases->martensite * k->added_expansion_per_k;
    const double per_martensite =
        strain->oriented + stress_pa * k->added_compliance_per_pa + k->added_expansion_per_k * warm_k;
    const double strain_per_k =
        per_martensite * phases->martensite_per_k + k->r_phase_strain * phases->r_phase_per_k + expansion;
    const double strain_per_pa = per_martensite * phases->martensite_per_pa + k->r_phase_strain * phases->r_phase_per_pa
                                 + compliance + phases->martensite * strain->oriented_per_pa;
    const double stiffness = point->load.per_contraction_n * k->per_section_m2 * k->per_stretch;
    mw_balance found;
    found.heat_j = capacity * warm_k - latent * (phases->martensite + ratio * phases->r_phase) - enthalpy_j;
    found.excess_pa = stress_pa - point->load.force_n * k->per_section_m2;
    found.heat_per_k = capacity - latent * (phases->martensite_per_k + ratio * phases->r_phase_per_k);
    found.heat_per_pa = -latent * (phases->martensite_per_pa + ratio * phases->r_phase_per_pa);
    found.excess_per_k = stiffness * strain_per_k;
    found.excess_per_pa = 1.0 + stiffness * strain_per_pa;
    found.per_determinant = 1.0 / (found.heat_per_k * found.excess_per_pa - found.heat_per_pa * found.excess_per_k);
    found.rise_k =
        (found.heat_per_pa * found.excess_pa - found.excess_per_pa * found.heat_j) * found.per_determinant;
    found.rise_pa =
        (found.excess_per_k * found.heat_j - found.heat_per_k * found.excess_pa) * found.per_determinant;
    found.contraction = mw_contraction_of(k, shakedown, strain);
    found.contraction_per_k = -strain_per_k * k->per_stretch;
    found.contraction_per_pa = -strain_per_pa * k->per_stretch;
    return found;
}

mw_settled mw_settled_at(const mw_step_constants *k, const mw_shakedown *shakedown, const mw_trial *point, double rise_k,
                         double rise_pa, double stress_pa, double enthalpy_j)
{
    const mw_phases *phases = &point->phases;
    const mw_load_point *load = &point->load;
    const mw_balance *balance = &point->balance;
    const double martensite =
        phases->martensite + phases->martensite_per_k * rise_k + phases->martensite_per_pa * rise_pa;
    const double r_phase = phases->r_phase + phases->r_phase_per_k * rise_k + phases->r_phase_per_pa * rise_pa;
    const double moved = balance->contraction_per_k * rise_k + balance->contraction_per_pa * rise_pa;
    const double transformed = martensite + k->r_phase_entropy_ratio * r_phase;
    double friction_n = load->friction_n + load->friction_per_contraction_n * moved;
    mw_strain after = point->strain;
    mw_settled found;
    friction_n = friction_n < load->limit_n ? friction_n : load->limit_n;
    friction_n = friction_n > -load->limit_n ? friction_n : -load->limit_n;
    stress_pa = stress_pa + rise_pa;
    stress_pa = stress_pa > 0.0 ? stress_pa : 0.0; /* a slack wire carries nothing */
    found.temperature_k =
        REFERENCE_TEMPERATURE_K + (enthalpy_j + k->latent_heat_j * transformed) * k->per_capacity_k_per_j;
    after.oriented = after.oriented + after.oriented_per_pa * rise_pa;
    after.transformation = after.oriented * martensite + k->r_phase_strain * r_phase;
    after.elastic = stress_pa * (k->austenite_compliance_per_pa + martensite * k->added_compliance_per_pa);
    after.thermal = (k->austenite_expansion_per_k + martensite * k->added_expansion_per_k)
                    * (found.temperature_k - REFERENCE_TEMPERATURE_K);
    found.stress_pa = stress_pa;
    found.contraction = balance->contraction + moved;
    found.friction_n = friction_n;
    found.martensite = martensite;
    found.r_phase = r_phase;
    found.resistance_ohm = mw_resistance_at(k, shakedown, &after, found.temperature_k, martensite, r_phase);
    found.rise_k = rise_k;
    found.rise_pa = rise_pa;
    return found;
}

/* The correlation's heat transfer coefficient, from the wire's table over wall temperature. */
static double convection_w_per_m2_k(const mw_step_constants *k, double temperature_k)
{
    const int last = MW_CONVECTION_POINTS - 1;
    double place = (temperature_k - k->convection_start_k) * k->convection_per_k;
    double part;
    int low;
    place = place > 0.0 ? place : 0.0;
    place = place < last ? place : (double)last;
    low = (int)place;
    low = low < last ? low : last - 1;
    part = place - low;
    return mw_convection_w_per_m2_k[low] * (1.0 - part) + mw_convection_w_per_m2_k[low + 1] * part;
}

double mw_heat_loss_w(const mw_step_constants *k, double temperature_k)
{
    const double coefficient = convection_w_per_m2_k(k, temperature_k);
    const double excess_k = temperature_k - k->ambient_temperature_k;
    return coefficient * k->surface_factor_m2 * excess_k;
}
