"""What a library costs on a microcontroller: flash, memory, and instructions of a tick in the emulator."""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from musclewire.errors import NumericsError
from musclewire.export.c.compilers import EMULATOR, EMULATOR_PACKAGES, FLAGS, TARGETS, Target, missing_tool

__all__ = ["emulated", "library_figures", "linked", "target_figures"]

LONGEST_RUN_S = 1200.0


def library_figures(folder: Path, *, double: bool = False) -> list[dict[str, Any]]:
    """Return a row for each target: flash and RAM of the library's objects, and the instructions of a whole tick.

    A number that could not be measured is None, and ``not_measured`` says what is missing. The ATmega has no double
    precision of 64 bits, so a library that needs it has no row for it.
    """
    rows = []
    for target in TARGETS:
        if double and target.compiler == "avr-gcc":
            continue
        rows.append(target_figures(folder, target))
    return rows


def target_figures(folder: Path, target: Target) -> dict[str, Any]:
    """Return the row of one target."""
    row: dict[str, Any] = {
        "target": target.name,
        "flash_bytes": None,
        "ram_bytes": None,
        "state_bytes": None,
        "tick_instructions_mean": None,
        "tick_instructions_most": None,
        "not_measured": missing_tool(target.compiler, target.packages),
    }
    if row["not_measured"]:
        return row
    with tempfile.TemporaryDirectory() as name:
        row["flash_bytes"], row["ram_bytes"] = _sizes(folder, target, Path(name))
        if not target.machine:
            return {**row, "not_measured": "instructions: counted on Cortex-M only"}
        row["not_measured"] = missing_tool(EMULATOR, EMULATOR_PACKAGES)
        if not row["not_measured"]:
            program = linked(folder, target, "test/cortex_m/tick_cost.c", Path(name))
            counted = json.loads(emulated(program, target, counting=True))
            row["state_bytes"] = counted["state_bytes"]
            row["tick_instructions_mean"] = counted["instructions_mean"]
            row["tick_instructions_most"] = counted["instructions_most"]
    return row


def linked(folder: Path, target: Target, main: str, out: Path, *definitions: str) -> Path:
    """Return an ELF of the library and one of its test programs for a Cortex-M of QEMU."""
    program = out / f"{target.name}.elf"
    sources = [*sorted((folder / "src").glob("*.c")), folder / main, folder / "test/cortex_m/start.c"]
    _run(
        [target.compiler, *target.core, *FLAGS, *(f"-D{name}" for name in definitions), f"-I{folder / 'src'}"]
        + [str(source) for source in sources]
        + ["-T", str(folder / "test/cortex_m/mps2.ld"), "--specs=rdimon.specs", "-Wl,--gc-sections", "-o", str(program)]
    )
    return program


def emulated(program: Path, target: Target, *, counting: bool = False) -> str:
    """Run an ELF in QEMU and return what it printed; ``counting`` makes an instruction take a nanosecond."""
    clock = ["-icount", "shift=0"] if counting else []
    semihosting = ["-semihosting-config", "enable=on,target=native"]
    plain = ["-nographic", "-monitor", "none", "-serial", "none"]
    return _run([EMULATOR, "-M", target.machine, *clock, *plain, *semihosting, "-kernel", str(program)])


def _sizes(folder: Path, target: Target, out: Path) -> tuple[int, int]:
    """Return bytes of code and constants, and of memory, of the library's objects."""
    objects = []
    for source in sorted((folder / "src").glob("*.c")):
        objects.append(str(out / f"{source.stem}.o"))
        _run([target.compiler, *target.core, *FLAGS, f"-I{folder / 'src'}", "-c", str(source), "-o", objects[-1]])
    total = _run([target.size_program, "-t", *objects]).splitlines()[-1].split()
    text, data, bss = (int(number) for number in total[:3])
    return text + data, data + bss


def _run(command: Sequence[str]) -> str:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST_RUN_S, check=False)
    except subprocess.TimeoutExpired:
        raise NumericsError(
            f"{command[0]} did not end within {LONGEST_RUN_S:g} s: end what else the machine does"
        ) from None
    if done.returncode:
        last = (done.stderr or done.stdout).strip().splitlines() or ["nothing was printed"]
        raise NumericsError(f"{command[0]} ended with {done.returncode}: {last[-1]}")
    return done.stdout
