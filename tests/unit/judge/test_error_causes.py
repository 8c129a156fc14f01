"""Where the errors of an estimate are, and what causes them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.other_estimators import DriftingEstimator

from musclewire.arrays import FloatArray
from musclewire.experiment import characterize
from musclewire.identify import estimate, fit
from musclewire.judge import JudgedEstimate, JudgedRecording
from musclewire.rigs import open_rig
from musclewire.sensing import SensingModel, evaluate
from musclewire.signals import Reason, Recording

# Strain from 0 to 4 % over normalised resistance; the branches are 0.4 % apart.
MODEL = SensingModel(
    resistance_min_ohm=15.0,
    resistance_max_ohm=17.0,
    heating_coefficients=(0.042, -0.04),
    cooling_coefficients=(0.038, -0.04),
    normalised_min=0.0,
    normalised_max=0.9,
)
ONCE = np.linspace(0.9, 0.0, 400)
LOOP = np.concatenate([ONCE, ONCE[::-1]])


def judged(measured: FloatArray, normalised: FloatArray = LOOP, valid: FloatArray | None = None) -> JudgedEstimate:
    resistance = 15.0 + 2.0 * normalised
    columns = {"time_s": 0.05 * np.arange(measured.size), "drive_voltage_v": np.linspace(1.0, 3.0, measured.size)}
    counted = np.ones(measured.size, dtype=np.bool_) if valid is None else valid > 0.0
    return JudgedEstimate(MODEL, Recording(columns), resistance, MODEL.estimate(resistance).value, measured, counted)


def on_branches(normalised: FloatArray = LOOP) -> FloatArray:
    """Return the strain of a wire that is on the heating branch first, then on the cooling one."""
    half = normalised.size // 2
    branches = (MODEL.heating_coefficients, MODEL.cooling_coefficients)
    return np.concatenate(
        [evaluate(one, part) for one, part in zip(branches, (normalised[:half], normalised[half:]), strict=True)]
    )


def test_a_wire_on_its_branches_is_off_by_half_their_gap() -> None:
    (group,) = judged(on_branches()).groups
    assert group.cause == "gap of the branches"
    assert group.fraction == group.squared_error_fraction == 1.0
    assert group.rms_without_pct is None
    assert abs(group.explained) == pytest.approx(0.002)


def test_the_largest_error_is_named_with_time_branch_and_voltage() -> None:
    measured = on_branches()
    normalised = LOOP.copy()
    normalised[300:400] = 0.0
    measured[300:400] = 0.05  # the branches end at 3.8 and 4.2 %
    groups = judged(measured, normalised).groups
    assert [group.cause for group in groups] == ["beyond the model", "gap of the branches"]
    hot = groups[0]
    assert hot.fraction == pytest.approx(0.125)
    assert hot.time_s == pytest.approx(300 * 0.05)
    assert hot.branch == "heating"
    assert hot.voltage_v == pytest.approx(1.0 + 2.0 * 300 / 799)
    assert hot.rms_without_pct == pytest.approx(100 * 0.002 / 0.036)
    line = hot.in_words("strain")
    assert "beyond the hot end of the model (12.5 % of the counted samples; without them 5.556 % rms)" in line
    assert "largest at 15.0 s, heating, 1.75 V: 4 % estimated, 5 % measured, -0.8 % by this" in line


def test_a_wire_colder_than_the_model_begins_does_not_count_and_is_told() -> None:
    measured = on_branches()
    measured[:100] = 0.0  # the mean begins at 0.4 %
    report = report_of({"reference_strain": measured})
    told = {why: fraction for why, fraction in report.not_counted.items() if why.startswith("colder than the model")}
    there = (report.columns["valid"] > 0.0) & (measured < MODEL.quantity_min)
    assert told == {"colder than the model begins, which the estimator did not notice": pytest.approx(there.mean())}
    assert there.sum() > 20
    assert report.max_pct == pytest.approx(100 * 0.002 / 0.036, rel=1e-3)


def test_noise_of_single_readings_is_told_from_an_offset() -> None:
    normalised = LOOP.copy()
    normalised[1:-1:2] += 0.03
    normalised[2:-1:2] -= 0.03
    exact = MODEL.estimate(15.0 + 2.0 * LOOP).value
    noisy = judged(exact, normalised).groups
    assert noisy[0].cause == "noise"
    (shifted,) = judged(exact - 0.01).groups
    assert shifted.cause == "another relation"


def test_a_small_noise_is_not_the_cause_of_an_estimate_that_jumps() -> None:
    jumping = judged(on_branches())
    jumping = replace(jumping, estimated=jumping.estimated + np.where(np.arange(LOOP.size) % 2, 0.01, -0.01))
    assert {group.cause for group in jumping.groups} == {"estimator"}


# What estimators do wrong, and what makes it.
WRONG: dict[str, tuple[Callable[[FloatArray], FloatArray], set[str]]] = {
    "2 % of strain too high": (lambda value: value + 0.02, {"estimator"}),
    "a scale": (lambda value: 1.3 * value, {"estimator"}),
    "nothing": (lambda value: value, set()),
    "one value": (lambda value: 0.0 * value + 0.03, {"estimator"}),
}


@pytest.fixture(scope="module")
def recorded() -> tuple[SensingModel, Recording]:
    with open_rig("simulated") as rig:
        loop = characterize(rig)
    return fit(loop), loop


@pytest.mark.parametrize("estimator", [None, "polynomial", DriftingEstimator], ids=["default", "polynomial", "own"])
@pytest.mark.parametrize("wrong", WRONG)
def test_a_cause_is_named_only_if_it_makes_most_of_the_error_that_it_is_named_for(
    estimator: Any, wrong: str, recorded: tuple[SensingModel, Recording]
) -> None:
    model, loop = recorded
    found = estimate(model, loop, estimator=estimator)
    change, causes = WRONG[wrong]
    value, valid = change(found.columns["estimated_strain"]), found.columns["valid"] > 0.0
    measured = loop["displacement_m"] / float(loop.metadata["leg_length_m"])
    resistance_ohm = loop["wire_voltage_v"] / loop["shunt_voltage_v"] * float(loop.metadata["shunt_resistance_ohm"])
    groups = JudgedEstimate(model, loop, resistance_ohm, value, measured, valid).groups
    for group in groups:
        error = group.estimated - group.measured
        assert abs(error - group.explained) <= 0.5 * abs(error)
        assert group.largest_pct == pytest.approx(100.0 * error / model.stroke)
    assert sum(group.fraction for group in groups) == pytest.approx(1.0)
    assert not causes or groups[0].cause in causes


def test_samples_that_do_not_count_are_told_by_their_reason() -> None:
    reasons = [Reason.OK, Reason.COLD, Reason.COLD, Reason.NO_CURRENT, Reason.OK]
    marked = Recording({"time_s": np.arange(5.0), "wire_resistance_ohm": np.array([17.0, 17.1, 17.2, 17.3, 9.9e37])})
    valid = np.array([True, False, False, False, False])
    fractions = JudgedRecording(marked).not_counted(reasons, valid, valid)
    assert list(fractions.items()) == [
        ("colder than B", 0.4),
        ("without current", 0.2),
        ("that are no measurements", 0.2),
    ]


def report_of(columns: dict[str, FloatArray]) -> Any:
    resistance = 15.0 + 2.0 * LOOP
    time_s = 0.05 * np.arange(LOOP.size)
    return estimate(MODEL, Recording({"time_s": time_s, "wire_resistance_ohm": resistance, **columns}))


def test_the_plot_of_an_estimate_has_the_estimate_its_deviation_and_the_reference() -> None:
    report = report_of({"reference_strain": on_branches()})
    over_time, over_resistance = report.plot().axes
    assert over_time.get_xlabel() == "time [s]"
    assert over_resistance.get_xlabel() == "resistance [ohm]"
    drawn = {line.get_label(): line.get_ydata() for line in over_time.lines}
    counted = report.columns["valid"] > 0.0
    assert np.allclose(drawn["estimate"][counted], 100 * report.columns["estimated_strain"][counted])
    assert np.allclose(drawn["reference"], 100 * on_branches())
    band = over_time.collections[0].get_datalim(over_time.transData)
    assert band.height > np.ptp(100 * report.columns["estimated_strain"][counted])
    assert len(over_resistance.lines) == 2


def test_without_a_reference_the_plot_has_the_estimate_alone() -> None:
    report = report_of({})
    assert [line.get_label() for line in report.plot().axes[0].lines][-1] == "estimate"
    assert report.error_groups == ()
    assert "nothing to compare with" in report.summary()
