"""Each finding is a row with a detector and a remedy, and a command judges its run in one pass."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import CodeType, FrameType

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view

import musclewire as mw
from musclewire.app import run
from musclewire.judge._findings import FINDINGS, GRAVE, judged, remedies
from musclewire.judge._first_heating import seen_at_b
from musclewire.judge._known_strain import compared_with_known
from musclewire.judge._loop import Cause, in_windows
from musclewire.judge._missed_target import missed_target
from musclewire.judge._odd_resistance import odd_resistance

SHARED = (seen_at_b, compared_with_known, missed_target, odd_resistance)


def test_every_finding_has_a_key_a_name_and_a_remedy_of_its_own() -> None:
    keys = [one.key for one in FINDINGS]
    assert sorted(remedies()) == sorted(keys)
    assert all(len(set(column)) == len(keys) for column in (keys, [one.name for one in FINDINGS], remedies().values()))


def test_what_an_estimator_records_is_a_finding_without_a_detector() -> None:
    recorded = {one.recorded: one.detect for one in FINDINGS if one.recorded}
    assert recorded == dict.fromkeys(set(Cause) - {Cause.NONE})
    assert GRAVE == (Cause.CHANGED_LOAD, Cause.OTHER_WIRE)


@pytest.mark.parametrize("length", range(1, 12))
def test_windows_of_any_length_have_the_extremes_of_all_their_values(length: int) -> None:
    values = np.random.default_rng(length).standard_normal(30)
    values[17] = np.nan
    seen = sliding_window_view(values, length)
    np.testing.assert_array_equal(in_windows(np.minimum, values, length), seen.min(axis=1))
    np.testing.assert_array_equal(in_windows(np.maximum, values, length), seen.max(axis=1))


@contextmanager
def calls() -> Iterator[Counter[CodeType]]:
    """How often each function was called."""
    counted: Counter[CodeType] = Counter()

    def called(frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            counted[frame.f_code] += 1

    before = sys.getprofile()
    sys.setprofile(called)
    try:
        yield counted
    finally:
        sys.setprofile(before)


def test_in_one_command_with_figure_file_and_answer_each_detector_looks_once(tmp_path: Path) -> None:
    with mw.open_rig("simulated", seed=1) as rig:
        mw.fit(mw.characterize(rig, cycles=1, minor_loop=False)).save(tmp_path / "model.json")
    options = [
        "--reference",
        "1.5 % to 1.8 % by 0.3 %",
        "--known-strain",
        "1.5 % at 3 s",
        "--zero-from",
        "today",
        "--json",
    ]
    files = ["--plot", tmp_path / "run.png", "-o", tmp_path / "run.h5"]
    with calls() as counted:
        code = run(list(map(str, ["control", "simulated", tmp_path / "model.json", *options, *files])))
    assert code in (0, 1)
    detectors = {one.detect for one in FINDINGS if one.detect} | set(SHARED)
    assert {one.__name__: counted[one.__code__] for one in detectors} == {one.__name__: 1 for one in detectors}
    assert (tmp_path / "run.png").stat().st_size > 0


def test_a_recording_is_judged_once_and_another_of_other_facts_anew() -> None:
    facts = {"limit_sense_voltage_v": 0.3, "limit_maximum_voltage_v": 3.6, "approach_s": 0.0, "sample_period_s": 0.05}
    rows = {"time_s": 0.05 * np.arange(1, 401), "drive_voltage_v": np.full(400, 2.0)}
    missed = mw.Recording({**rows, "target_strain": np.full(400, 0.02), "estimated_strain": np.full(400, 0.03)}, facts)
    assert judged(missed) is judged(missed)
    assert [one.key for one in judged(missed).findings] == ["target_missed"]
    assert judged(missed.with_metadata(sensed_range=2.0)).findings == ()
