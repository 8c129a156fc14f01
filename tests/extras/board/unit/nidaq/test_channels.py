"""Scales and the division of a sample period: arithmetic without a card."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.extras.board._nidaq.configuration import SETTLING_READINGS, layout_of
from musclewire.extras.board._nidaq.scale import LinearScale

NUMBERS = st.floats(-1e3, 1e3).filter(lambda value: abs(value) > 1e-3)


@given(NUMBERS, NUMBERS, NUMBERS)
def test_a_scale_and_back_is_the_same(per_volt: float, offset: float, voltage_v: float) -> None:
    scale = LinearScale(per_volt, offset)
    assert scale.voltage_v(scale.quantity(voltage_v)) == pytest.approx(voltage_v, rel=1e-6, abs=1e-6)


def test_the_largest_quantity_is_that_of_the_nearer_end() -> None:
    assert LinearScale(2.0, 0.5).largest(10.0) == pytest.approx(19.5)


@pytest.mark.parametrize(
    ("clocked", "waiting", "span"),
    [
        # On demand: the host's time, then the averaged readings; what is left of a late period, or the next one.
        (False, 0, (50, 40, 1)),
        (False, 10, (50, 40, 1)),
        (False, 25, (50, 25, 1)),
        (False, 31, (100, 40, 2)),
        (False, 120, (150, 30, 3)),
        # By the card's clock: a late write skips to the edge at which it is out.
        (True, 9, (50, 40, 1)),
        (True, 10, (100, 40, 2)),
        (True, 59, (100, 40, 2)),
        (True, 60, (150, 40, 3)),
    ],
)
def test_a_write_has_the_rest_of_its_period_or_skips_it(clocked: bool, waiting: int, span: tuple[int, ...]) -> None:
    layout = layout_of(0.05, 1000.0, 40, clocked=clocked)
    assert layout.first() == ((41, 40, 1) if clocked else (50, 40, 1))
    assert layout.following(waiting) == span


@given(st.integers(3, 200), st.data(), st.integers(0, 2000), st.booleans())
def test_no_averaged_reading_is_older_than_the_write(
    period: int, data: st.DataObject, waiting: int, clocked: bool
) -> None:
    settling = SETTLING_READINGS if clocked else 0
    readings = data.draw(st.integers(1, period - settling - 1))
    layout = layout_of(period / 1000.0, 1000.0, readings, clocked=clocked)
    span = layout.following(waiting)
    assert 1 <= span.average <= readings
    assert 2 * span.average >= readings
    assert span.fetch == span.periods * period
    first_averaged = span.fetch - span.average
    assert first_averaged >= waiting
    if clocked:
        # Since the last sample ended, the next edge comes after the host's time, and then every period.
        edges = range(layout.decision, waiting + 2 * period, period)
        taken_at = next(edge for edge in edges if edge >= waiting)
        assert first_averaged >= taken_at + settling


@pytest.mark.parametrize(
    ("rate_hz", "readings", "clocked", "expected"),
    [
        (1010.0, 10, False, "whole number"),
        (1000.0, 50, False, "average at most 49"),
        (1000.0, 49, True, "average at most 48"),  # the card's clock needs a reading to settle
    ],
)
def test_numbers_that_do_not_fit_are_refused(rate_hz: float, readings: int, clocked: bool, expected: str) -> None:
    with pytest.raises(CallerError, match=expected):
        layout_of(0.05, rate_hz, readings, clocked=clocked)
