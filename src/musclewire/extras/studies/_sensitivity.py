"""How much each quantity of a study depends on each parameter: the indices of SALib, by the study's own runs.

What can be said depends on how the parameters were varied. Saltelli's design gives first and total Sobol indices. Any
other sample gives the first index, from means over classes of a parameter, and PAWN's index, which also shows what
changes a distribution without its mean. With few runs the classes are few, and a wavy dependence looks weaker than it
is. RBD-FAST is for random samples only: in a quasi-random sequence it takes one parameter for another. A grid is
complete, so that its first indices are variances of means: nothing is estimated.

Where some parameters are on a grid and others sampled, all indices are fractions of one variance, that of all runs.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import require_extra
from musclewire.extras.studies._design import StudyDesign

# Fewer runs estimate no index.
MIN_RUNS = 64
# A quantity that varies by less than this fraction of itself does not depend on anything.
MIN_VARIATION = 1e-12
PAWN_SLICES = 10
# Resamples behind the intervals of indices from classes; each takes as long as the index.
RESAMPLES = 25
GRID = "variance of means"


class Sensitivity(NamedTuple):
    """How much a quantity depends on a parameter; None for an index that the study's runs do not give."""

    quantity: str
    parameter: str
    method: str
    first: float | None = None  # first Sobol index: the fraction of the variance that the parameter explains by itself
    first_error: float | None = None  # half width of its 95 % interval; 0 where it is exact
    total: float | None = None  # total Sobol index: the same with all interactions
    total_error: float | None = None  # half width of its 95 % interval
    # Median over slices of the largest distance between distribution functions, with the parameter known and unknown; 0
    # if the parameter has no effect.
    pawn: float | None = None


def sensitivity_of(design: StudyDesign, columns: Mapping[str, FloatArray], seed: int) -> list[Sensitivity]:
    """Return the indices of every quantity that is a number and varies, with intervals by resampling.

    None for quantities of which runs failed in a design that needs all of them, and for fewer runs than 64.

    References
    ----------
    Herman and Usher 2017, doi:10.21105/joss.00097 (SALib); Saltelli et al. 2010, doi:10.1016/j.cpc.2009.09.018;
    Plischke, Borgonovo and Smith 2013, doi:10.1016/j.ejor.2012.11.047 (from given data); Pianosi and Wagener 2018,
    doi:10.1016/j.envsoft.2018.07.019 (PAWN).
    """
    require_extra("a sensitivity table", "sweep")
    found: list[Sensitivity] = []
    if len(design.samples) < MIN_RUNS and design.sampled:
        return found
    for quantity, values in columns.items():
        if values.ndim == 1 and varies(values):
            found += of_grid(design, quantity, values, seed)
            found += of_samples(design, quantity, values, seed)
    return found


def varies(values: FloatArray) -> bool:
    """Return whether a quantity varies at all."""
    finite = values[np.isfinite(values)]
    return bool(finite.size and np.ptp(finite) > MIN_VARIATION * float(np.abs(finite).max()))


def of_grid(design: StudyDesign, quantity: str, values: FloatArray, seed: int) -> list[Sensitivity]:
    """Return the first index of each axis of a grid: the variance of the means over all else, relative to the whole.

    Means over sampled parameters are estimates; their interval is that of drawing the samples again.
    """
    if not np.isfinite(values).all():
        return []
    cube = values.reshape((*(len(axis.values) for axis in design.axes), len(design.samples)))
    exact = first_of_axes(cube)
    errors = np.zeros(len(design.axes))
    if design.sampled:
        draws = np.random.default_rng(seed).integers(cube.shape[-1], size=(RESAMPLES, cube.shape[-1]))
        errors = 1.96 * np.std([first_of_axes(cube[..., draw]) for draw in draws], axis=0)
    return [
        Sensitivity(quantity, axis.name, GRID, first=float(exact[place]), first_error=float(errors[place]))
        for place, axis in enumerate(design.axes)
    ]


def first_of_axes(cube: FloatArray) -> FloatArray:
    """Return the first index of every axis of a cube but the last, which is over samples."""
    whole, axes = float(cube.var()), range(cube.ndim)
    means = [cube.mean(axis=tuple(other for other in axes if other != place)) for place in axes[:-1]]
    return np.array([mean.var() / whole for mean in means])


def of_samples(design: StudyDesign, quantity: str, values: FloatArray, seed: int) -> list[Sensitivity]:
    """Return the indices of the sampled parameters, relative to the variance of all runs, over all points of a grid."""
    if not design.sampled:
        return []
    rows = values.reshape(design.points, len(design.samples))
    analyse = saltelli if design.method == "saltelli" else given_data
    return analyse(design, quantity, rows, seed)


def problem_of(design: StudyDesign) -> dict[str, Any]:
    """Return the sampled parameters as SALib describes them."""
    ends = [[float(column.min()), float(column.max())] for column in design.samples.T]
    return {"num_vars": len(design.sampled), "names": [name for name, _ in design.sampled], "bounds": ends}


def saltelli(design: StudyDesign, quantity: str, rows: FloatArray, seed: int) -> list[Sensitivity]:
    """Return first and total Sobol indices; the design needs every run. ``rows`` [point of the grid, sample]."""
    from SALib.analyze import sobol

    if not np.isfinite(rows).all():
        return []
    problem, whole = problem_of(design), float(rows.var())

    def indices(values: FloatArray) -> dict[str, FloatArray]:
        """Return SALib's indices as parts of the variance of all runs."""
        part = float(values.var()) / whole
        found = sobol.analyze(problem, values, calc_second_order=False, seed=seed) if varies(values) else {}
        return {name: part * np.asarray(found.get(name, 0.0)) for name in ("S1", "S1_conf", "ST", "ST_conf")}

    # A parameter explains by itself what the mean over the grid shows; in total, what is left at each point of it.
    of_mean, at_points = indices(rows.mean(axis=0)), [indices(row) for row in rows]
    total = {
        name: np.mean([np.broadcast_to(one[name], len(design.sampled)) for one in at_points], axis=0)
        for name in of_mean
    }
    first = {name: np.broadcast_to(value, len(design.sampled)) for name, value in of_mean.items()}
    return [
        Sensitivity(
            quantity,
            name,
            "Sobol (Saltelli)",
            first=float(first["S1"][place]),
            first_error=float(first["S1_conf"][place]),
            total=float(total["ST"][place]),
            total_error=float(total["ST_conf"][place]),
        )
        for place, (name, _) in enumerate(design.sampled)
    ]


def given_data(design: StudyDesign, quantity: str, rows: FloatArray, seed: int) -> list[Sensitivity]:
    """Return first index and PAWN's from any sample; samples with a failed run are left out. ``rows`` as above."""
    from SALib.analyze import delta, pawn

    usable = np.isfinite(rows).all(axis=0)
    if usable.sum() < MIN_RUNS or not varies(rows[:, usable]):
        return []
    problem, inputs, outputs = problem_of(design), design.samples[usable], rows[:, usable]
    # SALib refuses some endings of names.
    numbered = {**problem, "names": [f"x{place}" for place in range(problem["num_vars"])]}
    of_mean = outputs.mean(axis=0)
    part = float(of_mean.var() / outputs.var())
    first = delta.analyze(numbered, inputs, of_mean, num_resamples=RESAMPLES, seed=seed, method="sobol")
    slices = pawn.analyze(problem, np.tile(inputs, (len(outputs), 1)), outputs.ravel(), S=PAWN_SLICES, seed=seed)
    return [
        Sensitivity(
            quantity,
            name,
            "classes, PAWN",
            first=part * float(first["S1"][place]),
            first_error=part * float(first["S1_conf"][place]),
            pawn=float(slices["median"][place]),
        )
        for place, (name, _) in enumerate(design.sampled)
    ]


def sensitivity_text(rows: Iterable[Sensitivity]) -> str:
    """Return the table as CSV; an index that is not known is an empty cell."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(Sensitivity._fields)
    writer.writerows([["" if value is None else value for value in row] for row in rows])
    return text.getvalue()
