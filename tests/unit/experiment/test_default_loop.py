"""What a loop takes that nobody has chosen: the gains that the model keeps, else the paper's controller."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from fake_rig import FakeRig, straight_model

import musclewire as mw
from musclewire.controllers import FeedforwardSettings, FuzzyPidSettings, PidSettings, staircase
from musclewire.errors import CallerError
from musclewire.experiment import LoopChoice, control, control_metrics, run_warnings
from musclewire.identify import gains_of
from musclewire.judge import judgement_of
from musclewire.sensing import KnownSpring, SensingModel
from musclewire.signals import Recording

PERIOD_S = 0.05


@pytest.fixture(scope="module")
def model() -> SensingModel:
    """A model of the simulated wire with the gains that ``fit`` finds."""
    with mw.open_rig("simulated", seed=3) as rig:
        return mw.fit(mw.characterize(rig))


def test_fit_keeps_the_gains_that_tune_finds() -> None:
    with mw.open_rig("simulated", seed=3) as rig:
        loop = mw.characterize(rig)
    model = mw.fit(loop)
    gains = gains_of(model, PERIOD_S)
    assert gains is not None
    assert (gains.controller, gains.settings) == ("inverse-model", mw.tune(model, loop).settings)


def test_nobody_has_to_choose_and_the_wire_follows_from_cold(model: SensingModel) -> None:
    with mw.open_rig("simulated", seed=4) as rig:
        run = control(rig, model)
    assert (run.metadata["controller"], run.metadata["approach_s"]) == ("inverse-model", 0.0)
    assert run.metrics.start == pytest.approx(0.0, abs=1e-3)  # cold
    assert run.metrics.mae_max_pct is not None
    assert run.metrics.mae_max_pct <= 2.62  # the paper's largest, after an approach
    # What was not sensed yet, below B, counts neither against the run nor as a finding.
    assert run.metrics.valid_share == 1.0
    assert "health" not in run.metadata
    assert not [said for said in run_warnings(run) if " B " in said]


def test_a_resistance_that_has_changed_by_a_hundredth_is_named_as_soon_as_b_is_passed(model: SensingModel) -> None:
    other = replace(
        model, resistance_min_ohm=model.resistance_min_ohm / 1.01, resistance_max_ohm=model.resistance_max_ohm / 1.01
    )
    with mw.open_rig("simulated", seed=4) as rig:
        run = control(rig, other, staircase(0.015, 0.018, 0.003, 2.0))
    (found,) = [one for one in judgement_of(run).findings if one.key == "other_height_of_b"]
    assert found.from_s < 1.0
    assert judgement_of(run).does_not_hold
    assert "changed load or resistance" in str(run.metadata["health"])
    assert "without_gains" not in run.metadata
    assert run.metadata["zero_from"] == "kept"
    assert "resistance_factor" not in run


def test_from_todays_zero_a_resistance_that_has_changed_by_a_hundredth_is_scaled_and_the_run_says_so(
    model: SensingModel,
) -> None:
    other = replace(
        model, resistance_min_ohm=model.resistance_min_ohm / 1.01, resistance_max_ohm=model.resistance_max_ohm / 1.01
    )
    steps = staircase(0.015, 0.018, 0.003, 2.0)
    errors_pct = {}
    for zero_from in ("kept", "today"):
        with mw.open_rig("simulated", seed=4) as rig:
            run = control(rig, other, steps, zero_from=zero_from)
        errors_pct[zero_from] = run.metrics.estimate_rms_pct
    assert run.metadata["zero_from"] == "today"
    assert run["resistance_factor"][0] == 1.0
    assert run["resistance_factor"][-1] == pytest.approx(1.0 / 1.01, abs=5e-4)
    assert "the resistance is scaled by it" in str(run.metadata["health"])
    assert judgement_of(run).does_not_hold.startswith("changed load or resistance")
    assert errors_pct["kept"] > 5.0
    assert errors_pct["today"] < 1.0


def test_from_todays_zero_a_scaled_resistance_is_all_that_is_named(model: SensingModel) -> None:
    other = replace(
        model, resistance_min_ohm=model.resistance_min_ohm / 1.01, resistance_max_ohm=model.resistance_max_ohm / 1.01
    )
    with mw.open_rig("simulated", seed=4) as rig:
        run = control(rig, other, staircase(0.015, 0.018, 0.003, 2.0), zero_from="today")
    assert judgement_of(run).does_not_hold == "changed load or resistance"


def test_a_zero_that_there_is_not_is_refused_with_the_nearest(model: SensingModel) -> None:
    with mw.open_rig("simulated", seed=4) as rig, pytest.raises(CallerError, match="did you mean 'today'"):
        control(rig, model, zero_from="to-day")


@pytest.mark.parametrize(
    ("chosen", "controller", "kind", "approach_s"),
    [
        ({}, "inverse-model", FeedforwardSettings, 0.0),
        ({"approach_s": 3.0}, "inverse-model", FeedforwardSettings, 3.0),
        ({"controller": "inverse-model"}, "inverse-model", FeedforwardSettings, 0.0),
        ({"controller": "fuzzy-pid"}, "fuzzy-pid", type(None), 12.0),
        ({"settings": FuzzyPidSettings()}, "fuzzy-pid", FuzzyPidSettings, 12.0),
        ({"settings": PidSettings()}, "pid", PidSettings, 12.0),
        ({"load": KnownSpring(500.0)}, "fuzzy-pid", type(None), 12.0),
    ],
)
def test_what_the_caller_leaves_open_follows_from_the_gains(
    model: SensingModel, chosen: dict[str, Any], controller: str, kind: type, approach_s: float
) -> None:
    settled = LoopChoice(**chosen).settled(model, PERIOD_S)
    assert (settled.controller, type(settled.settings), settled.approach_s) == (controller, kind, approach_s)
    assert settled.without_gains == ""


def test_a_model_of_force_keeps_the_fuzzy_pid(model: SensingModel) -> None:
    assert LoopChoice().settled(replace(model, quantity="force"), PERIOD_S).controller == "fuzzy-pid"


def test_settings_that_do_not_say_whose_they_are_are_refused(model: SensingModel) -> None:
    with pytest.raises(CallerError, match="name the controller"):
        LoopChoice(settings={"kp": 1.0}).settled(model, PERIOD_S)


def test_a_model_without_gains_is_driven_as_before_and_the_run_says_how_to_get_the_better_loop() -> None:
    run = control(FakeRig(), replace(straight_model(), no_gains="this recording has no power"))
    assert (run.metadata["controller"], run.metadata["approach_s"]) == ("fuzzy-pid", 12.0)
    said = [text for text in run_warnings(run) if "musclewire tune" in text]
    assert len(said) == 1
    assert "(this recording has no power)" in said[0]


def test_who_chose_the_fuzzy_pid_is_told_nothing() -> None:
    run = control(FakeRig(), straight_model(), controller="fuzzy-pid")
    assert not any("musclewire tune" in text for text in run_warnings(run))


def test_samples_further_apart_than_in_the_slow_loop_make_the_loop_slower_and_nearer_ones_change_nothing(
    model: SensingModel,
) -> None:
    def settings_at(period_s: float) -> FeedforwardSettings:
        gains = gains_of(model, period_s)
        assert gains is not None
        assert isinstance(gains.settings, FeedforwardSettings)
        return gains.settings

    own, faster, slower = (settings_at(period_s) for period_s in (PERIOD_S, 0.01, 0.2))
    assert faster == own
    assert slower.dead_time_s == pytest.approx(4.0 * own.dead_time_s)
    assert slower.closed_loop_time_s >= slower.dead_time_s
    assert slower.integral_time_s >= own.integral_time_s
    assert slower.heating_power_w == own.heating_power_w


@pytest.mark.parametrize("period_s", [0.1, 0.2])
def test_a_loop_that_samples_more_slowly_than_the_slow_loop_comes_to_rest(model: SensingModel, period_s: float) -> None:
    with mw.open_rig("simulated", seed=5, sample_period_s=period_s) as rig:
        run = control(rig, model)
    in_step_s = (run["time_s"] - run["time_s"][0]) % 6.0
    resting = run["drive_voltage_v"][(in_step_s > 4.0) & (in_step_s < 5.5)]
    each = np.array_split(resting, 11)
    assert max(np.ptp(one) for one in each) < 0.5


def from_cold(valid_from: int) -> Recording:
    """A loop that cannot sense before a sample, its drive at its limit as announced, and is on target later."""
    n = 600
    sensed = np.arange(n) >= valid_from
    columns = {
        "time_s": PERIOD_S * np.arange(1, n + 1),
        "drive_voltage_v": np.where(sensed, 2.0, 3.6),
        "target_strain": np.full(n, 0.02),
        "estimated_strain": np.where(sensed, 0.02, 0.006),
        "valid": sensed.astype(float),
        "announced_miss": np.where(sensed, 0.0, -0.014),
        "wire_resistance_ohm": np.linspace(17.0, 16.0, n),
    }
    return Recording(columns, {"approach_s": 0.0, "sample_period_s": PERIOD_S, "limit_maximum_voltage_v": 3.6})


def test_what_comes_before_b_is_no_finding_and_does_not_count_against_what_was_sensed() -> None:
    run = from_cold(200)
    assert judgement_of(run).findings == ()
    assert control_metrics(run, "strain", staircase()).valid_share == 1.0


def test_a_drive_at_its_limit_that_never_comes_to_b_is_found() -> None:
    run = from_cold(600)
    assert "saturation" in [one.key for one in judgement_of(run).findings]
    assert control_metrics(run, "strain", staircase()).valid_share == 0.0


def test_the_errors_begin_with_mean_and_largest_and_the_papers_stand_beside(model: SensingModel) -> None:
    with mw.open_rig("simulated", seed=4) as rig:
        lines = str(control(rig, model).metrics).splitlines()
    assert lines[0].startswith("mean ")
    assert ", largest " in lines[0]
    assert lines[0].endswith(", begun at 0.00 %")
    assert lines[1].startswith("the paper's wire: mean 1.19 %, largest 2.62 %")


def test_a_run_that_never_sensed_says_so_before_any_number() -> None:
    said = str(control_metrics(from_cold(600), "strain", staircase()))
    assert said == "no estimate was ever valid: the strain was never sensed, and the loop never closed"


def test_a_wire_that_the_air_cools_at_the_largest_power_is_named_so(model: SensingModel) -> None:
    """The protection, which counts with the model's air, gives the sense voltage for most of what is asked for."""
    blown_on = mw.RigConfiguration(maximum_voltage="6.5 V", settings={"convection_factor": 2.0})
    with mw.open_rig(blown_on, seed=5) as rig:
        run = control(rig, model)
    health = str(run.metadata["health"])
    assert "saturation" in health
    assert ": the protection" in health
    assert "hotter than 200 C" in str(run.metadata["held_back"])
    assert "saturation" in judgement_of(run).does_not_hold
