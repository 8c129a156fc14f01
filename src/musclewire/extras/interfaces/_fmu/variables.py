"""The variables of an FMU: one list, from which modelDescription.xml and the C header of the sources are written."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib.resources import files
from typing import Any, Literal

Kind = Literal["real", "integer", "boolean"]
Role = Literal["input", "output", "fixed", "tunable", "constant"]
KINDS: tuple[Kind, ...] = ("real", "integer", "boolean")


@dataclass(frozen=True)
class FmuVariable:
    """One variable of an FMU.

    ``role`` is an input, an output, a parameter that is set before the end of initialization (fixed) or at any time
    (tunable), or a constant. ``names`` are those of an integer's values: it is then an enumeration of the type
    ``type_name``. ``starts_with`` are the inputs and parameters on which an output depends at rest.
    """

    name: str
    role: Role
    meaning: str
    unit: str = ""
    kind: Kind = "real"
    start: float = 0.0
    minimum: float = -math.inf
    maximum: float = math.inf
    nominal: float = 0.0
    continuous: bool = True
    type_name: str = ""
    names: tuple[tuple[int, str, str], ...] = ()
    starts_with: tuple[str, ...] = ()


def rows_of(name: str) -> list[dict[str, Any]]:
    """Return the rows of a file of ``export/fmu/data``; what is a list there is a tuple."""
    text = (files("musclewire.extras.interfaces._fmu") / "data" / f"{name}.toml").read_text(encoding="utf-8")
    return [
        {key: tuple(value) if isinstance(value, list) else value for key, value in row.items()}
        for row in tomllib.loads(text)["variable"]
    ]


@dataclass(frozen=True)
class FmuVariables:
    """All variables of an FMU, those of one kind together: a value reference is a variable's place in this order."""

    ordered: tuple[FmuVariable, ...] = field(default=())

    @classmethod
    def in_order(cls, variables: Iterable[FmuVariable]) -> FmuVariables:
        """Return the variables in the order of their value references."""
        given = tuple(variables)
        return cls(tuple(variable for kind in KINDS for variable in given if variable.kind == kind))

    @classmethod
    def from_files(cls, *names: str) -> FmuVariables:
        """Return the variables of files of ``export/fmu/data``, those of a kind together."""
        return cls.in_order(FmuVariable(**row) for name in names for row in rows_of(name))

    def changed(self, changes: Mapping[str, Mapping[str, Any]]) -> FmuVariables:
        """Return the variables with what differs from FMU to FMU filled in: by name, then by attribute."""
        return FmuVariables(tuple(replace(variable, **changes.get(variable.name, {})) for variable in self.ordered))

    def and_also(self, others: Iterable[FmuVariable]) -> FmuVariables:
        """Return these variables and others."""
        return FmuVariables.in_order((*self.ordered, *others))

    def of_kind(self, kind: Kind) -> Sequence[FmuVariable]:
        """Return the variables of one kind, in order."""
        return [variable for variable in self.ordered if variable.kind == kind]

    def first(self, kind: Kind) -> int:
        """Return the value reference of the first variable of a kind."""
        return sum(len(self.of_kind(other)) for other in KINDS[: KINDS.index(kind)])

    def reference(self, name: str) -> int:
        """Return the value reference of a variable."""
        return next(place for place, variable in enumerate(self.ordered) if variable.name == name)

    def named(self, name: str) -> FmuVariable:
        """Return a variable by its name."""
        return self.ordered[self.reference(name)]
