"""The wires of a simulated rig over time in their driving circuit, behind one interface; and one wire.

The circuit of one wire is a buffer amplifier, wire, shunt and leads in series.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.wire._building import resting_state
from musclewire.wire._row import Rows, WireConstants, WireState
from musclewire.wire._step import RunningWire
from musclewire.wire._stepping import (
    CHOSEN,
    VOLTAGE,
    SourceOutput,
    StepControl,
    advance_wire,
    are_resolved,
    plan_of,
    require_resolved,
)


class WireMeans(NamedTuple):
    """Means over a sample: what an averaging acquisition card measures."""

    wire_voltage_v: float
    shunt_voltage_v: float
    displacement_m: float  # of the connector, positive for a shorter wire
    force_n: float  # of all legs: of both wires if they pull together, otherwise of the first one
    grip_n: float | None = None  # between each endpoint and the object; None with one wire


def advance(
    state: WireState,
    constants: WireConstants,
    drive_voltage_v: float,
    duration_s: float,
    stepping: StepControl = CHOSEN,
) -> tuple[WireState, WireMeans]:
    """Return the state after a time at one drive voltage, and the means over that time; the one passed in stays.

    Energy is conserved to rounding: enthalpy changes by heat in minus heat out, and temperature follows from enthalpy
    and phase fractions.

    References
    ----------
    The circuit is that of Lan and Fan 2010, Fig. 2.
    """
    plan = plan_of(stepping, duration_s)
    after = state.copy()
    # Arrays go into compiled code and plain numbers come back. Numba would call the class of a named tuple on the way
    # out; a Ctrl-C that arrives during that call is not handled, and the process dies.
    means = advance_rows(after.row, *constants.step_arrays(), drive_voltage_v, plan)
    return after, WireMeans(*means)


@compiled
def advance_rows(
    states: Rows,
    constants: Rows,
    cells: Rows,
    load: Rows,
    drive_voltage_v: float,
    plan: FloatArray,
) -> tuple[float, float, float, float]:
    """Advance a wire in place, arrays of one record, (1,); return the means of :func:`advance`."""
    return advance_wire(
        RunningWire(states[0], constants[0], cells[0], load[0]), SourceOutput(drive_voltage_v, VOLTAGE), plan
    )


def aged(constants: WireConstants, before: WireState) -> tuple[WireConstants, WireState]:
    """Return a wire at rest with the clock and cycles of another, its instruments zeroed at this setting."""
    # The length that a new wire has gained until now belongs to the new zero.
    remaining = math.exp(-before.cycles / constants.shakedown_cycles)
    gained = constants.shakedown_strain * (1.0 - remaining)
    zeroed = constants.replace(cold_strain=constants.cold_strain + gained)
    return zeroed, resting_state(zeroed).replace(time_s=before.time_s, cycles=before.cycles)


# Places of both contractions among the plain numbers of a state, before its arrays: a field takes ten times as long.
CONTRACTION, CONNECTOR = (
    [item.name for item in WireState.fields].index(name) for name in ("contraction", "connector_contraction")
)


class SimulatedWires(Protocol):
    """One wire, or several that are coupled; load and circuit are the first one's."""

    @property
    def state(self) -> WireState:
        """State of the first wire."""

    @property
    def partner_state(self) -> WireState | None:
        """State of a second wire; None without one."""

    @property
    def time_s(self) -> float:
        """Time since the wires were first at rest [s]."""

    @property
    def slack_m(self) -> float:
        """Length by which friction holds a connector ahead of its slack wire [m]."""

    @property
    def step_error_k(self) -> float:
        """Largest estimated error of a step in temperature since the wires were at rest [K]."""

    def advance(self, drive_voltage_v: float, duration_s: float, stepping: StepControl) -> WireMeans:
        """Advance by one sample at one drive voltage."""

    def require_resolved(self) -> None:
        """Raise NumericsError if steps were unsolved or too long."""

    def surround(self, ambient_temperature_k: float, convection_ratio: float) -> None:
        """Change the temperature and the convection of the air from now on."""

    def age_like(self, before: SimulatedWires) -> None:
        """Take over clock and cycles from the wires at the previous setting."""


class OneWire:
    """A wire on its load. It runs in place; a state that was handed out is left alone and copied first."""

    partner_state: WireState | None = None

    def __init__(self, constants: WireConstants) -> None:
        """Cool the wire under its pretension."""
        self._last = (CHOSEN, 0.0)
        self._stand_at(constants, resting_state(constants))

    def _stand_at(self, constants: WireConstants, state: WireState) -> None:
        """Take constants, those of still air, and a state of one's own."""
        self._state, self._handed_out = state, False
        self.constants, self._leg_length_m = constants, constants.leg_length_m
        derived, *tables = constants.step_arrays()
        self._derived, (self._cells, self._load) = derived.copy(), tables

    @property
    def state(self) -> WireState:
        """The present state; it does not change any more."""
        self._handed_out = True
        return self._state

    @property
    def time_s(self) -> float:
        """Time since the wire was first at rest [s]."""
        return float(self._state.numbers[0])

    @property
    def slack_m(self) -> float:
        """Length by which friction holds the connector ahead of the slack wire [m]."""
        numbers = self._state.numbers
        return float(numbers[CONNECTOR] - numbers[CONTRACTION]) * self._leg_length_m

    @property
    def step_error_k(self) -> float:
        """Largest estimated error of a step in temperature since the wire was at rest [K]."""
        return float(self._state.step_error_k)

    def advance(self, drive_voltage_v: float, duration_s: float, stepping: StepControl) -> WireMeans:
        """Advance by one sample at one drive voltage."""
        if self._handed_out:
            self._state, self._handed_out = self._state.copy(), False
        self._last = (stepping, duration_s)
        plan = plan_of(stepping, duration_s)
        means = advance_rows(self._state.row, self._derived, self._cells, self._load, drive_voltage_v, plan)
        return WireMeans(*means)

    def adopt_compiled_state(self, states: Rows, constants: Rows) -> None:
        """Take the state that samples in compiled code have left behind, (1,), and the constants in the air then."""
        numbers: FloatArray = states.view(np.float64)
        self._state, self._handed_out, self._derived = WireState(numbers, states.dtype), False, constants

    def require_resolved(self) -> None:
        """Raise NumericsError if steps were unsolved or too long."""
        if not are_resolved(self._state.row):
            require_resolved(self._state, *self._last)

    def surround(self, ambient_temperature_k: float, convection_ratio: float) -> None:
        """Change the temperature and the convection of the air from now on."""
        self._derived["ambient_temperature_k"] = ambient_temperature_k
        self._derived["surface_factor_m2"] = self.surface_factor_m2(convection_ratio)

    def surface_factor_m2(self, convection_ratio: float) -> float:
        """Return surface times convection factor [m2] for a loss to the air as a multiple of that in still air."""
        return self.constants.surface_m2 * (self.constants.convection_factor * convection_ratio)

    def age_like(self, before: SimulatedWires) -> None:
        """Take over clock and cycles from the wire at the previous setting."""
        self._stand_at(*aged(self.constants, before.state))
