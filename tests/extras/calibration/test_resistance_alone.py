"""A model from resistance alone: what it takes from the prior, from the resistance and from marks, and what it says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import musclewire as mw
from musclewire.errors import CallerError, FitRejectedError, RecordingError
from musclewire.experiment import characterize
from musclewire.extras.calibration import priors_around
from musclewire.identify import estimate, fit
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.rigs import GuardedRig, SimulatedDevice, SimulatedSpool
from musclewire.sensing import load_model
from musclewire.signals import Recording

pytestmark = pytest.mark.slow

NAME = "paper-100um"
# The strain of this spool is a tenth above that of its name: one and a half standard deviations of the prior.
FACTOR = 1.1


@pytest.fixture(scope="module")
def loop() -> Recording:
    """One slow sine of a spool that differs from its name, with a displacement sensor to judge by."""
    wire = load_wire(NAME)
    alloy, shift = load_alloy(wire.alloy), wire.temperature_shift_k
    strains = {name: getattr(alloy, name) for name in ("strain_at_no_stress", "strain_saturated")}
    spool = SimulatedSpool(
        wire.model_copy(update={"temperature_shift_k": shift.model_copy(update={"value": shift.value - 5.0})}),
        alloy.model_copy(
            update={name: item.model_copy(update={"value": FACTOR * item.value}) for name, item in strains.items()}
        ),
        load_bench("paper"),
    )
    with GuardedRig(SimulatedDevice(spool, seed=3)) as rig:
        return characterize(rig, cycles=1)


@pytest.fixture(scope="module")
def by_name(loop: Recording) -> Any:
    return mw.fit_resistance(loop, NAME)


@pytest.fixture(scope="module")
def by_marks(loop: Recording) -> Any:
    stroke_m = float(loop["displacement_m"].max())
    return mw.fit_resistance(loop, NAME, marks=mw.Marks(cold_m=2e-3, hot_m=2e-3 + stroke_m, reading_std_m=0.01e-3))


def true_stroke(loop: Recording) -> float:
    return float(loop["displacement_m"].max() / loop.metadata["leg_length_m"])


def test_the_true_stroke_lies_within_two_stated_deviations(loop: Recording, by_name: Any, by_marks: Any) -> None:
    for found in (by_name, by_marks):
        assert abs(found.stroke - true_stroke(loop)) < 2.0 * found.stroke_std


def test_marks_bring_the_stroke_to_their_own_error(loop: Recording, by_name: Any, by_marks: Any) -> None:
    """A dial gauge reads 0.5 % of this stroke; the length adds 0.7 %."""
    assert by_marks.stroke == pytest.approx(true_stroke(loop), rel=0.02)
    assert by_marks.stroke_std < 0.3 * by_name.stroke_std


def test_both_branches_are_those_of_the_wire(loop: Recording, by_marks: Any) -> None:
    measured = fit(loop)
    low, high = measured.valid_resistance_ohm
    ohm = np.linspace(max(low, by_marks.model.valid_resistance_ohm[0]), high, 50)
    for branch in ("strain_heating", "strain_cooling"):
        off = getattr(by_marks.model, branch)(ohm) - getattr(measured, branch)(ohm)
        assert np.sqrt(np.mean(off**2)) < 0.02 * true_stroke(loop)


def test_r_max_and_r_min_are_the_measured_ones(loop: Recording, by_name: Any) -> None:
    measured = fit(loop)
    assert by_name.model.resistance_min_ohm == pytest.approx(measured.resistance_min_ohm, abs=0.01)
    assert by_name.model.resistance_max_ohm == pytest.approx(measured.resistance_max_ohm, abs=0.02)
    assert by_name.model.resistance_noise_ohm == pytest.approx(measured.resistance_noise_ohm, rel=1e-9)


def test_an_instrument_in_the_recording_does_not_enter(loop: Recording, by_name: Any) -> None:
    wrong = loop.with_columns(displacement_m=-3.0 * loop["displacement_m"], force_n=0.0 * loop["force_n"])
    assert mw.fit_resistance(wrong, NAME).model.heating_coefficients == by_name.model.heating_coefficients


def test_a_ruler_too_coarse_changes_nothing_and_says_so(loop: Recording, by_name: Any) -> None:
    found = mw.fit_resistance(loop, NAME, marks=mw.Marks(cold_m=0.0, hot_m=4e-3, reading_std_m=1e-3))
    assert found.model.heating_coefficients == by_name.model.heating_coefficients
    assert found.stroke_std == by_name.stroke_std
    assert any("the marks are left out" in text for text in found.model.warnings)


def test_what_would_help_says_by_how_much(by_name: Any, by_marks: Any) -> None:
    """The prediction for a dial gauge is made before the marks are read; the length's part it leaves out."""
    gauge = next(item for item in by_name.helps if "dial gauge" in item.what)
    now = by_name.stroke_std / by_name.stroke
    assert gauge.stroke_std < by_marks.stroke_std / by_marks.stroke < 0.3 * now
    assert [item.stroke_std for item in by_name.helps] == sorted(item.stroke_std for item in by_name.helps)
    assert by_marks.costs[0].name == "wire_length_m"
    assert by_marks.costs[0].stroke_std == pytest.approx(by_marks.costs[0].relative_std, rel=0.3)


def test_every_estimate_carries_the_uncertainty_of_the_whole(loop: Recording, by_name: Any, tmp_path: Path) -> None:
    by_name.model.save(tmp_path / "m.json")
    again = load_model(tmp_path / "m.json")
    assert again == by_name.model
    hottest = again.estimate(again.resistance_min_ohm + 0.01)
    assert hottest.std >= again.scale_std * hottest.value > 0.02 * hottest.value
    report = estimate(again, loop)
    assert report.rms_pct is not None
    assert report.rms_pct < 15.0


def test_another_wire_is_refused(loop: Recording) -> None:
    other = loop.with_columns(wire_voltage_v=1.6 * loop["wire_voltage_v"])
    with pytest.raises((FitRejectedError, RecordingError), match=r"is not that of paper-100um|resistivity"):
        mw.fit_resistance(other, NAME)


def test_force_and_a_recording_without_a_length_are_refused_with_what_is_needed(loop: Recording) -> None:
    with pytest.raises(CallerError, match="known stiffness"):
        mw.fit_resistance(loop, NAME, quantity="force")
    unknown = {name: value for name, value in loop.metadata.items() if "length" not in name}
    with pytest.raises(CallerError, match="length is not known"):
        mw.fit_resistance(Recording(loop.columns, unknown), NAME)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"cold_m": 0.0}, "give both"),
        ({"cold_m": 5e-3, "hot_m": 0.0}, "further along"),
        ({"end_stop_m": -1e-3}, "must be beyond"),
        ({"reading_std_m": 0.0}, "no ruler is exact"),
        ({"leg_length_std_m": float("nan")}, "no ruler is exact"),
    ],
)
def test_impossible_marks_are_refused(given: dict[str, float], words: str) -> None:
    with pytest.raises(CallerError, match=words):
        mw.Marks(**given)


def test_the_prior_is_the_named_wire_with_the_spreads_of_a_spool() -> None:
    wire, bench = load_wire(NAME), load_bench("paper")
    alloy = load_alloy(wire.alloy)
    found = priors_around(alloy, wire, bench).parameters
    assert found["temperature_shift_k"].std == 5.0
    assert found["resistivity_factor"].std == pytest.approx(0.03)
    assert found["convection_factor"].std == pytest.approx(0.1 * wire.convection_factor.value)
    for name, prior in found.items():
        assert prior.mean == {"alloy": alloy, "wire": wire, "bench": bench}[prior.group][name]
