"""What a recording says of how punctual its run was."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import musclewire as mw
from musclewire.experiment import WaveformPolicy, run_on_rig, timing_json
from musclewire.experiment._run import LoopTiming

PERIOD_NS = 1_000_000


def noted(arrivals_ns: list[int], paced: bool = True, callback_ns: int = 0) -> LoopTiming:
    """Return the timing of samples that came then, each drive handed over 50 us after the sample before."""
    timing = LoopTiming(PERIOD_NS * 1e-9, paced)
    before = 0
    for at in arrivals_ns:
        timing.sampled(before + 50_000, at)
        timing.record_callback(callback_ns)
        before = at
    return timing


def test_a_punctual_run_has_no_misses_no_jitter_and_no_drift_and_a_callback_is_latency_but_not_compute_time() -> None:
    found = noted([n * PERIOD_NS for n in range(1000)], callback_ns=30_000).metadata()
    assert found["deadline_misses"] == 0
    assert found["jitter_p999_us"] == 0.0
    assert found["drift_us"] == 0.0
    assert found["latency_p50_us"] == 50.0
    assert found["compute_p99_us"] == 20.0


def test_every_period_without_a_sample_is_a_missed_deadline_and_catching_up_is_none() -> None:
    """A stall of 3.2 periods after the third sample, then what was missed at once."""
    late = [3.2, 3.21, 3.22, 3.23]
    arrivals = [0.0, 1.0, *(2.0 + extra for extra in late), 6.0, 7.0]
    found = noted([round(at * PERIOD_NS) for at in arrivals]).metadata()
    assert found["deadline_misses"] == 3
    assert found["drift_us"] == 0.0


def test_jitter_is_how_far_an_interval_is_from_the_period() -> None:
    found = noted([0, PERIOD_NS + 7_000, 2 * PERIOD_NS, 3 * PERIOD_NS]).metadata()
    assert found["jitter_p50_us"] == 7.0
    assert found["deadline_misses"] == 0


def test_without_a_clock_only_compute_times_are_said() -> None:
    found = noted([n * PERIOD_NS for n in range(10)], paced=False).metadata()
    assert str(found["pace"]).startswith("none")
    assert found["compute_p50_us"] == 50.0
    assert not [key for key in found if key.startswith(("jitter", "latency", "drift"))]
    assert timing_json(found)["jitter_us"] is None


class AtSpeed:
    """A clock with a speed."""

    def __init__(self, speed: float) -> None:
        self.speed, self.changes = speed, 0

    def set_speed(self, factor: float) -> None:
        self.speed, self.changes = factor, self.changes + 1


def test_a_faster_clock_is_named_and_its_samples_are_due_earlier() -> None:
    timing = LoopTiming(PERIOD_NS * 1e-8, True, AtSpeed(10.0))
    for number in range(10):
        timing.sampled(number * PERIOD_NS, number * PERIOD_NS + 50_000)
    found = timing.metadata()
    assert found["pace"] == "10 times real time"
    assert (found["jitter_p50_us"], found["drift_us"], found["deadline_misses"]) == (0.0, 0.0, 0)


def test_a_run_whose_clock_changed_its_speed_on_the_way_has_no_jitter() -> None:
    clock = AtSpeed(1.0)
    timing = LoopTiming(PERIOD_NS * 1e-9, True, clock)
    for number in range(10):
        timing.sampled(number * PERIOD_NS, number * PERIOD_NS + 50_000)
    clock.set_speed(10.0)
    clock.set_speed(1.0)
    found = timing.metadata()
    assert found["pace"] == "a clock whose speed was changed during the run"
    assert not [key for key in found if key.startswith(("jitter", "latency", "drift"))]


@pytest.mark.parametrize("samples", [0, 1])
def test_a_run_too_short_to_time_says_only_its_pace(samples: int) -> None:
    found = noted([PERIOD_NS] * samples).metadata()
    assert found == {"pace": "real time", "deadline_misses": 0}
    assert json.dumps(timing_json(found), allow_nan=False)


def test_every_recording_tells_its_timing_and_its_limits_in_memory_and_in_its_file(tmp_path: Path) -> None:
    with mw.open_rig("simulated") as rig:
        policy = WaveformPolicy(lambda _: 0.5, 1.0)
        recording = run_on_rig(rig, policy, 1.0, path=tmp_path / "run.h5", on_sample=lambda _: None)
        for name, value in rig.protection_limits._asdict().items():
            assert recording.metadata[f"limit_{name}"] == value
    stored = mw.read_recording(tmp_path / "run.h5")
    assert stored.metadata["compute_p99_us"] == recording.metadata["compute_p99_us"] > 0.0
    assert stored.metadata["deadline_misses"] == 0
    assert stored == recording
