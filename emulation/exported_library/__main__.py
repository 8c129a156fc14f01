"""Print what an exported library costs on a board: ``python -m emulation.exported_library FOLDER [--double]``.

Flash and memory of the library's objects, and the instructions (Cortex-M, in QEMU) or cycles (ATmega, in simavr) of a
whole tick. A compiler or emulator that is missing is named with the line that installs it.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from emulation.exported_library.cost import library_figures

COLUMNS = ("flash_bytes", "ram_bytes", "state_bytes")


def main() -> int:
    """Print a table of the costs, a row for each target."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="folder that 'musclewire export c' wrote")
    parser.add_argument("--double", action="store_true", help="it was exported with --double")
    given = parser.parse_args()
    if not (given.folder / "src/mw_constants.h").is_file():
        print(f"{given.folder} holds no exported library", file=sys.stderr)
        return 2
    rows = library_figures(given.folder, double=given.double)
    print(f"{'target':<12}{'flash [B]':>10}{'RAM [B]':>9}{'state [B]':>11}{'a tick: mean, most':>32}")
    for row in rows:
        flash, ram, state = ("-" if row[key] is None else str(row[key]) for key in COLUMNS)
        print(f"{row['target']:<12}{flash:>10}{ram:>9}{state:>11}{tick_text(row):>32}")
    for note in dict.fromkeys(row["not_measured"] for row in rows if row["not_measured"]):
        print(f"not measured: {note}", file=sys.stderr)
    return 0


def tick_text(row: dict[str, Any]) -> str:
    """Return what a whole tick costs on a target: instructions, or cycles if the emulator counts those."""
    for unit in ("instructions", "cycles"):
        if row[f"tick_{unit}_mean"] is not None:
            return f"{row[f'tick_{unit}_mean']}, {row[f'tick_{unit}_most']} {unit}"
    return "-"


if __name__ == "__main__":
    sys.exit(main())
