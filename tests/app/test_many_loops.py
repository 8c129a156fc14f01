"""``control --runs``: many loops at once, beside the options of a single one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.slow


STEPS = ("--reference", "1.5 % to 1.8 % by 0.3 %")


def test_every_loop_is_the_single_run_of_its_seed(musclewire: Callable[..., Any], model: Path) -> None:
    many = musclewire("control", "simulated", model, *STEPS, "--runs", 3, "--seed", 4, "--json").json
    assert [run["seed"] for run in many["runs"]] == [4, 5, 6]
    alone = musclewire("control", "simulated", model, *STEPS, "--seed", 5, "--json").json
    assert many["runs"][1]["mae_pct"] == [step["mae_pct"] for step in alone["steps"]]
    assert many["runs"][1]["mae_approached_pct"] == [step["mae_approached_pct"] for step in alone["steps"]]
    assert many["approach_s"] == alone["approach_s"] == 0.0
    assert many["runs"][1]["ended"] == "done"
    runs = ("--runs", 3, "--seed", 4, "--in-python")
    in_python = musclewire("control", "simulated", model, *STEPS, *runs, "--json").json
    assert in_python["steps"] == many["steps"]


def test_people_get_a_table_of_medians_and_spreads(musclewire: Callable[..., Any], model: Path) -> None:
    answer = musclewire("control", "simulated", model, *STEPS, "--runs", 2)
    assert answer.code == 0
    assert answer.out.startswith("2 of 2 loops reached their end")
    assert answer.out.splitlines()[1].startswith("mean of the steps: median ")
    assert "1.8 %  rise" in answer.out
    assert "no approach" in answer.out
    papers = ("--controller", "fuzzy-pid", "--approach", "10 s")
    after = musclewire("control", "simulated", model, *STEPS, *papers, "--runs", 2)
    assert "the first step began 10 s later" in after.out
    assert "largest step error after the approach: median " in after.out


def test_a_loop_that_fails_is_named_and_the_exit_code_is_1(
    musclewire: Callable[..., Any], model: Path, tmp_path: Path
) -> None:
    rig = tmp_path / "other.toml"
    rig.write_text("[settings]\nresistivity_factor = 1.2\n", "utf-8")
    answer = musclewire("control", rig, model, *STEPS, "--runs", 2)
    assert answer.code == 1
    assert "seed 1: RigError: resistance" in answer.out


def test_loops_under_another_load_do_not_hold_and_say_why(
    musclewire: Callable[..., Any], model: Path, tmp_path: Path
) -> None:
    rig = tmp_path / "half.toml"
    rig.write_text('pretension = "0.95 N"\n', "utf-8")
    many = musclewire("control", rig, model, *STEPS, "--runs", 2)
    assert many.code == 1
    assert many.out.splitlines()[-1].startswith("seed 2 does not hold: the rig states a pretension of 0.95 N")
    alone = musclewire("control", rig, model, *STEPS, "--seed", 2, "--json")
    answer = musclewire("control", rig, model, *STEPS, "--runs", 2, "--json").json
    assert alone.code == 1
    assert all(run["does_not_hold"].startswith("the rig states a pretension") for run in answer["runs"])
