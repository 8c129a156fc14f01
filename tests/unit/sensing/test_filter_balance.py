"""The compiled balance of the filter against the exponential and against its own heat, and its covariance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.sensing import (
    FilterEstimator,
    SensingModel,
    wire_model_of,
)
from musclewire.sensing._filter_estimator import FIRST_COVARIANCE, N_CONSTANTS, N_TABLES, NUMBERS_ROW, STATES, advanced
from musclewire.sensing._wire_tables import WireModel
from musclewire.signals import WireSample

SHUNT_OHM = 1.0


@pytest.fixture(scope="module")
def wire(model: SensingModel) -> WireModel:
    return wire_model_of(model)


def kernel_arguments(model: SensingModel) -> tuple[np.ndarray, np.ndarray]:
    """Return the row of numbers and the tables that the compiled functions read."""
    constants = FilterEstimator(model, SHUNT_OHM).compiled_tick().constants
    return constants[:N_CONSTANTS].view(NUMBERS_ROW)[0], constants[N_CONSTANTS : N_CONSTANTS + N_TABLES]


def test_between_its_branches_a_wire_cools_as_the_exponential_says(model: SensingModel, wire: WireModel) -> None:
    numbers, tables = kernel_arguments(model)
    place = 0.5 * (wire.sensed_from.value + wire.places[-1])
    heating_w, cooling_w = (
        float(np.interp(place, wire.places, row)) for row in (wire.heating_power_w, wire.cooling_power_w)
    )
    toward_w = 0.5 * cooling_w
    for dt_s in (0.01, 0.05, 0.1):
        found_w, still = advanced(numbers, tables, heating_w, place, 0.0, 1.0, toward_w, dt_s)
        exact_w = toward_w + (heating_w - toward_w) * math.exp(-dt_s / wire.time_constant_s.value)
        assert found_w == pytest.approx(exact_w, abs=2e-3 * (heating_w - toward_w))
        assert still == place


def test_heat_that_is_given_is_lost_or_stored(model: SensingModel, wire: WireModel) -> None:
    numbers, tables = kernel_arguments(model)
    place = wire.sensed_from.value + 0.3
    steady_w = float(np.interp(place, wire.places, wire.heating_power_w))
    power_w, dt_s = 1.5 * steady_w, 0.001
    after_w, after = advanced(numbers, tables, steady_w, place, 0.0, 1.0, power_w, dt_s)
    assert after > place
    tau_s, heat_j = wire.time_constant_s.value, wire.heat_j_per_unit.value * model.quantity_max
    stored_j = tau_s * (after_w - steady_w) + heat_j * (after - place)
    assert stored_j == pytest.approx(dt_s * (power_w - steady_w), rel=0.01)


@given(st.lists(st.tuples(st.floats(0.3, 3.6), st.floats(15.0, 17.5), st.floats(0.01, 0.5)), min_size=1, max_size=60))
def test_the_covariance_stays_one_whatever_a_wire_does(
    model: SensingModel, given: list[tuple[float, float, float]]
) -> None:
    made = FilterEstimator(model, SHUNT_OHM)
    state, time_s = made.start(), 0.0
    for drive_v, ohm, wait_s in given:
        current_a = drive_v / (ohm + SHUNT_OHM)
        step = made.step(state, WireSample(time_s, drive_v, current_a * ohm, current_a))
        state, time_s = step.state, time_s + wait_s
        triangle = np.zeros((STATES, STATES))
        triangle[np.tril_indices(STATES)] = state[FIRST_COVARIANCE:]
        covariance = triangle + np.tril(triangle, -1).T
        scale = np.sqrt(np.maximum(np.diag(covariance), 1e-12))
        assert np.linalg.eigvalsh(covariance / np.outer(scale, scale)).min() > -1e-6
        assert step.estimate.std > 0.0


def test_a_resistance_that_contradicts_its_power_for_hours_leaves_no_more_than_nothing_known(
    model: SensingModel, wire: WireModel
) -> None:
    high_ohm = model.resistance_max_ohm + 0.1 * (model.resistance_max_ohm - model.resistance_min_ohm)
    tick = FilterEstimator(model, SHUNT_OHM).compiled_tick()
    state, answer = tick.state.copy(), np.zeros(16)
    for row in range(20_000):
        ohm = high_ohm if row % 40 else model.resistance_min_ohm
        wire_v = 3.0 * ohm / (ohm + SHUNT_OHM)
        tick.function(tick.constants, state, np.array([row * 1.0, 3.0, wire_v, 3.0 - wire_v]), answer)
    power, place, loss = (state[FIRST_COVARIANCE + index] for index in (0, 2, 9))
    assert np.isfinite(answer).all()
    assert power < 2.0 * wire.middle_power_w**2
    assert place < 2.0
    assert loss < 1.1
