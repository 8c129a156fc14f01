"""``musclewire doctor`` on the rigs that ship with musclewire: what is typed, what comes back."""

from __future__ import annotations

import pytest
from tests.command_line import CommandLine


@pytest.mark.parametrize("rig", ["simulated", "finger"])
def test_a_sound_rig_passes(musclewire: CommandLine, rig: str) -> None:
    answer = musclewire("doctor", rig, "--json")
    assert answer.code == 0, answer.out
    said = answer.json
    assert said["ok"] is True
    assert all(check["ok"] for check in said["checks"])
    assert all(set(check) == {"name", "ok", "value", "unit", "advice"} for check in said["checks"])
    assert said["highest_drive_voltage_v"] <= 0.3
