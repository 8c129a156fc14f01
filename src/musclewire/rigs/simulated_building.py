"""Simulated wires from a wire, a bench and the parts at the connector."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from musclewire.controllers.protection import ProtectionLimits
from musclewire.errors import CallerError
from musclewire.parameters.library import load_alloy, load_wire
from musclewire.parameters.parameter_groups import Alloy, Bench, Wire
from musclewire.physics.heat import convection_range_note
from musclewire.rigs.load_part import LoadPart, Pull, SecondWire, Supply
from musclewire.rigs.mechanism import MAX_CONTRACTION, TABLE_POINTS, Mechanism, Tendon
from musclewire.rigs.protocol import Metadata
from musclewire.rigs.wire_limits import WireCircuit, limits_of
from musclewire.wire.building import constants_from
from musclewire.wire.constants import WireConstants
from musclewire.wire.loads import ConnectorLoad, ElasticObject, spring_load
from musclewire.wire.pairs import APART, OWN_SUPPLY, PARALLEL, SERIES, Grip, Pair, no_grip
from musclewire.wire.stepping import Stepping, steps_within
from musclewire.wire.wires import OneWire, SimulatedWires, TwoWires

__all__ = [
    "Spool",
    "convection_metadata",
    "force_limit_n",
    "load_metadata",
    "require_allowed_pull",
    "simulated_limits",
    "stepping_of",
    "wires_of",
]

# Noise in steps of the converter times the root of the readings in a mean: from this value on, two means in a row are
# equal in less than a tenth of all cases, and eight in a row once in a hundred million.
MIN_SPREAD_STEPS = 3.0

# Codes of pulls and supplies in the kernel of two wires.
DIRECTIONS = {Pull.ALONG: 1.0, Pull.AGAINST: -1.0, Pull.APART: APART}
FEEDS = {Supply.OWN: OWN_SUPPLY, Supply.PARALLEL: PARALLEL, Supply.SERIES: SERIES}


def wires_of(
    alloy: Alloy, wire: Wire, bench: Bench, parts: Sequence[LoadPart], mechanism: Mechanism, *, new_wire: bool
) -> SimulatedWires:
    """Return the wires of a rig, cold and at rest under the stage's pretension and the weights on the connector.

    Raises CallerError for numbers that cannot belong to a wire, for a force or voltage that one does not allow, and
    for an unknown second wire.
    """
    first = Spool(wire, alloy, bench, new_wire)
    stage_n = bench.pretension_n.value if mechanism.stage else 0.0
    cold_n = stage_n + mechanism.added_n
    second = second_wire_of(parts)
    if second is None:
        return OneWire(first.pulling(mechanism.load, cold_n))
    other = wire if second.wire is None else load_wire(second.wire)
    require_voltage(second, other)
    spool = Spool(other, alloy if second.wire is None else load_alloy(other.alloy), bench, new_wire)
    if second.pull is Pull.APART:
        one, two = (item.pulling(mechanism.load, cold_n) for item in (first, spool))
        grip = grip_between(parts, mechanism.tendon, one)
    elif second.pull is Pull.AGAINST:
        one, two, grip = first.pulling(mechanism.load, cold_n), spool.pulling(None, stage_n), no_grip()
    else:
        sections = [item.diameter_m.value**2 for item in (wire, other)]
        own = sections[0] / sum(sections)
        one, two = first.pulling(mechanism.load, own * cold_n), spool.pulling(None, (1.0 - own) * cold_n)
        grip = no_grip()
    series_ohm = one.series_resistance_ohm if second.supply is Supply.OWN else 1.0
    return TwoWires((one, two), Pair(DIRECTIONS[second.pull], FEEDS[second.supply], second.voltage_v, series_ohm), grip)


def second_wire_of(parts: Sequence[LoadPart]) -> SecondWire | None:
    """Return the second wire that a part adds, if one does."""
    return next((part.second_wire for part in parts if part.second_wire is not None), None)


def force_limit_n(wire: Wire, parts: Sequence[LoadPart]) -> float:
    """Return the largest reading of the load cell at which no wire of a rig exceeds its allowed force [N].

    The load cell reads parallel wires together, and the force is divided by their cross sections, as when cold. In
    other arrangements each wire pulls about the reading: an antagonist on the same connector, or a second finger's wire
    against the same object.
    """
    second = second_wire_of(parts)
    own_n = wire.maximum_force_n.value
    if second is None:
        return own_n
    other = wire if second.wire is None else load_wire(second.wire)
    other_n = other.maximum_force_n.value
    if second.pull is not Pull.ALONG:
        return min(own_n, other_n)
    sections = [spool.diameter_m.value**2 for spool in (wire, other)]
    return min(own_n / sections[0], other_n / sections[1]) * sum(sections)


def simulated_limits(
    alloy: Alloy, wire: Wire, bench: Mapping[str, float], parts: Sequence[LoadPart], changed: Mapping[str, float] | None
) -> ProtectionLimits:
    """Return the limits of a simulated rig's protection. Raises CallerError for numbers that cannot belong together."""
    maximum_v = wire.maximum_voltage_v.value
    second = second_wire_of(parts)
    supply = None if second is None else second.supply
    if bench["sense_voltage_v"] >= maximum_v:
        raise CallerError(f"sense_voltage_v {bench['sense_voltage_v']} V must be below maximum_voltage_v {maximum_v} V")
    step_v = 2.0 * bench["acquisition_range_v"] / 2.0 ** bench["acquisition_bits"]
    circuit = WireCircuit(
        sense_voltage_v=bench["sense_voltage_v"],
        maximum_voltage_v=maximum_v,
        shunt_resistance_ohm=bench["shunt_resistance_ohm"],
        wire_length_m=bench["wire_length_m"],
        ambient_temperature_k=bench["ambient_temperature_k"],
        sample_period_s=bench["sample_period_s"],
        wire_range_v=bench["acquisition_range_v"],
        shunt_range_v=bench["acquisition_range_v"],
        readings_noisy=bench["acquisition_noise_v"] / step_v * bench["acquisition_readings"] ** 0.5 >= MIN_SPREAD_STEPS,
        in_series=2 if supply is Supply.SERIES else 1,
        in_parallel=2 if supply is Supply.PARALLEL else 1,
    )
    return limits_of(wire, alloy, circuit, changed)


def stepping_of(bench: Mapping[str, float]) -> Stepping:
    """Return how a bench's samples are divided into steps. Raises CallerError for a step that does not divide them."""
    stepping = Stepping(
        bench["time_step_s"],
        bench["temperature_tolerance_k"],
        bench["resistance_tolerance"],
        bench["strain_tolerance"],
    )
    steps_within(stepping, bench["sample_period_s"])
    return stepping


class Spool(NamedTuple):
    """A wire, its alloy, its bench, and whether it starts before its first cycles (shakedown)."""

    wire: Wire
    alloy: Alloy
    bench: Bench
    new_wire: bool = False

    def pulling(self, load: ConnectorLoad | None, pretension_n: float) -> WireConstants:
        """Return the constants of this wire at a cold force; without a load it acts on another wire's connector only.

        Raises CallerError for a pull that the wire does not allow.
        """
        require_allowed_pull(pretension_n, self.wire.maximum_force_n.value, self.wire.name)
        changed = {"pretension_n": pretension_n}
        if load is None:  # the guide's friction belongs to the first wire
            changed["guide_friction_n"] = 0.0
        known = {name: getattr(self.bench, name).model_copy(update={"value": value}) for name, value in changed.items()}
        around = self.bench.model_copy(update=known)
        return constants_from(self.alloy, self.wire, around, load=load or spring_load(0.0), new_wire=self.new_wire)


def require_allowed_pull(pretension_n: float, allowed_n: float, name: str) -> None:
    """Raise CallerError if stage and weights pull a cold wire harder than it allows."""
    if pretension_n > allowed_n:
        raise CallerError(
            f"stage and weight pull the cold wire {name} with {pretension_n:g} N, "
            f"{pretension_n - allowed_n:.3g} N more than the {allowed_n:g} N it allows: a lighter weight, less "
            "pretension or a thicker wire"
        )


def require_voltage(second: SecondWire, wire: Wire) -> None:
    """Raise CallerError if the voltage of an own supply is above the wire's maximum."""
    if second.voltage_v > wire.maximum_voltage_v.value:
        raise CallerError(
            f"the antagonist's voltage of {second.voltage_v:g} V is above the {wire.maximum_voltage_v.value:g} V "
            f"that wire {wire.name} allows: lower it"
        )


def grip_between(parts: Sequence[LoadPart], tendon: Tendon | None, constants: WireConstants) -> Grip:
    """Return the object between two like fingers, with the tables of both fingers' endpoints."""
    between: ElasticObject | None = next((part.obstacle for part in parts if part.obstacle is not None), None)
    if between is None:
        raise CallerError("a second finger needs a part 'contact' between it and the first")
    if tendon is None:
        raise CallerError("a second finger needs a part 'finger', which it mirrors")
    displacement = np.linspace(0.0, MAX_CONTRACTION * constants.leg_length_m, TABLE_POINTS)
    return Grip(
        between.stiffness_n_per_m,
        between.clearance_m,
        float(displacement[1]),
        np.ascontiguousarray(tendon.free_endpoint_m(displacement)),
        np.ascontiguousarray(tendon.column("endpoint_compliance_m_per_n", displacement)),
        np.ascontiguousarray(tendon.column("tendon_force_per_endpoint_force", displacement)),
    )


def convection_metadata(diameter_m: float, ambient_temperature_k: float) -> Metadata:
    """Return a note for wires so thin that the convection correlation leaves its published range near the air."""
    note = convection_range_note(diameter_m, ambient_temperature_k)
    return {"convection_note": note} if note else {}


def load_metadata(parts: Sequence[LoadPart], mechanism: Mechanism, two_wires: bool) -> Metadata:
    """Return the metadata of a recording that describe a wire's load."""
    stiffness = mechanism.load.stiffness_n_per_m
    if not parts:
        return {"spring_stiffness_n_per_m": stiffness}
    plain = all(part.is_straight for part in parts)
    named: Metadata = {"load": ", ".join(part.part for part in parts)}
    for part in parts:
        named |= part.facts()
    if two_wires:
        named["wires"] = 2
    return {**named, "spring_stiffness_n_per_m": stiffness} if plain else named
