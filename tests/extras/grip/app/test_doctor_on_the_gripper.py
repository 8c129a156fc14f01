"""``musclewire doctor`` on two fingers."""

from __future__ import annotations

from tests.command_line import CommandLine


def test_a_sound_gripper_passes(musclewire: CommandLine) -> None:
    answer = musclewire("doctor", "gripper", "--json")
    assert answer.code == 0, answer.out
    assert answer.json["highest_drive_voltage_v"] <= 0.3
