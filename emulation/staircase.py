"""The paper's staircase by emulated boards without a host, from cold: what fits where, and how well it follows.

    python -m emulation.staircase [--board arduino-uno]

Builds each board's firmware for the simulated rig's wire, with the estimator and the controller that its flash holds,
to go along the staircase by itself; presses its button, and waits. Prints flash and memory, the longest tick that the
emulator counted, and the mean absolute error of the true strain in percent of each target (Eq. 7, from the first
target on). Bar: at most 1.0 in the mean on a board with the filter, 2.0 on an Uno, whose flash does not hold it.
Exit 1 beyond.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from firmware.build import board_description, size_of

from emulation.board import EmulatedBoard, firmware_for
from musclewire.arrays import FloatArray
from musclewire.controllers import staircase

__all__ = ["BARS_PCT", "AloneRun", "alone_on_the_staircase"]

# The Arduino's emulator runs by the clock only.
BARS_PCT = {"mps2-an386": 1.0, "arduino-uno": 2.0}
AT_REST_S, PRESSED_S = 0.5, 0.2
# Eq. 7 counts from one second after each step on.
SETTLE_S = 1.0


class AloneRun(NamedTuple):
    """A run without a host: the error of each step in percent of its target, and what the build and the ticks took."""

    error_pct: FloatArray
    size: str
    most_cycles: int | None


def alone_on_the_staircase(board: str, folder: Path) -> AloneRun:
    """Build a board's firmware, press its button on a cold wire, and return how it followed the staircase."""
    elf, reference = firmware_for(board, folder, ["--staircase"]), staircase()
    tick_s = float(board_description(board)["tick_period_s"])
    with EmulatedBoard(board=board, elf=elf, pace="clock" if board == "arduino-uno" else "lockstep") as emulated:
        emulated.pass_time(AT_REST_S)
        emulated.press(PRESSED_S)
        ticks, driven, strain = round(reference.duration_s / tick_s), np.empty(0, np.intp), np.empty(0)
        while not driven.size or len(strain) < driven[0] + ticks:
            emulated.pass_time(1.0)
            log = emulated.log()
            strain, driven = log["strain"], np.flatnonzero(log["output_voltage_v"] > 0.0)
        cycles = [int(most) for most in re.findall(r"most (\d+) of", emulated.messages())]
    held = strain[driven[0] :][:ticks].reshape(len(reference.levels), -1)[:, round(SETTLE_S / tick_s) :]
    targets = np.array(reference.levels)
    errors = 100.0 * np.mean(np.abs(held - targets[:, np.newaxis]), axis=1) / targets
    return AloneRun(errors, size_of(board, elf), max(cycles, default=None))


def main() -> int:
    """Print the runs of all boards, or of one."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--board", choices=BARS_PCT, default=None)
    asked = parser.parse_args().board
    held = []
    for board in BARS_PCT if asked is None else (asked,):
        about = board_description(board)
        print(f"{board}: estimator {about['estimator']}, controller {about['controller']}")
        with tempfile.TemporaryDirectory() as folder:
            run = alone_on_the_staircase(board, Path(folder))
        print(run.size, end="")
        if run.most_cycles is not None:
            print(f"at most {run.most_cycles} cycles of a tick, {run.most_cycles / 16e3:.1f} ms at 16 MHz")
        print("error of the steps in % of the target: " + " ".join(f"{value:.2f}" for value in run.error_pct))
        mean = float(run.error_pct.mean())
        print(f"mean {mean:.2f} % (bar {BARS_PCT[board]} %)\n")
        held.append(mean <= BARS_PCT[board])
    return 0 if all(held) else 1


if __name__ == "__main__":
    sys.exit(main())
