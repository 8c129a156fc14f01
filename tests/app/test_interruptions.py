"""Ctrl-C and SIGTERM in the middle of a run: the documented exit code, and a readable recording."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from tests.app.interrupting import ONE_IN_CI, PATIENCE_S, SIGNALS, start

from musclewire.app import is_compiling
from musclewire.errors import RecordingError
from musclewire.files import read_hdf5, read_recording


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


@pytest.mark.parametrize(("number", "code"), ONE_IN_CI)
def test_a_demo_stopped_by_a_signal_keeps_what_it_recorded(number: signal.Signals, code: int, tmp_path: Path) -> None:
    process = start("demo", "--json", "--output", tmp_path / "demo")
    wait_for_rows(process, tmp_path / "demo" / "loop-3.2V.h5", 200)
    process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == code, err
    assert out == ""
    assert len(read_recording(tmp_path / "demo" / "loop-3.2V.h5")) >= 200
    assert not (tmp_path / "demo" / "report.html").exists()


SLOW_TO_OPEN = """
import time
from pathlib import Path
from musclewire import DeviceFacts, MountedWire, RawSample, drive_voltage_of

class Plant:
    def __init__(self, configuration):
        self.drive_voltage_v, self.samples = 0.0, 0
        self.facts = DeviceFacts(
            sample_period_s=0.05, paced=False, leg_length_m=0.07, drive_amplitude_v=3.0,
            limits=configuration.protection_limits(wire_range_v=10.0, shunt_range_v=10.0, readings_noisy=False),
            wire_temperature_k=295.15,
        )
        Path("opening").touch()
        time.sleep(25.0)

    def metadata(self):
        return {}

    def exchange(self, command):
        Path("exchanged").touch()
        self.drive_voltage_v, self.samples = drive_voltage_of(command), self.samples + 1
        current_a = self.drive_voltage_v / 18.0
        return RawSample(0.05 * self.samples, self.drive_voltage_v, 17.0 * current_a, current_a)

    def sense(self):
        return True

    def off(self):
        self.drive_voltage_v = 0.0
        return True
"""
ITS_RIG_FILE = """
kind = "python:slow_to_open:Plant"
wire = "paper-100um"
wire_length = "14 cm"
shunt = "1 ohm"
sense_voltage = "0.3 V"
drive_amplitude = "3.0 V"
maximum_voltage = "3.6 V"
"""


@pytest.mark.parametrize(("number", "code"), ONE_IN_CI)
def test_an_opening_of_25_s_hears_the_first_signal_and_takes_no_sample(
    number: signal.Signals, code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "slow_to_open.py").write_text(SLOW_TO_OPEN)
    (tmp_path / "rig.toml").write_text(ITS_RIG_FILE)
    monkeypatch.chdir(tmp_path)
    process = start("characterize", "rig.toml", "-o", "loop.h5")
    deadline = time.monotonic() + PATIENCE_S
    while not Path("opening").exists():
        assert time.monotonic() < deadline
        assert process.poll() is None, process.communicate()
        time.sleep(0.05)
    sent_s = time.monotonic()
    process.send_signal(number)
    _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == code, err
    assert time.monotonic() - sent_s < 10.0
    assert "Traceback" not in err
    assert not Path("exchanged").exists()


SAYS_WHEN_IT_LISTENS = """
import signal
import musclewire.__main__ as it
listen, taken = signal.signal, []
def listened(number, handler):
    before = listen(number, handler)
    taken.append(number)
    if len(taken) == 2:
        print("ours", flush=True)
    return before
signal.signal = listened
it.main()
"""


@pytest.mark.slow
def test_a_signal_at_any_moment_of_the_start_ends_without_a_traceback() -> None:
    """From the first moment that is ours: before that it is Python's own start."""
    for wait_s in (0.0, 0.05, 0.1, 0.2, 0.4, 0.8):
        command = [sys.executable, "-c", SAYS_WHEN_IT_LISTENS, "doctor", "simulated"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert process.stdout is not None
        assert process.stdout.readline() == "ours\n"
        time.sleep(0.01 + wait_s)
        process.send_signal(signal.SIGINT)
        answer, err = process.communicate(timeout=PATIENCE_S)
        assert "Traceback" not in err
        if answer and process.returncode == 0:  # on a quick machine the command is through before the last signals
            continue
        assert process.returncode == 130, err
        assert "stopped by Ctrl-C" in err


def test_a_signal_waits_while_the_compiler_runs() -> None:
    found = {"__name__": "numba.core.compiler", "is_compiling": is_compiling}
    exec("import sys; inside = (lambda: is_compiling(sys._getframe()))()", found)
    assert found["inside"]
    assert not is_compiling(sys._getframe())
