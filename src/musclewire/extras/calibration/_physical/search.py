"""A global, then a local search for the vector that fits the observations.

Global: least-squares descents from several starts. The uncertainty of the observations is large at first and
decreases step by step (graduated least squares, a homotopy in the noise). At large uncertainty the valley is wide and
smooth; it narrows around the current vector. Starts are the prior's mean and draws from the prior, with the starts
that a prior states; then jumps from the best vector. Local: once more from the best, with the finest time step; the
final derivative gives the uncertainty. Each descent is SciPy's trust-region reflective least squares with bounds
(Branch, Coleman and Li 1999, doi 10.1137/S1064827595289108). Derivatives are simulated on threads: the simulator
releases the interpreter's lock.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, NumericsError, nearest_hint
from musclewire.parameters import require_seed


class SearchJournal:
    """A text file with one line of numbers for each descent, after a first line that identifies the search."""

    def __init__(self, path: Path, fingerprint: str) -> None:
        """Open or create a journal. Raises CallerError for a file that belongs to another search."""
        self._path = path
        self._remembered: list[list[float]] = []
        self._position = 0
        try:
            if path.exists():
                self._remembered = read_journal(path, fingerprint)
            lines = [json.dumps({"search": fingerprint}), *(json.dumps(numbers) for numbers in self._remembered)]
            path.write_text("\n".join(lines) + "\n", "utf-8")
        except OSError as problem:
            raise CallerError(f"{path}: cannot be written: {problem.strerror or problem}; check the folder") from None

    @property
    def remembered(self) -> int:
        """Number of descents of an earlier run."""
        return len(self._remembered)

    def next(self) -> list[float] | None:
        """Return the numbers of the next descent, None after the last one of the earlier run."""
        if self._position >= len(self._remembered):
            return None
        self._position += 1
        return self._remembered[self._position - 1]

    def write(self, numbers: list[float]) -> None:
        """Add a descent; it is on the disk when this returns."""
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps([float(number) for number in numbers]) + "\n")
            file.flush()
            os.fsync(file.fileno())

    def remove(self) -> None:
        """Delete the journal of a completed search."""
        self._path.unlink(missing_ok=True)


def read_journal(path: Path, fingerprint: str) -> list[list[float]]:
    """Return the lines of a journal; an incomplete last line is dropped."""
    try:
        lines = path.read_text("utf-8").splitlines()
        belongs = json.loads(lines[0])["search"] == fingerprint
    except (IndexError, KeyError, TypeError, UnicodeDecodeError, json.JSONDecodeError):
        raise CallerError(f"{path} is not the journal of a search: give another output, or move it away") from None
    if not belongs:
        raise CallerError(
            f"{path} belongs to a search with other recordings, settings or another version: finish that one, or "
            "delete the file"
        )
    found: list[list[float]] = []
    for line in lines[1:]:
        try:
            found.append([float(number) for number in json.loads(line)])
        except json.JSONDecodeError:
            break
    return found


OnProgress = Callable[[str, int, int, float], None]
OnStep = Callable[[], None]

# A candidate that cannot be simulated has this value in every residual.
IMPOSSIBLE = 1e4
# Steps of a derivative, in prior standard deviations. They were chosen for an ensemble with edges between its grains,
# which smaller steps showed; two fronts have none. Larger ones show curvature.
SEARCH_STEP, LAST_STEPS, FINAL_STEP = 0.05, (0.1, 0.03), 0.05
# Factors on the observations' uncertainty, descent by descent.
START_SCALES = (100.0, 30.0, 10.0, 3.0, 1.0)
JUMP_SCALES = (10.0, 3.0, 1.0)
# No more descents are made after this many that end within this fraction of the best cost.
AGREEING, AGREEMENT = 3, 1e-3
# Ends within this fraction of the best cost are as good as it: the model's own error is larger.
ALIKE = 0.1
# Spread of starts and jumps, in prior standard deviations.
START_SPREAD, JUMP_SPREAD = 0.8, 0.5


class LeastSquaresProblem(Protocol):
    """Residuals of a vector, (n_observed + n,), in standard deviations, those of the prior last; and its bounds."""

    low: FloatArray
    high: FloatArray

    def residuals(self, coordinates: FloatArray) -> FloatArray:
        """Return the residuals of a vector, not finite if the simulation diverges. Raises NumericsError without one."""
        ...

    def start(self, number: int, drawn: FloatArray) -> FloatArray:
        """Return the vector from which the start of this number begins; ``drawn`` is around the prior's mean."""
        ...

    def refined(self) -> LeastSquaresProblem:
        """Return the same problem with the finest time step, for the end of a search."""
        ...


@dataclass(frozen=True)
class SearchSettings:
    """Effort of a search; the defaults suit a wire with some thirty unknowns.

    Parameters
    ----------
    seed
        Seed of the starting points.
    starts
        Number of descents from points of the prior, one or more.
    jumps
        Number of descents from points near the best one.
    evaluations_each
        Evaluations of each of these descents.
    evaluations_last
        Evaluations of the last descent, from the best point.
    threads
        Number of threads; None for as many as there are processor cores.

    Raises
    ------
    CallerError
        For an impossible seed, and for a search without starts, evaluations or threads.
    """

    seed: int = 1
    starts: int = 4
    jumps: int = 5
    evaluations_each: int = 12
    evaluations_last: int = 12
    threads: int | None = None

    def __post_init__(self) -> None:
        """Raise CallerError for an impossible seed, and for a search without starts, evaluations or threads."""
        require_seed(self.seed)
        if self.starts < 1 or self.jumps < 0 or min(self.evaluations_each, self.evaluations_last) < 1:
            raise CallerError(f"a search needs one start or more and no less than 0 jumps: {self.starts}, {self.jumps}")
        if self.threads is not None and self.threads < 1:
            raise CallerError(f"a search needs a thread or more, got {self.threads}")


# Effort by name: one descent to see whether a fit is possible; the default; for a final result.
EFFORTS: Mapping[str, SearchSettings] = {
    "quick": SearchSettings(starts=1, jumps=0, evaluations_each=5, evaluations_last=5),
    "normal": SearchSettings(),
    "thorough": SearchSettings(starts=8, jumps=10, evaluations_each=15, evaluations_last=20),
}


def settings_of_effort(effort: str) -> SearchSettings:
    """Return the settings of a search by the name of its effort.

    Parameters
    ----------
    effort
        "quick" (one descent), "normal" (the default of a calibration) or "thorough".

    Returns
    -------
    The settings.

    Raises
    ------
    CallerError
        If the word is another one.
    """
    if effort not in EFFORTS:
        raise CallerError(f"there is no effort '{effort}'{nearest_hint(effort, EFFORTS)}")
    return EFFORTS[effort]


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of a search: vector (n,), residuals (m,), their derivative (m, n), and the number of simulations.

    ``costs`` are the sums of squares at which the descents ended, in their order, and ``ends`` their vectors,
    (descents, n): if several agree, no other minimum was found.
    """

    coordinates: FloatArray
    residuals: FloatArray
    jacobian: FloatArray
    costs: tuple[float, ...]
    ends: FloatArray
    simulations: int

    @property
    def best_ends(self) -> FloatArray:
        """Where the best descents ended, (descents, n): as many as end a search if they agree, of about equal cost."""
        best = np.argsort(self.costs, kind="stable")[:AGREEING]
        costs = np.array(self.costs)[best]
        return np.asarray(self.ends[best[costs <= (1.0 + ALIKE) * costs[0]]])

    @property
    def cost(self) -> float:
        """Sum of squares of the residuals."""
        return float(self.residuals @ self.residuals)


class ParallelProblem:
    """A problem with threads to simulate it on, and a count of simulations; ``on_step`` may raise to stop a search."""

    def __init__(
        self, problem: LeastSquaresProblem, each: Callable[..., list[FloatArray | None]], on_step: OnStep | None = None
    ) -> None:
        """Take a problem and a map over vectors."""
        self.problem = problem
        self.simulations = 0
        self._each = each
        self._on_step = on_step or (lambda: None)

    def residuals(self, coordinates: FloatArray) -> FloatArray | None:
        """Return residuals at a vector, None if its wire cannot be simulated."""
        self._on_step()
        self.simulations += 1
        return residuals_or_none(self.problem, coordinates)

    def several(self, vectors: Sequence[FloatArray]) -> list[FloatArray | None]:
        """Return residuals at several vectors, simulated in parallel."""
        self._on_step()
        self.simulations += len(vectors)
        return self._each(lambda vector: residuals_or_none(self.problem, vector), vectors)

    def inside(self, coordinates: FloatArray) -> FloatArray:
        """Return a vector moved off the bounds, from which a descent may begin."""
        margin = 1e-4 * (self.problem.high - self.problem.low)
        return np.clip(coordinates, self.problem.low + margin, self.problem.high - margin)


def residuals_or_none(problem: LeastSquaresProblem, coordinates: FloatArray) -> FloatArray | None:
    """Return residuals, None if the simulation diverges."""
    try:
        residuals = problem.residuals(coordinates)
    except NumericsError:
        return None
    return residuals if np.all(np.isfinite(residuals)) else None


@contextmanager
def threads(count: int | None) -> Iterator[Callable[..., list[FloatArray | None]]]:
    """Yield a map over vectors that runs on all cores, in order."""
    with ThreadPoolExecutor(count or os.cpu_count() or 1) as pool:
        yield lambda function, vectors: list(pool.map(function, vectors))


def search(
    problem: LeastSquaresProblem,
    settings: SearchSettings,
    *,
    journal: SearchJournal | None = None,
    on_progress: OnProgress | None = None,
    on_step: OnStep | None = None,
) -> SearchResult:
    """Return the best vector found, repeatable for one seed with any number of threads.

    Parameters
    ----------
    problem
        Residuals of a vector, and its bounds.
    settings
        Seed and effort.
    journal
        Journal of finished descents: an interrupted search continues after the last of them. None for no journal.
    on_progress
        Called after each descent with the stage's name, the number of finished descents and of all, and the best sum of
        squares; an exception that it raises ends the search.
    on_step
        Called many times during a descent; an exception that it raises ends the search.

    Returns
    -------
    The vector, its residuals, their derivative, and the number of simulations.

    Raises
    ------
    NumericsError
        If no vector can be simulated.

    References
    ----------
    Branch, Coleman and Li 1999, doi 10.1137/S1064827595289108, for each descent.
    """
    report = on_progress or (lambda *_: None)
    with threads(settings.threads) as each:
        parallel = ParallelProblem(problem, each, on_step)
        ends = descents(parallel, settings, journal, report)
        if not np.isfinite(min(cost for cost, _ in ends)):
            raise NumericsError("no candidate could be simulated: check the recording's bench, drive and units")
        rough = min(ends, key=lambda end: end[0])[1]
        fine = ParallelProblem(problem.refined(), each, on_step)
        best = rough
        for step in LAST_STEPS:
            _, best = descend(fine, best, 1.0, settings.evaluations_last, step)
        residuals = fine.residuals(best)
        if residuals is None:
            raise NumericsError("the best candidate cannot be simulated: report this with the recording")
        report("local search", 1, 1, float(residuals @ residuals))
        slope = jacobian(fine, best, residuals, FINAL_STEP, central=True)
    return SearchResult(
        best,
        residuals,
        slope,
        tuple(cost for cost, _ in ends),
        np.array([vector for _, vector in ends]),
        parallel.simulations + fine.simulations,
    )


def descents(
    parallel: ParallelProblem, settings: SearchSettings, journal: SearchJournal | None, report: OnProgress
) -> list[tuple[float, FloatArray]]:
    """Return the ends of all graduated descents, (cost, vector), in their order."""
    size = parallel.problem.low.size
    ends: list[tuple[float, FloatArray]] = []
    for number in range(settings.starts + settings.jumps):
        # Each start has its own stream, so that descents read from a journal do not change the others.
        random = np.random.default_rng([settings.seed, number])
        remembered = journal.next() if journal is not None else None
        if remembered is not None:
            ends.append((remembered[0], np.array(remembered[2:])))
            parallel.simulations += int(remembered[1])
        else:
            before = parallel.simulations
            ends.append(one_descent(parallel, ends, number, settings, random, size))
            if journal is not None:
                journal.write([ends[-1][0], parallel.simulations - before, *ends[-1][1]])
        costs = sorted(cost for cost, _ in ends)
        report("global search", number + 1, settings.starts + settings.jumps, costs[0])
        if len(costs) >= AGREEING and costs[AGREEING - 1] <= (1.0 + AGREEMENT) * costs[0]:
            break
    return ends


def one_descent(
    parallel: ParallelProblem,
    ends: Sequence[tuple[float, FloatArray]],
    number: int,
    settings: SearchSettings,
    random: np.random.Generator,
    size: int,
) -> tuple[float, FloatArray]:
    """Descend from the prior's mean, from a draw, or from a jump off the best end."""
    jump = random.standard_normal(size)
    if number < settings.starts:
        vector = parallel.problem.start(number, START_SPREAD * jump if number else np.zeros(size))
        scales: tuple[float, ...] = START_SCALES
    else:
        vector, scales = min(ends, key=lambda end: end[0])[1] + JUMP_SPREAD * jump, JUMP_SCALES
    cost = np.inf
    for uncertainty_scale in scales:
        cost, vector = descend(parallel, vector, uncertainty_scale, settings.evaluations_each, SEARCH_STEP)
        if not np.isfinite(cost):
            break
    return cost, vector


def descend(
    parallel: ParallelProblem, start: FloatArray, uncertainty_scale: float, evaluations: int, step: float
) -> tuple[float, FloatArray]:
    """Return cost and vector of the least-squares minimum next to ``start``.

    The uncertainty of the observations is multiplied by ``uncertainty_scale``, and the cost is that of the problem so
    relaxed. It is infinite if the start cannot be simulated.
    """
    from scipy.optimize import least_squares

    first = parallel.residuals(parallel.inside(start))
    if first is None:
        return np.inf, start
    weight = np.ones(first.size)
    weight[: first.size - start.size] /= uncertainty_scale

    def residuals(vector: FloatArray) -> FloatArray:
        found = parallel.residuals(vector)
        return np.full(first.size, IMPOSSIBLE) if found is None else weight * found

    def slope(vector: FloatArray) -> FloatArray:
        here = parallel.residuals(vector)
        if here is None:
            return np.zeros((first.size, vector.size))
        return np.asarray(weight[:, None] * jacobian(parallel, vector, here, step, central=False))

    fit = least_squares(
        residuals,
        parallel.inside(start),
        jac=slope,
        bounds=(parallel.problem.low, parallel.problem.high),
        ftol=1e-3 if uncertainty_scale > 1.0 else 1e-5,
        xtol=1e-4,
        max_nfev=evaluations,
    )
    return 2.0 * float(fit.cost), np.asarray(fit.x)


def jacobian(
    parallel: ParallelProblem, coordinates: FloatArray, here: FloatArray, step: float, *, central: bool
) -> FloatArray:
    """Return the derivative of residuals by coordinates, (m, n), by differences within the bounds.

    ``here`` are the residuals at ``coordinates``. A column whose vectors cannot be simulated is zero.
    """
    low, high = parallel.problem.low, parallel.problem.high
    vectors = []
    for index in range(coordinates.size):
        for sign in (-1.0, 1.0) if central else (1.0 if coordinates[index] + step < high[index] else -1.0,):
            vector = coordinates.copy()
            vector[index] = min(max(vector[index] + sign * step, low[index]), high[index])
            vectors.append(vector)
    found = parallel.several(vectors)
    columns = []
    for index in range(coordinates.size):
        before, after = (found[2 * index], found[2 * index + 1]) if central else (here, found[index])
        width = (vectors[2 * index + 1] - vectors[2 * index] if central else vectors[index] - coordinates)[index]
        usable = before is not None and after is not None and width != 0.0
        columns.append((after - before) / width if usable else np.zeros_like(here))  # type: ignore[operator]
    return np.stack(columns, axis=1)
