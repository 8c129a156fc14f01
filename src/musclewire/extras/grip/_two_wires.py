"""Two coupled wires of a simulated rig over time, and how they are built from the parts of its load."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from musclewire.errors import CallerError
from musclewire.extras.grip._coupling import SEPARATE, GrippedObject, no_grip
from musclewire.extras.grip._pairs import OWN_SUPPLY, PARALLEL, SERIES, PairConnection, advance_pair
from musclewire.parameters import Wire, load_alloy, load_wire
from musclewire.rigs import FingerTendon, LoadPart, SimulatedLoad, SimulatedSpool, tabulated_m
from musclewire.wire import (
    CHOSEN,
    SimulatedWires,
    StepControl,
    WireConstants,
    WireMeans,
    WireState,
    aged,
    require_resolved,
    resting_state,
)

# Codes of pulls and feeds in the kernel.
DIRECTIONS = {"along": 1.0, "against": -1.0, "apart": SEPARATE}
FEEDS = {"own": OWN_SUPPLY, "parallel": PARALLEL, "series": SERIES}


class TwoWires:
    """Two coupled wires; the load and the circuit are the first one's."""

    def __init__(
        self, constants: tuple[WireConstants, WireConstants], pair: PairConnection, grip: GrippedObject
    ) -> None:
        """Cool both wires under their pretension."""
        self._both = constants
        self._states = (resting_state(constants[0]), resting_state(constants[1]))
        self._pair, self._grip = pair, grip
        self._last = (CHOSEN, 0.0)
        self._still_factors = tuple(one.convection_factor for one in constants)

    @property
    def state(self) -> WireState:
        """State of the first wire."""
        return self._states[0]

    @property
    def partner_state(self) -> WireState:
        """State of the second wire."""
        return self._states[1]

    @property
    def time_s(self) -> float:
        """Time since the wires were first at rest [s]."""
        return self._states[0].time_s

    @property
    def slack_m(self) -> float:
        """The larger of both lengths [m]; 0 on a common connector, where a slack wire is moved by the other one."""
        if self._pair.direction != SEPARATE:
            return 0.0
        return max(state.slack * one.leg_length_m for state, one in zip(self._states, self._both, strict=True))

    @property
    def step_error_k(self) -> float:
        """The larger of both errors [K]."""
        return max(state.step_error_k for state in self._states)

    def advance(self, drive_voltage_v: float, duration_s: float, stepping: StepControl) -> WireMeans:
        """Advance by one sample at one drive voltage."""
        self._last = (stepping, duration_s)
        self._states, means = advance_pair(
            self._states, self._both, self._pair, self._grip, drive_voltage_v, duration_s, stepping
        )
        together_n = means.force_n + means.second_force_n if self._pair.direction > 0.0 else means.force_n
        return WireMeans(
            means.wire_voltage_v,
            means.shunt_voltage_v,
            means.displacement_m,
            together_n,
            means.grip_n,
        )

    def require_resolved(self) -> None:
        """Raise NumericsError if steps of a wire were unsolved or too long."""
        for state in self._states:
            require_resolved(state, *self._last)

    def surround(self, ambient_temperature_k: float, convection_ratio: float) -> None:
        """Change the temperature and the convection of the air around both wires from now on."""
        first, second = (
            one.replace(ambient_temperature_k=ambient_temperature_k, convection_factor=factor * convection_ratio)
            for one, factor in zip(self._both, self._still_factors, strict=True)
        )
        self._both = (first, second)

    def age_like(self, before: SimulatedWires) -> None:
        """Take over clock and cycles from the wires at the previous setting."""
        assert isinstance(before, TwoWires)  # another setting of one rig: its parts are the same
        first, state = aged(self._both[0], before.state)
        second, other = aged(self._both[1], before.partner_state)
        self._both, self._states = (first, second), (state, other)


def coupled_wires(
    second: Any, first: SimulatedSpool, parts: Sequence[LoadPart], mechanism: SimulatedLoad, stage_n: float
) -> TwoWires:
    """Return both wires of a rig, cold and at rest; CallerError for a force or voltage that one does not allow."""
    wire, cold_n = first.wire, stage_n + mechanism.added_n
    other = wire if second.wire is None else load_wire(second.wire)
    require_voltage(second.voltage_v, other)
    spool = first._replace(wire=other, alloy=first.alloy if second.wire is None else load_alloy(other.alloy))
    grip = no_grip()
    if second.pull == "apart":
        one, two = (item.pulling(mechanism.load, cold_n) for item in (first, spool))
        grip = grip_between(parts, mechanism.tendon, one)
    elif second.pull == "against":
        one, two = first.pulling(mechanism.load, cold_n), spool.pulling(None, stage_n)
    else:
        sections = [item.diameter_m.value**2 for item in (wire, other)]
        own = sections[0] / sum(sections)
        one, two = first.pulling(mechanism.load, own * cold_n), spool.pulling(None, (1.0 - own) * cold_n)
    series_ohm = one.series_resistance_ohm if second.feed == "own" else 1.0
    return TwoWires(
        (one, two), PairConnection(DIRECTIONS[second.pull], FEEDS[second.feed], second.voltage_v, series_ohm), grip
    )


def require_voltage(voltage_v: float, wire: Wire) -> None:
    """Raise CallerError if the voltage of an own supply is above the wire's maximum."""
    if voltage_v > wire.maximum_voltage_v.value:
        raise CallerError(
            f"the antagonist's voltage of {voltage_v:g} V is above the {wire.maximum_voltage_v.value:g} V "
            f"that wire {wire.name} allows: lower it"
        )


def grip_between(parts: Sequence[LoadPart], tendon: FingerTendon | None, constants: WireConstants) -> GrippedObject:
    """Return the object between two like fingers, with the tables of both fingers' endpoints."""
    between = next((part.obstacle for part in parts if part.obstacle is not None), None)
    if between is None:
        raise CallerError("a second finger needs a part 'contact' between it and the first")
    if tendon is None:
        raise CallerError("a second finger needs a part 'finger', which it mirrors")
    displacement = tabulated_m(constants.leg_length_m)
    return GrippedObject(
        between.stiffness_n_per_m,
        between.clearance_m,
        float(displacement[1]),
        np.ascontiguousarray(tendon.free_endpoint_m(displacement)),
        np.ascontiguousarray(tendon.column("endpoint_compliance_m_per_n", displacement)),
        np.ascontiguousarray(tendon.column("tendon_force_per_endpoint_force", displacement)),
    )
