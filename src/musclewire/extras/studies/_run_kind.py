"""What a study may run: kinds of runs by name, our own and those of other packages."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict

from musclewire.arrays import FloatArray
from musclewire.controllers import Event
from musclewire.errors import CallerError, MusclewireError, RigError
from musclewire.extras.studies._design import run_seed
from musclewire.extras.studies._varied_rig import Value, VariedRig, VariedWire
from musclewire.registry import Registry
from musclewire.rigs import GuardedRig, ProtectionTripError

# The result of a run: a number, an array of numbers for a series, or a text, by quantity; or the error that ended it.
# Of ``overheated`` the value is a pair, temperature and limit [K].
Outcome = Mapping[str, float | FloatArray | str | tuple[float, float]] | MusclewireError


class KindOptions(BaseModel):
    """The keys of the table ``[run]`` besides ``kind`` and ``keep``; a kind of run adds its own as fields."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Quantity(NamedTuple):
    """A quantity that a kind of run computes.

    Parameters
    ----------
    unit
        SI unit, "1" for a fraction or a number of something.
    meaning
        What it is, in a few words.
    is_series
        Whether it has a value for every sample of the run, instead of one for the run.
    is_text
        Whether it is a text and no number; such a quantity is kept only if the study names it.
    """

    unit: str
    meaning: str
    is_series: bool = False
    is_text: bool = False


Options = TypeVar("Options", bound=KindOptions)
# Key of an outcome, besides its quantities, for a wire that went beyond its protection's limit: an Overheated.
OVERHEATED = "overheated"


class Overheated(NamedTuple):
    """A run whose wire went beyond the highest temperature that its protection allows."""

    run: int
    temperature_max_k: float  # the true one, or the protection's estimate if it ended the run
    limit_k: float  # highest temperature allowed


class OverheatedRunError(RigError):
    """The protection ended a run for over-temperature; ``temperature_k`` is its estimate, ``limit_k`` its limit."""

    def __init__(self, message: str, temperature_k: float, limit_k: float) -> None:
        """Keep the numbers with the message."""
        super().__init__(message)
        self.temperature_k, self.limit_k = temperature_k, limit_k


@contextmanager
def noted_overheating(rig: GuardedRig) -> Iterator[None]:
    """Raise OverheatedRunError instead of a trip for over-temperature."""
    try:
        yield
    except ProtectionTripError as trip:
        if trip.event is not Event.OVER_TEMPERATURE:
            raise
        limit_k = rig.protection_limits.maximum_temperature_k
        raise OverheatedRunError(str(trip), rig.protection.temperature_k, limit_k) from trip


@dataclass(frozen=True)
class StudyRun(Generic[Options]):
    """One run of a study."""

    number: int  # from 0
    values: Mapping[str, Value]  # the rig's parameters, in SI
    options: Options  # with the values of the parameters ``run.KEY``
    seed: int  # of the study

    @property
    def own_seed(self) -> int:
        """Seed of this run: the same whatever runs before it, and where."""
        return run_seed(self.seed, self.number)


@dataclass(frozen=True)
class StudyRuns(Generic[Options]):
    """Some runs of a study that are evaluated together."""

    rig: VariedRig  # whose numbers and keys vary
    runs: Sequence[StudyRun[Options]]
    keep: frozenset[str]  # names of the quantities to return

    def open(self, run: StudyRun[Options]) -> GuardedRig:
        """Return the open rig of a run, with instruments and protection; its noise has the seed of the run."""
        return self.rig.open(run.values, run.own_seed)

    def wire(self, run: StudyRun[Options]) -> VariedWire:
        """Return the wire of a run without instruments. Raises CallerError for values that make none."""
        return self.rig.wire(run.values)

    def overheating(self, wire: VariedWire, hottest_k: float) -> dict[str, tuple[float, float]]:
        """Return temperature and limit [K] by their key if a wire went beyond its protection's limit, else nothing."""
        limit_k = self.rig.maximum_temperature_k(wire)
        return {OVERHEATED: (hottest_k, limit_k)} if hottest_k > limit_k else {}


@dataclass(frozen=True)
class RunKind(Generic[Options]):
    """A kind of run. Register yours with ``RUN_KINDS.register("name", kind)`` or in a package's manifest.

    Its functions belong into a module that every worker can import; they have no state.

    Parameters
    ----------
    options
        Schema of the table ``[run]``.
    quantities
        Returns what a run with such options computes, by name.
    evaluate
        Returns an outcome for each of some runs, in their order; each is the same whatever the others are.
    runs_per_chunk
        How many runs are evaluated together and written as one file, unless the user says: about a second of work.
    """

    options: type[Options]
    quantities: Callable[[Options], Mapping[str, Quantity]]
    evaluate: Callable[[StudyRuns[Options]], Sequence[Outcome]]
    runs_per_chunk: int = 1


# A kind is loaded only when a study names it.
RUN_KINDS: Registry[RunKind[Any]] = Registry(
    "kind of run",
    "run_kinds",
    {
        "characterize": "musclewire.extras.studies._characterize_runs:CHARACTERIZE",
        "simulate": "musclewire.extras.studies._simulate_runs:SIMULATE",
        "control": "musclewire.extras.studies._control_runs:CONTROL",
    },
)

Item = TypeVar("Item")
Result = TypeVar("Result")


def each(function: Callable[[Item], Result], items: Sequence[Item]) -> list[Result | MusclewireError]:
    """Return what a function returns for each item, or the error of one that fails: the others go on.

    Parameters
    ----------
    function
        What to do with an item.
    items
        The items.

    Returns
    -------
    Results and errors, in the order of the items; an item that is an error already stays one.
    """

    def attempted(item: Item) -> Result | MusclewireError:
        if isinstance(item, MusclewireError):
            return item
        try:
            return function(item)
        except MusclewireError as error:
            return error

    return [attempted(item) for item in items]


def column_of(name: str, quantity: Quantity, outcomes: Sequence[Outcome]) -> FloatArray:
    """Return a quantity over some runs, NaN for runs that failed: (n_runs,), or (n_runs, n_samples) for a series."""
    values = values_of(name, outcomes)
    if not quantity.is_series:
        return np.array([np.nan if value is None else float(value) for value in values])
    rows = [np.empty(0) if value is None else np.asarray(value) for value in values]
    found = np.full((len(rows), max((row.size for row in rows), default=0)), np.nan)
    for row, samples in zip(found, rows, strict=True):
        row[: samples.size] = samples
    return found


def texts_of(name: str, outcomes: Sequence[Outcome]) -> tuple[str, ...]:
    """Return a quantity that is a text over some runs, "" for runs that failed."""
    return tuple("" if value is None else str(value) for value in values_of(name, outcomes))


def overheated_of(outcomes: Sequence[Outcome], first: int) -> tuple[Overheated, ...]:
    """Return the runs, counted from ``first``, whose wires went beyond their limits."""
    found = []
    for number, outcome in enumerate(outcomes, first):
        if isinstance(outcome, OverheatedRunError):
            found.append(Overheated(number, outcome.temperature_k, outcome.limit_k))
        elif not isinstance(outcome, MusclewireError) and isinstance(pair := outcome.get(OVERHEATED), tuple):
            found.append(Overheated(number, *pair))
    return tuple(found)


def values_of(name: str, outcomes: Sequence[Outcome]) -> list[Any]:
    """Return a quantity of each run, None of one that failed. Raises CallerError if the kind has not computed it."""
    for outcome in outcomes:
        if not isinstance(outcome, MusclewireError) and name not in outcome:
            raise CallerError(
                f"the kind of run has computed no '{name}', which is among its quantities: let it return that, too"
            )
    return [None if isinstance(one, MusclewireError) else one[name] for one in outcomes]
