"""A wire heated slowly from cold, at rest: the start of a cooling curve."""

from __future__ import annotations

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.errors import CallerError
from musclewire.physics.resistance import REFERENCE_TEMPERATURE_K
from musclewire.wire.building import resting_state
from musclewire.wire.state import Rows, WireConstants, WireState
from musclewire.wire.step import find_equilibrium, running
from musclewire.wire.switching import follow, phase_fractions

__all__ = ["heated_state"]

# Stress follows temperature by one Newton step at a time: in steps this fine nothing remains to be balanced.
STEP_K = 0.1


@compiled
def warm_rows(states: Rows, constants: Rows, load_table_n: FloatArray, temperature_k: FloatArray) -> None:
    """Take a wire, a row of (1,), through temperatures, (n,), in equilibrium with its load, in place."""
    state, of = states[0], constants[0]
    wire = running(state, of, load_table_n)
    for point in range(temperature_k.shape[0]):
        rise_k = temperature_k[point] - state.temperature_k
        follow(state, of, temperature_k[point], state.stress_pa, wire.shakedown.barrier_factor)
        state.martensite_fraction, state.r_phase_fraction = phase_fractions(state)
        transformed = state.martensite_fraction + of.r_phase_entropy_ratio * state.r_phase_fraction
        state.temperature_k = temperature_k[point]
        state.enthalpy_j = (
            of.heat_capacity_j_per_k * (temperature_k[point] - REFERENCE_TEMPERATURE_K) - of.latent_heat_j * transformed
        )
        find_equilibrium(wire, rise_k, 1.0, 0.0, 0.0)
    # At rest: the rates of the last step do not hold any more.
    state.stress_slope_pa_per_k = 0.0
    state.temperature_rate_k_per_s = 0.0
    state.resistance_rate_ohm_per_s = 0.0


def heated_state(constants: WireConstants, temperature_k: float) -> WireState:
    """Return a wire on its load, heated from cold to a temperature so slowly that it is in equilibrium throughout.

    It is on the heating branch of its loop: austenite above the end of the transformation, partly martensite below.

    Parameters
    ----------
    constants
        The wire on its load.
    temperature_k
        Temperature to which it was heated [K], above that of the air.

    Returns
    -------
    The state at that temperature, at rest.

    Raises
    ------
    CallerError
        If the temperature is not above that of the air.
    """
    ambient = constants.ambient_temperature_k
    if not temperature_k > ambient:
        raise CallerError(
            f"a heated wire must be above the {ambient - 273.15:.1f} C of the air around it, not at "
            f"{temperature_k - 273.15:.1f} C"
        )
    start = resting_state(constants)
    steps = int((temperature_k - ambient) / STEP_K) + 1
    way = np.linspace(ambient, temperature_k, steps + 1)[1:]
    warm_rows(start.row, constants.row, constants.load_table_n, way)
    return start
