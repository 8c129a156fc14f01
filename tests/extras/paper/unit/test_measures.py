"""Distances and excursions on curves made by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import spearmanr

from musclewire.errors import RecordingError
from musclewire.extras.paper import lowest_place, outside_band
from musclewire.extras.paper._reproduce.measures import (
    largest_distance,
    off_line_pct,
    off_place_pct,
    one_sided_fraction,
    rank_correlation,
)
from musclewire.extras.paper._reproduce.section3 import distance_of_models_pct
from musclewire.extras.paper._reproduce.staircases import last_less_others_pct
from musclewire.sensing import Branch

RISING = np.linspace(0.0, 10.0, 101)


def test_the_excursion_is_how_far_the_farthest_point_is_from_the_nearer_curve() -> None:
    low, high = Branch(RISING, 0.0 * RISING), Branch(RISING, 0.0 * RISING + 1.0)
    assert outside_band(np.array([1.0, 2.0, 3.0]), np.array([0.5, 1.2, -0.3]), low, high) == pytest.approx(0.3)


def test_curves_are_compared_where_they_overlap_only() -> None:
    one = Branch(RISING, RISING)
    other = Branch(RISING + 5.0, np.where(RISING > 5.0, 99.0, RISING + 5.25))
    assert largest_distance(one, other) == pytest.approx(0.25, abs=1e-9)
    with pytest.raises(RecordingError, match="share no resistance"):
        largest_distance(one, Branch(RISING + 20.0, RISING))


@given(st.floats(2.0, 8.0), st.floats(0.1, 5.0))
def test_the_lowest_place_of_a_parabola_is_its_vertex(vertex: float, bend: float) -> None:
    places = np.linspace(0.0, 10.0, 11)
    assert lowest_place(places.tolist(), (bend * (places - vertex) ** 2).tolist()) == pytest.approx(vertex, abs=1e-6)


def test_the_lowest_place_at_an_end_is_that_end() -> None:
    assert lowest_place([1.0, 2.0, 3.0], [5.0, 4.0, 3.0]) == 3.0
    assert lowest_place([1.0, 2.0, 3.0], [3.0, 4.0, 5.0]) == 1.0


@given(st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=12, unique=True))
def test_the_rank_correlation_is_that_of_scipy(values: list[float]) -> None:
    places = [float(index) for index in range(len(values))]
    assert rank_correlation(places, values) == pytest.approx(spearmanr(places, values).statistic, abs=1e-12)


def test_one_of_five_gaps_two_places_off_is_seven_tenths() -> None:
    assert rank_correlation([1, 2, 3, 4, 5], [9.0, 8.0, 7.0, 6.0, 5.0]) == pytest.approx(-1.0)
    assert rank_correlation([1, 2, 3, 4, 5], [7.0, 9.0, 8.0, 6.0, 5.0]) == pytest.approx(-0.7)


def test_branches_that_cross_share_less_than_those_apart() -> None:
    base = 5.0 - 0.1 * RISING
    level = Branch(RISING, base)
    assert one_sided_fraction(Branch(RISING, base + 0.2), level) == pytest.approx(1.0, abs=0.01)
    assert one_sided_fraction(Branch(RISING, base - 0.2), level) == pytest.approx(1.0, abs=0.01)
    assert one_sided_fraction(Branch(RISING, base + 0.02 * (RISING - 5.0)), level) == pytest.approx(0.0, abs=0.02)
    # Three quarters above, a quarter below: (9 - 1) / (9 + 1).
    assert one_sided_fraction(Branch(RISING, base + 0.02 * (RISING - 2.5)), level) == pytest.approx(0.8, abs=0.02)


UP_AND_DOWN = np.concatenate([RISING, RISING[-2::-1]])


def test_a_temperature_that_follows_the_voltage_leaves_strain_where_it_was() -> None:
    """However it follows it, as long as heating and cooling have the same."""
    strain = 0.01 * np.sqrt(UP_AND_DOWN)
    assert off_place_pct(UP_AND_DOWN, strain, 20.0 + UP_AND_DOWN**2) == pytest.approx(0.0, abs=1e-9)


def test_a_temperature_that_lags_moves_the_strain_along_the_voltage() -> None:
    """One volt late on both ways, the strain a straight line over temperature: by that one volt."""
    lag = np.concatenate([np.full(RISING.size, -1.0), np.full(RISING.size - 1, 1.0)])
    temperature = UP_AND_DOWN + lag
    strain = 0.001 * (temperature + 1.0)
    assert off_place_pct(UP_AND_DOWN, strain, temperature) == pytest.approx(100.0 * 0.001 / strain.max(), rel=0.1)


def test_a_straight_line_is_on_its_line_and_a_parabola_a_sixth_of_its_height_off() -> None:
    assert off_line_pct(Branch(RISING, 3.0 - 0.1 * RISING)) == pytest.approx(0.0, abs=1e-9)
    # x^2 from 0 to 1 is fitted by x - 1/6: 1/6 apart at both ends.
    assert off_line_pct(Branch(RISING, (RISING / 10.0) ** 2)) == pytest.approx(100.0 / 6.0, rel=0.01)


@pytest.mark.parametrize(("errors", "above"), [([1.0, 0.5, 2.6], 1.6), ([1.0, 3.0, 2.6], -0.4)])
def test_the_last_step_has_the_largest_error_or_by_how_much_it_has_not(errors: list[float], above: float) -> None:
    steps = [SimpleNamespace(mae_approached_pct=error) for error in errors]
    runs: Any = SimpleNamespace(control_run=SimpleNamespace(metrics=SimpleNamespace(steps=steps)))
    assert last_less_others_pct(runs, staircase="spring") == pytest.approx(above)


def test_two_models_are_as_far_apart_as_their_strains_on_average() -> None:
    model, steeper = (cast(Any, SimpleNamespace(strain=lambda ohm, slope=slope: slope * ohm)) for slope in (1.0, 1.5))
    assert distance_of_models_pct(model, (0.0, 2.0), steeper, (0.0, 2.0)) == pytest.approx(100.0 / 6.0)
    assert distance_of_models_pct(model, (0.0, 3.0), steeper, (0.0, 2.0)) == pytest.approx(0.0, abs=1e-9)
