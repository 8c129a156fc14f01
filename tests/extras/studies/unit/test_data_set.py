"""A study as xarray: every number where its parameters say, units, series, and the axes of a grid as dimensions."""

from __future__ import annotations

import numpy as np
from tests.extras.studies.unit.study_parts import study_of

from musclewire.extras.studies import StudyResult, read_study
from musclewire.extras.studies._data_set import on_grid
from musclewire.extras.studies._study import joined


def result_of(series: bool = False) -> StudyResult:
    """Return a study of a grid of 3 x 2 points with 4 samples each, whose quantities are the runs' numbers."""
    run = {"kind": "characterize", "keep": ["stroke", "strain"] if series else ["stroke"]}
    plan = read_study(
        study_of(
            run=run,
            sampling={"method": "sobol", "samples": 4},
            parameters={
                "pretension": {"values": ["1 N", "2 N", "3 N"]},
                "convection_factor": {"low": 0.8, "high": 1.0},
                "wire": {"values": ["paper-100um", "paper-125um"]},
            },
        )
    )
    columns = {"stroke": np.arange(24.0)}
    if series:
        columns["strain"] = np.arange(24.0)[:, None] + np.array([0.0, 0.25, 0.5])
    return StudyResult(plan, columns, ("",) * 23 + ("NumericsError: lost",))


def test_the_axes_of_a_grid_become_dimensions() -> None:
    result = result_of(series=True)
    grid = on_grid(result.dataset())
    assert grid["strain"].sizes == {"pretension": 3, "wire": 2, "draw": 4, "sample": 3}
    flat = result.dataset()
    for run in range(24):
        where = {"pretension": float(flat["pretension"][run]), "wire": str(flat["wire"].values[run])}
        point = grid.sel(where)
        draw = int(np.flatnonzero(point["convection_factor"].values == flat["convection_factor"].values[run])[0])
        assert point["stroke"].values[draw] == run
        assert point["strain"].values[draw].tolist() == [run, run + 0.25, run + 0.5]


def test_series_of_different_lengths_end_with_nan() -> None:
    found = joined([np.ones((2, 2)), np.zeros((1, 3))])
    assert np.isnan(found).tolist() == [[False, False, True], [False, False, True], [False, False, False]]
    assert joined([]).size == 0
    assert joined([np.empty((2, 0))]).shape == (2, 1)
