"""Whose fault it is and what to do about it.

Every error musclewire raises on purpose belongs to one owner: the caller, the recording, the rig or the
numerics. The owner decides the exit code of the command line, so that a script can react without
reading text. A message is one line that says what is wrong, where, and what to do.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable

__all__ = [
    "CallerError",
    "FitRejectedError",
    "MissingExtraError",
    "MusclewireError",
    "NumericsError",
    "RecordingError",
    "RecordingNotWrittenError",
    "RigError",
    "an_object",
    "installed_by",
    "nearest_hint",
    "toml_problem",
]


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


def installed_by(extra: str) -> str:
    """Return the command that installs an extra from the checkout, quoted as every shell takes it, Windows' too."""
    return f'pip install ".[{extra}]" in the checkout'


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
    """Return what an object is, with its article: "an int", "a function".

    Parameters
    ----------
    thing
        Anything that a caller gave by mistake.

    Returns
    -------
    The name of its type with its article.
    """
    name = type(thing).__name__
    return f"{'an' if name[0].lower() in 'aeiou' else 'a'} {name}"


def toml_problem(error: Exception) -> str:
    """Return what is wrong with a TOML text, by its reader's exception; an open quote is called that.

    Parameters
    ----------
    error
        The reader's exception, which calls a quote that is left open an illegal end of line.

    Returns
    -------
    The problem in words, with its line.
    """
    text = str(error)
    line = re.search(r"at line (\d+)", text)
    if line and "Illegal character '\\n'" in text:
        return f"a quote is not closed in line {line[1]}"
    return text


def nearest_hint(name: str, known: Iterable[str]) -> str:
    """Return the end of a message about an unknown name: the nearest known one, or all if none is near.

    Parameters
    ----------
    name
        The unknown name, as it was written.
    known
        All valid names.

    Returns
    -------
    ``"; did you mean 'x'?"``, or ``"; known: ..."``, or "" if nothing is known.
    """
    names = sorted(known)
    near = difflib.get_close_matches(name, names, n=1, cutoff=0.6)
    if near:
        return f"; did you mean '{near[0]}'?"
    return f"; known: {', '.join(names)}" if names else ""
