"""The runs of a study: which values each has, and the seed of each run. The same study makes the same runs."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.extras.studies._varied_parameters import GridAxis, SampledParameter, Value

# How the unit cube of the sampled parameters is filled.
METHODS = ("random", "latin-hypercube", "sobol", "halton", "saltelli")
MAX_RUNS = 10_000_000


@dataclass(frozen=True, eq=False)
class StudyDesign:
    """The values of all runs: every point of the grid with every sample, the samples of a point next to each other."""

    axes: tuple[GridAxis, ...]  # the last one changes fastest
    sampled: tuple[tuple[str, str], ...]  # names and units
    samples: FloatArray  # (n_samples, n_sampled), in SI
    method: str  # "" without any samples

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all parameters, those of the grid first."""
        return (*(axis.name for axis in self.axes), *(name for name, _ in self.sampled))

    @property
    def units(self) -> dict[str, str]:
        """SI unit of each parameter, "" for a name."""
        return {**{axis.name: axis.unit for axis in self.axes}, **dict(self.sampled)}

    @property
    def points(self) -> int:
        """Number of points of the grid."""
        return int(np.prod([len(axis.values) for axis in self.axes], dtype=np.int64))

    def __len__(self) -> int:
        """Return the number of runs."""
        return self.points * len(self.samples)

    def rows(self, first: int, stop: int) -> list[tuple[Value, ...]]:
        """Return the values of the runs from ``first`` to before ``stop``, in the order of ``names``."""
        return [self._row(run) for run in range(first, stop)]

    def _row(self, run: int) -> tuple[Value, ...]:
        point, sample = divmod(run, len(self.samples))
        values: list[Value] = []
        for axis in reversed(self.axes):
            point, place = divmod(point, len(axis.values))
            values.append(axis.values[place])
        return (*reversed(values), *self.samples[sample].tolist())

    def column(self, name: str) -> np.ndarray[Any, Any]:
        """Return the values of one parameter over all runs, (n_runs,): numbers in SI, or texts."""
        place = self.names.index(name)
        if place >= len(self.axes):
            return np.tile(self.samples[:, place - len(self.axes)], self.points)
        before = int(np.prod([len(axis.values) for axis in self.axes[:place]], dtype=np.int64))
        after = len(self) // (before * len(self.axes[place].values))
        return np.tile(np.repeat(np.array(self.axes[place].values), after), before)


def design_of(parameters: Sequence[GridAxis | SampledParameter], method: str, samples: int, seed: int) -> StudyDesign:
    """Return the runs of a study; "saltelli" makes ``samples`` times two plus the sampled parameters."""
    axes = tuple(item for item in parameters if isinstance(item, GridAxis))
    drawn = [item for item in parameters if isinstance(item, SampledParameter)]
    cube = unit_cube(method, len(drawn), samples, seed) if drawn else np.empty((samples, 0))
    columns = [item.quantile(cube[:, place]) for place, item in enumerate(drawn)]
    values = np.column_stack(columns) if columns else cube
    for item, column in zip(drawn, columns, strict=True):
        if not np.isfinite(column).all():
            raise CallerError(f"parameters.{item.name}: the distribution has values that are not finite: truncate it")
    design = StudyDesign(axes, tuple((item.name, item.unit) for item in drawn), values, method if drawn else "")
    if len(design) > MAX_RUNS:
        raise CallerError(f"this study has {len(design)} runs, more than {MAX_RUNS}: fewer points or samples")
    return design


def unit_cube(method: str, dimensions: int, samples: int, seed: int) -> FloatArray:
    """Return points of the unit cube, (n, dimensions), inside of it and never on its faces."""
    if method in ("sobol", "saltelli") and samples & (samples - 1):
        below = 1 << (samples.bit_length() - 1)
        raise CallerError(f"sampling.samples is {samples}: '{method}' needs a power of 2, {below} or {2 * below}")
    if method == "random":
        return np.random.default_rng(seed).random((samples, dimensions))
    if method == "saltelli":
        return saltelli_points(open_cube(sequence("Sobol", 2 * dimensions, seed).random(samples)))
    kinds = {"latin-hypercube": "LatinHypercube", "sobol": "Sobol", "halton": "Halton"}
    return open_cube(sequence(kinds[method], dimensions, seed).random(samples))


def sequence(kind: str, dimensions: int, seed: int) -> Any:
    """Return a generator of points of scipy.stats.qmc, whose argument for randomness was renamed in SciPy 1.15."""
    from scipy.stats import qmc

    engine = getattr(qmc, kind)
    name = "rng" if "rng" in inspect.signature(engine).parameters else "seed"
    return engine(d=dimensions, **{name: np.random.default_rng(seed)})


def open_cube(points: FloatArray) -> FloatArray:
    """Return points of the unit cube, those on its faces moved inside: there many distributions are infinite."""
    least = 2.0**-53
    return np.asarray(np.clip(points, least, 1.0 - least), dtype=np.float64)


def saltelli_points(pairs: FloatArray) -> FloatArray:
    """Return Saltelli's design from points of twice the dimension, (n, 2 d): n (d + 2) points, in SALib's order.

    Each pair (a, b) becomes a, then a with one coordinate after the other taken from b, then b.

    References
    ----------
    Saltelli et al. 2010, doi:10.1016/j.cpc.2009.09.018, Table 2, design (b).
    """
    dimensions = pairs.shape[1] // 2
    first, second = pairs[:, :dimensions], pairs[:, dimensions:]
    points = np.repeat(first[:, None, :], dimensions + 2, axis=1)
    for place in range(dimensions):
        points[:, place + 1, place] = second[:, place]
    points[:, -1, :] = second
    return points.reshape(-1, dimensions)


def run_seed(seed: int, run: int) -> int:
    """Return the seed of a run, which depends on the study's seed and the run's number alone."""
    return int(np.random.SeedSequence(seed, spawn_key=(run,)).generate_state(1)[0])
