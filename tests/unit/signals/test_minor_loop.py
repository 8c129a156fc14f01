"""A minor loop after the cycles of a recording: a segment of its own, which no reader of the cycles sees."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

from musclewire.files import read_recording
from musclewire.identify import import_recording, join_recordings
from musclewire.signals import MINOR_LOOP_FROM, Recording, journal_of, recover_recording
from musclewire.signals._journal import encoded_rows, encoded_start

ROWS, OF_CYCLES = 10, 6
TIME_S = np.arange(1.0, ROWS + 1.0)
FORCE_N = np.sin(TIME_S)
FACTS = {"wire": "x", "ended": "done"}


@pytest.fixture
def recording() -> Recording:
    return Recording({"time_s": TIME_S, "force_n": FORCE_N}, {**FACTS, MINOR_LOOP_FROM: float(OF_CYCLES)})


def test_what_comes_later_is_no_part_of_the_cycles_and_a_recording_of_its_own(recording: Recording) -> None:
    assert len(recording) == OF_CYCLES
    assert recording.duration_s == OF_CYCLES - 1.0
    np.testing.assert_array_equal(recording["force_n"], FORCE_N[:OF_CYCLES], strict=True)
    assert recording.minor_loop == Recording({"time_s": TIME_S[OF_CYCLES:], "force_n": FORCE_N[OF_CYCLES:]}, FACTS)
    assert recording.with_minor_loop == Recording({"time_s": TIME_S, "force_n": FORCE_N}, FACTS)
    assert recording.with_minor_loop.minor_loop is None


@pytest.mark.parametrize("stated", [None, "later", True, float(ROWS), 100.0, -1.0])
def test_without_rows_after_a_stated_time_there_is_none(stated: str | float | None) -> None:
    whole = Recording({"time_s": TIME_S, "force_n": FORCE_N}, {MINOR_LOOP_FROM: stated})
    assert len(whole) == ROWS
    assert whole.minor_loop is None


def test_two_recordings_put_together_have_none_where_the_first_ones_cycles_ended(recording: Recording) -> None:
    columns = {**recording.whole_columns, "cycle": np.repeat([1.0, 2.0], 5)}
    assert len(Recording(columns, recording.metadata)) == ROWS
    columns["cycle"] = np.where(TIME_S > OF_CYCLES + 1.0, 0.0, 1.0)
    assert len(Recording(columns, recording.metadata)) == OF_CYCLES + 1


def test_a_recording_without_rows_or_without_a_clock_has_none() -> None:
    assert Recording({"time_s": np.empty(0)}, {MINOR_LOOP_FROM: 1.0}).minor_loop is None
    names = ("resistance_ohm", "strain_heating", "strain_cooling")
    assert len(Recording(dict.fromkeys(names, TIME_S), {MINOR_LOOP_FROM: 1.0})) == ROWS


def test_it_goes_wherever_the_recording_goes_whole(recording: Recording) -> None:
    for same in (pickle.loads(pickle.dumps(recording)), recording.with_metadata()):
        assert same == recording
        assert same.minor_loop == recording.minor_loop
    other = Recording({**recording.whole_columns, "force_n": np.append(FORCE_N[:-1], 9.0)}, recording.metadata)
    assert other.columns["force_n"].tolist() == recording.columns["force_n"].tolist()
    assert other != recording


def test_other_rows_and_other_columns_are_of_the_cycles_alone(recording: Recording) -> None:
    """A clock of another rate would else cut the cycles where they do not end."""
    slower = recording.with_columns(time_s=2.0 * recording["time_s"])
    assert len(slower) == OF_CYCLES
    for changed in (slower, recording.between(2)):
        assert changed.minor_loop is None
        assert MINOR_LOOP_FROM not in changed.metadata


def test_files_keep_it(recording: Recording, tmp_path: Path) -> None:
    for name in ("run.h5", "run.csv"):
        recording.save(tmp_path / name)
        assert read_recording(tmp_path / name) == recording
    understood = import_recording(tmp_path / "run.h5", tmp_path / "imported.csv")
    assert understood.row_count == ROWS
    assert read_recording(tmp_path / "imported.csv").minor_loop == recording.minor_loop


def test_a_run_that_was_cut_off_in_it_has_all_cycles_and_is_recovered_whole(tmp_path: Path) -> None:
    path, rows = tmp_path / "run.h5", np.column_stack([TIME_S, FORCE_N])[:8]
    facts = {"wire": "x", MINOR_LOOP_FROM: float(OF_CYCLES)}
    journal_of(path).write_bytes(encoded_start(("time_s", "force_n"), facts) + encoded_rows(rows.tobytes()))
    for found in (read_recording(path), recover_recording(path, tmp_path / "b.csv"), recover_recording(path)):
        assert len(found) == OF_CYCLES
        assert found.minor_loop is not None
        assert len(found.minor_loop) == 2
    assert read_recording(path) == read_recording(tmp_path / "b.csv")
    assert read_recording(path).metadata["ended"] == "cut off"


def test_another_loggers_columns_are_joined_to_it_too(recording: Recording) -> None:
    logger = Recording({"time_s": TIME_S, "displacement_m": np.cos(TIME_S)}, {MINOR_LOOP_FROM: 2.0})
    joined = join_recordings(recording, logger, on="time_s").recording
    assert len(joined) == OF_CYCLES
    assert joined.minor_loop is not None
    np.testing.assert_array_equal(joined.minor_loop["displacement_m"], np.cos(TIME_S[OF_CYCLES:]))
