"""What a board with MicroPython decides is what the host decides, to the bit: its ticks on the real interpreter."""

from __future__ import annotations

import math
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest
from emulation.board import micropython_for, wire_on
from firmware.build import model_of, mounted_wire
from tests.extras.board.micropython.interpreters import require_interpreter

from musclewire.controllers import DriveLimits
from musclewire.extras.board import ReferenceTick, exercise, settings_in_c

SCRIPT = Path(__file__).with_name("on_the_interpreter.py")
EMULATION = Path(__file__).parents[4] / "emulation" / "micropython"
TICKS = 5_000  # of each of 20 seeds
ROW, OUTCOME = struct.Struct("<Bdddd"), struct.Struct("<dddBB")


def outcomes_on(folder: Path, rows: list[bytes]) -> list[tuple[float, ...]]:
    """Return what the interpreter makes of rows of exercise, with the program in a folder."""
    found = require_interpreter()
    (folder / "exercise.bin").write_bytes(b"".join(rows))
    (folder / SCRIPT.name).write_bytes(SCRIPT.read_bytes())
    command = [str(found.node), str(EMULATION / "script.mjs"), str(found.folder), str(folder), SCRIPT.stem]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300.0)
    return [OUTCOME.unpack(bytes.fromhex(line)) for line in done.stdout.split()]


@pytest.mark.parametrize(
    "seed", [pytest.param(seed, marks=pytest.mark.full if seed > 1 else pytest.mark.emulated) for seed in range(1, 21)]
)
def test_every_tick_has_the_hosts_bits(seed: int, tmp_path: Path) -> None:
    require_interpreter()
    mounted, model = wire_on("pico", "paper-100um"), model_of(mounted_wire("paper-100um"), None)
    limits = mounted.protection_limits(wire_range_v=16.0, shunt_range_v=0.32, readings_noisy=False)
    drive = DriveLimits(limits.sense_voltage_v, limits.maximum_voltage_v)
    reference = ReferenceTick(model, settings_in_c(model, sample_period_s=0.05), drive, limits, estimator="filter")
    rows, expected = [], []
    for row in exercise(reference, seed, TICKS):
        rows.append(ROW.pack(row.start, row.wire_voltage_v, row.shunt_voltage_v, row.target, row.tick_s))
        now = row.outcome
        expected.append((now.drive_voltage_v, reference.protection.temperature_k, now.estimate, now.state, now.event))
    found = outcomes_on(micropython_for("pico", tmp_path), rows)
    assert len(found) == TICKS
    assert len({row[3:] for row in expected}) > 10, "states and events that come up"
    assert not [
        (place, here, there)
        for place, (here, there) in enumerate(zip(found, expected, strict=True))
        if not np.array_equal(here, there, equal_nan=True)
    ][:3]
    assert math.isfinite(found[-1][1])
