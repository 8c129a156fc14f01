"""The options of designs: of the one list, with a hint for typos, and from a file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


@pytest.mark.slow
def test_a_design_reads_its_options_from_a_file_and_the_command_line_takes_precedence(
    musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    file = tmp_path / "options.toml"
    file.write_text('stiffness = "386.2 N/m"\npretension = "0.71 N"\n', "utf-8")
    by_file = musclewire("design", "pretensioner", file, "--json")
    by_options = musclewire("design", "pretensioner", "--stiffness", "386.2 N/m", "--pretension", "0.71 N", "--json")
    assert by_file == by_options
    assert by_file.code == 0
    softer = musclewire("design", "pretensioner", file, "--stiffness", "300 N/m", "--json").json
    assert softer["stiffness_n_per_m"] == pytest.approx(300.0, rel=1e-3)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('stifness = "1 N/m"', "unknown key 'stifness'; did you mean 'stiffness'?"),
        ('finger = "lan-fan-2010"\ndepth = "5 mm"', "--depth and --finger exclude each other"),
    ],
)
def test_a_wrong_options_file_is_one_line(text: str, said: str, musclewire: Callable[..., Any], tmp_path: Path) -> None:
    file = tmp_path / "options.toml"
    file.write_text(text + "\n", "utf-8")
    assert said in musclewire("design", "finger", file).refusal
