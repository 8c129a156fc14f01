"""The exported C library: the same bits on every processor, as close to Python as promised, small and quick enough.

    python benchmarks/exported_c.py [--quick]

Exports the simulated wire's model (polynomials of order 6, rule base zhao-1993), with the polynomial and the
filter, and with filter and inverse model, and prints, each with its bar:

- one hash over all outputs of 1,000,000 ticks, in single and double precision, on this machine and on emulated
  Cortex-M3, M4F and M7 (--quick: 20,000 ticks);
- the largest differences from Python over golden vectors and over a long random run;
- flash, memory and the instructions of a whole tick, counted in QEMU;
- the accuracy of the library's own exponential.

Ends with 1 where a bar is not held, with 2 where a compiler or the emulator is missing (the apt line is printed).
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # for emulation/, which is not installed

from emulation.exported_library.cost import emulated, library_figures, linked
from emulation.exported_library.on_this_machine import (
    FILTER_DIFFERENCE,
    MAX_DIFFERENCE,
    HostLibrary,
    built,
    host_hash,
    largest_differences,
)
from emulation.exported_library.targets import TARGETS, missing_tool

import musclewire as mw
from musclewire.controllers import DriveLimits, FeedforwardSettings, FuzzyPidSettings, Gains
from musclewire.extras.board import CLibrary, ReferenceTick, exercise, golden_ticks, write_library

FULL_SAMPLES, QUICK_SAMPLES = 1_000_000, 20_000
FULL_RANDOM, QUICK_RANDOM = 200_000, 10_000
# A whole tick and the library on a Cortex-M4F: instructions, and flash [B].
MOST = {"polynomial": (2300, 8 * 1024), "filter": (15_000, 12 * 1024)}
INVERSE_MODEL = "inverse-model"  # after the filter, in place of the fuzzy PID
MOST[INVERSE_MODEL] = (15_000, 13 * 1024)
UNO_HZ = 16e6
EXPONENTIAL_ULPS = 2.0
CORTEX_M = [target for target in TARGETS if target.emulator != "simavr"]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer ticks")
    quick = parser.parse_args().quick
    missing = [
        line
        for line in (
            missing_tool("gcc", "gcc libc6-dev"),
            *(missing_tool(target.compiler, target.packages) for target in TARGETS),
            *(missing_tool(target.emulator, target.emulator_packages) for target in TARGETS),
        )
        if line
    ]
    if missing:
        print(*dict.fromkeys(missing), sep="\n", file=sys.stderr)
        return 2
    held: list[bool] = []
    with tempfile.TemporaryDirectory() as name:
        for made in MOST:
            folder = Path(name) / made
            folder.mkdir()
            library, reference = exported(folder / "library", made)
            held += [
                *same_bits(library, folder, QUICK_SAMPLES if quick else FULL_SAMPLES),
                *against_python(library, reference, folder, QUICK_RANDOM if quick else FULL_RANDOM),
                *costs(library, made),
                *(() if made == INVERSE_MODEL else exponential(library, folder)),
            ]
    print(f"{sum(held)} of {len(held)} bars held")
    return 0 if all(held) else 1


def exported(folder: Path, made: str) -> tuple[CLibrary, ReferenceTick]:
    """Export the simulated wire's own model with an estimator or the inverse model; also return its reference."""
    with mw.open_rig("simulated") as rig:
        model = mw.fit(mw.characterize(rig, minor_loop=False))
        limits = rig.protection_limits
    drive = DriveLimits(limits.sense_voltage_v, limits.maximum_voltage_v)
    estimator = "filter" if made == INVERSE_MODEL else made
    settings: FuzzyPidSettings | FeedforwardSettings = FuzzyPidSettings()
    if made == INVERSE_MODEL:
        gains = Gains.read(model.gains, "the fitted model").settings
        assert isinstance(gains, FeedforwardSettings)
        settings = gains
    print(f"model of order {model.order}, {made if made == INVERSE_MODEL else 'fuzzy-pid'}, estimator {estimator}")
    library = write_library(model, settings, drive, limits, folder, estimator=estimator)
    return library, ReferenceTick(model, settings, drive, limits, estimator=estimator)


def same_bits(library: CLibrary, folder: Path, samples: int) -> Iterator[bool]:
    """Print and compare the hash of every target."""
    for precision in ("single", "double"):
        definitions = ["MW_DOUBLE"] if precision == "double" else []
        here = host_hash(library.folder, samples, double=bool(definitions))
        print(f"{precision}: {here}, this machine")
        for target in CORTEX_M:
            program = linked(library.folder, target, "test/same_bits.c", folder, f"SAMPLES={samples}", *definitions)
            there = emulated(program, target).strip()
            print(f"{precision}: {there}, {target.name}{'' if there == here else ': DIFFERENT'}")
            yield there == here


def against_python(library: CLibrary, reference: ReferenceTick, folder: Path, ticks: int) -> Iterator[bool]:
    """Print and judge the largest differences from Python."""
    filters = reference.estimator == "filter"
    for double, most in (FILTER_DIFFERENCE if filters else MAX_DIFFERENCE).items():
        precision = "double" if double else "single"
        loaded = HostLibrary(built(library.folder, folder, double=double), double=double)
        for what, rows in (
            ("golden vectors", iter(golden_ticks(reference))),
            (f"{ticks} random ticks", exercise(reference, 7, ticks)),
        )[: 1 if filters and not double else None]:
            found = largest_differences(loaded, reference, rows, relative=double)
            worst = max(found.values())
            said = ", ".join(f"{name} {value:.1e}" for name, value in found.items() if value > 0.0) or "none"
            print(f"{precision} against Python, {what}: at most {worst:.1e} (bar {most:g}); {said}")
            yield worst <= most


def costs(library: CLibrary, made: str) -> Iterator[bool]:
    """Print flash, memory, instructions or cycles; judge those of the Cortex-M4F."""
    for row in library_figures(library.folder):
        print(", ".join(f"{key} {value}" for key, value in row.items() if value not in (None, "")))
        if row["target"] == "cortex-m4f":
            instructions, flash_bytes = MOST[made]
            yield row["tick_instructions_most"] <= instructions
            yield row["flash_bytes"] <= flash_bytes
        elif row["tick_cycles_most"]:
            print(f"an Uno takes at most {1e3 * row['tick_cycles_most'] / UNO_HZ:.1f} ms for a tick")


def exponential(library: CLibrary, folder: Path) -> Iterator[bool]:
    """Print the error of the library's exponential in units of the last place, against NumPy's in wider numbers."""
    for double in (False, True):
        loaded = HostLibrary(built(library.folder, folder, double=double), double=double)
        kind = np.float64 if double else np.float32
        points = np.linspace(-4.0, 0.0, 40_001).astype(kind)
        exact = np.exp(points.astype(np.longdouble))
        ours = np.array([loaded.exponential(float(x)) for x in points], dtype=np.longdouble)
        ulps = float(np.max(np.abs(ours - exact) / np.spacing(exact.astype(kind))))
        print(f"exponential, {'double' if double else 'single'}: {ulps:.2f} units in the last place at most")
        yield ulps <= EXPONENTIAL_ULPS


if __name__ == "__main__":
    sys.exit(main())
