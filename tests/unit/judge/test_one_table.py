"""Each finding is a row with a detector and a remedy, and a command judges its run in one pass."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view
from tests.places import DOCS

import musclewire as mw
from musclewire.app import run
from musclewire.experiment import run_warnings
from musclewire.judge import GRAVE, Cause, JudgedLoop, judgement_of, odd_resistance, remedies
from musclewire.judge._defects import DEFECTS
from musclewire.judge._findings import ALWAYS, FINDINGS, NEVER
from musclewire.judge._first_heating import seen_at_b
from musclewire.judge._known_strain import compared_with_known
from musclewire.judge._loop import in_windows
from musclewire.judge._missed_target import MAX_MISSED, missed_target
from musclewire.sensing import SensingModel

SHARED = {seen_at_b, compared_with_known, missed_target, odd_resistance}
DETECTORS = SHARED | {one.detect for one in FINDINGS if one.detect}


def test_every_finding_has_a_key_a_name_and_a_remedy_of_its_own() -> None:
    tables = {
        "loop": [one.key for one in FINDINGS],
        "recording": [one.key for one in DEFECTS],
    }
    for name, keys in tables.items():
        assert sorted(remedies(name)) == sorted(keys)
        assert len(set(keys)) == len(set(remedies(name).values())) == len(keys)
    assert len({one.name for one in FINDINGS}) == len(FINDINGS)


def test_what_an_estimator_records_is_a_finding_without_a_detector() -> None:
    recorded = {one.recorded: one.detect for one in FINDINGS if one.recorded}
    assert recorded == dict.fromkeys(set(Cause) - {Cause.NONE})
    assert GRAVE == (Cause.CHANGED_LOAD, Cause.OTHER_WIRE)


def test_the_page_on_estimators_has_each_finding_and_whether_a_command_ends_with_1() -> None:
    page = (DOCS / "explanation" / "estimators.md").read_text("utf-8")
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("|")]
    ends = {ALWAYS: "yes", NEVER: "no", MAX_MISSED: "above a tenth of the time"}
    on_page = {cells[0]: cells[-1] for cells in rows}
    assert {one.name: ends[one.grave_beyond] for one in FINDINGS}.items() <= on_page.items()


@pytest.mark.parametrize("length", range(1, 12))
def test_windows_of_any_length_have_the_extremes_of_all_their_values(length: int) -> None:
    values = np.random.default_rng(length).standard_normal(30)
    values[17] = np.nan
    seen = sliding_window_view(values, length)
    np.testing.assert_array_equal(in_windows(np.minimum, values, length), seen.min(axis=1))
    np.testing.assert_array_equal(in_windows(np.maximum, values, length), seen.max(axis=1))


@pytest.fixture
def looks(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """How often each detector looks at a recording: wherever one stands, what counts and calls it stands."""
    counted: Counter[str] = Counter()

    def counting(detect: Callable[[JudgedLoop], Any]) -> Callable[[JudgedLoop], Any]:
        def look(loop: JudgedLoop) -> Any:
            counted[detect.__name__] += 1
            return detect(loop)

        return look

    spies = {detect: counting(detect) for detect in DETECTORS}
    for module in [one for name, one in sys.modules.items() if name.startswith("musclewire.judge._")]:
        for name, value in list(vars(module).items()):
            if isinstance(value, FunctionType) and value in spies:
                monkeypatch.setattr(module, name, spies[value])
    rows = tuple(one._replace(detect=spies.get(one.detect)) for one in FINDINGS)
    monkeypatch.setattr("musclewire.judge._findings.FINDINGS", rows)
    return counted


def test_in_one_loop_with_its_metrics_and_warnings_each_detector_looks_once(
    model: SensingModel, looks: Counter[str]
) -> None:
    with mw.open_rig("simulated", seed=4) as rig:
        loop = mw.control(rig, model, mw.staircase(0.015, 0.018, 0.003, 1.5), known_strain=(0.015, 1.0))
    assert run_warnings(loop)[-1:] == judgement_of(loop).warnings[-1:]
    assert looks == {one.__name__: 1 for one in DETECTORS}
    (outcome,) = mw.control_many("simulated", model, seeds=[4]).outcomes
    assert outcome.compiled
    assert looks == {one.__name__: 2 for one in DETECTORS}


@pytest.mark.slow
def test_in_one_command_with_figure_file_and_answer_each_detector_looks_once(
    tmp_path: Path, model: SensingModel, looks: Counter[str]
) -> None:
    model.save(tmp_path / "model.json")
    options = ["--reference", "1.5 % to 1.8 % by 0.3 % for 1.5 s", "--known-strain", "1.5 % at 1 s", "--zero-from"]
    options += ["today", "--json"]
    files = ["--plot", tmp_path / "run.png", "-o", tmp_path / "run.h5"]
    assert run(list(map(str, ["control", "simulated", tmp_path / "model.json", *options, *files]))) in (0, 1)
    assert looks == {one.__name__: 1 for one in DETECTORS}
    assert (tmp_path / "run.png").stat().st_size > 0


def test_a_recording_is_judged_once_and_another_of_other_facts_anew() -> None:
    facts = {"limit_sense_voltage_v": 0.3, "limit_maximum_voltage_v": 3.6, "approach_s": 0.0, "sample_period_s": 0.05}
    rows = {"time_s": 0.05 * np.arange(1, 401), "drive_voltage_v": np.full(400, 2.0)}
    missed = mw.Recording({**rows, "target_strain": np.full(400, 0.02), "estimated_strain": np.full(400, 0.03)}, facts)
    assert judgement_of(missed) is judgement_of(missed)
    assert [one.key for one in judgement_of(missed).findings] == ["target_missed"]
    assert judgement_of(missed.with_metadata(sensed_range=2.0)).findings == ()
