"""A recording's file written by another process: the same file, whatever happens to the host or to the disk."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from musclewire.errors import CallerError, RecordingNotWrittenError
from musclewire.experiment.run import Recorder
from musclewire.signals import read_recording
from musclewire.signals.hdf5_process import WriterProcess

COLUMNS = ["time_s", "drive_voltage_v", "wire_voltage_v"]
KILLED_HOST = """
import os, signal, sys
from threading import Event
from musclewire.signals.hdf5_process import WriterProcess

class Watched(WriterProcess):
    sent = Event()

    def _send_rows(self):
        super()._send_rows()
        self.sent.set()

writer = Watched(sys.argv[1], ["time_s", "drive_voltage_v"], {}, 1000, False)
for row in range(1000):
    writer.append_values([row * 1e-3, 1.0])
for _ in range(2):  # the thread may have been sending when the last row came
    writer.sent.clear()
    writer.sent.wait()
print(writer._process.pid, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_the_file_is_what_the_recorder_has_in_memory(tmp_path: Path) -> None:
    with Recorder(COLUMNS, {"wire": "paper-100um"}, tmp_path / "run.h5", apart=True) as recorder:
        for row in range(2345):
            recorder.append([row * 1e-3, 0.1 * row, 0.2])
        recorder.describe({"deadline_misses": 3})
    assert read_recording(tmp_path / "run.h5") == recorder.recording()
    assert recorder.recording().metadata["deadline_misses"] == 3


def test_a_file_that_exists_is_refused_as_by_the_writer_itself(tmp_path: Path) -> None:
    (tmp_path / "run.h5").write_text("something else")
    with pytest.raises(CallerError, match="exists"):
        WriterProcess(tmp_path / "run.h5", COLUMNS, {}, 100, False)


def test_a_killed_host_leaves_a_file_with_all_that_was_sent(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    host = subprocess.run([sys.executable, "-c", KILLED_HOST, path], capture_output=True, text=True, timeout=300)
    assert host.returncode == -signal.SIGKILL
    # The writer goes on for a moment; it is nobody's child any more, so it is waited for by a descriptor.
    with contextlib.suppress(ProcessLookupError):
        left = os.pidfd_open(int(host.stdout))
        assert select.select([left], [], [], 30.0)[0]
        os.close(left)
    recording = read_recording(path)
    assert len(recording) == 1000
    assert recording.metadata["ended"] == "cut off"


def test_a_writer_that_has_died_ends_the_run_with_the_samples_on_the_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "rescue"))
    (tmp_path / "rescue").mkdir()
    with pytest.raises(RecordingNotWrittenError, match=r"cannot write .*run\.h5") as caught:
        record_until_it_fails(tmp_path / "run.h5")
    assert len(caught.value.recording) == 101  # type: ignore[attr-defined]
    assert list((tmp_path / "rescue").glob("*.csv"))


def record_until_it_fails(path: Path) -> None:
    """Record with a writer that is killed at the start; once the thread has found out, the next row must fail."""
    with Recorder(COLUMNS, {}, path, apart=True) as recorder:
        writer = recorder._writer
        assert isinstance(writer, WriterProcess)
        writer._process.kill()
        writer._process.wait()
        for row in range(100):
            recorder.append([float(row)] * len(COLUMNS))
        writer._sender.join(60.0)
        recorder.append([100.0] * len(COLUMNS))
        raise AssertionError("the row was accepted")


def test_a_file_of_the_users_folder_takes_the_place_of_no_module(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "h5py.py").write_text("raise SystemExit('not this one')")
    monkeypatch.chdir(tmp_path)
    with Recorder(COLUMNS, {}, tmp_path / "run.h5", apart=True) as recorder:
        for row in (1.0, 2.0):
            recorder.append([row] * len(COLUMNS))
    assert len(read_recording(tmp_path / "run.h5")) == 2


def test_a_disk_that_takes_nothing_is_an_error_with_the_samples(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("musclewire.signals.hdf5_process.MAX_CLOSING_S", 0.2)
    recorder = Recorder(COLUMNS, {}, tmp_path / "run.h5", apart=True)
    recorder.append([1.0] * len(COLUMNS))
    writer = recorder._writer
    assert isinstance(writer, WriterProcess)
    writer._process.send_signal(signal.SIGSTOP)
    try:
        with pytest.raises(RecordingNotWrittenError, match="the disk has accepted nothing") as caught, recorder:
            pass
        assert len(caught.value.recording) == 1  # type: ignore[attr-defined]
    finally:
        writer._process.kill()
        writer._process.wait()


def test_a_row_of_another_length_is_refused_and_the_others_are_kept(tmp_path: Path) -> None:
    with Recorder([*COLUMNS, "displacement_m"], {}, tmp_path / "run.h5", apart=True) as recorder:
        recorder.append([0.0, 1.0, 2.0, 1e-3])
        with pytest.raises(ValueError, match="a row of 3 values for 4 columns"):
            recorder.append([1.0, 2.0, 3.0])
        recorder.append([2.0, 1.0, 2.0, None])
    assert recorder.recording()["time_s"].tolist() == [0.0, 2.0]
    with h5py.File(tmp_path / "run.h5") as file:
        assert np.array_equal(file["displacement_m"], [1e-3, np.nan], equal_nan=True)
