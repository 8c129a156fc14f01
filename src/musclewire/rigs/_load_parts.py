"""The parts of a load that ship with musclewire: each is one class with its contribution to the load.

[[load]]
part = "pretensioner"
stiffness = "386.2 N/m"

[[load]]
part = "finger"
finger = "lan-fan-2010"
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from musclewire.arrays import FloatArray
from musclewire.parameters import FingerFile, load_finger, read_pretensioner
from musclewire.rigs._device import Metadata
from musclewire.rigs._load_part import Force, Length, LoadPart, Stiffness, second_wire_of
from musclewire.wire import ElasticObject


class Spring(LoadPart):
    """A spring at the connector; with ``slack`` it begins to pull only after that much contraction.

    Parameters
    ----------
    stiffness
        Its stiffness [N/m]; it carries the pretension.
    slack
        Contraction before it begins to pull [m]; with slack it carries no pretension.
    """

    is_straight: ClassVar[bool] = True

    part: Literal["spring"]
    stiffness: Stiffness
    slack: Length = 0.0

    @property
    def carries_pretension(self) -> bool:
        """A spring carries the pretension unless it has slack."""
        return self.slack == 0.0

    @property
    def stiffness_n_per_m(self) -> float:
        """Its stiffness [N/m]; 0 with slack, because it then begins later (``force_n``)."""
        return self.stiffness if self.slack == 0.0 else 0.0

    def force_n(self, displacement_m: FloatArray) -> FloatArray | None:
        """Return its force [N] if it has slack; None otherwise."""
        return None if self.slack == 0.0 else self.stiffness * np.maximum(displacement_m - self.slack, 0.0)


class Pretensioner(LoadPart):
    """A flexure on the linear stage that carries the pretension alone (Eq. 8 of Lan and Fan 2010).

    Either its stiffness, or the ``file`` that ``musclewire design pretensioner`` writes.

    Parameters
    ----------
    stiffness
        Stiffness along the wire [N/m]; None if a file states it.
    file
        Path of a design file (.toml); None if the stiffness is given.
    """

    is_straight: ClassVar[bool] = True

    part: Literal["pretensioner"]
    stiffness: Stiffness | None = None
    file: str | None = None

    @model_validator(mode="after")
    def _one_of_both(self) -> Pretensioner:
        if (self.stiffness is None) == (self.file is None):
            raise ValueError("a pretensioner has either a stiffness or a file: give one of them")
        return self

    @property
    def carries_pretension(self) -> bool:
        """A pretensioner carries the pretension."""
        return True

    @property
    def stiffness_n_per_m(self) -> float:
        """Stiffness along the wire [N/m]. Raises CallerError for a file that cannot be used."""
        return (
            read_pretensioner(self.file).stiffness_n_per_m
            if self.stiffness is None and self.file
            else (self.stiffness or 0.0)
        )


class Finger(LoadPart):
    """A tendon-driven finger.

    Parameters
    ----------
    finger
        Name of a finger that ships with musclewire, or path of a finger file (.toml).
    slack
        Displacement of the connector before the tendon pulls [m].
    """

    once: ClassVar[bool] = True

    part: Literal["finger"]
    finger: str
    slack: Length = 0.0

    @property
    def finger_name(self) -> str:
        """Name or file of the finger."""
        return self.finger

    @property
    def tendon_slack_m(self) -> float:
        """Displacement before the tendon pulls [m]."""
        return self.slack

    def finger_file(self) -> FingerFile:
        """Return the finger. Raises CallerError for a file that cannot be used."""
        return load_finger(self.finger)

    def facts(self) -> Metadata:
        """Return the finger's name and stiffness."""
        return {
            "finger": Path(self.finger).stem,
            "finger_stiffness_n_per_m": self.finger_file().curve.stiffness_n_per_m,
        }


class Weight(LoadPart):
    """A hanging weight: the same force at any height.

    Parameters
    ----------
    force
        The weight [N].
    """

    is_straight: ClassVar[bool] = True

    part: Literal["weight"]
    force: Force

    @property
    def hanging_force_n(self) -> float:
        """The weight [N]."""
        return self.force


class Blocked(LoadPart):
    """A wire held at both ends; nothing is rigid, so the mount has a stiffness.

    Parameters
    ----------
    mount_stiffness
        Stiffness of the mount [N/m].
    """

    part: Literal["blocked"]
    mount_stiffness: Stiffness = 1e6

    @property
    def carries_pretension(self) -> bool:
        """The mount holds what the stage pulls."""
        return True

    @property
    def stiffness_n_per_m(self) -> float:
        """Stiffness of the mount [N/m]."""
        return self.mount_stiffness


class Contact(LoadPart):
    """An object in the way: a foam block in front of the finger's endpoint, or of the connector without a finger.

    Parameters
    ----------
    stiffness
        Stiffness of the object [N/m].
    clearance
        Travel of the endpoint, or of both fingers' endpoints together, before contact [m].
    """

    once: ClassVar[bool] = True

    part: Literal["contact"]
    stiffness: Stiffness
    clearance: Length

    @property
    def obstacle(self) -> ElasticObject:
        """The object."""
        return ElasticObject(self.stiffness, self.clearance)

    def with_obstacle(self, obstacle: ElasticObject) -> Self:
        """Return a contact with another object."""
        return self.model_copy(update={"stiffness": obstacle.stiffness_n_per_m, "clearance": obstacle.clearance_m})

    def misfit(self, parts: Sequence[LoadPart]) -> str | None:
        """Return why it does not fit: two wires on one connector that meet an object are not simulated."""
        second = second_wire_of(parts)
        if second is not None and not second.holds_the_object:
            return "a contact together with a second wire on one connector is not simulated: leave one out"
        return None
