"""SciPy's least squares from several starts, for the vector that fits the observations.

The uncertainty of the observations is large at first and falls from descent to descent (graduated least squares): at a
large one the valley is wide and smooth, and it narrows around the current vector. Starts are the prior's mean and draws
from the prior, with those that a prior states; then jumps from the best vector. Last comes a descent from the best with
the finest time step, whose derivative gives the uncertainty. Each is a trust-region reflective descent within bounds
(Branch, Coleman and Li 1999, doi 10.1137/S1064827595289108). Derivatives are simulated on threads: the simulator
releases the interpreter's lock.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, NumericsError, nearest_hint
from musclewire.extras.calibration._physical.posterior import PosteriorProblem
from musclewire.parameters import require_seed

OnProgress = Callable[[str, int, int, float], None]
OnStep = Callable[[], None]

# A candidate that cannot be simulated has this value in every residual.
IMPOSSIBLE = 1e4
# Steps of a derivative, in prior standard deviations. They were chosen for an ensemble with edges between its grains,
# which smaller steps showed; two fronts have none. Larger ones show curvature.
SEARCH_STEP = 0.05  # of the descents
LAST_STEPS = (0.1, 0.03)  # of the last descents, from the best end
FINAL_STEP = 0.05  # of the slopes from which the uncertainty follows
# Factors on the observations' uncertainty, descent by descent.
START_SCALES = (100.0, 30.0, 10.0, 3.0, 1.0)
JUMP_SCALES = (10.0, 3.0, 1.0)
AGREEING = 3  # descents with about the best cost after which no more are made
AGREEMENT = 1e-3  # of the best cost, by which theirs may be above it
# Ends within this fraction of the best cost are as good as it: the model's own error is larger.
ALIKE = 0.1
# Spread in prior standard deviations.
START_SPREAD = 0.8  # of the starts about the prior
JUMP_SPREAD = 0.5  # of the jumps from the best end
# A descent begins off the bounds by this fraction of their distance.
OFF_BOUNDS = 1e-4


class SearchJournal:
    """A text file whose first line identifies a search, with a line of numbers for each of its descents."""

    def __init__(self, path: Path, fingerprint: str) -> None:
        """Open or create a journal. Raises CallerError for a file that belongs to another search."""
        self._path = path
        try:
            self.descents = read_journal(path, fingerprint) if path.exists() else []
            lines = [{"search": fingerprint}, *self.descents]
            path.write_text("".join(json.dumps(line) + "\n" for line in lines), "utf-8")
        except OSError as problem:
            raise CallerError(f"{path}: cannot be written: {problem.strerror or problem}; check the folder") from None

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
    """Return the descents in a journal but an incomplete last one. Raises CallerError if it is of another search."""
    try:
        first, *lines = path.read_bytes().splitlines()
        belongs = json.loads(first)["search"] == fingerprint
    except (KeyError, TypeError, ValueError):
        raise CallerError(f"{path} is not the journal of a search: give another output, or move it away") from None
    if not belongs:
        raise CallerError(
            f"{path} belongs to a search with other recordings, settings or another version: finish that one, or "
            "delete the file"
        )
    return [json.loads(line) for line in lines if line.endswith(b"]")]


@dataclass(frozen=True)
class SearchSettings:
    """Effort of a search; the defaults suit a wire with some thirty unknowns.

    Raises CallerError for an impossible seed, and for a search without starts, evaluations or threads.
    """

    seed: int = 1  # seed of the starting points
    starts: int = 4  # number of descents from points of the prior, one or more
    jumps: int = 5  # number of descents from points near the best one
    evaluations_each: int = 12  # evaluations of each of these descents
    evaluations_last: int = 12  # evaluations of the last descent, from the best point
    threads: int | None = None  # number of threads; None for as many as there are processor cores

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
        For another name; the message suggests the nearest.
    """
    if effort not in EFFORTS:
        raise CallerError(f"there is no effort '{effort}'{nearest_hint(effort, EFFORTS)}")
    return EFFORTS[effort]


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of a search: vector (n,), residuals (m,), their derivative (m, n), and the number of simulations."""

    coordinates: FloatArray
    residuals: FloatArray
    jacobian: FloatArray
    costs: tuple[float, ...]  # at the ends of the descents; if several agree, no other minimum was found
    ends: FloatArray  # (descents, n)
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
    """A problem that is simulated on threads, and a count of simulations; ``on_step`` may raise to stop a search."""

    def __init__(self, problem: PosteriorProblem, pool: ThreadPoolExecutor, on_step: OnStep | None = None) -> None:
        """Take a problem and the threads."""
        self.problem, self.simulations = problem, 0
        self._pool, self._on_step = pool, on_step or (lambda: None)

    def several(self, vectors: Sequence[FloatArray]) -> list[FloatArray | None]:
        """Return residuals at several vectors, None for a wire that cannot be simulated."""
        self._on_step()
        self.simulations += len(vectors)
        return list(self._pool.map(self._residuals, vectors))

    def residuals(self, coordinates: FloatArray) -> FloatArray | None:
        """Return residuals at a vector, None if its wire cannot be simulated."""
        return self.several([coordinates])[0]

    def _residuals(self, coordinates: FloatArray) -> FloatArray | None:
        try:
            residuals = self.problem.residuals(coordinates)
        except NumericsError:
            return None
        return residuals if np.all(np.isfinite(residuals)) else None


def threads(count: int | None) -> ThreadPoolExecutor:
    """Return so many threads, or one for each core."""
    return ThreadPoolExecutor(count or os.cpu_count() or 1)


def search(
    problem: PosteriorProblem,
    settings: SearchSettings,
    *,
    journal: SearchJournal | None = None,
    on_progress: OnProgress | None = None,
    on_step: OnStep | None = None,
) -> SearchResult:
    """Return the best vector, repeatable for one seed. Raises NumericsError if no vector can be simulated."""
    report = on_progress or (lambda *_: None)
    with threads(settings.threads) as pool:
        parallel = ParallelProblem(problem, pool, on_step)
        ends = descents(parallel, settings, journal, report)
        cost, best = min(ends, key=lambda end: end[0])
        if not np.isfinite(cost):
            raise NumericsError("no candidate could be simulated: check the recording's bench, drive and units")
        fine = ParallelProblem(problem.refined(), pool, on_step)
        for step in LAST_STEPS:
            _, best = descend(fine, best, 1.0, settings.evaluations_last, step)
        residuals = fine.residuals(best)
        if residuals is None:
            raise NumericsError("the best candidate cannot be simulated: report this with the recording")
        report("local search", 1, 1, float(residuals @ residuals))
        slope = jacobian(fine, best, residuals, FINAL_STEP, central=True)
    costs, vectors = tuple(cost for cost, _ in ends), np.array([vector for _, vector in ends])
    return SearchResult(best, residuals, slope, costs, vectors, parallel.simulations + fine.simulations)


def descents(
    parallel: ParallelProblem, settings: SearchSettings, journal: SearchJournal | None, report: OnProgress
) -> list[tuple[float, FloatArray]]:
    """Return the ends of all graduated descents, (cost, vector), in their order."""
    remembered = [] if journal is None else journal.descents
    ends: list[tuple[float, FloatArray]] = []
    for number in range(settings.starts + settings.jumps):
        if number < len(remembered):
            cost, simulations, *vector = remembered[number]
            ends.append((cost, np.array(vector)))
            parallel.simulations += int(simulations)
        else:
            before = parallel.simulations
            ends.append(one_descent(parallel, ends, number, settings))
            if journal is not None:
                journal.write([ends[-1][0], parallel.simulations - before, *ends[-1][1]])
        costs = sorted(cost for cost, _ in ends)
        report("global search", number + 1, settings.starts + settings.jumps, costs[0])
        if len(costs) >= AGREEING and costs[AGREEING - 1] <= (1.0 + AGREEMENT) * costs[0]:
            break
    return ends


def one_descent(
    parallel: ParallelProblem, ends: Sequence[tuple[float, FloatArray]], number: int, settings: SearchSettings
) -> tuple[float, FloatArray]:
    """Descend from the prior's mean, from a draw, or from a jump off the best end."""
    # Each has its own stream, so that descents read from a journal do not change the others.
    drawn = np.random.default_rng([settings.seed, number]).standard_normal(parallel.problem.low.size)
    if number < settings.starts:
        start = parallel.problem.start(number, START_SPREAD * drawn if number else np.zeros_like(drawn))
        return graduated(parallel, start, START_SCALES, settings.evaluations_each)
    start = min(ends, key=lambda end: end[0])[1] + JUMP_SPREAD * drawn
    return graduated(parallel, start, JUMP_SCALES, settings.evaluations_each)


def graduated(
    parallel: ParallelProblem, start: FloatArray, scales: Sequence[float], evaluations: int
) -> tuple[float, FloatArray]:
    """Return cost and vector after descents by falling uncertainties; the cost is infinite if none can be made."""
    cost, vector = np.inf, start
    for scale in scales:
        cost, vector = descend(parallel, vector, scale, evaluations, SEARCH_STEP)
        if not np.isfinite(cost):
            break
    return cost, vector


def descend(
    parallel: ParallelProblem, start: FloatArray, uncertainty_scale: float, evaluations: int, step: float
) -> tuple[float, FloatArray]:
    """Return cost and vector of the least-squares minimum next to ``start``; infinite if that cannot be simulated.

    The uncertainty of the observations is multiplied by ``uncertainty_scale``, and the cost is that of the problem so
    relaxed.
    """
    from scipy.optimize import least_squares

    low, high = parallel.problem.low, parallel.problem.high
    margin = OFF_BOUNDS * (high - low)
    inside = np.clip(start, low + margin, high - margin)
    first = parallel.residuals(inside)
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
        inside,
        jac=slope,
        bounds=(low, high),
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

    def moved(steps: FloatArray) -> list[FloatArray]:
        return [np.clip(coordinates + one, low, high) for one in np.diag(steps)]

    size = coordinates.size
    ahead = moved(np.full(size, step) if central else np.where(coordinates + step < high, step, -step))
    back = moved(np.full(size, -step)) if central else []
    found = parallel.several([*ahead, *back])
    columns = []
    for place, (after, before) in enumerate(zip(found[:size], found[size:] or [here] * size, strict=True)):
        width = (ahead[place] - (back[place] if central else coordinates))[place]
        usable = after is not None and before is not None and width != 0.0
        columns.append((after - before) / width if usable else np.zeros_like(here))  # type: ignore[operator]
    return np.stack(columns, axis=1)
