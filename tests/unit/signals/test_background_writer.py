"""A run's rows on their way to the disk, directly or by another process: all of them, whatever happens on the way."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from errno import ENOSPC
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from musclewire.errors import CallerError, RecordingNotWrittenError
from musclewire.experiment import Recorder
from musclewire.signals._background_writer import AppendingProcess, BackgroundWriter
from musclewire.signals._journal import journal_of
from musclewire.signals._reading import read_hdf5, read_recording
from musclewire.signals._synced_file import SyncedFile

COLUMNS = ["time_s", "drive_voltage_v", "wire_voltage_v"]
BOTH_WAYS = pytest.mark.parametrize("apart", [False, True], ids=["directly", "by another process"])
# A host that is killed as soon as all of its rows have been taken from the loop.
KILLED_HOST = """
import os, signal, sys
from musclewire.signals._background_writer import BackgroundWriter

class Watched(BackgroundWriter):
    def _take(self):
        super()._take()
        if self._taken == 1000:
            if self.kill_process:
                os.kill(self._target._process.pid, signal.SIGKILL)
            os.kill(os.getpid(), signal.SIGKILL)

writer = Watched(sys.argv[1], ["time_s", "drive_voltage_v"], {}, apart=sys.argv[2] != "directly")
writer.kill_process = False
for row in range(1000):
    writer.values.fromlist([row * 1e-3, 1.0])
writer._thread.join()
"""


@BOTH_WAYS
def test_the_file_is_what_the_recorder_has_in_memory(tmp_path: Path, apart: bool) -> None:
    with Recorder(COLUMNS, {"wire": "paper-100um"}, tmp_path / "run.h5", apart=apart) as recorder:
        for row in range(2345):
            recorder.append([row * 1e-3, 0.1 * row, 0.2])
        recorder.describe({"deadline_misses": 3})
    assert read_recording(tmp_path / "run.h5") == recorder.recording()
    assert recorder.recording().metadata["deadline_misses"] == 3
    assert [file.name for file in tmp_path.iterdir()] == ["run.h5"]


@BOTH_WAYS
def test_rows_that_come_at_once_and_are_more_than_a_block_are_all_there(tmp_path: Path, apart: bool) -> None:
    table = np.arange(300_000.0).reshape(-1, 3)
    with Recorder(COLUMNS, {}, tmp_path / "run.h5", apart=apart) as recorder:
        recorder.append_all(table)
    assert np.array_equal(read_recording(tmp_path / "run.h5")["wire_voltage_v"], table[:, 2])


def test_a_run_without_rows_is_a_file_without_rows(tmp_path: Path) -> None:
    with Recorder(COLUMNS, {}, tmp_path / "run.h5"):
        pass
    assert len(read_hdf5(tmp_path / "run.h5")) == 0


@pytest.mark.parametrize("there", ["run.h5", "run.h5.journal"])
def test_what_would_be_replaced_is_refused_unless_it_may_be(tmp_path: Path, there: str) -> None:
    (tmp_path / there).write_text("something else")
    with pytest.raises(CallerError, match=r"run\.h5.* allow replacing it"):
        BackgroundWriter(tmp_path / "run.h5", COLUMNS, {})
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
        writer = recorder._writer
        assert writer is not None
        while len(read_hdf5(path)) < 5:
            assert writer._thread.is_alive()
        assert read_recording(path).metadata["ended"] == "running"
        assert read_recording(journal_of(path)) == read_recording(path)
        with pytest.raises(CallerError, match="is still being written by another process"):
            BackgroundWriter(path, COLUMNS, {}, overwrite=True)
    assert read_recording(path).metadata["ended"] == "done"


@BOTH_WAYS
def test_a_killed_host_leaves_a_file_with_all_that_was_taken(tmp_path: Path, apart: bool) -> None:
    path = tmp_path / "run.h5"
    way = "apart" if apart else "directly"
    host = subprocess.run([sys.executable, "-c", KILLED_HOST, path, way], capture_output=True, text=True, timeout=300)
    assert host.returncode == -signal.SIGKILL, host.stderr
    # The other process goes on for a moment; the lock ends with it.
    while read_hdf5(path).metadata["ended"] == "running":
        os.sched_yield()
    recording = read_recording(path)
    assert len(recording) == 1000
    assert recording.metadata["ended"] == "cut off"


def test_a_killed_writer_is_replaced_and_no_row_is_missing(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with Recorder(COLUMNS, {}, path, apart=True) as recorder:
        for row in range(3000):
            recorder.append([float(row), 1.0, 2.0])
            if row == 1500:
                process = process_of(recorder)
                process.kill()
                process.wait()
    assert read_recording(path) == recorder.recording()
    assert read_recording(path).metadata["ended"] == "done"
    assert read_recording(path)["time_s"].tolist() == [float(row) for row in range(3000)]


def test_a_writer_that_cannot_start_is_replaced_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "broken.py").write_text("raise RuntimeError('not on this machine')")
    monkeypatch.setattr("musclewire.signals._background_writer.APPENDING", tmp_path / "broken.py")
    with Recorder(COLUMNS, {}, tmp_path / "run.h5", apart=True) as recorder:
        recorder.append([1.0, 2.0, 3.0])
    assert read_hdf5(tmp_path / "run.h5") == recorder.recording()


def process_of(recorder: Recorder) -> subprocess.Popen[bytes]:
    """Return the process that writes for a recorder."""
    assert recorder._writer is not None
    assert isinstance(recorder._writer._target, AppendingProcess)
    return recorder._writer._target._process


@BOTH_WAYS
def test_a_full_disk_ends_the_run_and_keeps_what_it_took(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, apart: bool
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    append = SyncedFile.append

    def full(file: SyncedFile, data: bytes) -> None:
        append(file, data[:1000])  # torn in the middle of a record
        raise OSError(ENOSPC, "No space left on device")

    target = "AppendingProcess" if apart else "SyncedFile"
    monkeypatch.setattr(f"musclewire.signals._background_writer.{target}.append", full if not apart else full_process)
    with pytest.raises(RecordingNotWrittenError, match=r"cannot write .*run\.h5: No space left") as caught:
        record_until_it_fails(tmp_path / "run.h5", apart)
    recording = caught.value.recording  # type: ignore[attr-defined]
    kept = read_hdf5(tmp_path / "run.h5")
    assert kept.metadata["ended"] == recording.metadata["ended"] == str(caught.value).splitlines()[0] or len(kept) == 0
    (rescued,) = tmp_path.glob("run-rescued-*.csv")
    assert len(read_recording(rescued)) == len(recording)
    assert any(str(rescued) in note for note in caught.value.__notes__)


def full_process(*_: object) -> None:
    """Find the disk full, as the other process does."""
    raise OSError(ENOSPC, "No space left on device")


def record_until_it_fails(path: Path, apart: bool) -> None:
    """Record until the thread has found out that the disk is full; the next row must fail."""
    with Recorder(COLUMNS, {}, path, apart=apart) as recorder:
        for row in range(100):
            recorder._values.fromlist([float(row)] * len(COLUMNS))
        assert recorder._writer is not None
        recorder._writer._thread.join(60.0)
        recorder.append([100.0] * len(COLUMNS))
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


def test_a_file_of_the_users_folder_takes_the_place_of_no_module(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "threading.py").write_text("raise SystemExit('not this one')")
    monkeypatch.chdir(tmp_path)
    with Recorder(COLUMNS, {}, tmp_path / "run.h5", apart=True) as recorder:
        for row in (1.0, 2.0):
            recorder.append([row] * len(COLUMNS))
    assert len(read_recording(tmp_path / "run.h5")) == 2


def test_a_disk_that_takes_nothing_is_an_error_with_the_samples(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    recorder = Recorder(COLUMNS, {}, tmp_path / "run.h5", apart=True)
    process = process_of(recorder)
    process.send_signal(signal.SIGSTOP)
    monkeypatch.setattr("musclewire.signals._background_writer.MAX_CLOSING_S", 0.2)
    recorder.append([1.0] * len(COLUMNS))
    with pytest.raises(RecordingNotWrittenError, match="the disk has accepted nothing") as caught, recorder:
        pass
    assert len(caught.value.recording) == 1  # type: ignore[attr-defined]
    process.wait()


def test_a_row_of_another_length_is_refused_and_the_others_are_kept(tmp_path: Path) -> None:
    with Recorder([*COLUMNS, "displacement_m"], {}, tmp_path / "run.h5", apart=True) as recorder:
        recorder.append([0.0, 1.0, 2.0, 1e-3])
        with pytest.raises(ValueError, match="a row of 3 values for 4 columns"):
            recorder.append([1.0, 2.0, 3.0])
        recorder.append([2.0, 1.0, 2.0, None])
    assert recorder.recording()["time_s"].tolist() == [0.0, 2.0]
    with h5py.File(tmp_path / "run.h5") as file:
        assert np.array_equal(file["displacement_m"], [1e-3, np.nan], equal_nan=True)
