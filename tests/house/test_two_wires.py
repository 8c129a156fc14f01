"""What takes one wire refuses a rig with two in one line, whichever extra it is of."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.command_line import CommandLine

import musclewire as mw
from musclewire.errors import CallerError

TWO = "gripper"


@pytest.mark.parametrize(
    "ask",
    [
        lambda: mw.WireVectorEnv(num_envs=1, rig=TWO),
        lambda: mw.linearise(displacement_m=1e-3, rig=TWO),
        lambda: mw.RigConfiguration(pwm={"frequency": 1000.0, "supply": 5.0}, load=[{"part": "antagonist"}]),
    ],
    ids=["vector environment", "operating point", "pulses"],
)
def test_a_rig_with_two_wires_is_refused(ask: Callable[[], Any]) -> None:
    with pytest.raises(CallerError, match=r"two wires|heats one wire"):
        ask()


def test_no_fmu_is_written_of_two_wires(tmp_path: Path, musclewire: CommandLine) -> None:
    assert "gripper has two wires" in musclewire("export", "fmu", TWO, "-o", tmp_path / "out").refusal
    assert not (tmp_path / "out").exists()
