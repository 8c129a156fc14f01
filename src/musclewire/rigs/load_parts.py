"""What a rig file may put at a wire's connector: parts that combine, each a small table of its own.

[[load]]
part = "pretensioner"
stiffness = "386.2 N/m"

[[load]]
part = "finger"
finger = "lan-fan-2010"
"""

from __future__ import annotations

from typing import Annotated, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, model_validator

from musclewire.parameters.pretensioner_file import read_pretensioner
from musclewire.rigs.quantities import measured_in

__all__ = [
    "Antagonist",
    "Blocked",
    "Contact",
    "Finger",
    "ParallelWire",
    "Part",
    "Pretensioner",
    "SecondFinger",
    "Spring",
    "Weight",
]


Stiffness = Annotated[float, measured_in("N/m"), Field(gt=0.0, allow_inf_nan=False)]
Length = Annotated[float, measured_in("m"), Field(ge=0.0, allow_inf_nan=False)]
Force = Annotated[float, measured_in("N"), Field(gt=0.0, allow_inf_nan=False)]
Voltage = Annotated[float, measured_in("V"), Field(ge=0.0, allow_inf_nan=False)]


class LoadPart(BaseModel):
    """What all parts share: an unknown key is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Spring(LoadPart):
    """A spring at the connector; with ``slack`` it begins to pull only after that much contraction."""

    part: Literal["spring"]
    stiffness: Stiffness
    slack: Length = 0.0


class Pretensioner(LoadPart):
    """A flexure on the linear stage that carries the pretension alone (Eq. 8 of Lan and Fan 2010).

    Either its stiffness, or the ``file`` that ``musclewire design pretensioner`` writes.
    """

    part: Literal["pretensioner"]
    stiffness: Stiffness | None = None
    file: str | None = None

    @model_validator(mode="after")
    def _one_of_both(self) -> Pretensioner:
        if (self.stiffness is None) == (self.file is None):
            raise ValueError("a pretensioner has either a stiffness or a file")
        return self

    @property
    def stiffness_n_per_m(self) -> float:
        """Stiffness along the wire [N/m]. Raises CallerError for a file that cannot be used."""
        return (
            read_pretensioner(self.file).stiffness_n_per_m
            if self.stiffness is None and self.file
            else (self.stiffness or 0.0)
        )


class Finger(LoadPart):
    """A tendon-driven finger, by name or file; ``slack`` is what the tendon hangs through before it pulls."""

    part: Literal["finger"]
    finger: str
    slack: Length = 0.0


class Weight(LoadPart):
    """A hanging weight: the same force at any height."""

    part: Literal["weight"]
    force: Force


class Blocked(LoadPart):
    """A wire held at both ends; nothing is rigid, so the mount has a stiffness."""

    part: Literal["blocked"]
    mount_stiffness: Stiffness = 1e6


class Contact(LoadPart):
    """An object in the way: a foam block before the finger's endpoint, or before the connector without a finger."""

    part: Literal["contact"]
    stiffness: Stiffness
    clearance: Length


class Antagonist(LoadPart):
    """A second wire of the same make and length that pulls against the first, from a supply of its own."""

    part: Literal["antagonist"]
    wire: str | None = None
    voltage: Voltage = 0.0


class ParallelWire(LoadPart):
    """A second wire beside the first, on the same connector and the same two terminals."""

    part: Literal["parallel wire"]
    wire: str | None = None


class SecondFinger(LoadPart):
    """A finger like the first, opposite to it, on a wire of its own in the same current; needs a contact between."""

    part: Literal["second finger"]
    wire: str | None = None


Part = Annotated[
    Spring | Pretensioner | Finger | Weight | Blocked | Contact | Antagonist | ParallelWire | SecondFinger,
    Field(discriminator="part"),
]
ONCE = (Finger, Contact, Antagonist, ParallelWire, SecondFinger)
SECOND_WIRES = (Antagonist, ParallelWire, SecondFinger)


class Parts(BaseModel):
    """A list of parts that fit together."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    load: list[Part]

    @model_validator(mode="after")
    def _parts_fit_together(self) -> Parts:
        for kind in ONCE:
            if self.count(kind) > 1:
                name = get_args(kind.model_fields["part"].annotation)[0]
                raise ValueError(f"there are {self.count(kind)} parts '{name}', 1 fits")
        if sum(self.count(kind) for kind in SECOND_WIRES) > 1:
            raise ValueError("a rig has room for one second wire: antagonist, parallel wire or second finger")
        if self.count(SecondFinger) and not (self.count(Finger) and self.count(Contact)):
            raise ValueError("a second finger needs a part 'finger', which it mirrors, and a 'contact' between them")
        if self.count(Contact) and self.count(Antagonist) + self.count(ParallelWire):
            raise ValueError("a contact beside a second wire on one connector is not simulated: leave one out")
        return self

    def count(self, kind: type[LoadPart]) -> int:
        """Return how many parts of a kind there are."""
        return sum(isinstance(item, kind) for item in self.load)
