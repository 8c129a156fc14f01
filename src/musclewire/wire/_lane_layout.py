"""How many wires lie side by side in memory: blocks of lanes, and one lane by the names of a wire."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from musclewire.compiled import compiled_inline
from musclewire.wire._constants import NO_LOAD_TABLE, StepConstants, as_record
from musclewire.wire._row import CLASSES, Rows
from musclewire.wire._state import WireState

__all__ = ["LANES", "Block", "block_layout", "blocks_of", "constants_of_lane", "state_fields", "state_of_lane"]

# Wires in a block: two of the widest vector registers. Eight would be unrolled into scalar code.
LANES = 16

# A record of ``block_layout`` in compiled code.
Block = Any

# Numbers of a step in progress, a lane each.
SCRATCH = [
    "drive_v",
    "current_a",
    "power_w",
    "loss_w",
    "middle_k",
    "middle_ohm",
    "temperature_slope",
    "stress_slope",
    "coefficient",
    "within_w",
    "heat_j",
    "trial_k",
    "trial_pa",
    "resistance_ohm",
    "resistance_slope",
    "connector_contraction",
    "friction_n",
    "stress_pa",
    "martensite",
    "cycles",
    "missed",
    "voltage_sum",
    "current_sum",
    "moved_sum",
    "stress_sum",
]
# Per class and lane: both fronts with their slopes, and the distribution at both.
CLASS_SCRATCH = [
    "austenite",
    "martensite",
    "austenite_per_k",
    "austenite_per_pa",
    "martensite_per_k",
    "martensite_per_pa",
    "martensite_fraction",
    "martensite_density",
    "austenite_fraction",
    "austenite_density",
    "austenite_before",
    "martensite_before",
]
NOT_IN_LANES = ("time_s", "step_s", "evaluations")
NO_LOAD = as_record(NO_LOAD_TABLE)


class LaneConstants(NamedTuple):
    """The single numbers of :class:`~musclewire.wire._constants.StepConstants`, of one lane, by the same names."""

    leg_length_m: float
    section_m2: float
    per_section_m2: float
    per_stretch: float
    cold_strain: float
    length_over_area_per_m: float
    capacity_j_per_k: float
    per_capacity_k_per_j: float
    latent_heat_j: float
    series_resistance_ohm: float
    shunt_resistance_ohm: float
    ambient_temperature_k: float
    surface_factor_m2: float
    convection_start_k: float
    convection_per_k: float
    pretension_n: float
    spring_n: float
    friction_n: float
    per_presliding: float
    load_points_per_contraction: float
    martensite_temperature_k: float
    martensite_k_per_pa: float
    martensite_barrier_k: float
    martensite_barrier_per_pa: float
    martensite_spread_k: float
    martensite_spread_per_pa: float
    r_phase_temperature_k: float
    r_phase_k_per_pa: float
    r_phase_entropy_ratio: float
    r_phase_barrier_k: float
    r_to_m_barrier_k: float
    r_phase_spread_k: float
    per_r_phase_spread: float
    strain_at_no_stress: float
    strain_saturated: float
    per_strain_scale_per_pa: float
    r_phase_strain: float
    austenite_compliance_per_pa: float
    added_compliance_per_pa: float
    austenite_expansion_per_k: float
    added_expansion_per_k: float
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
    distribution_core_start: float
    distribution_core_end: float
    distribution_core_place: float
    distribution_per_core_step: float
    distribution_per_step: float


class LaneState(NamedTuple):
    """The numbers of :class:`~musclewire.wire._state.WireState` that a step begins with, of one lane."""

    temperature_k: float
    stress_pa: float
    resistance_ohm: float
    temperature_slope_k_per_j: float
    stress_slope_pa_per_j: float
    resistance_slope_ohm_per_j: float
    last_heat_j: float


@cache
def block_layout(classes: int) -> np.dtype[np.void]:
    """Return the layout of a block of wires: constants ``k_...``, state ``s_...`` and scratch ``t_...``, by lane."""
    constants: list[tuple[str, str, tuple[int, ...]]] = [
        (f"k_{item.name}", "f8", (LANES,)) for item in StepConstants.fields if item.length is None
    ]
    constants += [(f"k_{name}", "f8", (classes, LANES)) for name in ("class_weight", "class_barrier_k")]
    state: list[tuple[str, str, tuple[int, ...]]] = [
        (f"s_{item.name}", "f8", (LANES,))
        for item in WireState.fields
        if item.length is None and item.name not in NOT_IN_LANES
    ]
    state += [(f"s_{name}", "f8", (classes, LANES)) for name in ("front_austenite", "front_martensite")]
    scratch: list[tuple[str, str, tuple[int, ...]]] = [(f"t_{name}", "f8", (LANES,)) for name in SCRATCH]
    scratch += [(f"t_class_{name}", "f8", (classes, LANES)) for name in CLASS_SCRATCH]
    return np.dtype((np.record, [*constants, *state, *scratch]))


def state_fields() -> list[str]:
    """Return the fields of the state that lanes hold."""
    return [item.name for item in WireState.fields if item.length in (None, CLASSES) and item.name not in NOT_IN_LANES]


def blocks_of(derived: Rows, states: Rows) -> Rows:
    """Return wires, (n_wires,), as blocks, (n_blocks,); the lanes left over in the last repeat the last wire."""
    count = len(derived)
    blocks = -(-count // LANES)
    each = np.minimum(np.arange(blocks * LANES), count - 1)
    found = np.zeros(blocks, block_layout(derived.dtype["class_weight"].shape[0]))
    for name in found.dtype.names or ():
        kind, field_name = name[0], name[2:]
        if kind == "t":
            continue
        values = (derived if kind == "k" else states)[field_name][each]
        found[name] = np.moveaxis(values.reshape(blocks, LANES, *values.shape[1:]), 1, -1)
    return found


# fmt: off
@compiled_inline
def constants_of_lane(b: Block, lane: int) -> Any:
    """Return the constants of a lane, in the order of their fields."""
    return LaneConstants(
        b.k_leg_length_m[lane], b.k_section_m2[lane], b.k_per_section_m2[lane], b.k_per_stretch[lane],
        b.k_cold_strain[lane], b.k_length_over_area_per_m[lane], b.k_capacity_j_per_k[lane],
        b.k_per_capacity_k_per_j[lane], b.k_latent_heat_j[lane], b.k_series_resistance_ohm[lane],
        b.k_shunt_resistance_ohm[lane], b.k_ambient_temperature_k[lane], b.k_surface_factor_m2[lane],
        b.k_convection_start_k[lane], b.k_convection_per_k[lane], b.k_pretension_n[lane], b.k_spring_n[lane],
        b.k_friction_n[lane], b.k_per_presliding[lane], b.k_load_points_per_contraction[lane],
        b.k_martensite_temperature_k[lane], b.k_martensite_k_per_pa[lane], b.k_martensite_barrier_k[lane],
        b.k_martensite_barrier_per_pa[lane], b.k_martensite_spread_k[lane], b.k_martensite_spread_per_pa[lane],
        b.k_r_phase_temperature_k[lane], b.k_r_phase_k_per_pa[lane], b.k_r_phase_entropy_ratio[lane],
        b.k_r_phase_barrier_k[lane], b.k_r_to_m_barrier_k[lane], b.k_r_phase_spread_k[lane],
        b.k_per_r_phase_spread[lane], b.k_strain_at_no_stress[lane], b.k_strain_saturated[lane],
        b.k_per_strain_scale_per_pa[lane], b.k_r_phase_strain[lane], b.k_austenite_compliance_per_pa[lane],
        b.k_added_compliance_per_pa[lane], b.k_austenite_expansion_per_k[lane], b.k_added_expansion_per_k[lane],
        b.k_austenite_resistivity_ohm_m[lane], b.k_austenite_resistivity_per_k[lane],
        b.k_r_phase_resistivity_ohm_m[lane], b.k_r_phase_resistivity_per_k[lane],
        b.k_martensite_resistivity_ohm_m[lane], b.k_martensite_resistivity_per_k[lane], b.k_shakedown_cycles[lane],
        b.k_shakedown_strain[lane], b.k_shakedown_resistivity[lane], b.k_shakedown_barrier[lane],
        b.k_distribution_core_start[lane], b.k_distribution_core_end[lane], b.k_distribution_core_place[lane],
        b.k_distribution_per_core_step[lane], b.k_distribution_per_step[lane],
    )


@compiled_inline
def state_of_lane(b: Block, lane: int) -> Any:
    """Return the numbers of a lane that a step begins with."""
    return LaneState(
        b.s_temperature_k[lane], b.s_stress_pa[lane], b.s_resistance_ohm[lane], b.s_temperature_slope_k_per_j[lane],
        b.s_stress_slope_pa_per_j[lane], b.s_resistance_slope_ohm_per_j[lane], b.s_last_heat_j[lane],
    )
# fmt: on
