# ruff: noqa: E402 - a package that may be missing is asked for first
"""``musclewire robustness --tasks``: what is asked, how it is judged, and what is named without an instrument."""

from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from tests.command_line import CommandLine
from tests.tools import require_package

import musclewire as mw
from musclewire.app import json_schema
from musclewire.errors import CallerError

require_package("musclewire_robustness", "pip install ./studies/robustness")
# README's second command does without the package: its tests are of a group that runs where developers' packages are.
pytestmark = pytest.mark.slow

from musclewire_robustness.task_plants import PLANTS, ChangedAir, TaskPlant
from musclewire_robustness.task_runs import FollowedTargets, TaskCase, case_of, scores_of
from musclewire_robustness.task_table import SEEDS, WIRES, asked_rows, task_table
from musclewire_robustness.tasks import CHANGES, IN_CHANGES, STILL, TASKS, Change

TIME_S = np.asarray(0.05 * np.arange(1, 401), dtype=np.float64)
STEPS = np.where(TIME_S <= 10.0, 0.02, 0.025)


@pytest.fixture(scope="module")
def model() -> mw.SensingModel:
    with mw.open_rig("simulated", seed=1) as rig:
        return mw.fit(mw.characterize(rig))


@pytest.mark.parametrize("name", TASKS)
def test_every_target_of_a_task_is_one_that_the_model_senses_and_a_seed_repeats_it(
    name: str, model: mw.SensingModel
) -> None:
    first, again, other = (TASKS[name].reference(model, seed) for seed in (741, 741, 742))
    times_s = 0.05 * np.arange(round(first.duration_s / 0.05))
    targets = first.targets_at(times_s)
    assert targets.min() >= model.quantity_min
    assert targets.max() <= model.quantity_max
    assert np.array_equal(targets, again.targets_at(times_s))
    drawn = name in ("random steps", "small steps", "slider", "near B", "near C")
    assert drawn != np.array_equal(targets, other.targets_at(times_s))


def test_a_task_that_jumps_leaves_out_a_second_and_one_that_moves_does_not() -> None:
    late = np.where((TIME_S > 10.0) & (TIME_S <= 11.0), 0.02, STEPS)
    followed = FollowedTargets(TIME_S, STEPS, late, np.full(400, 2.0))
    held, moving = (TaskCase("simulated", task, STILL, 1) for task in ("staircase", "sine 30 s"))
    assert followed.errors_pct(followed.counts(held)) == (0.0, 0.0)
    mean_pct, largest_pct = followed.errors_pct(followed.counts(moving))
    assert largest_pct == pytest.approx(20.0)
    assert mean_pct == pytest.approx(20.0 * 20 / 360)


def test_a_hold_swings_whose_drive_goes_by_more_than_half_a_volt_two_seconds_after_its_target() -> None:
    drive_v = np.where((TIME_S > 15.0) & (TIME_S < 16.0), 2.6, 2.0)
    followed = FollowedTargets(TIME_S, STEPS, STEPS, drive_v)
    assert followed.swings(TaskCase("simulated", "staircase", STILL, 1)) == (1, 2)
    assert followed.swings(TaskCase("simulated", "triangle 40 s", STILL, 1)) == (0, 0)
    slow = FollowedTargets(TIME_S, STEPS, STEPS, 2.0 + 0.1 * TIME_S)
    assert slow.swings(TaskCase("simulated", "staircase", STILL, 1)) == (0, 2)


def test_a_change_comes_within_a_second_and_draughts_repeat_for_a_seed() -> None:
    air = ChangedAir(Change(convection=2.0, warmer_k=10.0), 20.0, 741)
    found = [tuple(air.after(time_s, 0.05)) for time_s in (19.0, 20.5, 30.0)]
    assert found == [(0.0, 1.0), (5.0, pytest.approx(2.0**0.5)), (10.0, 2.0)]
    one, two = ([ChangedAir(CHANGES["draughts"], 0.0, 741).after(0.05 * k, 0.05) for k in range(100)] for _ in range(2))
    assert one == two


def test_the_table_has_every_task_in_still_air_and_three_of_them_in_every_change_on_reported_seeds() -> None:
    rows = asked_rows()
    for plant, of in PLANTS.items():
        own = [row for row in rows if row.plant == plant]
        assert {row.task for row in own if row.condition == STILL} == set(TASKS)
        changes = {name for name, change in CHANGES.items() if change.load == 0.0 or of.has_load}
        assert {row.condition for row in own} == changes
        assert {row.task for row in own if row.condition != STILL} == set(IN_CHANGES)
    seeds = {case.seed for row in rows for case in row.cases(quick=False)}
    assert seeds == set(WIRES) | set(SEEDS)
    assert all(case_of(case.name) == case for row in rows[:3] for case in row.cases(quick=True))


def test_a_part_of_a_name_that_no_row_has_is_refused() -> None:
    with pytest.raises(CallerError, match="no row has 'sines'"):
        asked_rows(["sines"])
    assert [row.name for row in asked_rows(["simulated/triangle"])] == ["simulated/triangle 40 s/still air"]


@pytest.mark.slow
def test_plants_of_examples_are_refused_outside_a_checkout_before_any_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    elsewhere = replace(PLANTS["Duhem"], rig=tmp_path / "duhem.toml")
    monkeypatch.setitem(cast(dict[str, TaskPlant], PLANTS), "Duhem", elsewhere)
    with pytest.raises(CallerError, match=r"duhem is an example of the checkout.*: run this there"):
        task_table(["Duhem/staircase/still"], folder=tmp_path / "runs")
    assert not (tmp_path / "runs").exists()


def test_a_row_has_three_controllers_and_names_what_a_user_without_a_sensor_can_see(
    tmp_path: Any, musclewire: CommandLine
) -> None:
    only = ("--only", "simulated/sine 3")
    answer = musclewire("robustness", "--tasks", *only, "-o", tmp_path / "out", "--workers", "1", "--json")
    assert answer.code == 0
    Draft202012Validator(json_schema("output-robustness")).validate(answer.json)
    rows = {(row["task"], row["controller"]): row for row in answer.json["rows"] if row["condition"] == "still air"}
    assert rows["sine 30 s", "default"]["mae_mean_pct"] < 1.5
    assert rows["sine 30 s", "default"]["exit"] == 0
    assert rows["sine 3 s", "default"]["named"] == ["target_missed 5/5"]
    assert rows["sine 3 s", "default"]["exit"] == 1
    assert rows["sine 3 s", "PI on a sensor"]["estimate_rms_pct"] is None
    again = musclewire("robustness", "--tasks", *only, "-o", tmp_path / "out", "--workers", "1", "--json")
    assert again.json["rows"] == answer.json["rows"]
    assert musclewire("robustness", "--only", "simulated").code == 2
    assert musclewire("robustness", "--tasks", "--tuning").code == 2


def test_a_wire_that_goes_against_its_power_is_one_of_another_heat_loss(model: mw.SensingModel) -> None:
    """Twice the heat loss from one sample to the next: every watt that comes late loses strain that none brings back.

    The supply holds the wire where it is, and no more. By a filter whose heat loss rests until readings have surprised
    for seconds the default erred by 30 % of target, and was worse than the paper's fuzzy PID.
    """
    scores = scores_of(TaskCase("simulated", "staircase", "twice the heat loss", 741), model)
    assert scores["default"].mean_pct < min(20.0, scores["fuzzy-pid"].mean_pct)


def test_a_wire_whose_resistance_is_a_hundredth_low_is_not_taken_for_cold(
    tmp_path: Any, musclewire: CommandLine
) -> None:
    """Its reading falls before B, though the power rises; that was another heat loss, and the wire cold to the end."""
    only = ("--condition", "R -1 %, zeroed again", "--track", "random steps", "--estimators", "filter")
    answer = musclewire("robustness", "--wires", "105", *only, "-o", tmp_path / "out", "--workers", "1", "--json")
    (row,) = [one for one in answer.json["rows"] if one["disturbance"] == "R" and one["estimator"] == "filter"]
    assert row["valid_share"] == 1.0
    assert row["estimate_rms_pct"] < 1.0
