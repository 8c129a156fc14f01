"""Every controller keeps to ``controllers.Controller``: pure, within limits, bumpless, without windup."""

from __future__ import annotations

import copy
import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.controllers import (
    CONTROLLERS,
    Controller,
    ControllerSetup,
    DriveLimits,
    FeedforwardSettings,
)
from musclewire.errors import CallerError, NumericsError
from musclewire.signals import COLUMNS, CONTROLLER_ANSWERS, UNKNOWN_WIRE, Drive, QuantityEstimate, Reason, declared_tick

LIMITS = DriveLimits(0.4, 3.2)
DT_S = 0.05
NO_CURRENT = QuantityEstimate(0.02, 0.03, False, Reason.NO_CURRENT)
# One that has no defaults, because it acts by what it knows of its wire, is given a wire: round numbers of one of
# 100 micrometres and 14 cm.
NEEDED: dict[str, Any] = {
    "inverse-model": FeedforwardSettings(
        lowest=0.005,
        highest=0.035,
        heating_power_w=(0.35, 0.42, 0.47, 0.55),
        cooling_power_w=(0.25, 0.28, 0.32, 0.45),
        resistance_ohm=(17.4, 16.7, 16.0, 15.2),
        shunt_resistance_ohm=1.0,
        thermal_time_constant_s=0.8,
        heat_per_unit=2.5,
        closed_loop_time_s=0.1,
        dead_time_s=0.1,
        integral_time_s=0.8,
        maximum_steady_power_w=0.98,
    )
}
every_controller = pytest.mark.parametrize("name", CONTROLLERS.names())
strains = st.floats(-0.01, 0.06)
readings = st.lists(st.one_of(strains, st.none()), min_size=1, max_size=30)


@cache
def made(name: str) -> Controller:
    """Make a controller when a test first asks for it: some compile, which no other test should wait for."""
    return CONTROLLERS.find(name)(ControllerSetup(LIMITS, settings=NEEDED.get(name)))


def estimate(value: float | None) -> QuantityEstimate:
    return NO_CURRENT if value is None else QuantityEstimate(value, 1e-4, True)


def drives(controller: Controller, first_v: float, target: float, measured: list[float | None]) -> list[float]:
    state, found = controller.start(first_v), []
    for value in measured:
        command, state, recorded = controller.step(state, target, estimate(value), DT_S)
        assert isinstance(command, Drive)
        assert len(recorded) == len(controller.columns)
        assert all(math.isfinite(number) for number in recorded)
        found.append(command.voltage_v)
    return found


@every_controller
@given(st.floats(0.0, 5.0), strains, readings)
def test_every_command_is_a_drive_within_the_limits(
    name: str, first_v: float, target: float, measured: list[float | None]
) -> None:
    found = drives(made(name), first_v, target, measured)
    assert all(LIMITS.sense_voltage_v <= drive <= LIMITS.maximum_voltage_v for drive in found)


@every_controller
@given(strains, readings)
def test_the_same_arguments_give_the_same_answer_and_the_state_is_left_alone(
    name: str, target: float, measured: list[float | None]
) -> None:
    controller = made(name)
    state = controller.start(1.0)
    for value in measured:
        before = copy.deepcopy(state)
        once = controller.step(state, target, estimate(value), DT_S)
        assert controller.step(state, target, estimate(value), DT_S) == once
        assert state == before
        state = once.state


@every_controller
def test_at_rest_on_target_it_takes_over_without_a_jump(name: str) -> None:
    assert drives(made(name), 1.7, 0.02, [0.02] * 5) == [1.7] * 5


@every_controller
def test_a_drive_outside_of_the_limits_is_taken_over_at_the_nearest_one(name: str) -> None:
    assert drives(made(name), 9.0, 0.02, [None]) == [LIMITS.maximum_voltage_v]
    assert drives(made(name), 0.0, 0.02, [None]) == [LIMITS.sense_voltage_v]


@every_controller
@pytest.mark.parametrize(("target", "limit"), [(0.06, LIMITS.maximum_voltage_v), (-0.02, LIMITS.sense_voltage_v)])
def test_it_saturates_without_windup(name: str, target: float, limit: float) -> None:
    """However long it has been at a limit, it leaves it in the tick in which the error has changed its sign."""
    for ticks in (200, 2000):
        found = drives(made(name), 1.5, target, [0.02] * ticks + [target + math.copysign(0.01, target)])
        assert found[-2] == limit
        assert found[-1] != limit


@every_controller
def test_samples_without_current_are_bridged_by_the_last_command(name: str) -> None:
    found = drives(made(name), 1.5, 0.0202, [0.02, 0.0201, None, None, None, 0.0203])
    assert found[1] == found[2] == found[3] == found[4] != found[5]
    assert drives(made(name), 1.5, 0.03, [None, None]) == [1.5, 1.5]


@every_controller
def test_a_hotter_target_raises_the_drive_and_a_colder_one_lowers_it(name: str) -> None:
    assert drives(made(name), 1.5, 0.03, [0.02] * 20)[-1] > 1.5
    assert drives(made(name), 1.5, 0.01, [0.02] * 20)[-1] < 1.5


@every_controller
def test_numbers_that_cannot_be_are_refused(name: str) -> None:
    controller = made(name)
    for target, value in ((math.nan, 0.02), (0.02, math.nan), (math.inf, 0.02)):
        with pytest.raises(NumericsError):
            controller.step(controller.start(1.0), target, estimate(value), DT_S)
    for dt_s in (0.0, -1.0):
        with pytest.raises(CallerError):
            controller.step(controller.start(1.0), 0.02, estimate(0.02), dt_s)


@every_controller
def test_its_columns_are_known_and_differ(name: str) -> None:
    columns = made(name).columns
    assert len(set(columns)) == len(columns)
    assert set(columns) <= set(COLUMNS)


@every_controller
def test_settings_of_another_controller_are_refused(name: str) -> None:
    with pytest.raises(CallerError, match="settings of the kind"):
        CONTROLLERS.find(name)(ControllerSetup(LIMITS, settings=object()))


@every_controller
def test_our_own_controllers_have_a_compiled_tick(name: str) -> None:
    assert declared_tick(made(name), 1.0) is not None


@every_controller
@given(st.floats(0.0, 5.0), st.lists(st.tuples(strains, st.one_of(strains, st.none())), min_size=1, max_size=30))
def test_a_compiled_tick_is_the_step_to_the_bit(
    name: str, first_v: float, given: list[tuple[float, float | None]]
) -> None:
    controller = made(name)
    tick = declared_tick(controller, first_v)
    assert tick is not None
    state, numbers = controller.start(first_v), tick.state.copy()
    answer = np.zeros(len(CONTROLLER_ANSWERS) + len(controller.columns))
    for target, value in given:
        read = estimate(value)
        command, state, recorded = controller.step(state, target, read, DT_S)
        inputs = np.array([target, read.value, read.std, float(read.valid), float(read.reason), DT_S, *UNKNOWN_WIRE])
        tick.function(tick.constants, numbers, inputs, answer)
        assert isinstance(command, Drive)
        assert answer.tolist() == [command.voltage_v, 0.0, *recorded]


@every_controller
@pytest.mark.parametrize(
    ("target", "value", "dt_s"),
    [(math.nan, 0.01, 0.05), (0.01, math.inf, 0.05), (1e308, -1e308, 1e-9), (0.01, 0.02, 0.0)],
)
def test_a_compiled_tick_fails_where_the_step_raises(name: str, target: float, value: float, dt_s: float) -> None:
    controller = made(name)
    tick = declared_tick(controller, 1.0)
    assert tick is not None
    state, numbers = controller.start(1.0), tick.state.copy()
    answer = np.zeros(len(CONTROLLER_ANSWERS) + len(controller.columns))
    state = controller.step(state, 0.02, estimate(0.019), DT_S).state
    tick.function(tick.constants, numbers, np.array([0.02, 0.019, 1e-4, 1.0, 0.0, DT_S, *UNKNOWN_WIRE]), answer)
    with pytest.raises((NumericsError, CallerError)):
        controller.step(state, target, QuantityEstimate(value, 1e-4, True), dt_s)
    tick.function(tick.constants, numbers, np.array([target, value, 1e-4, 1.0, 0.0, dt_s, *UNKNOWN_WIRE]), answer)
    assert answer[1] == 1.0
