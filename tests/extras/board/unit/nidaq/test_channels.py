"""Scales and the division of a sample period: arithmetic without a card."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.extras.board._nidaq.channels import SETTLING_READINGS, LinearScale, layout_of

NUMBERS = st.floats(-1e3, 1e3).filter(lambda value: abs(value) > 1e-3)


def test_a_scale_turns_volts_into_a_quantity() -> None:
    lvdt = LinearScale(per_volt=1e-3, offset=-2e-3)
    assert lvdt.quantity(3.0) == pytest.approx(1e-3)
    assert lvdt.voltage_v(1e-3) == pytest.approx(3.0)


@given(NUMBERS, NUMBERS, NUMBERS)
def test_a_scale_and_back_is_the_same(per_volt: float, offset: float, voltage_v: float) -> None:
    scale = LinearScale(per_volt, offset)
    assert scale.voltage_v(scale.quantity(voltage_v)) == pytest.approx(voltage_v, rel=1e-6, abs=1e-6)


def test_the_largest_quantity_is_that_of_the_nearer_end() -> None:
    assert LinearScale(2.0, 0.5).largest(10.0) == pytest.approx(19.5)


def test_a_period_on_demand_is_the_hosts_time_then_the_averaged_readings() -> None:
    layout = layout_of(0.05, 1000.0, 40, clocked=False)
    assert layout.period == 50
    assert layout.decision == 10
    assert layout.first() == (50, 40, 1)
    assert layout.following(0) == layout.following(10) == (50, 40, 1)


def test_a_period_by_the_cards_clock_settles_averages_and_leaves_the_rest_to_the_host() -> None:
    layout = layout_of(0.05, 1000.0, 40, clocked=True)
    assert layout.decision == 9
    assert layout.first() == (41, 40, 1)
    assert layout.following(9) == (50, 40, 1)


def test_a_late_write_on_demand_averages_what_is_left_of_its_period_or_skips_it() -> None:
    layout = layout_of(0.05, 1000.0, 40, clocked=False)
    assert layout.following(25) == (50, 25, 1)
    assert layout.following(31) == (100, 40, 2)
    assert layout.following(120) == (150, 30, 3)


def test_a_late_write_by_the_cards_clock_skips_to_the_edge_at_which_it_is_out() -> None:
    layout = layout_of(0.05, 1000.0, 40, clocked=True)
    assert layout.following(10) == (100, 40, 2)
    assert layout.following(59) == (100, 40, 2)
    assert layout.following(60) == (150, 40, 3)


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
    ("period_s", "rate_hz", "readings", "expected"),
    [
        (0.05, 1010.0, 10, "whole number"),
        (0.05, 1000.0, 50, "average at most 49"),
        (0.001, 100.0, 1, "whole number"),
    ],
)
def test_numbers_that_do_not_fit_are_refused(period_s: float, rate_hz: float, readings: int, expected: str) -> None:
    with pytest.raises(CallerError, match=expected):
        layout_of(period_s, rate_hz, readings, clocked=False)


def test_the_cards_clock_needs_a_reading_to_settle() -> None:
    with pytest.raises(CallerError, match="average at most 48"):
        layout_of(0.05, 1000.0, 49, clocked=True)
