"""What the page asks for as a target, against its closed form at every sample."""

from __future__ import annotations

import math

import numpy as np
import pytest

from musclewire.errors import CallerError
from musclewire.extras.live._bench.recipes import path_of, require_bounded, sine_of
from musclewire.extras.live._messages import DrawnPath, Sine

PERIOD_S = 0.05


def test_a_sine_begins_at_its_middle_rises_and_ends_after_its_cycles() -> None:
    reference = sine_of(Sine(kind="sine", middle=0.02, amplitude=0.01, period_s=8.0, cycles=2), PERIOD_S)
    for time_s in np.arange(0.0, 16.0, PERIOD_S):
        exact = 0.02 + 0.01 * math.sin(2.0 * math.pi * time_s / 8.0)
        assert reference.target_at(float(time_s)) == pytest.approx(exact, abs=1e-12)
    assert reference.target_at(2.0) == pytest.approx(0.03)
    assert reference.duration_s == pytest.approx(16.0)


def test_a_path_is_straight_between_its_points_and_begins_with_the_first() -> None:
    drawn = DrawnPath(kind="path", time_s=[5.0, 7.0, 8.0], target=[0.01, 0.03, 0.0])
    reference = path_of(drawn, PERIOD_S)
    for after_s, target in ((0.0, 0.01), (1.0, 0.02), (2.0, 0.03), (2.5, 0.015), (3.0, 0.0)):
        assert reference.target_at(after_s) == pytest.approx(target, abs=1e-12)
    assert reference.duration_s == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("time_s", "target"),
    [((0.0,), (0.0,)), ((0.0, 1.0), (0.0,)), ((0.0, 0.0), (0.0, 1.0)), ((1.0, 0.0), (0.0, 1.0))],
)
def test_points_that_are_no_path_are_refused(time_s: tuple[float, ...], target: tuple[float, ...]) -> None:
    with pytest.raises(CallerError, match="times that increase"):
        path_of(DrawnPath.model_construct(kind="path", time_s=time_s, target=target), PERIOD_S)


def test_no_reference_lasts_for_more_than_an_hour() -> None:
    require_bounded(3600.0)
    with pytest.raises(CallerError, match="an hour at most"):
        require_bounded(3601.0)
    with pytest.raises(CallerError, match="an hour at most"):
        sine_of(Sine(kind="sine", middle=0.02, amplitude=0.01, period_s=4.0, cycles=901), PERIOD_S)
    with pytest.raises(CallerError, match="an hour at most"):
        path_of(DrawnPath(kind="path", time_s=[100.0, 3701.0], target=[0.0, 0.01]), PERIOD_S)
