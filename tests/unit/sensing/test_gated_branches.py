"""Direction-gated branches: which branch a power means, what a turn leaves alone, and when a wire counts as cold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.sensing._estimator import EstimatorSetup, estimates
from musclewire.sensing._gated_estimator import GATES, gated_estimator
from musclewire.sensing._model import SensingModel
from musclewire.signals import QuantityEstimate, Reason, WireSample

# 4 % at 13.5 ohm, nothing at 17.5 ohm; the heating branch 0.2 % strain above the cooling one.
GAP = 0.002
MODEL = SensingModel(13.5, 17.5, (0.04 + GAP / 2, -0.04), (0.04 - GAP / 2, -0.04), 0.05, 0.95)
SPAN = MODEL.quantity_max - MODEL.quantity_min
BEYOND = GATES.beyond * SPAN


def followed(
    readings: list[tuple[float, float]], period_s: float = 0.05, model: SensingModel = MODEL
) -> list[QuantityEstimate]:
    """Return the estimates of resistances [ohm] at electrical powers [W]."""
    samples = []
    for tick, (ohm, power_w) in enumerate(readings):
        current_a = float(np.sqrt(power_w / ohm))
        samples.append(WireSample(period_s * tick, 2.0, current_a * ohm, current_a))
    made = gated_estimator(EstimatorSetup(model, 1.0, period_s))
    return [estimate for estimate, _ in estimates(made, samples)]


def ramp(start_ohm: float, stop_ohm: float, count: int, power_w: float) -> list[tuple[float, float]]:
    return [(float(ohm), power_w) for ohm in np.linspace(start_ohm, stop_ohm, count)]


HELD = [(16.5, 0.2)] * 5


def test_a_wire_that_heats_is_on_the_heating_branch_and_one_that_cools_on_the_cooling_branch() -> None:
    heated = followed(HELD + ramp(16.5, 14.5, 60, 0.5))
    assert heated[-1].value == pytest.approx(MODEL.strain_heating(14.5), abs=1e-4)
    cooled = followed([(14.5, 0.5)] * 5 + ramp(14.5, 16.0, 60, 0.1))
    assert cooled[-1].value == pytest.approx(MODEL.strain_cooling(16.0), abs=1e-4)


def test_after_a_turn_strain_stands_still_while_resistance_follows_the_temperature() -> None:
    # Cooling from the heating branch: resistance falls with the temperature, then comes back on the cooling branch.
    turn = ramp(14.5, 14.45, 10, 0.1) + ramp(14.45, 14.5, 10, 0.1)
    found = followed(HELD + ramp(16.5, 14.5, 60, 0.5) + turn)
    at_turn = found[64].value
    assert max(abs(one.value - at_turn) for one in found[65:75]) < 0.5 * GAP
    assert MODEL.strain_heating(14.45) - at_turn > 0.4e-3  # what the heating branch would have added


@given(st.lists(st.tuples(st.floats(13.6, 17.4), st.floats(0.01, 1.0)), min_size=2, max_size=60))
def test_the_value_never_leaves_the_branches_of_the_range(readings: list[tuple[float, float]]) -> None:
    for one in followed(readings):
        assert MODEL.quantity_min - GAP / 2 - 1.01 * BEYOND <= one.value
        assert one.value <= MODEL.quantity_max + GAP / 2 + 1.01 * BEYOND
        assert 0.0 < one.std <= SPAN


@given(
    st.floats(0.001, 120.0),
    st.lists(st.tuples(st.floats(13.6, 17.4), st.floats(0.01, 1.0)), min_size=2, max_size=60),
)
def test_a_valid_sample_has_a_standard_deviation_at_any_sample_period(
    period_s: float, readings: list[tuple[float, float]]
) -> None:
    for one in followed(readings, period_s):
        assert 0.0 < one.std <= SPAN
        assert np.isfinite(one.value)


def test_the_same_course_gives_the_same_strain_at_any_sample_period() -> None:
    ends = []
    for period_s in (0.002, 0.01, 0.05):
        count = round(3.0 / period_s)
        course = [(16.5, 0.2)] * round(0.5 / period_s) + ramp(16.5, 14.5, count, 0.5) + ramp(14.5, 15.5, count, 0.1)
        ends.append([followed(course, period_s)[place].value for place in (-1 - count, -1)])
    assert np.ptp(np.array(ends), axis=0) == pytest.approx([0.0, 0.0], abs=0.02 * SPAN)


def test_a_wire_that_is_seldom_read_is_on_its_branch_all_the_same() -> None:
    heated = followed(HELD + ramp(16.5, 14.5, 12, 0.5), 14.0)
    assert heated[-1].value == pytest.approx(MODEL.strain_heating(14.5), abs=2e-5)
    cooled = followed(HELD + ramp(16.5, 14.5, 12, 0.5) + ramp(14.5, 16.0, 12, 0.1), 14.0)
    assert cooled[-1].value == pytest.approx(MODEL.strain_cooling(16.0), abs=2e-5)


def test_a_wire_whose_resistance_is_near_b_within_its_noise_is_cold() -> None:
    course = HELD + ramp(16.5, 15.0, 12, 0.5) + ramp(15.0, 17.2, 12, 0.1)
    near_b = [(17.25 + (0.03 if k % 2 else -0.03), 0.1) for k in range(8)]
    found = followed(course + near_b, 14.0)
    assert found[20].reason is Reason.OK
    assert found[-1].reason is Reason.COLD


def test_equal_branches_give_the_polynomial() -> None:
    model = SensingModel(13.5, 17.5, (0.04, -0.04), (0.04, -0.04), 0.05, 0.95)
    made = gated_estimator(EstimatorSetup(model, 1.0, 0.05))
    samples = [WireSample(0.05 * k, 2.0, 0.2 * ohm, 0.2) for k, ohm in enumerate(np.linspace(16.0, 14.0, 80))]
    last = [estimate for estimate, _ in estimates(made, samples)][-1]
    assert last.value == pytest.approx(model.strain(14.0), abs=2.0 * BEYOND)


def test_one_reading_of_another_wire_leaves_the_estimate_as_it_is() -> None:
    found = followed(HELD + ramp(16.5, 15.0, 40, 0.5) + [(30.0, 0.5), (15.0, 0.5)])
    assert found[-2].reason is Reason.MISMATCH
    assert found[-2].value == found[-3].value
    assert found[-1].value == pytest.approx(found[-3].value, abs=0.01 * SPAN)


def test_a_wire_that_has_cooled_to_the_cold_end_is_cold_until_heating_lowers_its_resistance() -> None:
    course = HELD + ramp(16.5, 15.0, 40, 0.5) + ramp(15.0, 17.4, 40, 0.1) + ramp(17.4, 16.9, 40, 0.1)
    found = followed(course + ramp(16.9, 17.25, 20, 0.5) + ramp(17.25, 16.0, 20, 0.5))
    assert found[60].reason is Reason.OK
    assert {one.reason for one in found[90:125]} == {Reason.COLD}
    assert {one.reason for one in found[126:144]} == {Reason.COLD}  # from A to B resistance rises
    assert found[-1].reason is Reason.OK


def test_noise_widens_the_interval() -> None:
    random = np.random.default_rng(3)
    stds = []
    for noise_ohm in (0.001, 0.1):
        readings = [(15.5 + noise_ohm * float(random.standard_normal()), 0.3) for _ in range(200)]
        stds.append(followed(readings)[-1].std)
    assert stds[1] > stds[0]


@pytest.mark.parametrize("loop_s", [14.0, 90.0, 1_000.0, 3_500.0, 4_200.0])
@pytest.mark.parametrize("points", [71, 1_420])
def test_a_loop_is_on_the_branch_of_its_direction_at_any_speed(loop_s: float, points: int) -> None:
    phase = np.linspace(0.0, 2.0 * np.pi, points)
    ohm, power_w = 15.5 + np.cos(phase), 0.3 - 0.25 * np.cos(phase)
    found = np.array([one.value for one in followed(list(zip(ohm, power_w, strict=True)), loop_s / points)])
    at = np.round(points * np.array([0.35, 0.85])).astype(int)
    expected = [MODEL.strain_heating(float(ohm[at[0]])), MODEL.strain_cooling(float(ohm[at[1]]))]
    assert found[at] == pytest.approx(expected, abs=0.3 * GAP)


def test_noise_of_the_power_at_a_hold_is_no_turn() -> None:
    random = np.random.default_rng(4)
    noisy = [(14.5, 0.5 * (1.0 + 0.02 * float(random.standard_normal()))) for _ in range(4_000)]
    held = followed(HELD + ramp(16.5, 14.5, 60, 0.5) + noisy)
    assert min(one.value for one in held[80:]) > MODEL.strain(14.5)


def test_readings_of_a_cold_wire_that_scatter_are_not_taken_for_motion() -> None:
    random = np.random.default_rng(5)
    cold = [(17.2 + 0.05 * float(random.standard_normal()), 0.01) for _ in range(2_000)]
    assert np.mean([one.valid for one in followed(cold)]) < 0.01


# A slow loop through B at 0.3 W that had cooled to the cold 17.2 ohm when its power was 0.1 W.
SLOW_LOOP = (
    *((10.0 * row, 0.01 + 0.1 * row, ohm) for row, ohm in enumerate((17.2, 17.2, 17.4, 17.5, 15.5, 13.5))),
    *((60.0 + 10.0 * row, power_w, ohm) for row, (power_w, ohm) in enumerate(((0.3, 15.5), (0.1, 17.2), (0.01, 17.2)))),
)


def valid_after_a_rest(model: SensingModel, power_w: float) -> float:
    """Return the share of valid samples in the last of two minutes in which a wire that was hot stands at 17.2 ohm."""
    readings = ramp(14.5, 17.2, 400, 0.05) + [(17.2, power_w)] * 2_400
    return float(
        np.mean([one.valid for one in followed(HELD + ramp(16.5, 14.5, 60, 0.5) + readings, model=model)[-1_200:]])
    )


def test_a_wire_that_rests_cold_is_not_valid() -> None:
    model = replace(MODEL, slow_loop=SLOW_LOOP)
    assert model.cold_resistance_ohm == pytest.approx(17.2)
    assert model.cold_power_w == pytest.approx(0.1)
    assert valid_after_a_rest(model, 0.01) == 0.0


def test_a_wire_that_is_held_near_its_cold_end_is_valid_in_air_that_takes_a_little_more_than_half_the_heat() -> None:
    assert valid_after_a_rest(replace(MODEL, slow_loop=SLOW_LOOP), 0.06) == 1.0


def test_a_model_that_states_no_slow_loop_says_nothing_of_cold_power() -> None:
    assert MODEL.cold_power_w == 0.0


def test_a_wire_that_came_from_rest_through_b_in_a_moment_turns_when_its_power_falls_below_that_of_b() -> None:
    """The mean power is mostly of the rest before: by it alone 0.2 W still heats, and the wire seems to go on."""
    from_rest = [(17.2, 0.01)] * 200 + ramp(17.2, 17.5, 4, 0.6) + ramp(17.5, 15.5, 12, 0.6)
    cools_at_rest = ramp(15.5, 15.2, 30, 0.2)
    with_loop = followed(from_rest + cools_at_rest, model=replace(MODEL, slow_loop=SLOW_LOOP))
    without = followed(from_rest + cools_at_rest)
    stopped = with_loop[len(from_rest)].value
    assert with_loop[-1].value == pytest.approx(stopped, abs=0.002)
    assert without[-1].value > stopped + 0.002


def test_a_wire_that_passes_b_with_less_power_than_the_slow_loop_heats_all_the_same() -> None:
    """As in warmer or calmer air: the mean is then its own power, not one that would make a turn of it."""
    slowly = [(17.2, 0.01)] * 200 + ramp(17.2, 17.5, 60, 0.22) + ramp(17.5, 16.0, 200, 0.22)
    with_loop = followed(slowly, model=replace(MODEL, slow_loop=SLOW_LOOP))[-1].value
    off = abs(followed(slowly)[-1].value - MODEL.strain_heating(16.0))
    assert abs(with_loop - MODEL.strain_heating(16.0)) < off + 1e-4


def test_between_crossed_branches_a_wire_at_rest_is_not_drawn_to_their_mean() -> None:
    crossed = replace(
        MODEL, heating_coefficients=MODEL.cooling_coefficients, cooling_coefficients=MODEL.heating_coefficients
    )
    cooled = [(14.5, 0.5)] * 5 + ramp(14.5, 16.0, 60, 0.1)
    # Power comes up a little, as a loop gives it to hold the wire: too little to be a turn.
    held = followed(cooled + [(16.0, 0.1)] * 400 + [(16.0, 0.1015)] * 40, model=crossed)
    assert held[-1].value == pytest.approx(crossed.strain_cooling(16.0), abs=1e-6)
