"""The particle filter: what has changed is found and told apart, on a wire that is the one of its file."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from musclewire.errors import CallerError
from musclewire.identify import fit
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.sensing import ESTIMATORS, Correction, EstimatorSetup, HomeMove, SensingModel, state_going_on
from musclewire.signals import Reason, Recording, WireSample
from musclewire.wire import CHOSEN, OneWire, constants_from, drive_path

PERIOD_S = 0.05
WIRE = constants_from(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"))
CHANGE_S = 15.0
STROKE = 0.038


@cache
def fitted() -> SensingModel:
    """The model of this wire, from a slow loop without noise; when a test first asks for it, because it compiles."""
    time_s = PERIOD_S * np.arange(1, 3601)
    drive_v = 0.3 + 1.45 * (1.0 - np.cos(2.0 * np.pi * time_s / 90.0))
    path, _ = drive_path(WIRE, drive_v, sample_s=PERIOD_S)
    columns = {
        "time_s": time_s,
        "drive_voltage_v": drive_v,
        "wire_voltage_v": path.wire_voltage_v,
        "shunt_voltage_v": path.shunt_voltage_v,
        "displacement_m": path.displacement_m,
    }
    return fit(Recording(columns, {"leg_length_m": 0.07, "shunt_resistance_ohm": 1.0}))


def particle_filter(setup: EstimatorSetup) -> Any:
    return ESTIMATORS.make("particle-filter", setup)


def drive_at(time_s: float) -> float:
    """A drive that goes on moving the wire: a warm-up, then steps up and down."""
    if time_s < 8.0:
        return 0.3 + 1.4 * (1.0 - np.cos(2.0 * np.pi * time_s / 8.0))
    return (2.6, 3.1, 2.8, 2.3, 2.95)[int(time_s / 2.5) % 5]


def followed(duration_s: float = 45.0, drive_ratio: float = 1.0, **changed: float) -> dict[str, Any]:
    """Estimates and true contraction of a wire whose numbers change to these after a while."""
    wire = OneWire(WIRE)
    estimator = particle_filter(EstimatorSetup(fitted(), 1.0, PERIOD_S, wire=WIRE))
    state, rows = estimator.start(), []
    random = np.random.default_rng(5)
    for tick in range(round(duration_s / PERIOD_S)):
        time_s = PERIOD_S * tick
        if time_s >= CHANGE_S:
            for name, value in changed.items():
                wire._derived[name] = value
        drive_v = drive_at(time_s) * (drive_ratio if time_s >= CHANGE_S else 1.0)
        means = wire.advance(drive_v, PERIOD_S, CHOSEN)
        noise_v = 3.5e-5 * random.standard_normal(2)
        sample = WireSample(time_s, drive_v, means.wire_voltage_v + noise_v[0], means.shunt_voltage_v + noise_v[1])
        estimate, state, recorded = estimator.step(state, sample)
        true = wire.state.connector_contraction
        rows.append((true, estimate.value, estimate.std, float(estimate.reason), *recorded))
    columns = ("true", "value", "std", "reason", *estimator.columns)
    return dict(zip(columns, np.array(rows).T, strict=True))


def error_pct(found: dict[str, Any], from_s: float) -> float:
    """RMS error in percent of the stroke, between 5 and 95 % of it, where strain is sensed."""
    late = np.arange(found["true"].size) >= round(from_s / PERIOD_S)
    usable = late & (found["true"] > 0.05 * STROKE) & (found["true"] < 0.95 * STROKE)
    assert usable.sum() > 100
    return 100.0 * float(np.sqrt(np.mean((found["value"] - found["true"])[usable] ** 2))) / STROKE


@pytest.mark.slow
def test_nothing_changed_and_nothing_is_said_to_have_changed() -> None:
    found = followed()
    assert error_pct(found, 8.0) < 0.6
    assert found["changed_load"][-200:].mean() < 0.5
    assert found["changed_air"][-200:].mean() < 0.5
    assert set(found["reason"][200:]) <= {float(Reason.OK), float(Reason.OUT_OF_RANGE), float(Reason.COLD)}
    assert np.mean(found["reason"][200:] == Reason.OK) > 0.9


def test_a_heavier_load_is_found_as_such() -> None:
    found = followed(pretension_n=1.5 * 1.9)
    assert found["load_change_n"][-100:].mean() == pytest.approx(0.95, abs=0.3)
    assert found["changed_load"][-100:].mean() > 0.9
    assert error_pct(found, CHANGE_S + 10.0) < 1.0


def test_half_the_convection_is_found_as_such() -> None:
    # The drive that held the wire before would overheat it now.
    found = followed(drive_ratio=0.72, surface_factor_m2=0.5 * float(WIRE.derived.surface_factor_m2))
    assert found["convection_ratio"][-100:].mean() == pytest.approx(0.5, abs=0.08)
    assert found["changed_air"][-100:].mean() > 0.9
    assert error_pct(found, CHANGE_S + 10.0) < 0.8


def test_the_interval_holds_most_of_the_time() -> None:
    found = followed(pretension_n=1.5 * 1.9)
    late = slice(round(25.0 / PERIOD_S), None)
    assert np.mean(np.abs(found["value"] - found["true"])[late] < 1.96 * found["std"][late]) > 0.9


def test_a_home_move_says_what_became_of_the_resistance() -> None:
    home = HomeMove(
        "2026-11-22T12:00:00+00:00", 1, None, 1.9, None, True, 1.01, 1e-3, 0.2, 0.02, 0.0, 8.0, 1.0, 0.1, 0.01
    )
    low, high = (1.01 * ohm + 0.2 for ohm in (fitted().resistance_min_ohm, fitted().resistance_max_ohm))
    homed = replace(fitted(), resistance_min_ohm=low, resistance_max_ohm=high, home=home)
    estimators = [particle_filter(EstimatorSetup(model, 1.0, PERIOD_S, wire=WIRE)) for model in (fitted(), homed)]
    wire, states = OneWire(WIRE), [one.start() for one in estimators]
    for tick in range(240):
        drive_v = drive_at(PERIOD_S * tick)
        means = wire.advance(drive_v, PERIOD_S, CHOSEN)
        fresh = WireSample(PERIOD_S * tick, drive_v, means.wire_voltage_v, means.shunt_voltage_v)
        aged_v = (1.01 * means.wire_voltage_v / means.shunt_voltage_v + 0.2) * means.shunt_voltage_v
        samples = [fresh, fresh._replace(wire_voltage_v=aged_v)]
        steps = [one.step(state, sample) for one, state, sample in zip(estimators, states, samples, strict=True)]
        states = [step.state for step in steps]
    # The aged wire takes 2 % more power at the same current; without the correction this costs 10 % of the stroke.
    assert steps[1].estimate.value == pytest.approx(steps[0].estimate.value, abs=0.015 * STROKE)


def test_a_correction_in_the_middle_of_a_run_reaches_the_wire_file_and_keeps_what_was_followed() -> None:
    """A resistance that reads 1 % high: corrected while the wire is warm, the filter says what it would have said."""
    told = Correction(scale=1.0 / 1.01)
    as_fitted = EstimatorSetup(fitted(), 1.0, PERIOD_S, wire=WIRE)
    as_today = EstimatorSetup(told.applied_to(fitted()), 1.0, PERIOD_S, wire=WIRE, correction=told)
    sound, high = particle_filter(as_fitted), particle_filter(as_fitted)
    wire, states = OneWire(WIRE), [sound.start(), high.start()]
    for tick in range(240):
        if tick == 60:
            high = particle_filter(as_today)
            states[1] = state_going_on(high, states[1])
        drive_v = drive_at(PERIOD_S * tick)
        means = wire.advance(drive_v, PERIOD_S, CHOSEN)
        fresh = WireSample(PERIOD_S * tick, drive_v, means.wire_voltage_v, means.shunt_voltage_v)
        reads_high = fresh._replace(wire_voltage_v=1.01 * fresh.wire_voltage_v)
        steps = [sound.step(states[0], fresh), high.step(states[1], reads_high)]
        states = [step.state for step in steps]
    assert steps[1].estimate.valid
    assert steps[1].estimate.value == pytest.approx(steps[0].estimate.value, abs=0.015 * STROKE)


def test_without_a_wire_file_the_message_says_how_to_make_one() -> None:
    with pytest.raises(CallerError, match="needs a wire file: musclewire calibrate makes one"):
        particle_filter(EstimatorSetup(fitted(), 1.0, PERIOD_S))
