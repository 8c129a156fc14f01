"""A stop from another thread does not wait for the sample, and ends the run that waits for it.

How fast it is, is measured by benchmarks/stop_latency.py; here a run that was not woken would last for minutes.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping

import pytest

from musclewire.errors import RigError
from musclewire.experiment import WaveformPolicy, run_on_rig
from musclewire.rigs import GuardedRig, adjustable_clock_of, open_rig


def stopped_during_a_run(rig: GuardedRig, after_samples: int = 3) -> RigError:
    """Return what a run ends with whose rig is closed by another thread after some samples."""
    going, ended = threading.Event(), []
    seen: list[float] = []

    def on_sample(row: Mapping[str, float]) -> None:
        seen.append(row["time_s"])
        if len(seen) == after_samples:
            going.set()

    def run() -> None:
        with pytest.raises(RigError) as caught:
            run_on_rig(rig, WaveformPolicy(lambda _: 1.0, 1.0), 1e5 * rig.sample_period_s, on_sample=on_sample)
        ended.append(caught.value)

    thread = threading.Thread(target=run)
    thread.start()
    assert going.wait(60.0)
    rig.close()
    assert rig.drive_voltage_v == 0.0
    thread.join(30.0)
    assert not thread.is_alive()
    assert rig.drive_voltage_v == 0.0
    return ended[0]


def test_a_run_that_waits_for_minutes_ends_at_once_with_its_rows() -> None:
    rig = open_rig("simulated", real_time=True, sample_period_s=600.0)
    error = stopped_during_a_run(rig, after_samples=1)
    assert "closed while a sample was awaited; the drive is off" in str(error)
    assert error.recording.columns["time_s"].size == 1  # type: ignore[attr-defined]


@pytest.mark.parametrize("sample_period_s", [1e-3, 0.05])
@pytest.mark.parametrize("real_time", [True, False])
def test_a_run_at_any_pace_is_stopped(sample_period_s: float, real_time: bool) -> None:
    error = stopped_during_a_run(open_rig("simulated", real_time=real_time, sample_period_s=sample_period_s))
    assert error.recording.columns["time_s"].size >= 3  # type: ignore[attr-defined]


def test_the_clock_of_a_run_that_waits_for_minutes_may_be_made_faster() -> None:
    rig = open_rig("simulated", real_time=True, sample_period_s=600.0)
    clock = adjustable_clock_of(rig)
    assert clock is not None
    rig.exchange(0.3)
    samples = []
    thread = threading.Thread(target=lambda: samples.append(rig.exchange(0.3)))
    thread.start()
    clock.set_speed(1000.0)  # 0.6 s
    thread.join(60.0)
    assert samples[0].time_s == pytest.approx(1200.0)
    rig.close()
