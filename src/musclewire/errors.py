"""Whose fault it is and what to do about it.

Every error musclewire raises on purpose belongs to one owner: the caller, the recording, the rig or the
numerics. The owner decides the exit code of the command line, so that a script can react without
reading text. A message is one line that says what is wrong, where, and what to do. An argument that it advises is
data in it: the command line shows an option there, and Python the argument.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Mapping
from importlib.util import find_spec
from typing import NamedTuple

__all__ = [
    "Argument",
    "CallerError",
    "FitRejectedError",
    "Message",
    "MissingExtraError",
    "MusclewireError",
    "NumericsError",
    "RecordingError",
    "RecordingNotWrittenError",
    "RigError",
    "an_object",
    "argument",
    "installed_by",
    "joined",
    "nearest_hint",
    "require_extra",
]


class Argument(NamedTuple):
    """An argument of Python that a message advises, with the value to give; None if only its user knows it."""

    name: str
    value: object = None

    def __str__(self) -> str:
        """Return the argument as one writes it in Python."""
        if self.value is None:
            return self.name
        if isinstance(self.value, Mapping):
            keys = (f"{key!r}: {'...' if value is None else repr(value)}" for key, value in self.value.items())
            return f"{self.name}={{{', '.join(keys)}}}"
        return f"{self.name}={self.value:g}" if isinstance(self.value, float) else f"{self.name}={self.value!r}"


class Message(str):
    """A text that advises arguments, as Python has them until spelled otherwise; a sum with texts is a message."""

    __slots__ = ("parts",)

    parts: tuple[object, ...]

    def __new__(cls, *parts: object) -> Message:
        """Return the message of its parts: texts, arguments and messages."""
        message = super().__new__(cls, "".join(str(part) for part in parts))
        message.parts = parts
        return message

    def __str__(self) -> Message:
        """Return the message itself, so that the text of an error is one if it was raised with one."""
        return self

    def __add__(self, other: str) -> Message:
        """Return this and what follows."""
        return Message(self, other)

    def __radd__(self, other: str) -> Message:
        """Return what precedes and this."""
        return Message(other, self)

    def spelled(self, spell: Callable[[Argument], str]) -> str:
        """Return the text with each argument as ``spell`` has it."""
        return "".join(
            spell(part)
            if isinstance(part, Argument)
            else part.spelled(spell)
            if isinstance(part, Message)
            else str(part)
            for part in self.parts
        )


def argument(name: str, value: object = None) -> Message:
    """Return a piece of a message: ``overwrite=True`` in Python, ``--overwrite`` on the command line."""
    return Message(Argument(name, value))


def joined(separator: str, texts: Iterable[str]) -> Message:
    """Return texts as one message, with a separator between them."""
    return Message(*[part for text in texts for part in (separator, text)][1:])


# What each extra of pyproject.toml brings that is asked for by name; pyproject.toml says why.
PACKAGES_OF = {
    "parquet": ("pyarrow",),
    "pandas": ("pandas",),
    "xarray": ("xarray",),
    "nidaq": ("nidaqmx", "grpc"),
    "gym": ("gymnasium",),
    "control": ("control",),
    "sweep": ("distributed", "xarray", "pyarrow", "SALib"),
}


class MusclewireError(Exception):
    """An error that musclewire raises on purpose, in one line: what is wrong, where, and what to do.

    Each belongs to an owner, by which to catch it: ``CallerError`` (the call), ``RecordingError`` (the data),
    ``RigError`` (the rig, which has been made safe) or ``NumericsError`` (a computation); all are in
    ``musclewire.errors``. ``exit_code`` is that of the command line.
    """

    exit_code = 1


class CallerError(MusclewireError, ValueError):
    """The caller asked for something that makes no sense: a wrong name, range, unit or key."""

    exit_code = 2


class MissingExtraError(CallerError):
    """An optional dependency is needed and not installed; the message names the extra."""

    def __init__(self, what: str, extra: str) -> None:
        """Say that ``what`` needs the optional extra ``extra``."""
        super().__init__(f"{what} needs the extra '{extra}': {installed_by(extra)}")
        self._said = (what, extra)

    def __reduce__(self) -> tuple[type[MissingExtraError], tuple[str, str]]:
        """Keep what it was made of, so that a process of a pool can raise it in another one."""
        return MissingExtraError, self._said


def installed_by(extra: str) -> str:
    """Return the command that installs an extra from the checkout, quoted as every shell takes it, Windows' too."""
    return f'pip install ".[{extra}]" in the checkout'


def require_extra(what: str, extra: str) -> None:
    """Raise MissingExtraError, which names the extra, if a package of it is not installed; none of them is imported."""
    if any(find_spec(package) is None for package in PACKAGES_OF[extra]):
        raise MissingExtraError(what, extra)


class RecordingError(MusclewireError, ValueError):
    """The recording cannot be used: missing column, unknown unit, NaN, clock running back, no transformation."""

    exit_code = 2


class RigError(MusclewireError):
    """The rig failed or reported something impossible. It has been made safe before this is raised."""

    exit_code = 3


class RecordingNotWrittenError(RigError):
    """A recording's file cannot be written any more. The rig is safe, and it is said where the rows are."""


class NumericsError(MusclewireError):
    """A computation did not converge or lost meaning; the message names the remedy."""


class FitRejectedError(NumericsError):
    """A fit ran, and its result cannot be used (because it is not invertible, for example)."""


def an_object(thing: object) -> str:
    """Return what an object is, with its article: "an int", "a function"."""
    name = type(thing).__name__
    return f"{'an' if name[0].lower() in 'aeiou' else 'a'} {name}"


def nearest_hint(name: str, known: Iterable[str]) -> str:
    """Return the end of a message about an unknown name: the nearest known one, or all if none is near."""
    names = sorted(known)
    near = difflib.get_close_matches(name, names, n=1, cutoff=0.6)
    if near:
        return f"; did you mean '{near[0]}'?"
    return f"; known: {', '.join(names)}" if names else ""
