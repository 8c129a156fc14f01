"""A bench with the real firmware in an emulator: the same page for hardware, and a stop that the board confirms."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Iterator
from importlib import resources
from pathlib import Path

import pytest
from emulation.board import EmulatedBoard
from tests.extras.board.contract.serial_rigs import PATIENCE_S, built_firmware, require_board
from tests.extras.live.bench import ask, bench, in_control, until_phase

pytestmark = pytest.mark.emulated


@pytest.fixture
def rig_file(tmp_path: Path) -> Iterator[Path]:
    """A rig file of a board in lockstep: its time passes only for commands, so that a busy machine trips nothing."""
    require_board()
    shipped = next(Path(str(resources.files("musclewire"))).rglob("serial-board.toml")).read_text("utf-8")
    with EmulatedBoard(pace="lockstep", elf=built_firmware()) as board:
        path = tmp_path / "bench.toml"
        there = f'port = "{board.port_url}"\npatience = "{PATIENCE_S:g} s"\nlockstep = true'
        path.write_text(re.sub(r'(?m)^port = ".*"', there, shipped), "utf-8")
        yield path


def test_a_board_is_driven_and_stopped_live(rig_file: Path, tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path, str(rig_file), seed=None) as handle, in_control(handle):
            assert (await ask(handle, do="switch_on")).accepted, handle.state["why"]
            assert handle.state["rig"]["simulated"] is False
            assert "shunt" in " ".join(handle.state["rig"]["wiring"])
            refused = await ask(handle, do="clock_speed", factor=2.0)
            assert not refused.accepted
            assert (await ask(handle, do="pulse", duration_s=0.5)).accepted, handle.state["why"]
            await until_phase(handle, "ready", "failed")
            assert handle.state["steps"]["pulse"], handle.state["why"]
            assert (await ask(handle, do="characterize", period_s=2000.0, cycles=1)).accepted
            await asyncio.sleep(1.0)
            handle.stop("a test")
            await until_phase(handle, "stopped", "failed")
            assert handle.state["why"].startswith("stopped by a test: the drive is off")
            assert handle.state["phase"] == "stopped"
            rows = handle.rows(0)[1][-1]
            assert rows.values[-1][handle.layouts[rows.layout].index("drive_voltage_v")] > 0.0
            assert (await ask(handle, do="switch_on")).accepted, handle.state["why"]
            await until_phase(handle, "ready")

    asyncio.run(run())
