"""Rows with names: one list of fields from which the layout in memory, its attributes and its documentation follow.

A row is a NumPy record. Compiled code reads and writes it in place, by attribute; in Python it is read through a class
whose attributes are the fields, and changed only by making another. Many wires are an array of such rows.
"""

from __future__ import annotations

from functools import cache
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError

__all__ = ["GRAINS", "GRAIN_EDGES", "Row", "Rows", "field"]

# Records as compiled code takes them, (n_wires,); what comes out by index has the attributes of its Row.
Rows = Any

# Lengths that differ from wire to wire, by the name they have in the documentation, and how many more than grains.
GRAINS, GRAIN_EDGES = "grains", "grains + 1"
BEYOND_GRAINS = {GRAINS: 0, GRAIN_EDGES: 1}


class Field:
    """One field of a row: a float, or an array of them where it has a length."""

    name: str

    def __init__(self, unit: str, meaning: str, length: int | str | None) -> None:
        """Take the unit, what the field means, and its length: None for one number."""
        self.unit, self.meaning, self.length = unit, meaning, length

    def __set_name__(self, owner: type, name: str) -> None:
        """Learn the name under which a row has this field."""
        self.name = name

    def __get__(self, row: Row | None, owner: type | None = None) -> Any:
        """Return the value in a row: a float, or a view of its array that cannot be written."""
        if row is None:
            return self
        values = row.row[self.name]
        if self.length is None:
            return values.item()
        values.flags.writeable = False
        return values[0]

    def __set__(self, row: Row, value: object) -> None:
        """Refuse to write: a state handed out stays what it was."""
        raise AttributeError(f"{self.name} of a {type(row).__name__} cannot be written: use replace({self.name}=...)")

    def shape(self, grains: int) -> tuple[int, ...]:
        """Return the shape in the row of a wire of so many grains."""
        if self.length is None:
            return ()
        return (self.length,) if isinstance(self.length, int) else (grains + BEYOND_GRAINS[self.length],)


def field(unit: str, meaning: str, length: int | str | None = None) -> Any:
    """Return a field for the body of a :class:`Row`: its SI unit, what it means, and an array's length."""
    return Field(unit, meaning, length)


class Row:
    """A row of named numbers. A subclass lists its fields, ``name: float = field(unit, meaning)``, and nothing else.

    ``row`` is an array of one record, (1,), which is what compiled code takes; a batch is a longer one.
    """

    fields: ClassVar[tuple[Field, ...]] = ()

    def __init_subclass__(cls) -> None:
        """Gather the fields in the order of their lines, those of the class above first."""
        cls.fields = (*cls.fields, *(item for item in vars(cls).values() if isinstance(item, Field)))

    def __init__(self, numbers: FloatArray, layout: np.dtype[np.void]) -> None:
        """Take the bare numbers of a row, which belong to this object from here on, and their layout."""
        # A view with names over bare numbers: NumPy copies and makes these ten times faster than records.
        self.numbers = numbers
        self.row: NDArray[np.void] = np.ndarray(1, layout, numbers)

    @classmethod
    @cache
    def layout(cls, grains: int) -> np.dtype[np.void]:
        """Return the layout in memory of a wire of so many grains; the same object for the same number."""
        # As np.record its records have attributes without compilation, too.
        return np.dtype((np.record, [(item.name, np.float64, item.shape(grains)) for item in cls.fields]))

    @classmethod
    def zeros(cls, grains: int) -> Self:
        """Return a row in which every number is 0."""
        layout = cls.layout(grains)
        return cls(np.zeros(layout.itemsize // np.dtype(np.float64).itemsize), layout)

    @classmethod
    def of(cls, grains: int, **values: object) -> Self:
        """Return a row of these values. Raises CallerError if a field is left out, or there is none of that name."""
        missing = [item.name for item in cls.fields if item.name not in values]
        if missing:
            raise CallerError(f"a {cls.__name__} needs {', '.join(missing)}")
        return cls.zeros(grains).replace(**values)

    @property
    def record(self) -> Any:
        """The one record of ``row``, which a compiled function for one row takes."""
        return self.row[0]

    @property
    def grains(self) -> int:
        """Number of grains that this row has room for."""
        sized = next(item for item in self.fields if item.length == GRAINS)
        return int(self.row.dtype[sized.name].shape[0])

    def copy(self) -> Self:
        """Return a row of the same numbers that may be changed without changing this one."""
        return type(self)(self.numbers.copy(), self.row.dtype)

    def replace(self, **changes: object) -> Self:
        """Return a row with other values of some fields. Raises CallerError for a field that there is none of."""
        changed = self.copy()
        for name, value in changes.items():
            if name not in (changed.row.dtype.names or ()):
                raise CallerError(f"a {type(self).__name__} has no field '{name}'")
            changed.row[name] = value
        return changed

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the bare numbers: the view with names is made again over them."""
        return type(self), (self.numbers, self.row.dtype)

    def values(self) -> dict[str, Any]:
        """Return every field by name."""
        return {item.name: getattr(self, item.name) for item in self.fields}

    def __repr__(self) -> str:
        """Show the single numbers; arrays would fill a screen."""
        shown = ", ".join(f"{item.name}={getattr(self, item.name):g}" for item in self.fields if item.length is None)
        return f"{type(self).__name__}({shown})"
