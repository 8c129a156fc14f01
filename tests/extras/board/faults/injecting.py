"""How each fault of the matrix is caused, and how it is judged: by the bench's own log, not by what anybody says."""

from __future__ import annotations

import os
import random
import resource
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from emulation.board import EmulatedBoard
from numpy.typing import NDArray
from tests.extras.board.contract.serial_rigs import COLD_K, mounted
from tests.faults.table import FaultRow
from tests.places import included_rig_file

from musclewire.errors import MusclewireError, RecordingError
from musclewire.experiment import Decision, run_on_rig
from musclewire.extras.board import MessageKind, SerialDevice, SerialFrame, encode_frame
from musclewire.files import read_hdf5
from musclewire.rigs import GuardedRig, ProtectionTripError, open_rig
from musclewire.signals import Command, Drive, RawSample, Recording, Target

__all__ = ["Outcome", "command_run", "judged_s", "scripted_run"]

INJECT = 0x7F
# Sound samples before the fault, and samples that a survived fault must outlive: 1 s and 5 s.
SOUND_SAMPLES, SURVIVED_SAMPLES = 20, 100
OFF_V = 1e-3
PATIENCE_S = 90.0
# Bytes after which a recording's file finds the disk full: it begins and some seconds of rows fit.
FULL_DISK_BYTES = 12_000
# Faults that come from outside the host.
FROM_OUTSIDE = ("bench", "line", "unplug", "reset", "power cut", "power drop")


class ConstantDrive:
    """A policy that only drives, until the fault makes it do something else."""

    columns = ()

    def __init__(self, drive_voltage_v: float) -> None:
        self.drive_voltage_v = drive_voltage_v

    def first_command(self) -> Command:
        return Drive(self.drive_voltage_v)

    def after(self, _sample: RawSample, _elapsed_s: float) -> Decision:
        # A channel that stands still shows only when something moves.
        self.drive_voltage_v += 0.002 * random.choice([-1, 1])
        return Decision(Drive(self.drive_voltage_v))


class Outcome:
    """What came of a fault: the error if any, what was recorded, and when it was injected on the log's axis."""

    def __init__(self) -> None:
        self.error: BaseException | None = None
        self.recording: Recording | None = None
        self.since = 0.0
        self.exit_code: int | None = None
        self.said = ""
        self.injected = False
        self.bench_was_late = False

    @property
    def ended(self) -> str:
        """How the recording says that it ended, "" without one."""
        return "" if self.recording is None else str(self.recording.metadata.get("ended"))


def judged_s(board: EmulatedBoard, since: float, row: FaultRow) -> float:
    """Return how long after a fault the last voltage was out, on the axis of the board's pace [s]."""
    lockstep = row.run == "lockstep"
    ends_s = time.monotonic() + 60.0
    while True:
        log = board.log()
        axis: NDArray[np.float64] = 1e-3 * log["tick"] if lockstep else log["clock_s"]
        if (axis.size and axis[-1] >= since + row.within_s + 0.05) or time.monotonic() > ends_s:
            break
        time.sleep(0.05)
    assert axis[-1] >= since + row.within_s, "the bench's log ends too early to judge"
    driven = axis[(axis > since) & (log[row.judged_by] > OFF_V)]
    return float(driven[-1] - since) if driven.size else 0.0


def now(board: EmulatedBoard, row: FaultRow) -> float:
    """Return the time on the axis of the board's pace [s]."""
    return 1e-3 * board.figures()["ticks"] if row.run == "lockstep" else time.monotonic()


def scripted_run(board: EmulatedBoard, row: FaultRow, path: Path, patience_s: float) -> Outcome:
    """Run a script's constant drive through the board, inject the fault in the middle, return what came of it."""
    outcome = Outcome()
    policy = ConstantDrive(row.drive_v)
    samples = SOUND_SAMPLES + SURVIVED_SAMPLES
    seen = 0
    beside: list[threading.Thread] = []
    try:
        lockstep = row.run == "lockstep"
        on_port = mounted(board.port_url, patience=patience_s, limits=row.limits, lockstep=lockstep)
        with open_rig(on_port, wire_temperature_k=COLD_K) as rig:
            assert isinstance(rig.device, SerialDevice)
            if row.inject == "from the start":
                outcome.since = now(board, row)

            def on_sample(_row: Mapping[str, float]) -> None:
                nonlocal seen
                seen += 1
                if seen == SOUND_SAMPLES:
                    outcome.injected = True
                    outcome.since = now(board, row) if row.inject != "from the start" else outcome.since
                    if row.run == "clock" and row.inject in FROM_OUTSIDE:
                        # Beside the run: what takes the injector its time must not make the host late.
                        beside.append(threading.Thread(target=inject, args=(board, rig, policy, row)))
                        beside[-1].start()
                    else:
                        inject(board, rig, policy, row)

            period_s = rig.sample_period_s
            outcome.recording = run_on_rig(rig, policy, samples * period_s, path=path, on_sample=on_sample)
    except Exception as error:
        outcome.error = error
        outcome.exit_code = error.exit_code if isinstance(error, MusclewireError) else None
        outcome.recording = getattr(error, "recording", None)
        event = f"{error.event.name.lower()}: " if isinstance(error, ProtectionTripError) else ""
        outcome.said = f"{type(error).__name__}: {event}{error}"
    for thread in beside:
        thread.join()
    if row.inject == "from the start" and outcome.recording is not None:
        # What was wrong from the beginning counts from when it showed: the first sample outside the limit.
        outcome.since = max(outcome.since, showed_s(outcome.recording, row) + outcome.since)
    return outcome


def showed_s(recording: Recording, row: FaultRow) -> float:
    """Return when a recording first went beyond a row's limit [s], the whole of it where it is the temperature's."""
    current_a = recording["shunt_voltage_v"]
    shown = {
        "resistance_high": recording["wire_voltage_v"] / np.maximum(recording["shunt_voltage_v"], 1e-9),
        "maximum_power": recording["wire_voltage_v"] * current_a,
        "maximum_current": current_a,
    }
    (name, limit), *_ = row.limits.items()
    if name not in shown:
        return float(recording["time_s"][-1])
    beyond = np.flatnonzero(shown[name] > limit)
    return float(recording["time_s"][max(int(beyond[0]) - 1, 0)]) if beyond.size else 0.0


def inject(board: EmulatedBoard, rig: GuardedRig, policy: ConstantDrive, row: FaultRow) -> None:
    """Cause a row's fault now."""
    given = dict(row.arguments)
    ways: dict[str, Callable[[], object]] = {
        "bench": lambda: board.fault(given.pop("kind"), **given),
        "line": lambda: board.spoil_line(**given),
        "unplug": board.unplug,
        "reset": board.reset,
        "power cut": board.kill_power,
        "power drop": lambda: (board.kill_power(), board.restart()),
        "stall": lambda: time.sleep(given["time_s"]),
        "exception": lambda: 1 / 0,
        "command": lambda: setattr(policy, "drive_voltage_v", given["drive_voltage_v"]),
        "firmware": lambda: send(rig, SerialFrame(INJECT, 60000, bytes([given["what"]]))),
        "past the check": lambda: send(
            rig, SerialFrame(MessageKind.DRIVE, 60000, struct.pack("<f", given["drive_voltage_v"]))
        ),
        "target": lambda: rig.exchange(Target(given["target"])),
        "flood": lambda: flood(rig),
        "from the start": lambda: None,
    }
    ways[row.inject]()


def send(rig: GuardedRig, frame: SerialFrame) -> None:
    """Put a frame on the rig's own line, past all that the host would check."""
    rig.device._board._line.write(encode_frame(frame))


def flood(rig: GuardedRig) -> None:
    """Write what another program might: bytes without meaning, for as long as the line takes them."""
    chance = random.Random(1)
    for _ in range(40):
        rig.device._board._line.write(bytes(chance.choice(b"\0ab\xff\x55") for _ in range(100)))


def rig_text(port: str, row: FaultRow) -> str:
    """Return a rig file as a user would write it."""
    shipped = included_rig_file("serial-board").read_text("utf-8")
    limits = "".join(f"{key} = {value}\n" for key, value in row.limits.items())
    return shipped.replace('"/dev/ttyACM0"', f'"{port}"') + (f"\n[limits]\n{limits}" if limits else "")


def rows_on_disk(path: Path) -> int:
    """Return how many samples a growing recording holds."""
    try:
        return len(read_hdf5(path))
    except RecordingError:
        return 0


def command_run(board: EmulatedBoard, row: FaultRow, folder: Path) -> Outcome:
    """Run `musclewire characterize` on the board as a process of its own and break something in the middle."""
    rig_file, path = folder / "board.toml", folder / "loop.h5"
    rig_file.write_text(rig_text(board.port_url, row))
    limited = limit_file_size if row.inject == "full disk" else None
    process = subprocess.Popen(
        [sys.executable, "-m", "musclewire", "characterize", str(rig_file), "-o", str(path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "NO_COLOR": "1"},
        preexec_fn=limited,
    )
    outcome = Outcome()
    deadline_s = time.monotonic() + PATIENCE_S
    while rows_on_disk(path) < 2 * SOUND_SAMPLES and process.poll() is None and time.monotonic() < deadline_s:
        time.sleep(0.02)
    outcome.since = time.monotonic()
    # A run that has ended by itself was not injected; a full disk is there from the beginning.
    outcome.injected = process.poll() is None or row.inject == "full disk"
    break_now(board, process, row)
    _, outcome.said = process.communicate(timeout=60.0)
    if row.inject == "full disk":
        outcome.since = time.monotonic() - 0.1  # it had made the rig safe when it ended
    outcome.exit_code = process.returncode
    return outcome


def limit_file_size() -> None:
    """Let the disk be full for this process after so many bytes; Python ignores the signal and gets an error."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (FULL_DISK_BYTES, FULL_DISK_BYTES))


def break_now(board: EmulatedBoard, process: subprocess.Popen[str], row: FaultRow) -> None:
    """Cause a row's fault from outside the process."""
    if row.inject == "signal":
        process.send_signal(row.arguments["number"])
    elif row.inject == "stop":
        process.send_signal(signal.SIGSTOP)
        time.sleep(0.8)
        process.send_signal(signal.SIGCONT)
    elif row.inject == "unplug":
        board.unplug()
    elif row.inject == "power cut":
        board.kill_power()
    elif row.inject == "bench":
        given = dict(row.arguments)
        board.fault(given.pop("kind"), **given)
