"""From a wire, a bench and the parts at the connector to wires that can run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from musclewire.errors import CallerError
from musclewire.parameters.library import load_alloy, load_wire
from musclewire.parameters.schema import Alloy, Bench, Wire
from musclewire.rigs.load_parts import Antagonist, Contact, ParallelWire, Part, SecondFinger
from musclewire.rigs.mechanism import LARGEST_CONTRACTION, TABLE_POINTS, Mechanism, Tendon
from musclewire.rigs.simulated_wires import OneWire, SimulatedWires, TwoWires
from musclewire.simulate.loads import Load, spring_load
from musclewire.simulate.pairs import APART, OWN_SUPPLY, PARALLEL, SERIES, Grip, Pair, no_grip
from musclewire.simulate.state import WireConstants
from musclewire.simulate.wire import constants_from

__all__ = ["wires_of"]


def wires_of(
    alloy: Alloy, wire: Wire, bench: Bench, parts: Sequence[Part], mechanism: Mechanism, *, new_wire: bool
) -> SimulatedWires:
    """Return the wires of a rig, cold and at rest under the stage's pretension and whatever hangs on the connector.

    Raises CallerError for numbers that cannot belong to a wire, for a force or voltage that one does not allow, and
    for an unknown second wire.
    """

    def made(spool: Wire, metal: Alloy, load: Load, *, rubs: bool, pretension_n: float) -> WireConstants:
        allowed_n = spool.maximum_force_n.value
        if pretension_n > allowed_n:
            raise CallerError(
                f"stage and weight pull the cold wire {spool.name} with {pretension_n:g} N, "
                f"{pretension_n - allowed_n:.3g} N more than the {allowed_n:g} N it allows: a lighter weight, less "
                "pretension or a thicker wire"
            )
        around = bench.model_copy(
            update={
                "pretension_n": bench.pretension_n.model_copy(update={"value": pretension_n}),
                **({} if rubs else {"guide_friction_n": bench.guide_friction_n.model_copy(update={"value": 0.0})}),
            }
        )
        return constants_from(metal, spool, around, load=load, new_wire=new_wire)

    stage_n = bench.pretension_n.value if mechanism.stage else 0.0
    cold_n = stage_n + mechanism.added_n
    partner = next((part for part in parts if isinstance(part, (Antagonist, ParallelWire, SecondFinger))), None)
    if partner is None:
        return OneWire(made(wire, alloy, mechanism.load, rubs=True, pretension_n=cold_n))
    other = wire if partner.wire is None else load_wire(partner.wire)
    metal = alloy if partner.wire is None else load_alloy(other.alloy)
    if isinstance(partner, SecondFinger):
        both = tuple(
            made(spool, of, mechanism.load, rubs=True, pretension_n=cold_n)
            for spool, of in ((wire, alloy), (other, metal))
        )
        pair = Pair(APART, SERIES, 0.0, 1.0)
        return TwoWires((both[0], both[1]), pair, grip_between(parts, mechanism.tendon, both[0]))
    alone = spring_load(0.0)
    if isinstance(partner, Antagonist):
        if partner.voltage > other.maximum_voltage_v.value:
            raise CallerError(
                f"the antagonist's voltage of {partner.voltage:g} V is above the {other.maximum_voltage_v.value:g} V "
                f"that wire {other.name} allows"
            )
        first = made(wire, alloy, mechanism.load, rubs=True, pretension_n=cold_n)
        second = made(other, metal, alone, rubs=False, pretension_n=stage_n)
        pair = Pair(-1.0, OWN_SUPPLY, partner.voltage, first.series_resistance_ohm)
        return TwoWires((first, second), pair, no_grip())
    sections = [spool.diameter_m.value**2 for spool in (wire, other)]
    own = sections[0] / sum(sections)
    first = made(wire, alloy, mechanism.load, rubs=True, pretension_n=own * cold_n)
    second = made(other, metal, alone, rubs=False, pretension_n=(1.0 - own) * cold_n)
    return TwoWires((first, second), Pair(1.0, PARALLEL, 0.0, 1.0), no_grip())


def grip_between(parts: Sequence[Part], tendon: Tendon | None, constants: WireConstants) -> Grip:
    """Return the object between two like fingers, with the tables by which both meet it."""
    contact = next(part for part in parts if isinstance(part, Contact))
    if tendon is None:
        raise CallerError("a second finger needs a part 'finger', which it mirrors")
    displacement = np.linspace(0.0, LARGEST_CONTRACTION * constants.leg_length_m, TABLE_POINTS)
    return Grip(
        contact.stiffness,
        contact.clearance,
        float(displacement[1]),
        np.ascontiguousarray(tendon.free_endpoint_m(displacement)),
        np.ascontiguousarray(tendon.column("endpoint_compliance_m_per_n", displacement)),
        np.ascontiguousarray(tendon.column("tendon_force_per_endpoint_force", displacement)),
    )
