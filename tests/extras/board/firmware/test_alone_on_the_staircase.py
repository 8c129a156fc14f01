"""Boards that close the loop by themselves, with what their flash holds, follow the paper's staircase from cold."""

from __future__ import annotations

from pathlib import Path

import pytest
from emulation.staircase import BARS_PCT, alone_on_the_staircase
from tests.tools import require_tool

pytestmark = pytest.mark.emulated


@pytest.mark.parametrize("board", BARS_PCT)
def test_without_a_host_and_from_cold_the_mean_error_is_within_its_bar(board: str, tmp_path: Path) -> None:
    if board == "arduino-uno":
        require_tool("avr-gcc", "gcc-avr avr-libc")
        require_tool("simavr", "simavr libsimavr-dev libelf-dev gcc libc6-dev")
    else:
        require_tool("arm-none-eabi-gcc", "gcc-arm-none-eabi libnewlib-arm-none-eabi")
        require_tool("qemu-system-arm", "qemu-system-arm")
    run = alone_on_the_staircase(board, tmp_path)
    assert len(run.error_pct) == 11
    assert run.error_pct.mean() <= BARS_PCT[board], run.error_pct
    if run.most_cycles is not None:
        assert run.most_cycles < 160_000  # of a tick of 10 ms
