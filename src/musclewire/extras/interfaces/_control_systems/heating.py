"""A wire heated or cooled without a clock: what it is at another enthalpy, after one motion of its fronts and guide."""

from __future__ import annotations

from typing import NamedTuple

from musclewire.compiled import compiled
from musclewire.errors import NumericsError
from musclewire.wire import (
    NO_PUSH,
    VOLTAGE,
    Rows,
    RunningWire,
    SourceOutput,
    WireConstants,
    WireState,
    accept,
    guess_after,
    instant_of,
    middle_of_step,
    shakedown_of,
    solve,
)

# Half of the width over which the slope of the loss to the air is taken; its table has a point every 2 K.
LOSS_SLOPE_K = 1.0


class HeatFlow(NamedTuple):
    """Heat that flows into a wire at a drive voltage, with its slopes."""

    power_w: float
    loss_w: float  # to the air
    per_volt: float  # slope of the power over the drive voltage [W/V]
    per_ohm: float  # slope of the power over the wire's resistance [W/ohm]
    loss_per_k: float  # slope of the loss over the wire's temperature [W/K]


@compiled
def heat_rows(states: Rows, derived: Rows, cells: Rows, loads: Rows, enthalpy_j: float) -> bool:
    """Bring a wire to an enthalpy in place, in balance with its load; return whether both balances are met."""
    state, constants = states[0], derived[0]
    wire = RunningWire(state, constants, cells[0], loads[0])
    heat_j = enthalpy_j - state.enthalpy_j
    guess = guess_after(state, middle_of_step(state, constants, 0.5 * heat_j), heat_j)
    found = solve(wire, shakedown_of(constants, state.cycles), enthalpy_j, guess, NO_PUSH)
    accept(wire, found, heat_j, NO_PUSH)
    return found.solved


@compiled
def flow_rows(
    derived: Rows, drive_voltage_v: float, resistance_ohm: float, temperature_k: float
) -> tuple[float, float]:
    """Return the electrical power of a wire in its circuit and its loss to the air [W]."""
    found = instant_of(derived[0], SourceOutput(drive_voltage_v, VOLTAGE), resistance_ohm, temperature_k)
    return found.power_w, found.loss_w


def heated_to(state: WireState, constants: WireConstants, enthalpy_j: float) -> WireState:
    """Return a wire at another enthalpy, heated or cooled there without turning; NumericsError if there is no balance.

    The path between does not matter: fronts and friction follow the farthest point of a motion.
    """
    after = state.copy()
    if not heat_rows(after.row, *constants.step_arrays(), enthalpy_j):
        raise NumericsError(
            f"the wire finds no balance with its load at an enthalpy of {enthalpy_j:g} J: look at the load"
        )
    return after


def heat_flow_of(state: WireState, constants: WireConstants, drive_voltage_v: float) -> HeatFlow:
    """Return the heat that flows into a wire at a drive voltage."""
    resistance, series, warm_k = state.resistance_ohm, constants.series_resistance_ohm, state.temperature_k
    derived, current_a = constants.step_arrays()[0], drive_voltage_v / (resistance + series)
    power_w, loss_w = flow_rows(derived, drive_voltage_v, resistance, warm_k)
    _, above_w = flow_rows(derived, drive_voltage_v, resistance, warm_k + LOSS_SLOPE_K)
    _, below_w = flow_rows(derived, drive_voltage_v, resistance, warm_k - LOSS_SLOPE_K)
    return HeatFlow(
        power_w,
        loss_w,
        2.0 * current_a * resistance / (resistance + series),
        current_a**2 * (series - resistance) / (series + resistance),
        (above_w - below_w) / (2.0 * LOSS_SLOPE_K),
    )
