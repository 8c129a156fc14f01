"""Causes for which a closed loop does not hold are found in its recording, with their time."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.judge import Cause, judgement_of
from musclewire.signals import Recording

PERIOD_S = 0.05
FACTS = {"limit_sense_voltage_v": 0.3, "limit_maximum_voltage_v": 3.6, "approach_s": 5.0}


def loop(**columns: np.ndarray) -> Recording:
    """A loop of 40 s on a staircase of two targets that is followed well, with some columns replaced."""
    time_s = PERIOD_S * np.arange(1, 801)
    target = np.where(time_s < 20.0, 0.015, 0.02)
    usual = {
        "time_s": time_s,
        "drive_voltage_v": np.full(800, 2.0),
        "wire_resistance_ohm": 15.0 + 0.3 * np.sin(time_s),
        "target_strain": target,
        "estimated_strain": target + 1e-5,
    }
    return Recording({**usual, **columns}, FACTS)


def between(first_s: float, last_s: float) -> np.ndarray:
    time_s = PERIOD_S * np.arange(1, 801)
    return (time_s > first_s) & (time_s <= last_s)


def test_a_loop_that_follows_its_target_has_no_finding() -> None:
    assert judgement_of(loop()).findings == ()
    assert judgement_of(loop()).metadata == {}
    assert not judgement_of(loop()).does_not_hold


def test_a_drive_at_its_upper_limit_below_the_target_is_saturated_after_a_second() -> None:
    missing = between(25.0, 35.0)
    run = loop(
        drive_voltage_v=np.where(missing, 3.6, 2.0),
        estimated_strain=np.where(missing, 0.017, np.where(between(0.0, 19.97), 0.015, 0.02)),
    )
    missed, found = judgement_of(run).findings
    assert missed.numbers == "29 % of the time, by up to 0.3 %: the supply"
    assert found.key == "saturation"
    assert 26.0 <= found.from_s <= 26.2
    assert judgement_of(run).does_not_hold
    assert (found.grave, found.answer["grave"]) == (True, True)  # it takes more than a tenth of the time
    assert "; saturation at 26." in judgement_of(run).metadata["health"]
    assert "a slower reference" in judgement_of(run).warnings[1]


def test_a_recording_that_states_no_approach_is_judged_from_its_beginning() -> None:
    run = loop(valid=np.where(between(0.0, 30.0), 0.0, 1.0))
    facts = {name: value for name, value in FACTS.items() if name != "approach_s"} | {"sample_period_s": PERIOD_S}
    stated_nothing = Recording(run.columns, facts)
    assert [finding.key for finding in judgement_of(stated_nothing).findings] == []
    half = loop(valid=np.where(np.arange(800) % 2, 0.0, 1.0))
    stated_nothing = Recording(half.columns, facts)
    assert [finding.key for finding in judgement_of(stated_nothing).findings] == ["hardly_sensed"]


def test_cooling_may_take_its_time() -> None:
    cooling = between(20.0, 23.0)
    target = np.where(between(0.0, 20.0), 0.02, 0.015)
    slow = np.where(cooling, 0.02, target)
    run = loop(drive_voltage_v=np.where(cooling, 0.3, 2.0), target_strain=target, estimated_strain=slow)
    assert judgement_of(run).findings == ()


def test_a_wire_that_heats_at_the_limit_while_its_resistance_stands_still_is_stalled() -> None:
    stuck = between(22.0, 38.0)
    run = loop(
        drive_voltage_v=np.where(stuck, 3.6, 2.0),
        estimated_strain=np.where(stuck, 0.017, np.where(between(0.0, 19.97), 0.015, 0.02)),
        wire_resistance_ohm=np.where(stuck, 15.0, 15.2),
    )
    assert "stalled" in {one.key for one in judgement_of(run).findings}
    assert judgement_of(run).does_not_hold


def test_what_the_estimator_has_found_counts() -> None:
    run = loop(health=np.where(between(30.0, 40.0), 2.0, np.where(between(10.0, 12.0), 3.0, 0.0)))
    assert [(one.key, round(one.from_s), round(one.lasted_s)) for one in judgement_of(run).findings] == [
        ("changed_air", 10, 2),
        ("changed_load", 30, 10),
    ]
    assert judgement_of(run).does_not_hold
    assert not judgement_of(loop(health=np.where(between(10.0, 12.0), 3.0, 0.0))).does_not_hold


def with_error(error: np.ndarray) -> Recording:
    """A loop whose instrument differs from the estimate by an error, of which the estimate states 0.01 % of strain."""
    target = np.where(between(0.0, 20.0), 0.015, 0.02)
    measured = target + 1e-5 - error
    columns = loop(estimate_std=np.full(800, 1e-4), valid=np.ones(800), displacement_m=0.07 * measured).columns
    return Recording(dict(columns), {**FACTS, "leg_length_m": 0.07, "sample_period_s": PERIOD_S})


def test_an_instrument_beyond_the_interval_in_more_than_a_quarter_of_the_samples_contradicts_the_estimate() -> None:
    (found,) = judgement_of(with_error(np.where(between(20.0, 32.0), 1e-3, 0.0))).findings
    assert (found.key, round(found.from_s), round(found.lasted_s)) == ("contradicted", 20, 12)
    assert "30 % of the samples" in found.numbers
    assert judgement_of(with_error(np.full(800, 1e-3))).does_not_hold


def test_a_step_beyond_the_interval_or_a_wide_one_that_holds_is_no_contradiction() -> None:
    assert judgement_of(with_error(np.where(between(20.0, 25.0), 1e-3, 0.0))).findings == ()
    assert judgement_of(with_error(np.full(800, 1.9e-4))).findings == ()


def test_a_rig_that_states_another_load_than_the_models_does_not_hold() -> None:
    stated = Recording(dict(loop().columns), {**FACTS, "other_load": "the rig states a pretension of 0.95 N"})
    assert judgement_of(stated).does_not_hold


def test_a_loop_with_fewer_than_four_valid_samples_in_five_does_not_hold_and_says_which_could_not_be_sensed() -> None:
    facts = {**FACTS, "sample_period_s": PERIOD_S}
    cold = Recording({**loop().columns, "valid": np.where(between(20.0, 28.0), 0.0, 1.0)}, facts)
    (found,) = judgement_of(cold).findings
    assert (found.key, round(found.from_s), round(found.lasted_s)) == ("hardly_sensed", 20, 8)
    assert judgement_of(cold).does_not_hold == "hardly sensed"
    assert "77 % of the samples could be sensed" in judgement_of(cold).metadata["health"]
    rarely = Recording({**loop().columns, "valid": np.where(between(20.0, 26.0), 0.0, 1.0)}, facts)
    assert judgement_of(rarely).findings == ()


def beyond_in(steps: int, by: float) -> Recording:
    """Return a staircase of eight targets to and fro, in the first steps of which the wire goes beyond and back."""
    number = np.arange(800) // 100
    target = np.where(number % 2 == 0, 0.02, 0.015)
    side = np.where(number % 2 == 0, 1.0, -1.0)
    at = np.arange(800) % 100
    away = np.where((number < steps) & (at >= 5) & (at < 15), by, np.where(at < 5, -0.005, 0.0))
    return loop(target_strain=target, estimated_strain=target + away * side)


def overshoots(run: Recording) -> bool:
    return "overshoot" in {one.key for one in judgement_of(run).findings}


def test_a_wire_that_goes_well_beyond_its_target_step_after_step_is_named_and_the_run_holds() -> None:
    run = beyond_in(3, 0.004)
    (found,) = (one for one in judgement_of(run).findings if one.key == "overshoot")
    assert found.lasted_s == pytest.approx(1.5)
    assert found.numbers == "at 3 of 8 steps, by up to 31 % of the motion"
    assert "overshoot" not in judgement_of(run).does_not_hold


def test_twice_or_by_less_than_a_tenth_is_no_overshoot() -> None:
    assert not overshoots(beyond_in(2, 0.004))
    assert not overshoots(beyond_in(8, 0.0006))


def test_what_lies_within_the_interval_of_the_estimate_is_no_overshoot() -> None:
    run = beyond_in(8, 0.004)
    assert overshoots(run)
    assert not overshoots(Recording({**run.columns, "estimate_std": np.full(800, 0.003)}, FACTS))


def test_a_wire_that_is_still_beyond_when_its_target_comes_has_not_gone_there() -> None:
    """As one that cools slowly: the target rises to below where it is, and the wire goes on down."""
    at = np.arange(800) % 200
    target = np.where(at < 100, 0.02, 0.012)
    assert not overshoots(loop(target_strain=target, estimated_strain=0.026 - 0.00006 * at))


def test_a_reference_that_never_stops_has_no_steps_to_overshoot() -> None:
    time_s = PERIOD_S * np.arange(1, 801)
    target = 0.015 + 0.005 * np.sin(0.5 * time_s)
    assert not overshoots(loop(target_strain=target, estimated_strain=target + 0.003 * np.sin(0.5 * time_s)))


def missing_by(away: np.ndarray, facts: dict[str, float | str] = FACTS, **columns: np.ndarray) -> Recording:
    """A loop whose estimate is away from its target of 2 % strain, in a model that senses 3 % of it."""
    run = loop(target_strain=np.full(800, 0.02), estimated_strain=0.02 + away, **columns)
    return Recording(dict(run.columns), {**facts, "sensed_range": 0.03})


def causes(run: Recording) -> list[str]:
    return [one.key for one in judgement_of(run).findings]


def test_an_estimate_far_from_its_target_for_more_than_a_tenth_of_the_time_misses_it_and_the_run_does_not_hold() -> (
    None
):
    far = missing_by(np.where(between(10.0, 14.0), 0.0007, 0.0))
    (found,) = judgement_of(far).findings
    assert (found.key, found.from_s) == ("target_missed", pytest.approx(10.05))
    assert found.lasted_s == pytest.approx(4.0)
    assert found.numbers == "11 % of the time, by up to 0.07 %"
    assert judgement_of(far).does_not_hold == "target missed"
    assert judgement_of(missing_by(np.where(between(10.0, 13.0), 0.0007, 0.0))).findings == ()


def test_an_error_within_tolerance_and_interval_or_in_the_approach_misses_nothing() -> None:
    assert judgement_of(missing_by(np.full(800, 0.0006))).findings == ()
    assert judgement_of(missing_by(np.full(800, 0.002), estimate_std=np.full(800, 0.0008))).findings == ()
    assert judgement_of(missing_by(np.where(between(0.0, 5.0), -0.02, 0.0))).findings == ()


def test_a_target_near_zero_is_missed_by_more_than_a_hundredth_of_the_models_range() -> None:
    run = loop(target_strain=np.full(800, 0.001), estimated_strain=np.full(800, 0.00125))
    assert judgement_of(Recording(dict(run.columns), {**FACTS, "sensed_range": 0.03})).findings == ()
    assert causes(Recording(dict(run.columns), {**FACTS, "sensed_range": 0.02})) == ["target_missed"]


def test_what_the_speed_limits_announced_is_no_miss_as_long_and_on_the_side_that_they_did() -> None:
    away = np.where(between(10.0, 20.0), 0.002, 0.0)
    assert judgement_of(missing_by(away, announced_miss=away)).findings == ()
    (found,) = judgement_of(missing_by(away, announced_miss=np.where(between(10.0, 15.0), 0.002, 0.0))).findings
    assert found.from_s == pytest.approx(16.05)  # a loop may follow a second later
    assert judgement_of(missing_by(away, announced_miss=0.7 * away)).findings == ()
    assert causes(missing_by(away, announced_miss=0.6 * away)) == ["target_missed"]
    assert causes(missing_by(away, announced_miss=-away)) == ["target_missed"]


@pytest.mark.parametrize(
    ("columns", "cause"),
    [
        ({"drive_voltage_v": np.where(between(10.0, 30.0), 3.6, 2.0)}, "the supply"),
        ({"power_limited": between(10.0, 30.0).astype(float)}, "the power that holds the highest temperature"),
        ({"valid": np.where(between(10.0, 30.0), 0.0, 1.0)}, "no valid estimate"),
        ({"health": np.where(between(10.0, 30.0), float(Cause.CHANGED_AIR), 0.0)}, "the air"),
    ],
)
def test_a_miss_states_its_cause_where_one_is_known(columns: dict[str, np.ndarray], cause: str) -> None:
    facts = {**FACTS, "sample_period_s": PERIOD_S}
    run = missing_by(np.where(between(10.0, 30.0), -0.004, 0.0), facts, **columns)
    (found,) = (one for one in judgement_of(run).findings if one.key == "target_missed")
    assert found.numbers.endswith(f": {cause}")


def test_a_wire_that_cools_at_the_sense_voltage_misses_its_target_by_cooling() -> None:
    cooling = between(10.0, 30.0)
    run = missing_by(np.where(cooling, 0.004, 0.0), drive_voltage_v=np.where(cooling, 0.3, 2.0))
    assert judgement_of(run).findings[0].numbers == "57 % of the time, by up to 0.4 %: cooling"


def test_an_interrupted_run_has_missed_no_target() -> None:
    assert judgement_of(missing_by(np.full(800, 0.004), {**FACTS, "ended": "interrupted"})).findings == ()
    assert causes(missing_by(np.full(800, 0.004), {**FACTS, "ended": "done"})) == ["target_missed"]


def test_an_interval_too_wide_to_show_a_miss_is_named_itself() -> None:
    wide = missing_by(np.full(800, 0.002), estimate_std=np.full(800, 0.0016))
    assert causes(wide) == ["wide_interval"]
    assert judgement_of(wide).does_not_hold == "interval too wide"
    assert judgement_of(missing_by(np.full(800, 0.0005), estimate_std=np.full(800, 0.0016))).findings == ()


@pytest.mark.parametrize(
    ("swing_v", "period_s", "is_one"), [(0.8, 1.2, True), (0.8, 2.4, True), (0.4, 1.2, False), (0.8, 6.0, False)]
)
def test_a_drive_that_swings_quickly_at_one_target_is_named_with_swing_and_period(
    swing_v: float, period_s: float, is_one: bool
) -> None:
    time_s = PERIOD_S * np.arange(1, 801)
    swings = 0.5 * swing_v * np.sin(2.0 * np.pi * time_s / period_s)
    run = loop(drive_voltage_v=2.0 + np.where(between(25.0, 34.0), swings, 0.0))
    named = [one for one in judgement_of(run).findings if one.key == "oscillation"]
    assert bool(named) is is_one
    assert not judgement_of(run).does_not_hold
    if named:
        assert named[0].numbers == f"{swing_v:.1f} V peak to peak, period {period_s:.1f} s"
        assert 25.0 <= named[0].from_s <= 25.0 + period_s


def test_a_step_of_the_target_takes_the_drive_to_and_fro_and_is_no_oscillation() -> None:
    time_s = PERIOD_S * np.arange(1, 801)
    run = loop(drive_voltage_v=2.0 + np.where(between(20.0, 20.8), np.sin(2.0 * np.pi * time_s / 0.4), 0.0))
    assert judgement_of(run).findings == ()
