"""A wire in its driving circuit through time: a buffer amplifier, wire, shunt and leads in series."""

from __future__ import annotations

from typing import NamedTuple

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.wire.state import Rows, WireConstants, WireState
from musclewire.wire.step import resistance_ahead_ohm, running, step

__all__ = ["WireMeans", "advance", "advance_rows"]


class WireMeans(NamedTuple):
    """Means over one call of :func:`advance`: what an averaging acquisition card sees."""

    wire_voltage_v: float
    shunt_voltage_v: float
    displacement_m: float
    force_n: float


def advance(
    state: WireState, constants: WireConstants, drive_voltage_v: float, dt_s: float, steps: int
) -> tuple[WireState, WireMeans]:
    """Return the state after ``steps`` steps of ``dt_s`` at one drive voltage, and the means on the way.

    The state given is left as it was. Energy is kept to rounding: enthalpy changes by heat in minus heat
    out, and temperature follows from enthalpy and phase fractions.
    """
    after = state.copy()
    # Arrays go into compiled code and plain numbers come back. Numba would call the class of a named tuple on the way
    # out; a Ctrl-C that arrives in that call finds nobody to handle it, and the process dies on the spot.
    means = advance_rows(after.row, constants.row, constants.load_table_n, drive_voltage_v, dt_s, steps)
    return after, WireMeans(*means)


@compiled
def advance_rows(
    states: Rows, constants: Rows, load_table_n: FloatArray, drive_voltage_v: float, dt_s: float, steps: int
) -> tuple[float, float, float, float]:
    """Do the work of :func:`advance` in place on arrays of one record, (1,)."""
    state, of = states[0], constants[0]
    wire = running(state, of, load_table_n)
    wire_voltage_sum = 0.0
    shunt_voltage_sum = 0.0
    displacement_sum = 0.0
    force_sum = 0.0
    for _ in range(steps):
        resistance_ohm = resistance_ahead_ohm(state, dt_s)
        # The buffer amplifier drives wire, shunt and leads in series.
        current = drive_voltage_v / (resistance_ohm + of.series_resistance_ohm)
        wire_voltage_sum += current * resistance_ohm
        shunt_voltage_sum += current * of.shunt_resistance_ohm
        contraction, stress_pa = state.contraction, state.stress_pa
        step(wire, current * current * resistance_ohm, dt_s)
        # The mean over a step, as for the voltages: else strain would lag resistance by a step.
        displacement_sum += 0.5 * (contraction + state.contraction) * of.leg_length_m
        force_sum += 0.5 * (stress_pa + state.stress_pa) * of.legs * of.area_m2
    # Time would gather rounding errors if it were added up step by step.
    state.time_s += steps * dt_s
    return wire_voltage_sum / steps, shunt_voltage_sum / steps, displacement_sum / steps, force_sum / steps
