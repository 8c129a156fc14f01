"""Rows of named numbers: one list of fields from which the layout in memory and the attributes follow.

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

# Records as compiled code takes them, (n_wires,); each element has the fields of its Row as attributes.
Rows = Any

# Array lengths that depend on the number of classes of barrier, as the documentation names them, and how many numbers
# of each class they hold.
CLASSES, CLASS_SLOPES = "classes", "6 x classes"
PER_CLASS = {CLASSES: 1, CLASS_SLOPES: 6}


class Field:
    """One field of a row: a float, or an array of floats if it has a length."""

    name: str

    def __init__(self, unit: str, meaning: str, length: int | str | None) -> None:
        """Take the unit, what the field means, and its length: None for one number."""
        self.unit, self.meaning, self.length = unit, meaning, length

    def __set_name__(self, owner: type, name: str) -> None:
        """Take the name that this field has in its row."""
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
        """Refuse to write: from Python a row never changes."""
        raise AttributeError(f"{self.name} of a {type(row).__name__} cannot be written: use replace({self.name}=...)")

    def shape(self, classes: int) -> tuple[int, ...]:
        """Return the shape in the row of a wire with so many classes of barrier."""
        if self.length is None:
            return ()
        return (self.length,) if isinstance(self.length, int) else (classes * PER_CLASS[self.length],)


def field(unit: str, meaning: str, length: int | str | None = None) -> Any:
    """Return a field for the body of a :class:`Row`: its SI unit, what it means, and an array's length."""
    return Field(unit, meaning, length)


class Row:
    """A row of named numbers. A subclass lists its fields, ``name: float = field(unit, meaning)``, and nothing else.

    ``row`` is an array of one record, (1,), which is what compiled code takes; a batch is a longer one. Make a row by
    ``of``, ``zeros`` or ``replace``.

    Parameters
    ----------
    numbers
        The plain numbers of the row in the order of its fields, one-dimensional; the row owns them from now on.
    layout
        Their layout in memory: ``layout(classes)``.
    """

    fields: ClassVar[tuple[Field, ...]] = ()

    def __init_subclass__(cls) -> None:
        """Collect the fields in the order of their lines, those of the base class first."""
        cls.fields = (*cls.fields, *(item for item in vars(cls).values() if isinstance(item, Field)))

    def __init__(self, numbers: FloatArray, layout: np.dtype[np.void]) -> None:
        """Take the plain numbers of a row, which this object owns from now on, and their layout."""
        # A view with names over plain numbers: NumPy creates and copies these ten times faster than records.
        self.numbers = numbers
        self.row: NDArray[np.void] = np.ndarray(1, layout, numbers)

    @classmethod
    @cache
    def layout(cls, classes: int = 1) -> np.dtype[np.void]:
        """Return the layout in memory for so many classes of barrier; the same object for the same number."""
        # As np.record its records have attributes without compilation, too.
        return np.dtype((np.record, [(item.name, np.float64, item.shape(classes)) for item in cls.fields]))

    @classmethod
    def zeros(cls, classes: int = 1) -> Self:
        """Return a row in which every number is 0."""
        layout = cls.layout(classes)
        return cls(np.zeros(layout.itemsize // np.dtype(np.float64).itemsize), layout)

    @classmethod
    def from_values(cls, classes: int, **values: object) -> Self:
        """Return a row of these values. Raises CallerError if a field is missing or unknown."""
        missing = [item.name for item in cls.fields if item.name not in values]
        if missing:
            raise CallerError(f"a {cls.__name__} needs {', '.join(missing)}")
        return cls.zeros(classes).replace(**values)

    @property
    def record(self) -> Any:
        """The only record of ``row``, as a compiled function of one wire takes it."""
        return self.row[0]

    @property
    def classes(self) -> int:
        """Number of classes of barrier that this row has room for."""
        sized = next(item for item in self.fields if item.length == CLASSES)
        return int(self.row.dtype[sized.name].shape[0])

    def copy(self) -> Self:
        """Return an independent row of the same numbers."""
        return type(self)(self.numbers.copy(), self.row.dtype)

    def replace(self, **changes: object) -> Self:
        """Return a row with other values of some fields. Raises CallerError for an unknown field."""
        changed = self.copy()
        for name, value in changes.items():
            if name not in (changed.row.dtype.names or ()):
                raise CallerError(
                    f"a {type(self).__name__} has no field '{name}'; it has {', '.join(changed.row.dtype.names or ())}"
                )
            changed.row[name] = value
        return changed

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the plain numbers; the view with names is rebuilt over them."""
        return type(self), (self.numbers, self.row.dtype)

    def values(self) -> dict[str, Any]:
        """Return every field by name."""
        return {item.name: getattr(self, item.name) for item in self.fields}

    def __repr__(self) -> str:
        """Show the single numbers; arrays would fill a screen."""
        shown = ", ".join(f"{item.name}={getattr(self, item.name):g}" for item in self.fields if item.length is None)
        return f"{type(self).__name__}({shown})"
