"""A strain that is known at one moment: what it corrects, when it is a finding, and when it cannot be compared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import musclewire as mw
from musclewire.controllers import staircase
from musclewire.errors import CallerError
from musclewire.experiment import control, run_warnings
from musclewire.judge import JudgedLoop, judgement_of
from musclewire.judge._known_strain import MissedBy, compared_with_known
from musclewire.sensing import SensingModel
from musclewire.signals import Recording

STEPS = staircase(0.015, 0.021, 0.003, 4.0)


def test_a_loop_whose_resistance_is_a_hundredth_off_is_right_after_one_known_strain(model: SensingModel) -> None:
    other = replace(
        model, resistance_min_ohm=model.resistance_min_ohm / 1.01, resistance_max_ohm=model.resistance_max_ohm / 1.01
    )
    # The same run up to there, for what its ruler reads at 3.5 s.
    with mw.open_rig("simulated", seed=4) as rig:
        before, leg_m = control(rig, other, STEPS), rig.leg_length_m
    time_s = before["time_s"] - before["time_s"][0]
    known = float(np.interp(3.5, time_s, before["displacement_m"])) / leg_m
    with mw.open_rig("simulated", seed=4) as rig:
        run = control(rig, other, STEPS, known_strain=(known, 3.5))
    error_pct = 100.0 * (run["estimated_strain"] - run["displacement_m"] / leg_m) / model.stroke
    late = (time_s > 4.5) & (run["valid"] > 0.0)
    assert np.sqrt(np.mean(error_pct[(time_s > 1.0) & (time_s < 3.5)] ** 2)) > 4.0
    assert np.sqrt(np.mean(error_pct[late] ** 2)) < 1.5
    assert run["resistance_factor"][0] == 1.0
    assert run["resistance_factor"][-1] == pytest.approx(1.0 / 1.01, abs=2e-3)
    assert "known strain missed" in judgement_of(run).does_not_hold
    assert "the resistance is scaled by 0.9" in str(run.metadata["health"])
    # Cut at its beginning, the recording counts from the beginning of the run all the same.
    assert missed_in(run.between(40)) == missed_in(run)._replace(row=30)  # type: ignore[union-attr]
    assert missed_in(run.between(80)) is None


def missed_in(run: Recording) -> MissedBy | None:
    return compared_with_known(JudgedLoop(run))


def test_a_known_strain_that_agrees_is_no_finding(model: SensingModel) -> None:
    with mw.open_rig("simulated", seed=4) as rig:
        before, leg_m = control(rig, model, STEPS), rig.leg_length_m
    known = float(np.interp(3.5, before["time_s"] - before["time_s"][0], before["displacement_m"])) / leg_m
    with mw.open_rig("simulated", seed=4) as rig:
        run = control(rig, model, STEPS, known_strain=(known, 3.5))
    assert not judgement_of(run).does_not_hold
    assert run.metadata["known_strain_at_s"] == 3.5


def test_without_a_time_it_is_known_at_the_end_of_the_first_hold(model: SensingModel) -> None:
    with mw.open_rig("simulated", seed=4) as rig:
        run = control(rig, model, STEPS, known_strain=0.014)
    assert run.metadata["known_strain_at_s"] == pytest.approx(STEPS.hold_s - 0.05)
    assert run["resistance_factor"][round(STEPS.hold_s / 0.05) - 2] == 1.0
    assert run["resistance_factor"][round(STEPS.hold_s / 0.05) + 1] != 1.0
    ramp = mw.sampled_reference(np.linspace(0.0, 5.0, 101), np.linspace(0.015, 0.02, 101))
    with mw.open_rig("simulated", seed=4) as rig, pytest.raises(CallerError, match="does not begin with a hold"):
        control(rig, model, ramp, known_strain=0.0148)


def test_a_moment_at_which_the_wire_is_still_cold_is_said_to_be_unused(model: SensingModel) -> None:
    with mw.open_rig("simulated", seed=4) as rig:
        run = control(rig, model, staircase(0.015, 0.018, 0.003, 1.0), known_strain=(0.01, 0.1))
    assert any("known at 0.1 s was not compared" in said for said in run_warnings(run))


@pytest.mark.parametrize("at_s", [4.2, 4.5, 8.3])
def test_a_true_strain_of_a_wire_that_has_just_moved_is_no_finding(model: SensingModel, at_s: float) -> None:
    with mw.open_rig("simulated", seed=4) as rig:
        before, leg_m = control(rig, model, STEPS), rig.leg_length_m
    known = float(np.interp(at_s, before["time_s"] - before["time_s"][0], before["displacement_m"])) / leg_m
    with mw.open_rig("simulated", seed=4) as rig:
        run = control(rig, model, STEPS, known_strain=[known, at_s])
    assert not judgement_of(run).does_not_hold
    assert run["resistance_factor"][-1] == pytest.approx(1.0, abs=3e-3)


@pytest.mark.parametrize(
    "wrong", [(0.015, float("inf")), (1, 2, 3), "1.5 %", ("1.5 %", "3 s"), (0.015, -1.0), (0.015, 900.0), float("nan")]
)
def test_what_is_no_known_strain_is_refused_before_anything_is_heated(model: SensingModel, wrong: object) -> None:
    with (
        mw.open_rig("simulated", seed=4) as rig,
        pytest.raises(CallerError, match=r"a known strain is a number in SI|the run goes from 0 to"),
    ):
        control(rig, model, STEPS, known_strain=wrong)  # type: ignore[arg-type]
