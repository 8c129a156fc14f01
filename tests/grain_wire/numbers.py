"""The numbers of a wire of grains: its records, and how they follow from alloy, spool and bench."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.special import ndtri

from grain_wire.switching import Array, Grains, offsets
from musclewire.physics import convection_coefficient_w_per_m2_k

# Units are in the names; without one a number is dimensionless.
STATE = [
    "time_s",
    "temperature_k",
    "stress_pa",
    "contraction",
    "friction_n",
    "enthalpy_j",
    "heat_in_j",
    "heat_out_j",
    "cycles",
    "martensite_fraction",
    "r_phase_fraction",
    "resistance_ohm",
    "capacity_j_per_k",
    "stress_slope_pa_per_k",
    "temperature_rate_k_per_s",
    "resistance_rate_ohm_per_s",
    "work_j",
]
FROM_ALLOY = [
    "martensite_temperature_k",
    "martensite_stress_rate_pa_per_k",
    "martensite_barrier_k",
    "martensite_barrier_per_pa",
    "r_phase_temperature_k",
    "r_phase_stress_rate_pa_per_k",
    "r_phase_entropy_ratio",
    "r_phase_barrier_k",
    "r_to_m_barrier_k",
    "strain_at_no_stress",
    "strain_saturated",
    "strain_stress_scale_pa",
    "r_phase_strain",
    "austenite_modulus_pa",
    "martensite_modulus_pa",
    "austenite_expansion_per_k",
    "martensite_expansion_per_k",
    "austenite_resistivity_ohm_m",
    "austenite_resistivity_per_k",
    "r_phase_resistivity_ohm_m",
    "r_phase_resistivity_per_k",
    "martensite_resistivity_ohm_m",
    "martensite_resistivity_per_k",
    "shakedown_cycles",
    "shakedown_strain",
    "shakedown_resistivity",
    "shakedown_barrier",
    "martensite_spread_k",
    "martensite_spread_per_pa",
    "r_phase_spread_k",
]
CONSTANTS = [
    *FROM_ALLOY,
    *[
        "wire_length_m",
        "leg_length_m",
        "legs",
        "austenite_length_m",
        "area_m2",
        "surface_m2",
        "heat_capacity_j_per_k",
        "latent_heat_j",
        "series_resistance_ohm",
        "shunt_resistance_ohm",
        "ambient_temperature_k",
        "convection_factor",
        "convection_table_start_k",
        "convection_table_step_k",
        "pretension_n",
        "spring_stiffness_n_per_m",
        "friction_n",
        "friction_presliding_m",
        "load_step_m",
        "cold_strain",
        "work_share",
    ],
]
TABLE_START_K, TABLE_STEP_K, TABLE_POINTS = 200.0, 2.0, 301


class Load(NamedTuple):
    """A load over the connector's displacement: a spring, and tables of force and friction [N] every ``step_m``."""

    stiffness_n_per_m: float
    step_m: float
    force_n: Array
    friction_n: Array


def spring(stiffness_n_per_m: float) -> Load:
    """Return a plain spring."""
    return Load(stiffness_n_per_m, 1.0, np.zeros(2), np.zeros(2))


def record(names: list[str], **values: float) -> np.ndarray:
    """Return an array of one record of these numbers, (1,)."""
    made = np.zeros(1, np.dtype((np.record, [(name, np.float64) for name in names])))
    for name, value in values.items():
        made[name] = value
    return made


def spread_grains(grains: int, material: Mapping[str, float]) -> Grains:
    """Return classes of equal weight as adjacent intervals; the outermost reach as far outwards as inwards."""
    inner = offsets_of(np.arange(1, grains) / grains, material)
    outermost = offsets_of(np.array([0.5, grains - 0.5]) / grains, material)
    edges = np.concatenate(([2.0 * outermost[0] - inner[0]], inner, [2.0 * outermost[1] - inner[-1]]))
    phases = (np.zeros(grains), np.zeros(grains))
    return Grains(edges, 0.5 * (edges[1:] + edges[:-1]), np.diff(edges), *phases, np.zeros(7))


def offsets_of(quantile: Array, material: Mapping[str, float]) -> Array:
    """Return offsets of quantiles: a signed power, below which the early fraction lies evenly over its width."""
    early, width = material["early_fraction"], material["early_width"]
    power = offsets(ndtri(np.maximum(quantile, early)), material["grain_skew"], material["grain_tail"])
    return np.array([x - width * (1.0 - u / early) if u < early else x for u, x in zip(quantile, power, strict=True)])


def convection_table(diameter_m: float, ambient_temperature_k: float) -> Array:
    """Return the convection coefficient [W/(m2 K)] every 2 K from 200 K on."""
    walls = TABLE_START_K + TABLE_STEP_K * np.arange(TABLE_POINTS)
    return np.array([convection_coefficient_w_per_m2_k(t, ambient_temperature_k, diameter_m) for t in walls])


def from_alloy(material: Mapping[str, float], spool: Mapping[str, float], new_wire: bool) -> dict[str, float]:
    """Return the alloy's numbers with the factors and shifts of a spool; a settled wire has no shakedown left."""
    same = {name: material[name] for name in FROM_ALLOY}
    if not new_wire:
        same |= {"shakedown_strain": 0.0, "shakedown_resistivity": 0.0, "shakedown_barrier": 0.0}
    for name in ("austenite", "martensite", "r_phase"):
        same[f"{name}_resistivity_ohm_m"] *= spool["resistivity_factor"]
    for name in ("martensite", "r_phase"):
        same[f"{name}_temperature_k"] += spool["temperature_shift_k"]
    same["r_phase_temperature_k"] += spool["r_phase_shift_k"]
    same["martensite_barrier_k"] += spool["martensite_barrier_shift_k"]
    return same


def body(material: Mapping[str, float], spool: Mapping[str, float], bench: Mapping[str, float]) -> dict[str, float]:
    """Return dimensions, heat capacity and latent heat."""
    length, legs, diameter = bench["wire_length_m"], bench["legs"], spool["diameter_m"]
    area = 0.25 * math.pi * diameter**2
    mass = area * length * material["density_kg_per_m3"]
    return {
        "wire_length_m": length,
        "leg_length_m": length / legs,
        "legs": legs,
        "austenite_length_m": length,
        "area_m2": area,
        "surface_m2": math.pi * diameter * length,
        "heat_capacity_j_per_k": mass * material["specific_heat_j_per_kg_k"],
        "latent_heat_j": mass * material["latent_heat_j_per_kg"],
    }


def surroundings(
    spool: Mapping[str, float], bench: Mapping[str, float], load: Any, guide_friction: bool
) -> dict[str, float]:
    """Return what circuit, air, load and guide contribute."""
    return {
        "series_resistance_ohm": bench["shunt_resistance_ohm"] + bench["lead_resistance_ohm"],
        "shunt_resistance_ohm": bench["shunt_resistance_ohm"],
        "ambient_temperature_k": bench["ambient_temperature_k"],
        "convection_factor": spool["convection_factor"],
        "convection_table_start_k": TABLE_START_K,
        "convection_table_step_k": TABLE_STEP_K,
        "pretension_n": bench["pretension_n"],
        "spring_stiffness_n_per_m": load.stiffness_n_per_m,
        "load_step_m": load.step_m,
        "friction_n": bench["guide_friction_n"] if guide_friction else 0.0,
        "friction_presliding_m": bench["guide_presliding_m"],
    }
