"""What a library costs on a microcontroller: flash, memory, and instructions or cycles of a tick in the emulator."""

from __future__ import annotations

import json
import re
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from emulation.exported_library.targets import FLAGS, TARGETS, Target, missing_tool
from musclewire.errors import NumericsError

__all__ = ["emulated", "library_figures", "linked", "target_figures"]

MAX_RUN_S = 1200.0
MEASURED = (
    "flash_bytes",
    "ram_bytes",
    "state_bytes",
    "tick_instructions_mean",
    "tick_instructions_most",
    "tick_cycles_mean",
    "tick_cycles_most",
)


def library_figures(folder: Path, *, double: bool = False) -> list[dict[str, Any]]:
    """Return a row for each target: flash and RAM of the library's objects, and the instructions (Cortex-M) or
    cycles (ATmega) of a whole tick.

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
    row: dict[str, Any] = {"target": target.name, **dict.fromkeys(MEASURED)}
    row["not_measured"] = missing_tool(target.compiler, target.packages)
    if row["not_measured"]:
        return row
    with tempfile.TemporaryDirectory() as name:
        row["flash_bytes"], row["ram_bytes"] = _sizes(folder, target, Path(name))
        row["not_measured"] = missing_tool(target.emulator, target.emulator_packages)
        if not row["not_measured"]:
            kind = "avr" if target.emulator == "simavr" else "cortex_m"
            program = linked(folder, target, f"test/{kind}/tick_cost.c", Path(name))
            counted = json.loads(emulated(program, target, counting=True))
            row |= {f"tick_{key}" if key != "state_bytes" else key: counted[key] for key in counted if key != "ticks"}
    return row


def linked(folder: Path, target: Target, main: str, out: Path, *definitions: str) -> Path:
    """Return an ELF of the library and one of its test programs for a target's emulator."""
    program = out / f"{target.name}.elf"
    sources = [*sorted((folder / "src").glob("*.c")), folder / main]
    ending = ["-Wl,--gc-sections", "-o", str(program)]
    if target.emulator != "simavr":
        sources.append(folder / "test/cortex_m/start.c")
        ending = ["-T", str(folder / "test/cortex_m/mps2.ld"), "--specs=rdimon.specs", *ending]
    definitions = tuple(f"-D{name}" for name in definitions)
    flags = [*target.core, *FLAGS, *definitions, f"-I{folder / 'src'}"]
    _run([target.compiler, *flags, *(str(source) for source in sources), *ending])
    return program


def emulated(program: Path, target: Target, *, counting: bool = False) -> str:
    """Run an ELF in its emulator and return what it printed; ``counting``: QEMU takes a nanosecond an instruction."""
    if target.emulator == "simavr":
        # It colours the lines of the serial port, shows their ends as dots, and prints them on stderr.
        printed = re.search(
            r"\{.*\}", _run(["simavr", "-m", target.machine, "-f", "16000000", str(program)], both=True)
        )
        if printed is None:
            raise NumericsError(f"simavr printed nothing for {program.name}: report it with simavr's version")
        return printed[0]
    clock = ["-icount", "shift=0"] if counting else []
    semihosting = ["-semihosting-config", "enable=on,target=native"]
    plain = ["-nographic", "-monitor", "none", "-serial", "none"]
    return _run([target.emulator, "-M", target.machine, *clock, *plain, *semihosting, "-kernel", str(program)])


def _sizes(folder: Path, target: Target, out: Path) -> tuple[int, int]:
    """Return bytes of code and constants, and of memory, of the library's objects."""
    objects = []
    for source in sorted((folder / "src").glob("*.c")):
        objects.append(str(out / f"{source.stem}.o"))
        _run([target.compiler, *target.core, *FLAGS, f"-I{folder / 'src'}", "-c", str(source), "-o", objects[-1]])
    total = _run([target.size_program, "-t", *objects]).splitlines()[-1].split()
    text, data, bss = (int(number) for number in total[:3])
    return text + data, data + bss


def _run(command: Sequence[str], *, both: bool = False) -> str:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=MAX_RUN_S, check=False)
    except subprocess.TimeoutExpired:
        raise NumericsError(
            f"{command[0]} did not end within {MAX_RUN_S:g} s: end what else the machine does"
        ) from None
    if done.returncode:
        last = (done.stderr or done.stdout).strip().splitlines() or ["nothing was printed"]
        raise NumericsError(f"{command[0]} ended with {done.returncode}: {last[-1]}")
    return done.stdout + done.stderr if both else done.stdout
