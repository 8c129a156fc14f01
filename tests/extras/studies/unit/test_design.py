"""The runs of a study: all points, all samples, the same each time."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.extras.studies._design import METHODS, design_of, run_seed, saltelli_points, unit_cube
from musclewire.extras.studies._varied_parameters import GridAxis, SampledParameter


def plain(values: FloatArray) -> FloatArray:
    return values


def sampled(name: str) -> SampledParameter:
    return SampledParameter(name, "1", plain)


axes = st.lists(st.integers(1, 4), max_size=3).map(
    lambda sizes: [GridAxis(f"a{place}", "N", tuple(10.0 * place + k for k in range(size)))
                   for place, size in enumerate(sizes)]
)  # fmt: skip


@given(axes, st.integers(0, 2), st.integers(1, 5))
def test_the_runs_are_every_point_of_the_grid_with_every_sample(grid: list[GridAxis], drawn: int, samples: int) -> None:
    design = design_of([*grid, *(sampled(f"s{k}") for k in range(drawn))], "random", samples, 3)
    points = list(itertools.product(*(axis.values for axis in grid)))
    rows = design.rows(0, len(design))
    assert len(rows) == len(points) * samples
    assert [row[: len(grid)] for row in rows] == [point for point in points for _ in range(samples)]
    for place, name in enumerate(design.names):
        assert design.column(name).tolist() == [row[place] for row in rows]


@given(axes, st.data())
def test_any_part_of_the_runs_is_that_part_of_all(grid: list[GridAxis], data: st.DataObject) -> None:
    design = design_of([*grid, sampled("s")], "latin-hypercube", 4, 1)
    first = data.draw(st.integers(0, len(design)))
    stop = data.draw(st.integers(first, len(design)))
    assert design.rows(first, stop) == design.rows(0, len(design))[first:stop]


@pytest.mark.parametrize("method", METHODS)
def test_the_same_seed_makes_the_same_runs_and_another_one_others(method: str) -> None:
    one, same, other = (unit_cube(method, 3, 16, seed) for seed in (5, 5, 6))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)
    assert ((one > 0.0) & (one < 1.0)).all()


def test_each_row_and_column_of_a_latin_hypercube_is_taken_once() -> None:
    cells = np.floor(unit_cube("latin-hypercube", 4, 50, 1) * 50).astype(int)
    assert all(sorted(column.tolist()) == list(range(50)) for column in cells.T)


def test_a_sobol_sequence_fills_every_dyadic_interval_equally() -> None:
    points = unit_cube("sobol", 3, 64, 2)
    for column in points.T:
        assert np.bincount((column * 64).astype(int), minlength=64).tolist() == [1] * 64


def test_saltellis_points_exchange_one_coordinate_at_a_time() -> None:
    pairs = np.arange(8.0).reshape(2, 4) / 10.0
    points = saltelli_points(pairs)
    assert points.tolist() == [
        [0.0, 0.1], [0.2, 0.1], [0.0, 0.3], [0.2, 0.3],
        [0.4, 0.5], [0.6, 0.5], [0.4, 0.7], [0.6, 0.7],
    ]  # fmt: skip


def test_the_seed_of_a_run_depends_on_its_number_alone() -> None:
    seeds = [run_seed(1, run) for run in range(1000)]
    assert len(set(seeds)) == 1000
    assert run_seed(1, 17) == seeds[17]
    assert run_seed(2, 17) != seeds[17]


def test_more_runs_than_anybody_evaluates_are_refused() -> None:
    with pytest.raises(CallerError, match="more than 10000000"):
        design_of([GridAxis(name, "N", tuple(map(float, range(300)))) for name in "abc"], "random", 1, 1)
