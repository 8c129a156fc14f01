"""What describes a simulated wire: what never changes while it runs, and all that it remembers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["Drives", "FloatArray", "Sums", "WireConstants", "WireNumbers", "WireState"]

FloatArray = NDArray[np.float64]


class WireConstants(NamedTuple):
    """Everything that does not change while a wire runs; SI units. Built by ``simulate.wire``.

    ``load_force_n`` and ``load_friction_n``, (n_points,), are what a load asks beyond pretension and spring, and its
    friction beyond the guide's, at displacements of 0, 1, 2... times ``load_step_m``.
    """

    wire_length_m: float
    leg_length_m: float
    legs: float
    austenite_length_m: float
    area_m2: float
    surface_m2: float
    heat_capacity_j_per_k: float
    latent_heat_j: float
    series_resistance_ohm: float
    shunt_resistance_ohm: float
    ambient_temperature_k: float
    convection_factor: float
    convection_table_start_k: float
    convection_table_step_k: float
    convection_table_w_per_m2_k: FloatArray
    pretension_n: float
    spring_stiffness_n_per_m: float
    friction_n: float
    friction_presliding_m: float
    load_step_m: float
    load_force_n: FloatArray
    load_friction_n: FloatArray
    martensite_temperature_k: float
    martensite_stress_rate_pa_per_k: float
    martensite_barrier_k: float
    martensite_barrier_per_pa: float
    r_phase_temperature_k: float
    r_phase_stress_rate_pa_per_k: float
    r_phase_entropy_ratio: float
    r_phase_barrier_k: float
    r_to_m_barrier_k: float
    strain_at_no_stress: float
    strain_saturated: float
    strain_stress_scale_pa: float
    r_phase_strain: float
    austenite_modulus_pa: float
    martensite_modulus_pa: float
    austenite_expansion_per_k: float
    martensite_expansion_per_k: float
    austenite_resistivity_ohm_m: float
    austenite_resistivity_per_k: float
    r_phase_resistivity_ohm_m: float
    r_phase_resistivity_per_k: float
    martensite_resistivity_ohm_m: float
    martensite_resistivity_per_k: float
    shakedown_cycles: float
    shakedown_strain: float
    shakedown_resistivity: float
    shakedown_barrier: float
    cold_strain: float
    martensite_spread_k: float
    martensite_spread_per_pa: float
    r_phase_spread_k: float
    grain_edges: FloatArray
    grain_middle: FloatArray
    grain_width: FloatArray


class WireNumbers(NamedTuple):
    """The numbers of a wire's state; with the grains' arrays they make a :class:`WireState`."""

    time_s: float
    temperature_k: float
    stress_pa: float
    contraction: float
    friction_n: float
    enthalpy_j: float
    heat_in_j: float
    heat_out_j: float
    cycles: float
    martensite_fraction: float
    r_phase_fraction: float
    resistance_ohm: float
    capacity_j_per_k: float
    stress_slope_pa_per_k: float
    temperature_rate_k_per_s: float
    resistance_rate_ohm_per_s: float


class WireState(NamedTuple):
    """All that a wire remembers.

    ``grain_*`` are shares of each grain, (n_grains,); ``seen_drives`` the drives they last followed, (7,).
    """

    time_s: float
    temperature_k: float
    stress_pa: float
    contraction: float
    friction_n: float
    enthalpy_j: float
    heat_in_j: float
    heat_out_j: float
    cycles: float
    martensite_fraction: float
    r_phase_fraction: float
    resistance_ohm: float
    capacity_j_per_k: float
    stress_slope_pa_per_k: float
    temperature_rate_k_per_s: float
    resistance_rate_ohm_per_s: float
    grain_martensite: FloatArray
    grain_r_phase: FloatArray
    seen_drives: FloatArray


class Sums(NamedTuple):
    """Means over one call of :func:`advance`: what an averaging acquisition card sees."""

    wire_voltage_v: float
    shunt_voltage_v: float
    displacement_m: float
    force_n: float


class Drives(NamedTuple):
    """How far [K] each of the six phase changes is beyond its barrier, for a grain of offset 0, and at what stress."""

    a_to_m_k: float
    a_to_r_k: float
    r_to_m_k: float
    m_to_a_k: float
    r_to_a_k: float
    m_to_r_k: float
    stress_pa: float
