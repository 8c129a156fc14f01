"""Ctrl-C and SIGTERM in the middle of a run: the documented exit code, and a readable recording."""

from __future__ import annotations

import signal
import subprocess
import time
from pathlib import Path

import pytest
from tests.app.interrupting import PATIENCE_S, SIGNALS, start

from musclewire.errors import RecordingError
from musclewire.signals import read_hdf5, read_recording


def rows_on_disk(path: Path) -> int:
    try:
        return len(read_hdf5(path))
    except RecordingError:
        return 0


def wait_for_rows(process: subprocess.Popen[str], path: Path, rows: int) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while rows_on_disk(path) < rows:
        assert time.monotonic() < deadline, "no rows came"
        try:
            process.wait(0.05)
        except subprocess.TimeoutExpired:
            continue
        pytest.fail(f"the run ended by itself: {process.communicate()}")


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), SIGNALS)
def test_a_paced_run_stopped_by_a_signal_ends_safe_and_readable(
    number: signal.Signals, code: int, tmp_path: Path
) -> None:
    path = tmp_path / "loop.h5"
    process = start("characterize", "simulated", "--real-time", "--amplitude", "3.2 V", "-o", path)
    wait_for_rows(process, path, 20)
    process.send_signal(number)
    _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == code, err
    assert "the rig is safe" in err
    assert str(path) in err
    assert "Traceback" not in err
    recording = read_recording(path)
    assert recording.metadata["ended"] == "interrupted"
    assert len(recording) >= 20


@pytest.mark.slow
def test_an_impatient_second_ctrl_c_changes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "loop.h5"
    process = start("characterize", "simulated", "--real-time", "--amplitude", "3.2 V", "-o", path)
    wait_for_rows(process, path, 20)
    for _ in range(3):
        process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130, err
    assert "Traceback" not in err
    assert read_recording(path).metadata["ended"] == "interrupted"


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), SIGNALS)
def test_a_demo_stopped_by_a_signal_keeps_what_it_recorded(number: signal.Signals, code: int, tmp_path: Path) -> None:
    process = start("demo", "--json", "--out", tmp_path / "demo")
    wait_for_rows(process, tmp_path / "demo" / "loop-3.2V.h5", 200)
    process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == code, err
    assert out == ""
    assert len(read_recording(tmp_path / "demo" / "loop-3.2V.h5")) >= 200
    assert not (tmp_path / "demo" / "report.html").exists()
