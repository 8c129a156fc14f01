"""A wire heated slowly from cold, at rest: the start of a cooling curve."""

from __future__ import annotations

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.errors import CallerError
from musclewire.wire._balance import settled
from musclewire.wire._building import resting_state
from musclewire.wire._constants import WireConstants
from musclewire.wire._fronts import shakedown_of
from musclewire.wire._row import Rows
from musclewire.wire._state import WireState
from musclewire.wire._step import (
    MAX_EVALUATIONS,
    NO_PUSH,
    RunningWire,
    accept,
    equilibrium_of,
    next_stress_pa,
    stress_balanced,
    trial_at,
)

__all__ = ["heated_state"]

# Far below any spread of the grains, so that the balance is found from the stress before in one or two evaluations.
STEP_K = 0.1


@compiled
def warm_rows(states: Rows, constants: Rows, cells: Rows, load: Rows, temperature_k: FloatArray) -> None:
    """Take a wire, a row of (1,), through temperatures, (n,), in balance with its load, in place."""
    wire = RunningWire(states[0], constants[0], cells[0], load[0])
    state, k = wire.state, wire.constants
    for point in range(temperature_k.shape[0]):
        balance_at_temperature(wire, temperature_k[point])
    # At rest: the slopes of the last step do not hold any more.
    state.temperature_slope_k_per_j = k.per_capacity_k_per_j
    state.stress_slope_pa_per_j = 0.0
    state.contraction_slope_per_j = 0.0
    state.resistance_slope_ohm_per_j = 0.0
    state.last_heat_j = 0.0


@compiled
def balance_at_temperature(wire: RunningWire, temperature_k: float) -> None:
    """Bring a wire to a temperature, its stress in balance with the load, in place."""
    state, k = wire.state, wire.constants
    shakedown = shakedown_of(k, state.cycles)
    stress_pa = state.stress_pa
    low_pa, high_pa = 0.0, np.inf
    evaluations = 0
    while True:
        evaluations += 1
        point = trial_at(wire, shakedown, NO_PUSH, temperature_k, stress_pa, 0.0)
        if point.balance.excess_pa > 0.0:
            high_pa = min(high_pa, stress_pa)
        else:
            low_pa = max(low_pa, stress_pa)
        solved = stress_balanced(k, point, stress_pa, high_pa - low_pa)
        if solved or evaluations >= MAX_EVALUATIONS:
            break
        stress_pa = next_stress_pa(point, stress_pa, low_pa, high_pa)
    enthalpy_j = point.balance.heat_j  # of a trial for enthalpy 0
    after = settled(k, shakedown, point, (0.0, 0.0), (temperature_k, stress_pa, enthalpy_j))
    accept(wire, equilibrium_of(point, after, evaluations, solved), enthalpy_j - state.enthalpy_j, NO_PUSH)


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
    warm_rows(start.row, *constants.step_arrays(), way)
    return start
