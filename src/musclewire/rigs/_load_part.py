"""The base class of every part of a load, with the contributions that a part at a wire's connector may make."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Protocol, Self

from pydantic import BaseModel, ConfigDict, Field

from musclewire.arrays import FloatArray
from musclewire.parameters import FingerFile, Wire
from musclewire.rigs._device import Metadata
from musclewire.signals import measured_in
from musclewire.wire import ElasticObject

if TYPE_CHECKING:
    from musclewire.wire import SimulatedWires

Stiffness = Annotated[float, measured_in("N/m"), Field(gt=0.0, allow_inf_nan=False)]
Length = Annotated[float, measured_in("m"), Field(ge=0.0, allow_inf_nan=False)]
Force = Annotated[float, measured_in("N"), Field(gt=0.0, allow_inf_nan=False)]


class SecondWire(Protocol):
    """A second wire that a part adds: coupled with the first by the circuit, and by its connector or an object."""

    @property
    def on_the_drive(self) -> tuple[int, int]:
        """How many wires the drive sees in series and in parallel."""

    @property
    def holds_the_object(self) -> bool:
        """Whether it pulls a finger of its own, with the load's object between that and the first."""

    def force_limit_n(self, first: Wire) -> float:
        """Return the largest reading of the load cell at which neither wire exceeds its allowed force [N]."""

    def coupled(self, first: Any, parts: Sequence[LoadPart], mechanism: Any, stage_n: float) -> SimulatedWires:
        """Return both wires, cold and at rest under the stage's pretension [N].

        ``first`` is the first one's ``SimulatedSpool``. Raises CallerError for an unknown wire, and for a force or
        voltage that one does not allow.
        """


class LoadPart(BaseModel):
    """A part at the connector of a simulated wire, as a table ``[[load]]`` of a rig file.

    A part of one's own is a subclass with ``part: Literal["its name"]``, its keys as fields, and those of the methods
    below that describe its contribution; ``LOAD_PARTS.register("its name", Class)`` or ``load_parts`` of a
    package's manifest makes it known to rig files.

    Parameters
    ----------
    part
        Name of the kind in rig files.

    Attributes
    ----------
    once
        Whether a rig has room for one part of the kind only.
    is_straight
        Whether the recording's stiffness describes the part completely.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    once: ClassVar[bool] = False
    is_straight: ClassVar[bool] = False

    part: str

    @property
    def carries_pretension(self) -> bool:
        """Whether the linear stage pulls against this part, so that a finger need not carry the pretension."""
        return False

    @property
    def stiffness_n_per_m(self) -> float:
        """Stiffness that it adds at the connector over the whole stroke [N/m]."""
        return 0.0

    @property
    def hanging_force_n(self) -> float:
        """Force that it adds to the pretension at any displacement [N]."""
        return 0.0

    def force_n(self, displacement_m: FloatArray) -> FloatArray | None:  # noqa: ARG002  parts use it
        """Return the force that it adds beyond pretension and stiffness [N], 0 in the beginning; None if it adds none.

        Parameters
        ----------
        displacement_m
            Displacement of the connector [m], (n,), rising from 0.

        Returns
        -------
        The force [N], (n,).
        """
        return None

    def friction_n(self, displacement_m: FloatArray) -> FloatArray | None:  # noqa: ARG002  parts use it
        """Return the largest friction that it adds to the guide's [N]; None if it adds none.

        Parameters
        ----------
        displacement_m
            Displacement of the connector [m], (n,), rising from 0.

        Returns
        -------
        The friction [N], (n,), not below 0.
        """
        return None

    @property
    def finger_name(self) -> str | None:
        """Name or file of the tendon-driven finger that it puts at the connector."""
        return None

    @property
    def tendon_slack_m(self) -> float:
        """Displacement before the tendon of its finger pulls [m]."""
        return 0.0

    def finger_file(self) -> FingerFile | None:
        """Return its finger, read from its file; None if it has none. Raises CallerError for an unusable file."""
        return None

    @property
    def obstacle(self) -> ElasticObject | None:
        """Object that it puts in the way."""
        return None

    def with_obstacle(self, obstacle: ElasticObject) -> Self:  # noqa: ARG002  parts use it
        """Return the part with another object in the way; a part without one as it is.

        Parameters
        ----------
        obstacle
            The object.

        Returns
        -------
        The changed part.
        """
        return self

    @property
    def second_wire(self) -> SecondWire | None:
        """Second wire that the part adds."""
        return None

    def misfit(self, parts: Sequence[LoadPart]) -> str | None:  # noqa: ARG002  parts use it
        """Return why it does not fit together with the parts of a load; None if it does.

        Parameters
        ----------
        parts
            All parts of the load, this one included.

        Returns
        -------
        What to change, for a message.
        """
        return None

    def facts(self) -> Metadata:
        """Return the metadata of a recording that describe the part, in addition to its name."""
        return {}


def second_wire_of(parts: Sequence[LoadPart]) -> SecondWire | None:
    """Return the second wire that a part adds, if one does."""
    return next((part.second_wire for part in parts if part.second_wire is not None), None)
