from __future__ import annotations

import numpy as np
import pytest
from fake_rig import FakeRig, straight_model

from musclewire.controllers import sampled_reference, staircase
from musclewire.experiment import control, control_metrics
from musclewire.signals import Recording


def recording_that_arrives_late(late_s: float) -> Recording:
    """Two steps of 6 s; the strain takes each new target ``late_s`` after the step, from 10 % below it."""
    time_s = 0.05 * np.arange(1, 241)
    target = np.where(time_s <= 6.0 + 1e-9, 0.02, 0.03)
    since = np.where(time_s <= 6.0 + 1e-9, time_s, time_s - 6.0)
    strain = np.where(since <= late_s + 1e-9, 0.9 * target, target)
    columns = {
        "time_s": time_s,
        "displacement_m": 0.07 * strain,
        "estimated_strain": target,
        "target_strain": target,
        "valid": 1.0 + 0 * time_s,
    }
    return Recording(columns, {"leg_length_m": 0.07, "sample_period_s": 0.05, "approach_s": 0.0})


@pytest.mark.parametrize(("late_s", "mae_pct"), [(0.5, 0.0), (1.0, 0.0), (2.0, 2.0), (6.0, 10.0)])
def test_the_first_second_of_a_step_does_not_count(late_s: float, mae_pct: float) -> None:
    reference = staircase(0.02, 0.03, 0.01, return_trip=False)
    metrics = control_metrics(recording_that_arrives_late(late_s), "strain", reference)
    assert [step.mae_pct for step in metrics.steps] == pytest.approx([mae_pct, mae_pct], abs=1e-9)
    assert [step.tracking_mae_pct for step in metrics.steps] == pytest.approx([0.0, 0.0], abs=1e-9)


# Six samples of 0.5 s at the first level, 0.02, before the first step; then levels of 2 s: 0.02, 0.04 and 0.02.
BY_HAND = [
    # The approach, 3 s. Its first second does not count; of the next, which is all that one step lasts, this is
    # 100 (0.010 + 0.006) / 2 / 0.02 = 40 %.
    *(0.000, 0.004, 0.010, 0.014, 0.019, 0.0196),
    # The first step after the approach: 100 (0.0002 + 0.0004) / 2 / 0.02 = 1.5 %.
    *(0.0, 0.0, 0.0202, 0.0196),
    # The second: 100 (0.004 + 0.002) / 2 / 0.04 = 7.5 %.
    *(0.0, 0.0, 0.036, 0.042),
    # The third: 100 (0.001 + 0) / 2 / 0.02 = 2.5 %.
    *(0.0, 0.0, 0.021, 0.020),
]


def run_by_hand(approach_s: float, strain: list[float]) -> Recording:
    """A run of three steps of 2 s, sampled each 0.5 s; the estimate is 10 % too large."""
    time_s = 0.5 * np.arange(1, len(strain) + 1)
    target = np.repeat([0.02, 0.02, 0.04, 0.02], [round(approach_s / 0.5), 4, 4, 4])
    columns = {
        "time_s": time_s,
        "displacement_m": 0.07 * np.array(strain),
        "estimated_strain": 1.1 * np.array(strain),
        "target_strain": target,
        "valid": 1.0 + 0 * time_s,
    }
    return Recording(columns, {"leg_length_m": 0.07, "sample_period_s": 0.5, "approach_s": approach_s})


UP_AND_BACK = staircase(0.02, 0.04, 0.02, hold_s=2.0)


def test_both_readings_of_equation_7_by_hand() -> None:
    metrics = control_metrics(run_by_hand(3.0, BY_HAND), "strain", UP_AND_BACK)
    assert [step.mae_pct for step in metrics.steps] == pytest.approx([40.0, 7.5, 2.5])
    assert [step.mae_approached_pct for step in metrics.steps] == pytest.approx([1.5, 7.5, 2.5])
    assert (metrics.mae_max_pct, metrics.mae_mean_pct) == pytest.approx((40.0, 50.0 / 3.0))
    assert (metrics.mae_max_approached_pct, metrics.mae_mean_approached_pct) == pytest.approx((7.5, 11.5 / 3.0))


def test_estimate_and_tracking_are_read_in_both_ways_too() -> None:
    first = control_metrics(run_by_hand(3.0, BY_HAND), "strain", UP_AND_BACK).steps[0]
    # Estimates 0.0110 and 0.0154, that is 0.0010 and 0.0014 above the wire, 0.0090 and 0.0046 below the target.
    assert first.estimate_mae_pct == pytest.approx(100 * 0.0012 / 0.02)
    assert first.tracking_mae_pct == pytest.approx(100 * 0.0068 / 0.02)
    # Estimates 0.02222 and 0.02156.
    assert first.estimate_mae_approached_pct == pytest.approx(100 * 0.00199 / 0.02)
    assert first.tracking_mae_approached_pct == pytest.approx(100 * 0.00189 / 0.02)


@pytest.mark.parametrize("approach_s", [0.5, 1.0, 1.5, 2.0, 3.0, 7.0])
def test_the_first_step_from_its_target_on_is_that_of_the_same_motion_without_an_approach(approach_s: float) -> None:
    ticks = round(approach_s / 0.5)
    motion = list(0.02 * (1.0 - np.exp(-0.5 * np.arange(1, ticks + 13))))
    held = control_metrics(run_by_hand(approach_s, motion), "strain", UP_AND_BACK).steps[0]
    at_once = control_metrics(run_by_hand(0.0, motion[:12]), "strain", UP_AND_BACK).steps[0]
    assert held.mae_pct == at_once.mae_pct
    assert held.mae_approached_pct < held.mae_pct  # type: ignore[operator]  # the recording has the instrument


def test_without_a_reference_instrument_only_tracking_is_known() -> None:
    recording = recording_that_arrives_late(2.0)
    bare = Recording(
        {name: recording[name] for name in recording.names if name != "displacement_m"}, recording.metadata
    )
    metrics = control_metrics(bare, "strain", staircase(0.02, 0.03, 0.01, return_trip=False))
    assert metrics.mae_max_pct is None
    assert metrics.mae_max_approached_pct is None
    assert metrics.steps[0].mae_pct is None
    assert metrics.steps[0].mae_approached_pct is None
    assert metrics.steps[0].tracking_mae_pct == pytest.approx(0.0, abs=1e-9)
    said = str(metrics).splitlines()
    assert said[0] == "no instrument measured the strain: how far its estimate is from the target, in % of it"
    assert said[1].startswith("mean 0.000 %, largest 0.000 %")
    assert " - " not in str(metrics)


def test_a_run_without_an_approach_begins_as_one_with_it_does() -> None:
    held = control(FakeRig(), straight_model()).metrics
    at_once = control(FakeRig(), straight_model(), approach_s=0.0).metrics
    assert (held.approach_s, at_once.approach_s) == (12.0, 0.0)
    assert held.steps[0].mae_pct == at_once.steps[0].mae_pct == at_once.steps[0].mae_approached_pct
    assert at_once.mae_max_pct == at_once.mae_max_approached_pct


def test_a_users_own_reference_is_followed_and_has_no_steps() -> None:
    times = np.arange(0.0, 20.0, 0.5)
    reference = sampled_reference(times, 0.02 + 0.005 * np.sin(0.3 * times))
    run = control(FakeRig(), straight_model(), reference)
    assert run.metrics.steps == ()
    assert run.metrics.rms_pct is not None
    assert 0.0 < run.metrics.rms_pct < 20.0
    assert "rms error" in str(run.metrics)
    late = run["time_s"] > 15.0
    assert np.abs(run["estimated_strain"] - run["target_strain"])[late].max() < 0.002
