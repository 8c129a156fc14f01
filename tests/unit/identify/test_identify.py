from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from musclewire.errors import CallerError, RecordingError
from musclewire.experiment import characterize, pretension_sweep
from musclewire.identify import estimate, fit, loop_gaps
from musclewire.judge import resistance_reading
from musclewire.rigs import RigConfiguration, open_rig
from musclewire.sensing import SensingModel
from musclewire.signals import COLUMN_SUFFIX, Recording, reference_quantity


def test_strain_is_displacement_over_one_leg(loop: Recording) -> None:
    strain = reference_quantity(loop, "strain")
    assert strain is not None
    assert np.allclose(strain, loop["displacement_m"] / 0.07)


@pytest.mark.parametrize("quantity", ["strain", "displacement", "force"])
def test_a_valid_estimate_has_a_deviation_in_the_unit_of_its_quantity(loop: Recording, quantity: str) -> None:
    model = fit(loop, quantity=quantity)
    found = estimate(model, loop).recording
    std = found["estimate_std"][found["valid"] > 0.0]
    assert np.isfinite(std).all()
    assert np.all((std > 0.001 * model.stroke) & (std < model.stroke))


def test_contraction_force_is_total_force_less_pretension(loop: Recording) -> None:
    force = reference_quantity(loop, "force")
    assert force is not None
    assert np.allclose(force, loop["force_n"] - 1.9)


def test_voltage_over_current_is_the_same_resistance_as_equation_1(loop: Recording) -> None:
    current = loop["shunt_voltage_v"] / 1.0
    columns = {"time_s": loop["time_s"], "wire_voltage_v": loop["wire_voltage_v"], "wire_current_a": current}
    by_current = resistance_reading(Recording(columns, {}))
    by_shunt = resistance_reading(loop)
    assert np.allclose(by_current.resistance_ohm, by_shunt.resistance_ohm)


@pytest.mark.parametrize("quantity", ["strain", "displacement", "force"])
def test_every_quantity_can_be_sensed(loop: Recording, quantity: str) -> None:
    """Where the wire is between B and C, as the reference shows: 0.9 % of stroke, and 3.8 % of force."""
    model = fit(loop, quantity=quantity)
    assert model.quantity == quantity
    report = estimate(model, loop)
    assert 0.3 < report.valid_share <= 1.0
    measured = reference_quantity(loop, quantity)
    assert measured is not None
    of_recording = report.recording
    estimated = of_recording[f"estimated_{COLUMN_SUFFIX[model.quantity]}"]
    within = (of_recording["valid"] > 0.0) & (measured >= model.quantity_min)
    off_pct = 100.0 * (estimated - measured)[within] / (model.quantity_max - model.quantity_min)
    # Of stroke; the force loop is the wider one (Fig. 6b).
    most_pct = 6.0 if quantity == "force" else 2.0
    assert np.sqrt(np.mean(off_pct**2)) < most_pct
    # Past B on cooling the resistance falls by a few hundredths of an ohm only, which a whole recording can date.
    assert report.rms_pct is not None
    assert report.rms_pct < most_pct


def test_a_recording_without_a_length_or_an_instrument_says_what_would_give_a_reference(loop: Recording) -> None:
    unknown = {name: value for name, value in loop.metadata.items() if name not in ("leg_length_m", "wire_length_m")}
    electrical = {name: loop[name] for name in ("time_s", "drive_voltage_v", "wire_voltage_v", "shunt_voltage_v")}
    for recording, said in (
        (Recording(loop.columns, unknown), "leg_length_m"),
        (Recording(electrical, loop.metadata), "reference_strain or displacement_m"),
    ):
        report = estimate(fit(loop), recording)
        assert report.rms_pct is None
        assert said in report.no_reference
    assert estimate(fit(loop), loop).no_reference == ""


def test_the_force_gap_differs_from_the_strain_gap_because_the_guide_rubs(loop: Recording) -> None:
    gaps = loop_gaps(loop)
    assert gaps.force_gap is not None
    assert abs(gaps.force_gap - gaps.strain_gap) > 0.002
    assert gaps.displacement_gap == pytest.approx(gaps.strain_gap, rel=1e-9)


def with_force(loop: Recording, stiffness_n_per_m: float, friction_n: float) -> Recording:
    """The loop with the force of a given spring and of a guide that rubs from its first micrometre on."""
    moved = loop["displacement_m"]
    noise = np.random.default_rng(1).normal(0.0, 2e-3, moved.size)
    heats = np.arange(moved.size) % 1800 < 900
    return loop.with_columns(force_n=1.9 + stiffness_n_per_m * moved + friction_n * np.where(heats, 1.0, -1.0) + noise)


@pytest.mark.parametrize("friction_n", [0.0, 0.02, 0.15, 1.0])
def test_a_force_that_does_not_rise_with_the_contraction_has_no_gap(loop: Recording, friction_n: float) -> None:
    gaps = loop_gaps(with_force(loop, 0.0, friction_n))
    assert gaps.force_gap is None
    assert gaps.no_force_gap.startswith("the force does not rise with the contraction")
    assert gaps.strain_gap == loop_gaps(loop).strain_gap


@pytest.mark.parametrize("friction_n", [0.0, 0.02, 0.15])
def test_a_soft_spring_is_a_spring_though_the_guide_rubs(loop: Recording, friction_n: float) -> None:
    gaps = loop_gaps(with_force(loop, 20.0, friction_n))
    assert gaps.force_gap is not None
    assert gaps.no_force_gap == ""


def test_a_recording_without_load_cell_says_why_it_has_no_gap_of_force(loop: Recording) -> None:
    columns = {name: loop[name] for name in loop.names if name != "force_n"}
    gaps = loop_gaps(Recording(columns, loop.metadata))
    assert (gaps.force_gap, gaps.no_force_gap) == (None, "no load cell")


def test_a_rig_without_a_spring_has_a_gap_of_strain_only_and_a_sweep_for_that_of_force_says_so() -> None:
    for friction_n in (0.0, 0.05, 0.3):
        with open_rig(bench="dead-weight", guide_friction_n=friction_n) as rig:
            gaps = loop_gaps(characterize(rig, cycles=1))
        assert gaps.force_gap is None
        assert gaps.strain_gap > 0.0
    with open_rig(bench="dead-weight") as rig, pytest.raises(RecordingError, match="as under a weight: sweep for an"):
        pretension_sweep(rig, [1.4], quantity="force", cycles=1)


def test_a_model_remembers_its_wire(loop: Recording) -> None:
    assert fit(loop).wire["wire"] == "paper-100um"
    assert fit(loop).wire["pretension_n"] == 1.9


def test_readings_of_another_wire_in_a_recording_are_named(loop: Recording) -> None:
    model = fit(loop)
    assert estimate(model, loop).warnings == ()
    voltage_v = loop["wire_voltage_v"].copy()
    voltage_v[: len(loop) // 10] *= 2.0
    (said,) = estimate(model, loop.with_columns(wire_voltage_v=voltage_v)).warnings
    assert said.startswith("10.0 % of the readings")
    assert "check that it is the same wire" in said


def test_a_wire_held_at_both_ends_is_said_to_have_no_loop_to_fit() -> None:
    with open_rig(RigConfiguration(load=[{"part": "blocked"}])) as rig:  # type: ignore[list-item]
        held = characterize(rig, cycles=1, period_s=30.0)
    for ask in (lambda: loop_gaps(held), lambda: fit(held), lambda: fit(held, quantity="force")):
        with pytest.raises(RecordingError, match=r"^no loop: the part 'blocked' holds the wire.*nothing to fit$"):
            ask()


def test_a_held_wires_soft_mount_lets_it_move_and_is_fitted_like_a_spring() -> None:
    with open_rig(RigConfiguration(load=[{"part": "blocked", "mount_stiffness": 588.6}])) as rig:  # type: ignore[list-item]
        assert fit(characterize(rig, cycles=1)).quantity_max > 0.03


def test_arrays_in_and_arrays_out(loop: Recording) -> None:
    resistance_ohm = resistance_reading(loop).resistance_ohm
    strain = np.asarray(reference_quantity(loop)).copy()
    strain[7] = np.nan
    model = fit(resistance_ohm, strain)
    assert np.array_equal(model.strain(np.array([16.0, 15.5])), fit(loop).strain(np.array([16.0, 15.5])))
    assert "two arrays show no power" in model.no_gains


@pytest.mark.parametrize("kept", [("wire_voltage_v", "shunt_voltage_v"), ("wire_voltage_v", "a"), ("r", "a")])
def test_the_filter_runs_on_what_other_programs_record(loop: Recording, kept: tuple[str, ...]) -> None:
    """Without the drive, with a current in the place of a shunt, with an ohmmeter in the place of a voltmeter."""
    wire_v, shunt_v = loop["wire_voltage_v"], loop["shunt_voltage_v"]
    offered = {"wire_voltage_v": wire_v, "shunt_voltage_v": shunt_v, "a": shunt_v, "r": wire_v / shunt_v}
    names = {"a": "wire_current_a", "r": "wire_resistance_ohm"}
    columns = {names.get(name, name): offered[name] for name in kept}
    facts = {"leg_length_m": loop.facts.leg_length_m} | (
        {"shunt_resistance_ohm": 1.0} if "shunt_voltage_v" in kept else {}
    )
    theirs = Recording({"time_s": loop["time_s"], "displacement_m": loop["displacement_m"], **columns}, facts)
    model = fit(loop)
    ours, found = (estimate(model, one, estimator="filter") for one in (loop, theirs))
    assert found.rms_pct == pytest.approx(ours.rms_pct, rel=1e-6)


def test_resistance_and_current_without_a_voltage_show_the_same_loop(loop: Recording) -> None:
    current_a = loop["shunt_voltage_v"] / float(loop.metadata["shunt_resistance_ohm"])
    kept = {name: loop[name] for name in ("time_s", "displacement_m", "cycle")}
    columns = {**kept, "wire_current_a": current_a, "wire_resistance_ohm": loop["wire_voltage_v"] / current_a}
    alone, whole = fit(Recording(columns, loop.metadata)), fit(loop)
    np.testing.assert_allclose(alone.slow_loop, whole.slow_loop, rtol=1e-6)


# What is asked of a loop and its model, and what is said of it.
REFUSED: list[tuple[Callable[[Recording, SensingModel], object], type[Exception], str]] = [
    (lambda _, __: fit(np.ones(3)), CallerError, "two arrays, not a ndarray alone"),
    (lambda _, __: fit("loop.csv"), CallerError, "read_recording opens a file"),
    (lambda _, __: fit(np.ones(3), np.ones(4)), CallerError, r"has the shape \(3,\) and the measured strain \(4,\)"),
    (lambda loop, _: fit(loop, np.ones(3)), CallerError, "give fit the recording alone"),
    (lambda loop, model: estimate(loop, model), CallerError, "a model and a recording, in this order, not a Sens"),
    (lambda loop, model: estimate(model, of_another_wire(loop)), RecordingError, r"is it the same wire\?"),
    (
        lambda loop, model: estimate(model, resistance_alone(loop), estimator="filter"),
        RecordingError,
        "add the column wire_current_a or wire_voltage_v, or choose",
    ),
]


def of_another_wire(loop: Recording) -> Recording:
    return loop.with_columns(wire_voltage_v=3.0 * loop["wire_voltage_v"])


def resistance_alone(loop: Recording) -> Recording:
    resistance_ohm = resistance_reading(loop).resistance_ohm
    return Recording({"time_s": loop["time_s"], "wire_resistance_ohm": resistance_ohm}, {})


@pytest.mark.parametrize(("ask", "error", "said"), REFUSED, ids=[said for *_, said in REFUSED])
def test_what_cannot_be_fitted_or_estimated_is_said(
    loop: Recording, ask: Callable[[Recording, SensingModel], object], error: type[Exception], said: str
) -> None:
    model = fit(loop)
    with pytest.raises(error, match=said):
        ask(loop, model)
