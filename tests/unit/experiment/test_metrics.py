from __future__ import annotations

import numpy as np
import pytest
from fake_rig import FakeRig, straight_model

from musclewire.controllers import sampled_reference, staircase
from musclewire.experiment.closed_loop import control
from musclewire.experiment.metrics import control_metrics, mean_absolute_error
from musclewire.signals import Recording


def test_equation_7_by_hand() -> None:
    # |1.49 - 1.5| + |1.52 - 1.5| + |1.5 - 1.5| = 0.03; a third of it is 0.01, two thirds of a percent of 1.5.
    assert mean_absolute_error(np.array([1.49, 1.52, 1.5]), 1.5, 1.5) == pytest.approx(100 * 0.01 / 1.5)


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


def test_without_a_reference_instrument_only_tracking_is_known() -> None:
    recording = recording_that_arrives_late(2.0)
    bare = Recording(
        {name: recording[name] for name in recording.names if name != "displacement_m"}, recording.metadata
    )
    metrics = control_metrics(bare, "strain", staircase(0.02, 0.03, 0.01, return_trip=False))
    assert metrics.mae_max_pct is None
    assert metrics.steps[0].mae_pct is None
    assert metrics.steps[0].tracking_mae_pct == pytest.approx(0.0, abs=1e-9)
    assert "-" in str(metrics)


def test_a_wire_that_follows_well_has_small_errors_in_every_step() -> None:
    metrics = control(FakeRig(), straight_model()).metrics
    assert len(metrics.steps) == 11
    assert metrics.mae_max_pct is not None
    assert metrics.mae_max_pct < 3.0


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
