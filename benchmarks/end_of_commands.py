"""How long after Ctrl-C a drive is off and a command has ended, on a machine that has other things to do.

    python -m benchmarks.end_of_commands [--ends 50] [--busy 2] [--quick] [--commands characterize control serve]

Each command heats a simulated wire at its own pace, and gets SIGINT at a random moment; beside it so many busy
processes for each core run at the same priority. The device notes in shared memory when more than the sense voltage was
ordered last, whatever the command says. Prints a row of JSON for each command, times in s as {median, p95, max} from
before the signal is sent: until the drive was at the sense voltage or off for good, and until the process, with all
that it had started, has ended. ``kept``: how many recordings have the last sample. ``bars_met``: the drive is off after
0.2 s in the median and within 0.5 s in 49 of 50, all processes have ended within 3 s, and nothing is lost.
"""

from __future__ import annotations

import argparse
import json
import mmap
import multiprocessing
import os
import random
import signal
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from benchmarks.live_server import running_server

import musclewire as mw
from musclewire.extras.live import LiveClient

OFF_MEDIAN_S, OFF_S, OFF_SHARE, ENDED_S = 0.2, 0.5, 0.98, 3.0
ENDS, QUICK_ENDS = 50, 5
# Until the wire is driven a cold machine compiles; then the signal comes within so many seconds.
PATIENCE_S, WITHIN_S = 120.0, 2.0
# A recording needs two rows; the rig samples every 0.05 s.
TWO_ROWS_S = 0.2
# What a recording says whose end nobody has written.
UNKNOWN = ("running", "cut off")


class Noted(NamedTuple):
    """What the device has noted: the drive of its last sample, when it was driven last, since when not; 0: never."""

    sampled_v: float
    driven_s: float
    off_s: float


class NotesConfiguration(mw.DeviceConfiguration):
    """A rig file that names a file for the notes."""

    notes: str


class NotedWire:
    """The simulated wire at its own pace, whose orders are noted with the machine's monotonic clock."""

    configuration = NotesConfiguration

    def __init__(self, configuration: NotesConfiguration) -> None:
        """Open both."""
        self._rig = mw.open_rig("simulated", real_time=True, seed=1)
        self._device = self._rig.device
        self.facts = self._device.facts
        with Path(configuration.notes).open("r+b") as file:
            self._notes = mmap.mmap(file.fileno(), 24)
        self._now = Noted(0.0, 0.0, 0.0)

    @property
    def drive_voltage_v(self) -> float:
        """The drive that is out [V]."""
        return self._device.drive_voltage_v

    def metadata(self) -> dict[str, Any]:
        """Return what describes the wire."""
        return dict(self._device.metadata())

    def exchange(self, command: Any) -> Any:
        """Follow a command for one sample period."""
        self._note(mw.drive_voltage_of(command))
        answer = self._device.exchange(command)
        if isinstance(answer, mw.RawSample):
            self._now = self._now._replace(sampled_v=answer.drive_voltage_v)
            self._write()
        return answer

    def sense(self) -> bool:
        """Go to the sense voltage."""
        self._note(0.0)
        return self._device.sense()

    def off(self) -> bool:
        """Switch off."""
        self._note(0.0)
        return self._device.off()

    def _note(self, voltage_v: float) -> None:
        if voltage_v > self.facts.limits.sense_voltage_v:
            self._now = self._now._replace(driven_s=time.monotonic(), off_s=0.0)
        elif not self._now.off_s:
            self._now = self._now._replace(off_s=time.monotonic())
        self._write()

    def _write(self) -> None:
        self._notes[:] = struct.pack("3d", *self._now)


def noted(path: Path) -> Noted:
    """Return what a device has noted."""
    return Noted(*struct.unpack("3d", path.read_bytes()))


def spin() -> None:
    """Be busy until the process is ended."""
    while True:
        pass


@contextmanager
def busy(each_core: int) -> Iterator[None]:
    """Keep so many processes for each core busy inside this block."""
    fresh = multiprocessing.get_context("spawn")
    others = [fresh.Process(target=spin, daemon=True) for _ in range(each_core * (os.cpu_count() or 1))]
    for one in others:
        one.start()
    try:
        yield
    finally:
        for one in others:
            one.kill()
            one.join()


def wait_until(is_so: Callable[[], bool], what: str) -> None:
    """Wait until something is so."""
    ends_s = time.monotonic() + PATIENCE_S
    while not is_so():
        assert time.monotonic() < ends_s, what
        time.sleep(0.005)


class End(NamedTuple):
    """How one command ended: times from the signal [s], and whether its recording holds all that was sampled."""

    off_s: float
    ended_s: float
    kept: bool


class Bench:
    """A folder with a rig whose orders are noted, and a model of its wire."""

    def __init__(self, folder: Path, model: Path) -> None:
        """Write the rig file."""
        self.folder, self.model, self.notes, self.rig = folder, model, folder / "notes", folder / "noted.toml"
        self.notes.write_bytes(bytes(24))
        self.rig.write_text(f'kind = "python:benchmarks.end_of_commands:NotedWire"\nnotes = "{self.notes}"\n')

    def interrupted(
        self, send: Callable[[], None], wait: Callable[[], Any], chance: random.Random
    ) -> tuple[float, float]:
        """Send a signal at a random moment of a driven run; return when the drive was off and all had ended [s]."""
        wait_until(lambda: noted(self.notes).driven_s > 0.0, "the wire was never driven")
        time.sleep(TWO_ROWS_S + WITHIN_S * chance.random())
        wait_until(lambda: not noted(self.notes).off_s, "the wire is not driven any more")
        sent_s = time.monotonic()
        send()
        wait()
        ended_s = time.monotonic()
        found = noted(self.notes)
        assert found.off_s, "the drive is still on"
        return max(0.0, found.off_s - sent_s), ended_s - sent_s

    def is_kept(self) -> bool:
        """Return whether the only recording says how it ended, and has the last sample that was taken."""
        (path,) = self.folder.rglob("*.h5")
        recording = mw.read_recording(path)
        last_v = float(recording["drive_voltage_v"][-1])
        return recording.metadata["ended"] not in UNKNOWN and last_v == noted(self.notes).sampled_v

    def command(self, *arguments: str) -> Callable[[random.Random], End]:
        """Return what runs a command of the command line and interrupts it."""

        def end(chance: random.Random) -> End:
            command = [sys.executable, "-m", "musclewire", *arguments, "-o", str(self.folder / "run.h5")]
            with (self.folder / "said").open("w") as said:
                process = subprocess.Popen(command, stderr=said, stdout=said)
            try:
                off_s, ended_s = self.interrupted(lambda: process.send_signal(signal.SIGINT), process.wait, chance)
            except AssertionError as error:
                raise AssertionError(f"{error}: rc {process.poll()}: " + (self.folder / "said").read_text()) from None
            return End(off_s, ended_s, process.returncode == 128 + signal.SIGINT and self.is_kept())

        return end

    def serve(self, chance: random.Random) -> End:
        """Interrupt a server whose page heats."""
        with (
            running_server(self.folder, "--port", "8927", rigs=(str(self.rig),)) as server,
            LiveClient(server.link) as client,
            client.control("the benchmark"),
        ):
            client.wait_for("off")
            client.command("switch_on")
            client.wait_for("ready")
            client.command("characterize", cycles=100, period_s=90.0)
            off_s, ended_s = self.interrupted(
                lambda: server.process.send_signal(signal.SIGINT), server.process.wait, chance
            )
        return End(off_s, ended_s, self.is_kept())


COMMANDS: dict[str, Callable[[Bench], Callable[[random.Random], End]]] = {
    "characterize": lambda bench: bench.command("characterize", str(bench.rig)),
    "control": lambda bench: bench.command("control", str(bench.rig), str(bench.model)),
    "serve": lambda bench: bench.serve,
}


def spread(times_s: list[float]) -> dict[str, float]:
    """Return median, 95th percentile and largest of times."""
    median, p95 = np.percentile(times_s, (50, 95))
    return {"median": round(float(median), 3), "p95": round(float(p95), 3), "max": round(max(times_s), 3)}


def row_of(command: str, folder: Path, model: Path, ends: int, seed: int) -> dict[str, Any]:
    """Return how a command ended so many times."""
    chance, found = random.Random(seed), list[End]()
    for number in range(ends):
        own = folder / f"{command}-{number}"
        own.mkdir()
        found.append(COMMANDS[command](Bench(own, model))(chance))
    off_s, ended_s = [one.off_s for one in found], [one.ended_s for one in found]
    kept, in_time = sum(one.kept for one in found), sum(one <= OFF_S for one in off_s)
    is_off = np.median(off_s) <= OFF_MEDIAN_S and in_time >= OFF_SHARE * ends
    return {
        "command": command,
        "ends": ends,
        "off_s": spread(off_s),
        f"off_within_{OFF_S:g}_s": in_time,
        "ended_s": spread(ended_s),
        "kept": kept,
        "bars_met": bool(is_off and max(ended_s) <= ENDED_S and kept == ends),
    }


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ends", type=int, default=ENDS)
    parser.add_argument("--busy", type=int, default=2)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--commands", nargs="+", choices=COMMANDS, default=tuple(COMMANDS))
    given = parser.parse_args()
    # The rig file names this module; who runs the command must find it, too.
    here = str(Path(__file__).resolve().parent.parent)
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (here, os.environ.get("PYTHONPATH"))))
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "model.json"
        with mw.open_rig("simulated", seed=1) as rig:
            mw.fit(mw.characterize(rig)).save(model)
        met = True
        with busy(given.busy):
            for command in given.commands:
                row = row_of(command, Path(folder), model, QUICK_ENDS if given.quick else given.ends, given.seed)
                print(json.dumps(row), flush=True)
                met = met and row["bars_met"]
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
