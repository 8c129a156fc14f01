"""Loops from the command line: steps, many runs, limits of speed, force by a stiffness, and the processor's time."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from tests.command_line import CommandLine

import musclewire as mw
from musclewire.controllers import SampledReference
from musclewire.files import read_recording
from musclewire.parameters import load_bench
from musclewire.sensing import SensingModel

# Steps are written as a text, with the time for which each is held.


@pytest.mark.parametrize(("text", "hold_s"), [("", 6.0), (" for 2 s", 2.0), (" for 2500 ms", 2.5)])
def test_each_step_is_held_for_the_time_that_is_given(
    text: str, hold_s: float, musclewire: CommandLine, model: Path, tmp_path: Path
) -> None:
    steps = ("--reference", f"1.5 % to 1.8 % by 0.3 %{text}")
    run = tmp_path / "run.h5"
    answer = musclewire("control", "simulated", model, *steps, "-o", run, "--json")
    assert [step["target_pct"] for step in answer.json["steps"]] == pytest.approx([1.5, 1.8, 1.5])
    assert len(read_recording(run)) == pytest.approx(3 * hold_s / 0.05, abs=1)


def test_a_time_without_a_unit_is_refused(musclewire: CommandLine, model: Path) -> None:
    refusal = musclewire("control", "simulated", model, "--reference", "1.5 % to 1.8 % by 0.3 % for 2").refusal
    assert "'2' has no unit" in refusal


# ``musclewire control --known-stiffness``: force by a model of strain.


def test_control_turns_strain_into_force_by_a_stiffness(musclewire: CommandLine, model: Path) -> None:
    said = musclewire(
        "control", "simulated", model, "--quantity", "force", "--known-stiffness", "588.6 N/m", "--json"
    ).json
    assert said["known_stiffness_n_per_m"] == 588.6
    assert said["known_friction_n"] == pytest.approx(load_bench("paper").guide_friction_n.value, abs=0.002)
    assert said["mae_max_approached_pct"] <= 5.0
    assert len(said["steps"]) == 11


# ``control --runs``: many loops at once, beside the options of a single one.

STEPS = ("--reference", "1.5 % to 1.8 % by 0.3 %")


@pytest.mark.slow
def test_every_loop_is_the_single_run_of_its_seed(musclewire: CommandLine, model: Path) -> None:
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


@pytest.mark.slow
def test_people_get_a_table_of_medians_and_spreads(musclewire: CommandLine, model: Path) -> None:
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


@pytest.mark.slow
def test_a_loop_that_fails_is_named_and_the_exit_code_is_1(
    musclewire: CommandLine, model: Path, tmp_path: Path
) -> None:
    rig = tmp_path / "other.toml"
    rig.write_text("[settings]\nresistivity_factor = 1.2\n", "utf-8")
    answer = musclewire("control", rig, model, *STEPS, "--runs", 2)
    assert answer.code == 1
    assert "seed 1: RigError: resistance" in answer.out


@pytest.mark.slow
def test_loops_under_another_load_do_not_hold_and_say_why(musclewire: CommandLine, model: Path, tmp_path: Path) -> None:
    rig = tmp_path / "half.toml"
    rig.write_text('pretension = "0.95 N"\n', "utf-8")
    many = musclewire("control", rig, model, *STEPS, "--runs", 2)
    assert many.code == 1
    assert many.out.splitlines()[-1].startswith("seed 2 does not hold: the rig states a pretension of 0.95 N")
    alone = musclewire("control", rig, model, *STEPS, "--seed", 2, "--json")
    answer = musclewire("control", rig, model, *STEPS, "--runs", 2, "--json").json
    assert alone.code == 1
    assert all(run["does_not_hold"].startswith("the rig states a pretension") for run in answer["runs"])


# Speed limits are said before a wire is heated, and the simulated wire keeps to them.

MIDDLE, AMPLITUDE = 0.0225, 0.0095


class Wire(NamedTuple):
    model: SensingModel
    settings: Any


@pytest.fixture(scope="module")
def wire() -> Wire:
    with mw.open_rig("simulated", seed=4) as rig:
        slow = mw.characterize(rig)
    model = mw.fit(slow)
    return Wire(model, mw.tune(model, slow).settings)


def sine(frequency_hz: float) -> SampledReference:
    time_s = np.arange(0.0, max(3.0 / frequency_hz, 12.0), 0.05)
    return mw.sampled_reference(time_s, MIDDLE + AMPLITUDE * np.sin(2.0 * math.pi * frequency_hz * time_s))


@pytest.mark.slow
@pytest.mark.parametrize("frequency_hz", [0.05, 0.5, 1.0])
@pytest.mark.parametrize("by_gains", [False, True])
def test_a_run_reaches_the_amplitude_that_was_said_before(wire: Wire, frequency_hz: float, by_gains: bool) -> None:
    """The bar: within 30 % of what a loop by the inverse of its model reaches."""
    reference, gains = sine(frequency_hz), wire.settings
    with mw.open_rig("simulated", seed=5) as rig:
        said = mw.speed_limits(rig, wire.model, reference, settings=gains if by_gains else None)
        run = mw.control(rig, wire.model, reference, controller="inverse-model", settings=gains)
    settled = run["displacement_m"][len(run) // 2 :] / 0.07
    reached = 0.5 * float(np.ptp(settled))
    assert said.possible_amplitude == pytest.approx(reached, rel=0.3)
    assert bool(said.findings) is (frequency_hz > 0.1)
    assert run.metadata.get("speed_limits", "").startswith("the reference") is (frequency_hz > 0.1)


def test_control_warns_before_it_heats_and_in_its_answer(wire: Wire, tmp_path: Path, musclewire: CommandLine) -> None:
    model_file, reference_file = tmp_path / "model.json", tmp_path / "target.csv"
    wire.model.save(model_file)
    fast = sine(1.0)
    rows = "\n".join(f"{t:.2f},{x:.6f}" for t, x in zip(fast.time_s, fast.target, strict=True))
    reference_file.write_text(f"time_s,target_strain\n{rows}\n", "utf-8")
    given = ("control", "simulated", model_file, "--reference", reference_file)
    answer = musclewire(*given, "--json").json
    assert any("faster than the wire cools" in text for text in answer["warnings"])
    assert answer["speed_limits"]["possible_amplitude"] < answer["speed_limits"]["asked_amplitude"]
    assert answer["speed_limits"]["help"]["heat_loss"] > 1.0
    shown = musclewire(*given).err
    assert shown.index("faster than the wire cools") < shown.index("Closed loop")


# ``--real-time-priority`` and ``--cpu`` on the command line.


@pytest.mark.skipif(sys.platform != "linux", reason="priority and pinning are Linux's")
@pytest.mark.slow
def test_what_the_system_refuses_is_a_warning_and_the_run_goes_on(
    musclewire: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("musclewire.rigs.take_priority", lambda: ["real-time priority is not permitted"])
    answer = musclewire(
        "characterize", "simulated", "--real-time", "--clock-speed", 10, "--real-time-priority", "--period", "1 s",
        "--cycles", "1", "-o", tmp_path / "loop.h5", "--json",
    )  # fmt: skip  # no sample is too late for a clock that is faster than time
    assert (tmp_path / "loop.h5").exists(), answer
    assert "warning: real-time priority is not permitted" in answer.err
    assert "real-time priority is not permitted" in answer.json["warnings"]
