"""The command linearise: what it prints, and what it refuses."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.command_line import CommandLine


def test_it_prints_points_poles_and_margins(musclewire: CommandLine) -> None:
    said = musclewire("linearise", "simulated", "--displacement", "2 mm").out
    for words in ("heating    |", "cooling    |", "heating, branch", "cooling, minor loop", "gain margin", "drifts"):
        assert words in said


def test_the_json_has_two_points_and_four_linear_wires(musclewire: CommandLine, tmp_path: Path) -> None:
    picture = tmp_path / "bode.svg"
    found = musclewire("linearise", "simulated", "--displacement", "2 mm", "--json", "--plot", picture).json
    assert [one["branch"] for one in found["operating_points"]] == ["heating", "cooling"]
    assert [one["motion"] for one in found["linearisations"]] == ["branch", "minor loop"] * 2
    assert found["width_v"] > 0.1
    assert picture.stat().st_size > 1000


@pytest.mark.parametrize("given", ["20 mm", "2 V", "-1 mm"])
def test_an_impossible_displacement_is_one_line_and_exit_code_2(given: str, musclewire: CommandLine) -> None:
    assert musclewire("linearise", "simulated", "--displacement", given).refusal
