"""Ctrl-C and SIGTERM in the middle of a run: the documented exit code, and a readable recording."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from musclewire.errors import RecordingError
from musclewire.signals import read_recording
from musclewire.signals.reading import read_hdf5

PATIENCE_S = 120.0  # a cold machine compiles first
SIGNALS = [(signal.SIGINT, 130), pytest.param(signal.SIGTERM, 143, marks=pytest.mark.slow)]


def rows_on_disk(path: Path) -> int:
    try:
        return len(read_hdf5(path))
    except RecordingError:
        return 0


def start(*arguments: object) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "musclewire", *map(str, arguments)]
    return subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "NO_COLOR": "1"},
    )


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
    process = start("characterize", "simulated", "--real-time", "-o", path)
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
    process = start("characterize", "simulated", "--real-time", "-o", path)
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


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), SIGNALS)
def test_verdicts_over_seeds_stopped_by_a_signal_leave_no_process_and_no_page(
    number: signal.Signals, code: int, tmp_path: Path
) -> None:
    arguments = ("--only", "table1.resistance", "--seeds", 20000, "--workers", 3, "--out", tmp_path)
    process = start("reproduce", *arguments)
    assert process.stderr is not None
    assert "of 20000 seeds" in process.stderr.readline()
    workers = subprocess.run(
        ["ps", "-o", "pid=", "--ppid", str(process.pid)], capture_output=True, text=True, check=True
    ).stdout.split()
    assert len(workers) == 2
    process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == code, err
    assert (out, "no page was written" in err, "Traceback" in err) == ("", True, False)
    assert [pid for pid in workers if Path(f"/proc/{pid}").exists()] == []
    assert list(tmp_path.iterdir()) == []
