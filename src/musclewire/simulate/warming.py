"""A wire that was heated slowly from cold and rests there: where a cooling curve begins."""

from __future__ import annotations

from typing import Any

import numpy as np

from musclewire.compiled import compiled
from musclewire.errors import CallerError
from musclewire.physics.resistivity import REFERENCE_TEMPERATURE_K
from musclewire.simulate.kernel import balanced, freshness_of
from musclewire.simulate.state import FloatArray, WireConstants, WireNumbers, WireState
from musclewire.simulate.switching import drives_at, drives_from, keep_drives, switch_grains
from musclewire.simulate.wire import resting_state

__all__ = ["heated_state"]

# Stress follows the temperature by one Newton step a time: steps as fine as this leave nothing over.
STEP_K = 0.1
NUMBERS = len(WireNumbers._fields)


@compiled
def warmed_plain(
    numbers: tuple[float, ...],
    grain_martensite: FloatArray,
    grain_r_phase: FloatArray,
    seen_drives: FloatArray,
    constant_values: tuple[Any, ...],
    temperature_k: FloatArray,
) -> tuple[float, ...]:
    """Return the numbers of a wire led along ``temperature_k``, (n,), in balance with its load; grains in place."""
    constants = WireConstants(*constant_values)
    state = WireNumbers(*numbers)
    freshness = freshness_of(constants, state.cycles)
    for point in range(temperature_k.shape[0]):
        rise_k = temperature_k[point] - state.temperature_k
        drives = drives_at(constants, temperature_k[point], state.stress_pa, freshness.barrier_factor)
        switch_grains(constants, drives, drives_from(seen_drives), grain_martensite, grain_r_phase)
        keep_drives(drives, seen_drives)
        martensite, r_phase = grain_martensite.mean(), grain_r_phase.mean()
        transformed = martensite + constants.r_phase_entropy_ratio * r_phase
        moved = WireNumbers(
            state.time_s,
            temperature_k[point],
            state.stress_pa,
            state.contraction,
            state.friction_n,
            constants.heat_capacity_j_per_k * (temperature_k[point] - REFERENCE_TEMPERATURE_K)
            - constants.latent_heat_j * transformed,
            state.heat_in_j,
            state.heat_out_j,
            state.cycles,
            martensite,
            r_phase,
            state.resistance_ohm,
            state.capacity_j_per_k,
            state.stress_slope_pa_per_k,
            0.0,
            0.0,
        )
        state = balanced(moved, constants, freshness, rise_k, 1.0, 0.0, 0.0)
    return (
        state.time_s,
        state.temperature_k,
        state.stress_pa,
        state.contraction,
        state.friction_n,
        state.enthalpy_j,
        state.heat_in_j,
        state.heat_out_j,
        state.cycles,
        state.martensite_fraction,
        state.r_phase_fraction,
        state.resistance_ohm,
        state.capacity_j_per_k,
        0.0,
        0.0,
        0.0,
    )


def heated_state(constants: WireConstants, temperature_k: float) -> WireState:
    """Return a wire on its load that was heated from cold to a temperature, so slowly that it was in balance all along.

    It is on the heating side of its loop: above the end of transformation austenite, below it whatever heating left.
    Raises CallerError for a temperature that is not above that of the air.
    """
    ambient = constants.ambient_temperature_k
    if not temperature_k > ambient:
        raise CallerError(
            f"a heated wire must be above the {ambient - 273.15:.1f} C of the air around it, not at "
            f"{temperature_k - 273.15:.1f} C"
        )
    start = resting_state(constants)
    martensite, r_phase, seen = start.grain_martensite, start.grain_r_phase, start.seen_drives
    steps = int((temperature_k - ambient) / STEP_K) + 1
    way = np.linspace(ambient, temperature_k, steps + 1)[1:]
    numbers: tuple[Any, ...] = tuple(start[:NUMBERS])
    after = warmed_plain(numbers, martensite, r_phase, seen, tuple(constants), way)
    return WireState._make((*after, martensite, r_phase, seen))
