"""The wires of a simulated rig over time, one or two in their driving circuit, behind one interface.

The circuit of one wire is a buffer amplifier, wire, shunt and leads in series.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.simulate.pairs import Grip, Pair, advance_pair
from musclewire.wire.building import resting_state
from musclewire.wire.state import Rows, WireConstants, WireState
from musclewire.wire.step import resistance_ahead_ohm, running, step

__all__ = ["WireMeans", "advance", "advance_rows", "SampleMeans", "OneWire", "SimulatedWires", "TwoWires"]


class WireMeans(NamedTuple):
    """Means over one call of :func:`advance`: what an averaging acquisition card measures.

    Parameters
    ----------
    wire_voltage_v
        Voltage of the wire [V].
    shunt_voltage_v
        Voltage of the shunt [V].
    displacement_m
        Displacement of the connector [m], positive for a shorter wire.
    force_n
        Force of all legs together [N].
    """

    wire_voltage_v: float
    shunt_voltage_v: float
    displacement_m: float
    force_n: float


def advance(
    state: WireState, constants: WireConstants, drive_voltage_v: float, dt_s: float, steps: int
) -> tuple[WireState, WireMeans]:
    """Return the state after ``steps`` steps of ``dt_s`` at one drive voltage, and the means over these steps.

    The state passed in is not changed. Energy is conserved to rounding: enthalpy changes by heat in minus heat
    out, and temperature follows from enthalpy and phase fractions.

    Parameters
    ----------
    state
        The wire before the first step.
    constants
        Its constants, with the load's table.
    drive_voltage_v
        Drive voltage of the buffer amplifier [V], the same in all steps.
    dt_s
        Length of a step [s]; the shipped benches take 1 ms, see docs/explanation/numerics.md.
    steps
        How many steps, 1 or more.

    Returns
    -------
    The state after the last step, and the means over all steps.

    References
    ----------
    The circuit is that of Lan and Fan 2010, Fig. 2.
    """
    after = state.copy()
    # Arrays go into compiled code and plain numbers come back. Numba would call the class of a named tuple on the way
    # out; a Ctrl-C that arrives during that call is not handled, and the process dies.
    means = advance_rows(after.row, constants.row, constants.load_table_n, drive_voltage_v, dt_s, steps)
    return after, WireMeans(*means)


@compiled
def advance_rows(
    states: Rows, constants: Rows, load_table_n: FloatArray, drive_voltage_v: float, dt_s: float, steps: int
) -> tuple[float, float, float, float]:
    """Advance a wire in place, arrays of one record, (1,); return the means of :func:`advance`."""
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
        # The mean over a step, as for the voltages: otherwise strain would lag resistance by a step.
        displacement_sum += 0.5 * (contraction + state.contraction) * of.leg_length_m
        force_sum += 0.5 * (stress_pa + state.stress_pa) * of.legs * of.area_m2
    # Adding up time step by step would accumulate rounding errors.
    state.time_s += steps * dt_s
    return wire_voltage_sum / steps, shunt_voltage_sum / steps, displacement_sum / steps, force_sum / steps


class SampleMeans(NamedTuple):
    """Means over a sample: what averaging instruments measure; ``grip_n`` is None with one wire.

    Force is that of both wires if they pull together, otherwise of the first one.
    """

    wire_voltage_v: float
    shunt_voltage_v: float
    displacement_m: float
    force_n: float
    grip_n: float | None = None


class SimulatedWires(Protocol):
    """One wire or two, with their present state."""

    @property
    def state(self) -> WireState:
        """State of the wire whose voltages are measured, the first of two."""
        ...

    @property
    def partner_state(self) -> WireState | None:
        """State of the second wire; None if there is one wire."""
        ...

    def advance(self, drive_voltage_v: float, dt_s: float, steps: int) -> SampleMeans:
        """Advance by some steps at one drive voltage.

        Parameters
        ----------
        drive_voltage_v
            Drive voltage [V] during all of the steps.
        dt_s
            Length of a step [s].
        steps
            Number of steps in one sample period.

        Returns
        -------
        Means over the steps, as averaging instruments measure them.
        """
        ...

    def surround(self, ambient_temperature_k: float, convection_ratio: float) -> None:
        """Change the temperature and the convection of the air from now on.

        Parameters
        ----------
        ambient_temperature_k
            Temperature of the air [K].
        convection_ratio
            Loss to the air as a multiple of that in still air.
        """
        ...

    def age_like(self, before: SimulatedWires) -> None:
        """Take over clock and cycles from the wires at the previous setting.

        Parameters
        ----------
        before
            Wires of the same kind, one or two, at another setting of the stages.
        """
        ...


def aged(constants: WireConstants, before: WireState) -> tuple[WireConstants, WireState]:
    """Return a wire at rest with the clock and cycles of another, its instruments zeroed at this setting."""
    # The length that a new wire has gained until now belongs to the new zero.
    remaining = math.exp(-before.cycles / constants.shakedown_cycles)
    gained = constants.shakedown_strain * (1.0 - remaining)
    zeroed = constants.replace(cold_strain=constants.cold_strain + gained)
    return zeroed, resting_state(zeroed).replace(time_s=before.time_s, cycles=before.cycles)


class OneWire:
    """A wire on its load."""

    partner_state: WireState | None = None

    def __init__(self, constants: WireConstants) -> None:
        """Cool the wire under its pretension."""
        self.constants = constants
        self.state = resting_state(constants)
        self._still_factor = constants.convection_factor

    def advance(self, drive_voltage_v: float, dt_s: float, steps: int) -> SampleMeans:
        """Advance by some steps at one drive voltage."""
        self.state, means = advance(self.state, self.constants, drive_voltage_v, dt_s, steps)
        return SampleMeans(*means)

    def surround(self, ambient_temperature_k: float, convection_ratio: float) -> None:
        """Change the temperature and the convection of the air from now on."""
        self.constants = self.constants.replace(
            ambient_temperature_k=ambient_temperature_k, convection_factor=self._still_factor * convection_ratio
        )

    def age_like(self, before: SimulatedWires) -> None:
        """Take over clock and cycles from the wire at the previous setting."""
        self.constants, self.state = aged(self.constants, before.state)


class TwoWires:
    """Two coupled wires; the load and the circuit are the first one's."""

    def __init__(self, constants: tuple[WireConstants, WireConstants], pair: Pair, grip: Grip) -> None:
        """Cool both wires under their pretension."""
        self._both = constants
        self._states = (resting_state(constants[0]), resting_state(constants[1]))
        self._pair, self._grip = pair, grip
        self._still_factors = tuple(one.convection_factor for one in constants)

    @property
    def state(self) -> WireState:
        """State of the first wire."""
        return self._states[0]

    @property
    def partner_state(self) -> WireState:
        """State of the second wire."""
        return self._states[1]

    def advance(self, drive_voltage_v: float, dt_s: float, steps: int) -> SampleMeans:
        """Advance by some steps at one drive voltage."""
        self._states, means = advance_pair(
            self._states, self._both, self._pair, self._grip, drive_voltage_v, dt_s, steps
        )
        together_n = means.force_n + means.partner_force_n if self._pair.direction > 0.0 else means.force_n
        return SampleMeans(
            means.wire_voltage_v,
            means.shunt_voltage_v,
            means.displacement_m,
            together_n,
            means.grip_n,
        )

    def surround(self, ambient_temperature_k: float, convection_ratio: float) -> None:
        """Change the temperature and the convection of the air around both wires from now on."""
        first, second = (
            one.replace(ambient_temperature_k=ambient_temperature_k, convection_factor=factor * convection_ratio)
            for one, factor in zip(self._both, self._still_factors, strict=True)
        )
        self._both = (first, second)

    def age_like(self, before: SimulatedWires) -> None:
        """Take over clock and cycles from the wires at the previous setting."""
        partner = before.partner_state
        assert partner is not None  # another setting of one rig: its parts are the same
        first, state = aged(self._both[0], before.state)
        second, other = aged(self._both[1], partner)
        self._both, self._states = (first, second), (state, other)
