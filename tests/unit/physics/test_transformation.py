from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.physics.material import advantage_k, cooled_grain, fraction_beyond, heated_grain

SETTINGS = settings(derandomize=True, deadline=None, max_examples=300)
FRACTIONS = st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)).map(lambda s: (s[0], (1.0 - s[0]) * s[1]))
DRIVES = st.tuples(*[st.floats(-60.0, 60.0)] * 3)
PER_WIDTHS = st.tuples(*[st.floats(0.05, 50.0)] * 3)
# A few sums and differences of numbers of size 1.
ROUNDING = 1e-14


def test_balance_moves_with_stress_by_clausius_and_clapeyron() -> None:
    assert advantage_k(350.0, 0.0, 350.0, 8e6) == 0.0
    assert advantage_k(350.0, 80e6, 350.0, 8e6) == pytest.approx(10.0)
    assert advantage_k(360.0, 80e6, 350.0, 8e6) == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("force_k", "fraction"), [(-1.0, 0.0), (-0.5, 0.25), (0.0, 0.5), (0.5, 0.75), (1.0, 1.0), (9.0, 1.0)]
)
def test_a_grain_two_kelvin_wide_changes_over_two_kelvin(force_k: float, fraction: float) -> None:
    assert fraction_beyond(force_k, 0.5) == fraction


@SETTINGS
@given(fractions=FRACTIONS, drives=DRIVES, per_widths=PER_WIDTHS, grain=st.sampled_from([cooled_grain, heated_grain]))
def test_fractions_stay_fractions(fractions, drives, per_widths, grain) -> None:
    martensite, r_phase = grain(*fractions, *drives, *per_widths)
    assert -ROUNDING <= martensite <= 1.0 + ROUNDING
    assert -ROUNDING <= r_phase <= 1.0 + ROUNDING
    assert martensite + r_phase <= 1.0 + ROUNDING


@SETTINGS
@given(fractions=FRACTIONS, drives=DRIVES, per_widths=PER_WIDTHS, grain=st.sampled_from([cooled_grain, heated_grain]))
def test_doing_it_again_changes_nothing(fractions, drives, per_widths, grain) -> None:
    once = grain(*fractions, *drives, *per_widths)
    twice = grain(*once, *drives, *per_widths)
    assert twice == pytest.approx(once, abs=ROUNDING)


@SETTINGS
@given(fractions=FRACTIONS, drives=DRIVES, per_widths=PER_WIDTHS)
def test_cooling_never_takes_martensite_nor_gives_austenite(fractions, drives, per_widths) -> None:
    martensite, r_phase = cooled_grain(*fractions, *drives, *per_widths)
    assert martensite >= fractions[0] - ROUNDING
    assert martensite + r_phase >= sum(fractions) - ROUNDING


@SETTINGS
@given(fractions=FRACTIONS, drives=DRIVES, per_widths=PER_WIDTHS)
def test_heating_never_gives_martensite_nor_takes_austenite(fractions, drives, per_widths) -> None:
    martensite, r_phase = heated_grain(*fractions, *drives, *per_widths)
    assert martensite <= fractions[0] + ROUNDING
    assert martensite + r_phase <= sum(fractions) + ROUNDING


@SETTINGS
@given(
    one=FRACTIONS,
    other=FRACTIONS,
    drives=DRIVES,
    per_widths=PER_WIDTHS,
    grain=st.sampled_from([cooled_grain, heated_grain]),
)
def test_a_grain_colder_in_everything_stays_colder(one, other, drives, per_widths, grain) -> None:
    """No passing: order between states outlasts every change. It is what return-point memory rests on."""
    colder = (max(one[0], other[0]), max(sum(one), sum(other)) - max(one[0], other[0]))
    after_one = grain(*one, *drives, *per_widths)
    after_colder = grain(*colder, *drives, *per_widths)
    assert after_colder[0] >= after_one[0] - ROUNDING
    assert sum(after_colder) >= sum(after_one) - ROUNDING


@pytest.mark.parametrize("fractions", [(0.0, 0.0), (0.3, 0.4), (0.0, 1.0), (1.0, 0.0)])
def test_far_below_all_is_martensite_and_far_above_all_is_austenite(fractions: tuple[float, float]) -> None:
    assert cooled_grain(*fractions, 90.0, 20.0, 70.0, 1.0, 1.0, 1.0) == pytest.approx((1.0, 0.0))
    assert heated_grain(*fractions, 90.0, 20.0, 70.0, 1.0, 1.0, 1.0) == pytest.approx((0.0, 0.0))


def test_between_its_drives_a_grain_stays_as_it_is() -> None:
    assert cooled_grain(0.2, 0.3, -5.0, -5.0, -5.0, 1.0, 1.0, 1.0) == pytest.approx((0.2, 0.3))
    assert heated_grain(0.2, 0.3, -5.0, -5.0, -5.0, 1.0, 1.0, 1.0) == pytest.approx((0.2, 0.3))


def test_cooling_at_low_stress_passes_through_r_phase() -> None:
    assert cooled_grain(0.0, 0.0, -5.0, 5.0, -5.0, 1.0, 1.0, 1.0) == pytest.approx((0.0, 1.0))
    assert cooled_grain(0.0, 1.0, -5.0, 5.0, 5.0, 1.0, 1.0, 1.0) == pytest.approx((1.0, 0.0))
