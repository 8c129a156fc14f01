"""An emulated board: its firmware in an emulator, the simulated wire on its pins, its serial line on a port.

    python -m emulation.board --wire flexinol-0.15-lt

builds the firmware for the wire, prints the port for a rig file (`port = "socket://127.0.0.1:..."`) and runs until
Ctrl-C. In tests:

    with EmulatedBoard(pace="lockstep") as board:
        ...                                  # talk to board.port_url
        truth = board.log()                  # the true state of the wire
"""

from __future__ import annotations

import argparse
import atexit
import json
import re
import select
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self

import numpy as np
from firmware.build import model_of, mounted_wire
from numpy.typing import NDArray

from emulation.boot_loaders import BOOT_LOADERS
from emulation.boot_loaders import boot_loader as boot_loader_hex
from emulation.machines import prepared
from emulation.plant import COLUMNS
from musclewire.errors import CallerError, MusclewireError, RigError
from musclewire.extras.board import (
    BoardLoop,
    MonitorCircuit,
    circuit_names,
    load_circuit,
    program_files,
    settings_in_c,
    write_program,
)
from musclewire.rigs import MountedWire

__all__ = ["EmulatedBoard", "firmware_for"]

ROOT = Path(__file__).resolve().parents[1]
FIRMWARE = ROOT / "firmware"
PATIENCE = "10 s"  # on a machine that is busy with other programs an emulator answers late
RIG_FILES = ROOT / "src/musclewire/extras/board/rig_files"


def firmware_for(board: str, folder: Path, options: Sequence[str] = ()) -> Path:
    """Return the ELF of a board's firmware, built now. Raises CallerError with what is missing or wrong."""
    if board in circuit_names():
        return micropython_for(board, folder, options)
    command = [sys.executable, str(FIRMWARE / "build.py"), "--board", board, "-o", str(folder), *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise CallerError(done.stderr.strip().removeprefix("error: "))
    return folder / f"musclewire-{board}.elf"


def micropython_for(board: str, folder: Path, options: Sequence[str] = ()) -> Path:
    """Return the folder of a board's program in MicroPython, written now, with the numbers of its bench next to it."""
    given = argparse.ArgumentParser()
    given.add_argument("--wire", default="paper-100um")
    given.add_argument("--fault-injection", action="store_true")
    asked = given.parse_args(options)
    circuit, mounted = load_circuit(board), wire_on(board, asked.wire)
    model = model_of(mounted_wire(asked.wire), None)
    limits = mounted.protection_limits(**RANGES_OF_MONITOR, readings_noisy=False)
    settings = settings_in_c(model, sample_period_s=circuit.tick)
    loop = BoardLoop(model, settings, limits, ("filter", "inverse-model"), circuit.tick)
    texts = program_files(limits, loop, circuit, asked.wire, injected=asked.fault_injection)
    program = folder / "program"
    write_program(texts, program)
    bench = bench_of(circuit) | {
        "tick_us": round(1e6 * circuit.tick),
        "output_full": 2**16 - 1,
        "monitor_address": circuit.monitor_address,
        "shunt_ohm": mounted.shunt,
        "beside_wire_ohm": circuit.beside_wire,
        "conversion_us": 1064,
    }
    (program / "circuit.json").write_text(json.dumps(bench), encoding="utf-8")
    return program


# A monitor's ranges [V] of bus and shunt.
RANGES_OF_MONITOR = {"wire_range_v": 16.0, "shunt_range_v": 0.32}


def bench_of(circuit: MonitorCircuit) -> dict[str, Any]:
    """Return what the bench knows of a circuit: it gives the voltages that the monitor's registers show."""
    return {
        "name": circuit.board,
        "tick_period_s": circuit.tick,
        "converter_bits": 16,
        "bench_bits": 16,
        "converter_range_v": 6.0,
        "converter_noise_v": 0.0,
        "divider_share": 1.0,
        "shunt_gain": 20.0,
        "output_bits": 16,
        "output_range_v": circuit.supply,
        "supply_v": circuit.supply,
    }


def wire_on(board: str, wire: str) -> MountedWire:
    """Return what hangs on a board; one with a monitor has the module's shunt, and a sense voltage that it can give."""
    mounted = mounted_wire(wire)
    if board not in circuit_names():
        return mounted
    return mounted.model_copy(update={"shunt": 0.1, "sense_voltage": 0.8})


# An emulator starts in a tenth of a second, but in many seconds on a machine that is busy with other programs.
START_S = 60.0
END_S = 5.0
# Processes of benches whose boards have ended. To start one takes a second, most of it for imports: the next board of
# this program takes one of these, with an emulator and a wire of its own.
IDLE: list[subprocess.Popen[str]] = []


def started_bench() -> subprocess.Popen[str]:
    """Return the process of a bench that waits for its settings."""
    while IDLE:
        bench = IDLE.pop()
        if bench.poll() is None:
            return bench
        ended(bench)
    command = [sys.executable, "-m", "emulation.plant"]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT)


def ended(bench: subprocess.Popen[str]) -> None:
    """End the process of a bench."""
    assert bench.stdin is not None
    assert bench.stdout is not None
    with suppress(BrokenPipeError):
        bench.stdin.close()
    try:
        bench.wait(timeout=END_S)
    except subprocess.TimeoutExpired:
        bench.kill()
        bench.wait()
    bench.stdout.close()


@atexit.register
def end_idle_benches() -> None:
    """Leave no process behind."""
    while IDLE:
        ended(IDLE.pop())


class EmulatedBoard:
    """A firmware in its emulator with a simulated wire on its pins.

    Args:
        wire: name of the wire, as in `musclewire simulate --list`; its shunt and pretension are the firmware's.
        pace: "clock": ticks by the clock; "lockstep": repeatable, and time passes only for commands.
        seed: of converter noise and of everything that goes wrong on the line by chance.
        faults: of wire and circuit, written as in a rig file; ``at`` counts from the start.
        board: which one, a folder of firmware/boards.
        elf: a firmware that is built already; without it one is built for the wire, with ``fault_injection`` the one
            for tests.
        boot_loader: of an empty ``arduino-uno``, by name: ``BOOT_LOADERS`` of emulation/boot_loaders.py. A host that
            opens the port resets the board then, as an Arduino's USB converter does.
        sample_period_s: in lockstep, how much time a DRIVE or TARGET lets pass.
        settings: changes of wire and bench by name, as for ``open_rig``.
    """

    def __init__(
        self,
        wire: str = "paper-100um",
        *,
        pace: Literal["clock", "lockstep"] = "clock",
        seed: int = 1,
        faults: Sequence[Mapping[str, Any]] = (),
        board: str = "mps2-an386",
        elf: Path | None = None,
        fault_injection: bool = False,
        sample_period_s: float = 0.05,
        boot_loader: str | None = None,
        settings: Mapping[str, float | str] | None = None,
    ) -> None:
        """Build the firmware if need be, start the bench and the emulator, wait until the board has started."""
        if board == "arduino-uno" and pace == "lockstep":
            raise CallerError(
                "the Arduino's emulator runs by the clock only: its bench keeps its time; use pace='clock'"
            )
        self._folder = tempfile.TemporaryDirectory(prefix="musclewire-board-")
        folder = Path(self._folder.name)
        if boot_loader is not None:
            elf = boot_loader_hex(boot_loader, folder)
        built = elf or firmware_for(
            board, folder, ["--wire", wire, *(["--fault-injection"] if fault_injection else [])]
        )
        mounted = wire_on(board, wire)
        circuit = {"shunt_resistance_ohm": mounted.shunt, "pretension_n": mounted.pretension}
        self._log, self._messages = folder / "log.bin", folder / "emulator.txt"
        if board in circuit_names():
            circuit_file = bench_of(load_circuit(board))
        else:
            circuit_file = tomllib.loads((FIRMWARE / "boards" / board / "circuit.toml").read_text(encoding="utf-8"))
        self._lockstep, self._tick_s = pace == "lockstep", float(circuit_file["tick_period_s"])
        self._start(
            {
                "board": circuit_file,
                "machine": board,
                "wire": wire,
                "seed": seed,
                "settings": {**circuit, **(settings or {})},
                "faults": [dict(fault) for fault in faults],
                "pace": pace,
                "sample_period_s": sample_period_s,
                "resets_on_open": boot_loader is not None,
                "elf": str(prepared(board, built, folder)),
                "log": str(self._log),
                "messages": str(self._messages),
            }
        )

    def _start(self, begin: Mapping[str, Any]) -> None:
        """Start the bench, which starts the emulator, and wait until the board has started."""
        self._lock = threading.Lock()
        self._closed = False
        self._plant = started_bench()
        try:
            self.port = int(self._say(begin)["port"])
            self._wait_for_start(1)
        except BaseException:
            self.close()
            raise

    @property
    def port_url(self) -> str:
        """What a rig file's ``port`` says: pyserial opens it like a serial port."""
        return f"socket://127.0.0.1:{self.port}"

    def _say(self, what: Mapping[str, Any]) -> dict[str, Any]:
        if self._closed:
            raise RigError("the emulated board has been closed")
        with self._lock:
            assert self._plant.stdin is not None
            assert self._plant.stdout is not None
            try:
                self._plant.stdin.write(json.dumps(what) + "\n")
                self._plant.stdin.flush()
                answer = self._plant.stdout.readline()
            except OSError as error:
                raise RigError(f"the emulated bench has ended: {error}") from error
        if not answer:
            raise RigError(f"the emulated bench has ended (exit code {self._plant.poll()}): look at its standard error")
        said: dict[str, Any] = json.loads(answer)
        if not said.pop("ok"):
            raise CallerError(str(said["error"]))
        return said

    def _wait_for_start(self, starts: int) -> None:
        until_s = time.monotonic() + START_S
        while time.monotonic() < until_s:
            figures = self.figures()
            if figures["starts"] >= starts:
                return
            if not figures["running"]:
                break
            time.sleep(0.01)
        raise RigError(f"the emulator did not start the board: {self._messages.read_text(encoding='utf-8').strip()}")

    def figures(self) -> dict[str, Any]:
        """Return the counts of ticks, late ticks and faults on the line."""
        return self._say({"do": "figures"})

    def messages(self) -> str:
        """Return what the emulator has printed: for the Arduino, cycles per tick."""
        return self._messages.read_text(encoding="utf-8")

    def log(self) -> dict[str, NDArray[np.float64]]:
        """Return what truly happened, one entry a tick, by column: see ``COLUMNS`` of emulation/plant.py."""
        self.figures()
        rows = np.fromfile(self._log).reshape(-1, len(COLUMNS))
        return {name: rows[:, place] for place, name in enumerate(COLUMNS)}

    def fault(self, kind: str, **details: Any) -> None:
        """Break something at the wire, in the circuit or in a channel, now."""
        self._say({"do": "fault", "faults": [{"kind": kind, **details}]})

    def repair(self) -> None:
        """Repair wire, circuit and channels."""
        self._say({"do": "repair"})

    def spoil_line(self, **faults: Any) -> None:
        """Inject faults into the host's line: the attributes of ``LineFaults``; without any it is sound again."""
        self._say({"do": "line", **faults})

    def unplug(self) -> None:
        """Pull the host's line out; the host's port fails, and none opens until ``plug``."""
        self._say({"do": "unplug"})

    def plug(self) -> None:
        """Put the host's line back in."""
        self._say({"do": "plug"})

    def kill_power(self) -> None:
        """Cut the board's power, whatever it is doing."""
        self._say({"do": "kill_power"})

    def restart(self) -> None:
        """Give the board its power again and wait until it has started."""
        starts = self.figures()["starts"]
        self._say({"do": "restart"})
        self._wait_for_start(starts + 1)

    def reset(self) -> None:
        """Press the board's reset button; its memory keeps its content."""
        starts = self.figures()["starts"]
        self._say({"do": "monitor", "text": "system_reset"})
        self._wait_for_start(starts + 1)

    def pause(self) -> None:
        """Stop the board's processor and its clocks; the bench's time goes on."""
        self._say({"do": "monitor", "text": "stop"})

    def resume(self) -> None:
        """Let the processor go on."""
        self._say({"do": "monitor", "text": "cont"})

    def press(self, duration_s: float = 0.2) -> None:
        """Press the button of a board that has one."""
        self._say({"do": "button", "down": True})
        self.pass_time(duration_s)
        self._say({"do": "button", "down": False})

    def pass_time(self, duration_s: float) -> None:
        """Let time pass without a command: the bench's in lockstep, else the clock's."""
        if self._lockstep:
            self.release(round(duration_s / self._tick_s))
        else:
            time.sleep(duration_s)

    def turn_knob(self, fraction: float) -> None:
        """Turn the knob of a board that has one: 0 to 1."""
        self._say({"do": "knob", "fraction": fraction})

    def release(self, ticks: int) -> None:
        """In lockstep: let some ticks pass without a command, and wait until they have."""
        self._say({"do": "release", "ticks": ticks})
        while self.figures()["released"]:
            time.sleep(0.001)

    def close(self) -> None:
        """End emulator and board; may be done twice."""
        if self._closed:
            return
        self._closed = True
        if self._ends_when_told():
            IDLE.append(self._plant)
        else:
            ended(self._plant)
        self._folder.cleanup()

    def _ends_when_told(self) -> bool:
        """Return whether the bench has ended its emulator and waits for another board."""
        assert self._plant.stdin is not None
        assert self._plant.stdout is not None
        with self._lock, suppress(OSError, ValueError):
            self._plant.stdin.write(json.dumps({"do": "end"}) + "\n")
            self._plant.stdin.flush()
            in_time = select.select([self._plant.stdout], [], [], END_S)[0]
            return bool(in_time and json.loads(self._plant.stdout.readline()) == {"ok": True})
        return False

    def __enter__(self) -> Self:
        """Return the board itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End it."""
        self.close()


def main() -> int:
    """Run a board until Ctrl-C; say once a second how well it keeps its ticks."""
    parser = argparse.ArgumentParser(description="An emulated board with a simulated wire, on a port of this machine.")
    parser.add_argument("--wire", default="paper-100um")
    parser.add_argument("--board", default="mps2-an386")
    parser.add_argument("--pace", choices=("clock", "lockstep"), default="clock")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=None, help="end by itself and print the rate of ticks")
    parser.add_argument(
        "--boot-loader",
        choices=BOOT_LOADERS,
        default=None,
        help="begin with this boot loader alone in the flash of an arduino-uno, for `musclewire flash`",
    )
    parser.add_argument("--rig-file", type=Path, default=None, help="write a rig file with this board's port here")
    given = parser.parse_args()
    try:
        with EmulatedBoard(
            given.wire,
            pace=given.pace,
            seed=given.seed,
            board=given.board,
            boot_loader=given.boot_loader,
        ) as board:
            if given.rig_file is not None:
                rig_text = rig_file_text(given.board, given.wire, board.port_url, lockstep=given.pace == "lockstep")
                given.rig_file.write_text(rig_text, encoding="utf-8")
            print(f'port = "{board.port_url}"', flush=True)
            before = board.figures()
            wait(given.seconds)
            after = board.figures()
            print(rate_of(before, after))
    except MusclewireError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    return 0


def rig_file_text(board: str, wire: str, port_url: str, *, lockstep: bool = False) -> str:
    """Return the rig file that is included for a board, with this port and wire, and patience with a slow emulator."""
    name = board if board == "arduino-uno" else "pico" if board in circuit_names() else "serial-board"
    text = (RIG_FILES / f"{name}.toml").read_text(encoding="utf-8")
    mounted = wire_on(board, wire)
    values = {
        "port": port_url,
        "wire": wire,
        "pretension": f"{mounted.pretension:g} N",
        "shunt": f"{mounted.shunt:g} ohm",
        "sense_voltage": f"{mounted.sense_voltage:g} V",
        "maximum_voltage": f"{mounted.maximum_voltage:g} V",
        "drive_amplitude": f"{mounted.drive_amplitude:g} V",
    }
    for key, value in values.items():
        text, found = re.subn(rf'^{key} = "[^"]*"', f'{key} = "{value}"', text, flags=re.M)
        assert found == 1, f"{key} stands {found} times in the rig file of {board}"
    more = [f'patience = "{PATIENCE}"', *(["lockstep = true"] if lockstep else [])]
    return text.replace("\nbaud", "\n".join(["", *more, "baud"]), 1)


def rate_of(before: Mapping[str, Any], after: Mapping[str, Any]) -> str:
    """Return in words how well a board has kept its ticks between two of its ``figures``."""
    passed_s = after["clock_s"] - before["clock_s"]
    ticks, late, lost, given_up = (after[key] - before[key] for key in ("ticks", "late", "overwritten", "given_up"))
    return (
        f"{ticks} ticks in {passed_s:.2f} s: {ticks / passed_s:.1f} Hz; {late} came late by more than a tick, "
        f"{lost} conversions were overwritten before the firmware fetched them, {given_up} ticks were given up"
    )


def wait(seconds: float | None) -> None:
    """Wait so long, or until Ctrl-C."""
    end_s = None if seconds is None else time.monotonic() + seconds
    try:
        while end_s is None or time.monotonic() < end_s:
            time.sleep(0.1)
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    sys.exit(main())
