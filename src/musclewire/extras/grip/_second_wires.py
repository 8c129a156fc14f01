"""Second wires as parts of a load: against the first, parallel to it, or on a finger of its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import Field

from musclewire.parameters import Wire, load_wire
from musclewire.rigs import LoadPart
from musclewire.signals import measured_in

if TYPE_CHECKING:
    from musclewire.wire import SimulatedWires

Voltage = Annotated[float, measured_in("V"), Field(ge=0.0, allow_inf_nan=False)]


class CoupledWire(NamedTuple):
    """A second wire: its name (None for one like the first), how it pulls, how it is fed, an own supply's voltage."""

    wire: str | None
    pull: Literal["along", "against", "apart"]
    feed: Literal["own", "parallel", "series"]
    voltage_v: float = 0.0

    @property
    def on_the_drive(self) -> tuple[int, int]:
        """How many wires the drive sees in series and in parallel."""
        return 1 + (self.feed == "series"), 1 + (self.feed == "parallel")

    @property
    def holds_the_object(self) -> bool:
        """Whether it pulls a finger of its own, with the load's object between that and the first."""
        return self.pull == "apart"

    def force_limit_n(self, first: Wire) -> float:
        """Return the largest reading of the load cell at which neither wire exceeds its allowed force.

        The load cell reads parallel wires together, and the force is divided by their cross sections, as when cold. In
        other arrangements each wire pulls about the reading: an antagonist on the same connector, or a second finger's
        wire against the same object.
        """
        wires = (first, first if self.wire is None else load_wire(self.wire))
        if self.pull != "along":
            return min(wire.maximum_force_n.value for wire in wires)
        sections = [wire.diameter_m.value**2 for wire in wires]
        return min(wire.maximum_force_n.value / own for wire, own in zip(wires, sections, strict=True)) * sum(sections)

    def coupled(self, first: Any, parts: Sequence[LoadPart], mechanism: Any, stage_n: float) -> SimulatedWires:
        """Return both wires, cold and at rest under the stage's pretension [N]."""
        from musclewire.extras.grip._two_wires import coupled_wires  # the simulator is loaded when a rig is opened

        return coupled_wires(self, first, parts, mechanism, stage_n)


class Antagonist(LoadPart):
    """A second wire of the same make and length that pulls against the first, from a supply of its own.

    Parameters
    ----------
    wire
        Name of the second wire; None for one like the first.
    voltage
        Drive voltage of the second wire [V], constant; 0 leaves it cold.
    """

    once: ClassVar[bool] = True

    part: Literal["antagonist"]
    wire: str | None = None
    voltage: Voltage = 0.0

    @property
    def carries_pretension(self) -> bool:
        """The stage pulls one wire against the other."""
        return True

    @property
    def second_wire(self) -> CoupledWire:
        """The wire that pulls against the first."""
        return CoupledWire(self.wire, "against", "own", self.voltage)


class ParallelWire(LoadPart):
    """A second wire parallel to the first, on the same connector and the same two terminals.

    Parameters
    ----------
    wire
        Name of the second wire; None for one like the first.
    """

    once: ClassVar[bool] = True

    part: Literal["parallel wire"]
    wire: str | None = None

    @property
    def second_wire(self) -> CoupledWire:
        """The wire parallel to the first."""
        return CoupledWire(self.wire, "along", "parallel")


class SecondFinger(LoadPart):
    """A finger like the first, opposite to it, on a wire of its own in the same current; needs a contact between.

    Parameters
    ----------
    wire
        Name of the second finger's wire; None for one like the first.
    """

    once: ClassVar[bool] = True

    part: Literal["second finger"]
    wire: str | None = None

    @property
    def second_wire(self) -> CoupledWire:
        """The wire of the other finger."""
        return CoupledWire(self.wire, "apart", "series")

    def misfit(self, parts: Sequence[LoadPart]) -> str | None:
        """Return what is missing of a finger, which this one mirrors, and a contact, which both meet."""
        finger = any(part.finger_name is not None for part in parts)
        if finger and any(part.obstacle is not None for part in parts):
            return None
        return "a second finger needs a part 'finger', which it mirrors, and a 'contact' between them"
