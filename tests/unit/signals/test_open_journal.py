"""A run's rows on their way to the disk: all of them, whatever happens on the way."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from errno import ENOSPC
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from musclewire.errors import CallerError, RecordingError, RecordingNotWrittenError
from musclewire.experiment import Recorder
from musclewire.files import read_hdf5, read_recording
from musclewire.signals import OpenJournal, journal_of

COLUMNS = ["time_s", "drive_voltage_v", "wire_voltage_v"]
# A host that is killed as soon as all of its rows have been taken from the loop.
KILLED_HOST = """
import os, signal, sys
from musclewire.signals._open_journal import OpenJournal

class Watched(OpenJournal):
    def write_rows(self):
        super().write_rows()
        if self.rows_written == 1000:
            os.kill(os.getpid(), signal.SIGKILL)

journal = Watched(sys.argv[1], ["time_s", "drive_voltage_v"], {}, in_background=True)
for row in range(1000):
    journal.values.fromlist([row * 1e-3, 1.0])
journal._threads[-1].join()
"""


def test_the_file_is_what_the_recorder_has_in_memory(tmp_path: Path) -> None:
    with Recorder(COLUMNS, {"wire": "paper-100um"}, tmp_path / "run.h5") as recorder:
        for row in range(2345):
            recorder.append([row * 1e-3, 0.1 * row, 0.2])
        recorder.describe({"deadline_misses": 3})
    assert read_recording(tmp_path / "run.h5") == recorder.recording()
    assert recorder.recording().metadata["deadline_misses"] == 3
    assert [file.name for file in tmp_path.iterdir()] == ["run.h5"]


def test_rows_that_come_at_once_and_are_more_than_a_block_are_all_there(tmp_path: Path) -> None:
    table = np.arange(300_000.0).reshape(-1, 3)
    with Recorder(COLUMNS, {}, tmp_path / "run.h5") as recorder:
        recorder.append_all(table)
    assert np.array_equal(read_recording(tmp_path / "run.h5")["wire_voltage_v"], table[:, 2])


def test_a_run_without_rows_is_a_file_without_rows(tmp_path: Path) -> None:
    with Recorder(COLUMNS, {}, tmp_path / "run.h5"):
        pass
    assert len(read_hdf5(tmp_path / "run.h5")) == 0
    with pytest.raises(RecordingError, match="has 0 rows; a recording needs 2 or more"):
        read_recording(tmp_path / "run.h5")


@pytest.mark.parametrize("there", ["run.h5", "run.h5.journal"])
def test_what_would_be_replaced_is_refused_unless_it_may_be(tmp_path: Path, there: str) -> None:
    (tmp_path / there).write_text("something else")
    with pytest.raises(CallerError, match=r"run\.h5.* allow replacing it"):
        OpenJournal(tmp_path / "run.h5", COLUMNS, {})
    assert (tmp_path / there).read_text() == "something else"
    with Recorder(COLUMNS, {}, tmp_path / "run.h5", overwrite=True) as recorder:
        recorder.append([1.0, 2.0, 3.0])
    assert len(read_hdf5(tmp_path / "run.h5")) == 1
    assert [file.name for file in tmp_path.iterdir()] == ["run.h5"]


def test_a_run_that_goes_on_is_readable_and_cannot_be_replaced(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with Recorder(COLUMNS, {"wire": "x"}, path) as recorder:
        for row in range(5):
            recorder.append([float(row), 1.0, 2.0])
        assert recorder._journal is not None
        while len(read_hdf5(path)) < 5:
            assert recorder._journal.failure is None
        assert read_recording(path).metadata["ended"] == "running"
        assert read_recording(journal_of(path)) == read_recording(path)
        with pytest.raises(CallerError, match="is still being written by another process"):
            OpenJournal(path, COLUMNS, {}, overwrite=True)
    assert read_recording(path).metadata["ended"] == "done"


def test_a_killed_host_leaves_a_file_with_all_that_was_taken(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    host = subprocess.run([sys.executable, "-c", KILLED_HOST, path], capture_output=True, text=True, timeout=300)
    assert host.returncode == -signal.SIGKILL, host.stderr
    recording = read_recording(path)
    assert len(recording) == 1000
    assert recording.metadata["ended"] == "cut off"


def test_an_fsync_that_takes_its_time_keeps_no_row_from_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, done = threading.Event(), threading.Event()

    def slow(_: int) -> None:
        begun.set()
        assert done.wait(60.0)

    monkeypatch.setattr("musclewire.signals._open_journal.SYNCED_EVERY_S", 1e-3)
    with Recorder(COLUMNS, {}, tmp_path / "run.h5") as recorder:
        monkeypatch.setattr(os, "fsync", slow)
        recorder.append([0.0, 1.0, 2.0])
        assert begun.wait(60.0)
        recorder.append([1.0, 1.0, 2.0])
        while len(read_hdf5(tmp_path / "run.h5")) < 2:
            assert recorder._journal is not None
            assert recorder._journal.failure is None
        done.set()


def test_a_record_whose_end_was_not_noted_is_written_over(tmp_path: Path) -> None:
    # A Ctrl-C may fall between the two.
    journal = OpenJournal(tmp_path / "run.h5", COLUMNS, {})
    journal.values.fromlist([0.0, 1.0, 2.0])
    before = journal._written
    journal.write_rows()
    journal._written = before
    journal.values.fromlist([1.0, 1.0, 2.0])
    journal.write_rows()
    assert read_hdf5(tmp_path / "run.h5")["time_s"].tolist() == [0.0, 1.0]
    journal.close("done", {})


def test_a_full_disk_ends_the_run_and_keeps_what_it_took(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))

    def full(descriptor: int, data: bytes) -> None:
        os.write(descriptor, data[:1000])  # torn in the middle of a record
        raise OSError(ENOSPC, "No space left on device")

    with pytest.raises(RecordingNotWrittenError, match=r"cannot write .*run\.h5: No space left") as caught:
        record_until_it_fails(tmp_path / "run.h5", full, monkeypatch)
    recording = caught.value.recording  # type: ignore[attr-defined]
    assert len(read_hdf5(tmp_path / "run.h5")) == 0
    (rescued,) = tmp_path.glob("run-rescued-*.csv")
    assert len(read_recording(rescued)) == len(recording) == 101
    assert any(str(rescued) in note for note in caught.value.__notes__)


def record_until_it_fails(path: Path, write: Callable[[int, bytes], None], patch: pytest.MonkeyPatch) -> None:
    """Record until the thread has found out that the disk is full; the next row must fail."""
    with Recorder(COLUMNS, {}, path) as recorder:
        patch.setattr("musclewire.signals._open_journal.write_all", write)
        recorder.append_all(np.arange(300.0).reshape(100, 3))
        assert recorder._journal is not None
        recorder._journal._threads[-1].join(60.0)
        recorder.append([1e3] * len(COLUMNS))
        raise AssertionError("the row was accepted")


def test_a_disk_that_is_full_only_for_the_hdf5_file_leaves_the_whole_journal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(file: Any, data: Any) -> int:
        file.problem = OSError(ENOSPC, "No space left on device")
        return len(data)

    monkeypatch.setattr("musclewire.signals._hdf5._QuietFile.write", full)
    path = tmp_path / "run.h5"
    recorder = Recorder(COLUMNS, {}, path)
    recorder.append_all(np.arange(300.0).reshape(100, 3))
    with pytest.raises(RecordingNotWrittenError, match=r"No space.*musclewire recover .*run\.h5"), recorder:
        pass
    assert [file.name for file in tmp_path.iterdir()] == ["run.h5.journal"]
    assert read_recording(path) == recorder.recording()
    assert read_recording(path).metadata["ended"] == "done"


def test_a_disk_that_takes_nothing_is_an_error_with_the_samples(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    going_on = threading.Event()
    recorder = Recorder(COLUMNS, {}, tmp_path / "run.h5")
    monkeypatch.setattr("musclewire.signals._open_journal.write_all", lambda *_: going_on.wait(60.0))
    monkeypatch.setattr("musclewire.signals._open_journal.MAX_CLOSING_S", 0.2)
    recorder.append([1.0] * len(COLUMNS))
    with pytest.raises(RecordingNotWrittenError, match="the disk has accepted nothing") as caught, recorder:
        pass
    going_on.set()
    assert len(caught.value.recording) == 1  # type: ignore[attr-defined]


def test_a_row_of_another_length_is_refused_and_the_others_are_kept(tmp_path: Path) -> None:
    with Recorder([*COLUMNS, "displacement_m"], {}, tmp_path / "run.h5") as recorder:
        recorder.append([0.0, 1.0, 2.0, 1e-3])
        with pytest.raises(ValueError, match="a row of 3 values for 4 columns"):
            recorder.append([1.0, 2.0, 3.0])
        recorder.append([2.0, 1.0, 2.0, None])
    assert recorder.recording()["time_s"].tolist() == [0.0, 2.0]
    with h5py.File(tmp_path / "run.h5") as file:
        assert np.array_equal(file["displacement_m"], [1e-3, np.nan], equal_nan=True)
