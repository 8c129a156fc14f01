"""One check: a number of the paper, the measurement of ours, and the tolerance between them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from musclewire.errors import CallerError, MusclewireError, nearest_hint
from musclewire.manifest import absent_part

if TYPE_CHECKING:
    from musclewire.extras.paper._reproduce.runs import RunCache

# printed: a measured number; words: a sentence, or several numbers, turned into one; equation: how far our run is from
# obeying it; input: a number of the paper that we took over; literature: published elsewhere.
Kind = Literal["printed", "words", "equation", "input", "literature"]
Compare = Literal["within", "at most", "at least", "reported"]
# What our number owes to the paper's. input: the number the run was made with; definition: follows from how numbers are
# computed, whatever the wire does; designed: a part or a rule was made to have it; fitted: a target of the search for
# the parameters; chosen: a spool or a setting was picked with this number in view; satisfied: a bar that any such wire
# or part keeps to; interpolated: between two numbers that were fitted; predicted: nothing was set by it.
Origin = Literal["input", "definition", "satisfied", "designed", "fitted", "chosen", "interpolated", "predicted"]
# What a row declares that compares the wire's behaviour with the paper: predicted, unless the list of the search's
# targets and of the choices names it (rows_of_targets.toml).
PREDICTED_OR_LISTED: Final[Origin] = "predicted"
# Allowance for rounding in the comparison itself.
ROUNDING = 1e-9


@dataclass(frozen=True)
class PaperCheck:
    """The paper's number and how to measure ours.

    "within" requires ours to be no further than the tolerance from the paper's number, "at most" no more than the
    tolerance above it, "at least" no more than the tolerance below it; "reported" requires nothing but a number: such a
    row counts neither as holding nor as failing.
    """

    name: str
    paper: float
    unit: str  # of the paper's number and the tolerance
    tolerance: float
    why: str
    kind: Kind
    measure: Callable[[RunCache], float]  # may raise any error of an unusable loop
    compare: Compare = "within"
    _: KW_ONLY
    origin: Origin  # what the number owes to the paper's
    needs: str = ""  # command of the package that it is measured by, "" if that is always there


class SeedResult(NamedTuple):
    """What one seed gave for a check: a finite number, or why there is none."""

    number: float | None
    problem: str | None = None


def subject_of(name: str) -> str:
    """Return the part of a row's name before its first point: "fig4" of "fig4.strain_gap_pct[125um,1.70N]"."""
    return name.partition(".")[0]


def bars(check: PaperCheck) -> tuple[float, ...]:
    """Return the limits of what a check allows, in its unit, with the allowance for rounding."""
    room = check.tolerance + ROUNDING * max(1.0, abs(check.paper))
    low, high = check.paper - room, check.paper + room
    return {"within": (low, high), "at most": (high,), "at least": (low,), "reported": ()}[check.compare]


def holds(check: PaperCheck, ours: float) -> bool:
    """Return whether a number is within the tolerance; True for one that is reported and not judged."""
    limits = bars(check)
    if not limits:
        return True
    return (check.compare == "at most" or ours >= limits[0]) and (check.compare == "at least" or ours <= limits[-1])


def measured(check: PaperCheck, runs: RunCache) -> SeedResult:
    """Return the number of a check on the runs of one seed, or why there is none: an unusable loop, or not finite."""
    try:
        ours = float(check.measure(runs))
    except MusclewireError as error:
        return SeedResult(None, " ".join(str(error).split()))
    return SeedResult(ours) if math.isfinite(ours) else SeedResult(None, "the result is not a finite number")


def left_out(checks: Iterable[PaperCheck]) -> dict[str, str]:
    """Return the names of the checks whose package is not installed, each with what is said of that."""
    absent = {check.name: absent_part("commands", check.needs) for check in checks if check.needs}
    return {name: str(error) for name, error in absent.items() if error is not None}


def selected(checks: Sequence[PaperCheck], only: str | None) -> list[PaperCheck]:
    """Return the checks whose names begin with ``only``, all without one.

    A number is not cut in two: "fig1" is not the beginning of "fig11". Raises CallerError, suggesting the nearest
    name, if no name begins so, and if one that does cannot be measured for want of a package.
    """
    if only is None:
        return list(checks)
    chosen = [check for check in checks if begins_with(check.name, only)]
    if only and chosen:
        for name, absent in left_out(chosen).items():
            raise CallerError(f"{name} cannot be measured: {absent}")
        return chosen
    names = [check.name for check in checks]
    subjects = list(dict.fromkeys(map(subject_of, names)))
    hint = nearest_hint(only, [*subjects, *names])
    if not hint.startswith("; did"):
        hint = f"; known: {', '.join(subjects)}"
    raise CallerError(f"no row or figure begins with '{only}'{hint}")


def begins_with(name: str, beginning: str) -> bool:
    """Return whether a name begins so, and not in the middle of a number."""
    rest = name.removeprefix(beginning)
    return name.startswith(beginning) and not (beginning[-1:].isdigit() and rest[:1].isdigit())
