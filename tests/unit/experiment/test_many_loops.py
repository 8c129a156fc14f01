"""Many loops in compiled code are the loop in Python, many times: same numbers, same ends."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.other_estimators import DriftingEstimator

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.controllers import (
    CONTROLLERS,
    ControllerSetup,
    staircase,
)
from musclewire.errors import CallerError, RigError
from musclewire.experiment import LoopOutcome, characterize, control, control_compiled, control_many, friction_warnings
from musclewire.identify import fit
from musclewire.rigs import RigConfiguration, Surroundings, open_rig
from musclewire.sensing import EstimatorSetup, KnownSpring, PolynomialEstimator, SensingModel
from musclewire.signals import CompiledTick, ControlStep, Drive, QuantityEstimate

pytestmark = pytest.mark.slow

SHORT = staircase(start=0.015, stop=0.018, hold_s=1.5)


@pytest.fixture(scope="module")
def model() -> SensingModel:
    with open_rig() as rig:
        return fit(characterize(rig, cycles=1))


def both(rig: Any, model: SensingModel, reference: Any = SHORT, **how: Any) -> tuple[LoopOutcome, LoopOutcome]:
    """Return the outcomes of the compiled loop and of the loop in Python."""
    made = [control_many(rig, model, reference, keep_recordings=True, in_python=way, **how) for way in (False, True)]
    return made[0].outcomes[-1], made[1].outcomes[-1]


def assert_same_numbers(fast: LoopOutcome, slow: LoopOutcome) -> None:
    """Every column is the same to the bit, and so are the errors and what is found wrong."""
    assert fast.run is not None
    assert slow.run is not None
    assert list(fast.run.columns) == list(slow.run.columns)
    for name, column in slow.run.whole_columns.items():
        np.testing.assert_array_equal(fast.run.whole_columns[name], column, err_msg=name)
    assert (fast.metrics, fast.does_not_hold) == (slow.metrics, slow.does_not_hold)
    assert fast.run.metadata.get("health") == slow.run.metadata.get("health")


def assert_same(fast: LoopOutcome, slow: LoopOutcome) -> None:
    """The numbers are the same to the bit; what is said of the run differs in its timing."""
    assert_same_numbers(fast, slow)
    assert fast.run is not None
    assert slow.run is not None
    timing = {name for name in slow.run.metadata if name.startswith(("compute_", "deadline", "start_time"))}
    assert {name: fast.run.metadata[name] for name in slow.run.metadata.keys() - timing} == {
        name: slow.run.metadata[name] for name in slow.run.metadata.keys() - timing
    }


RIGS = {
    "the paper's bench": {},
    "air that moves": {"surroundings": Surroundings(ambient_swing=2.0, draught=0.1)},
    "samples of 4 ms": {"settings": {"sample_period_s": 0.004, "acquisition_readings": 10.0}},
    "more readings than a block": {"settings": {"acquisition_readings": 300.0}},
}


@pytest.mark.parametrize("rig", RIGS.values(), ids=RIGS)
def test_the_compiled_loop_is_the_loop_in_python(rig: dict[str, Any], model: SensingModel) -> None:
    fast, slow = both(RigConfiguration(**rig), model, seeds=[7], approach_s=2.0)
    assert (fast.compiled, slow.compiled) == (True, False)
    assert_same(fast, slow)


def test_friction_that_holds_the_wire_is_said_by_both(model: SensingModel) -> None:
    rig = RigConfiguration(settings={"guide_friction_n": 1.0, "pretension_n": 0.5})
    fast, slow = both(rig, model, staircase(0.012, 0.03, 0.009, 4.0), seeds=[1])
    assert fast.compiled
    assert_same(fast, slow)
    assert fast.run is not None
    assert set(friction_warnings(fast.run)) & set(fast.warnings)


# It needs its wire's gains.
WITH_DEFAULTS = [name for name in CONTROLLERS.names() if name != "inverse-model"]
any_rig = st.fixed_dictionaries(
    {
        "pretension_n": st.floats(1.6, 2.2),
        "guide_friction_n": st.floats(0.0, 0.2),
        "ambient_temperature_k": st.floats(290.0, 300.0),
        "resistivity_factor": st.floats(0.98, 1.02),
        "acquisition_noise_v": st.floats(0.0, 5e-3),
        "acquisition_readings": st.integers(1, 60).map(float),
        "time_step_s": st.sampled_from([0.0, 0.001, 0.01]),
    }
)


@settings(max_examples=20)
@given(any_rig, st.integers(0, 1000), st.booleans(), st.sampled_from(WITH_DEFAULTS))
def test_whatever_becomes_of_a_loop_it_is_the_same_in_python(
    model: SensingModel, numbers: dict[str, float], seed: int, new_wire: bool, controller: str
) -> None:
    rig = RigConfiguration(settings=numbers, new_wire=new_wire)
    fast, slow = both(rig, model, seeds=[seed], controller=controller, approach_s=2.0)
    assert (fast.ended, fast.metrics) == (slow.ended, slow.metrics)
    if fast.ended == "done":
        assert_same(fast, slow)


def test_force_on_a_known_spring_too(model: SensingModel) -> None:
    fast, slow = both("simulated", model, staircase(1.0, 1.2, 0.1, 1.0), seeds=[7], load=KnownSpring(588.6, 0.05))
    assert fast.compiled
    assert_same(fast, slow)


def test_a_finger_with_its_endpoint_in_every_column() -> None:
    with open_rig("finger") as rig:
        own = fit(characterize(rig, cycles=1), quantity="displacement")
    fast, slow = both("finger", own, None, seeds=[3])
    assert fast.compiled
    assert_same(fast, slow)


def test_neither_the_number_of_threads_nor_that_of_loops_changes_a_digit(model: SensingModel) -> None:
    rigs = [RigConfiguration(settings={"pretension_n": 1.7 + 0.05 * number}) for number in range(8)]
    models = [replace(model, scale_std=0.01 * number) for number in range(8)]
    many = control_many(rigs, models, SHORT, seeds=range(1, 9), threads=3)
    one_by_one = control_many(rigs, models, SHORT, seeds=range(1, 9), threads=1)
    alone = control_many(rigs[4], models[4], SHORT, seeds=[5])
    assert many.metrics == one_by_one.metrics
    assert many.outcomes[4] == alone.outcomes[0]
    assert many.mae_pct.shape == (8, 3)


@pytest.mark.parametrize("air", [Surroundings(), Surroundings(ambient_swing=2.0, draught=0.1)], ids=["still", "moving"])
def test_a_loop_goes_on_from_where_an_experiment_has_left_the_rig(model: SensingModel, air: Surroundings) -> None:
    after = []
    for run in (control, control_compiled):
        with open_rig(RigConfiguration(surroundings=air), seed=5) as rig:
            characterize(rig, cycles=1)
            after.append(run(rig, model, SHORT))
    assert list(after[0].columns) == list(after[1].columns)
    for name in after[0].columns:
        np.testing.assert_array_equal(after[1][name], after[0][name], err_msg=name)
    assert after[0].metrics == after[1].metrics


def test_a_compiled_loop_closes_its_rig_and_fails_as_in_python(model: SensingModel) -> None:
    with open_rig() as rig:
        control_compiled(rig, model, SHORT)
        with pytest.raises(RigError, match="closed"):
            rig.exchange(0.3)
    with open_rig(resistivity_factor=1.2) as rig, pytest.raises(RigError, match="not this model's wire"):
        control_compiled(rig, model, SHORT)
    with open_rig() as rig:
        rig.exchange(0.3)
        with pytest.raises(CallerError, match="being driven"):
            control_compiled(rig, model, SHORT)


@pytest.mark.parametrize(
    ("wrong", "end"), [({"resistivity_factor": 1.2}, "this model's wire"), ({"acquisition_noise_v": 0.2}, "Trip")]
)
def test_a_loop_that_fails_ends_as_in_python(model: SensingModel, wrong: dict[str, float], end: str) -> None:
    fast, slow = both(RigConfiguration(settings=wrong), model, seeds=[7])
    assert end in fast.ended
    assert fast.ended == slow.ended
    assert (fast.compiled, fast.metrics) == (False, None)
    assert fast.run is not None
    assert slow.run is not None
    assert len(fast.run) == len(slow.run) > 0


@compiled
def half_way_tick(constants: FloatArray, state: FloatArray, given: FloatArray, answer: FloatArray) -> None:
    """Go a part of the way from the last drive to the one that the error asks for."""
    wanted_v = constants[0] + constants[1] * (given[0] - given[1])
    state[0] += 0.5 * (min(max(wanted_v, constants[2]), constants[3]) - state[0])
    answer[0] = state[0]
    answer[1] = 0.0
    answer[2] = wanted_v


class HalfWay:
    """A controller from outside, with a tick of its own."""

    columns = ("proportional_gain",)

    def __init__(self, setup: ControllerSetup) -> None:
        self.limits = setup.limits

    def start(self, drive_voltage_v: float) -> float:
        return self.limits.clamp(drive_voltage_v)

    def step(self, state: float, target: float, estimate: QuantityEstimate, _dt_s: float) -> ControlStep:
        wanted_v = 2.0 + 100.0 * (target - estimate.value)
        drive_v = state + 0.5 * (self.limits.clamp(wanted_v) - state)
        return ControlStep(Drive(drive_v), drive_v, (wanted_v,))

    def compiled_tick(self, drive_voltage_v: float) -> CompiledTick:
        constants = [2.0, 100.0, self.limits.sense_voltage_v, self.limits.maximum_voltage_v]
        return CompiledTick(half_way_tick, np.array(constants), np.array([self.start(drive_voltage_v)]))


def test_a_controller_from_outside_brings_its_own_tick(model: SensingModel) -> None:
    fast, slow = both("simulated", model, seeds=[7], controller=HalfWay)
    assert fast.compiled
    assert_same(fast, slow)


class Cautious(PolynomialEstimator):
    """The paper's estimator with another step, and with the tick that it inherits."""


def cautious(setup: EstimatorSetup) -> Cautious:
    return Cautious(setup.model.curve(), setup.shunt_resistance_ohm)


def test_without_a_tick_of_its_own_an_estimator_is_refused_by_its_name(model: SensingModel) -> None:
    for estimator in (cautious, DriftingEstimator):
        with pytest.raises(CallerError, match=r"estimator \w+ has no compiled tick.*in_python"):
            control_many("simulated", model, SHORT, seeds=[7], estimator=estimator)
    done = control_many("simulated", model, SHORT, seeds=[7], estimator=cautious, in_python=True)
    assert done.metrics == control_many("simulated", model, SHORT, seeds=[7], estimator="polynomial").metrics


def test_lists_must_be_as_long_as_the_seeds(model: SensingModel) -> None:
    with pytest.raises(CallerError, match="2 rigs for 3 seeds"):
        control_many(["simulated", "simulated"], model, seeds=[1, 2, 3])
    with open_rig() as rig, pytest.raises(CallerError, match="each loop opens its own"):
        control_many(rig, model, seeds=[1, 2])  # type: ignore[arg-type]


def test_outcomes_come_in_the_order_of_the_seeds_and_keep_recordings_only_on_request(model: SensingModel) -> None:
    seen: list[LoopOutcome] = []
    found = control_many("simulated", model, SHORT, seeds=[3, 1, 2], on_outcome=seen.append)
    assert [outcome.seed for outcome in seen] == [3, 1, 2]
    assert found.outcomes == tuple(seen)
    assert all(outcome.run is None for outcome in seen)
    assert not any(math.isnan(error) for error in found.mae_max_pct)


ROOM = {"ambient_temperature_k": 305.0}


@pytest.mark.parametrize(
    ("rig", "how"),
    [
        ({"pretension_n": 0.95}, {"zero_from": "today"}),
        ({"pretension_n": 0.95}, {"known_strain": (0.012, 1.4)}),
        (ROOM, {"zero_from": "today"}),
        (ROOM | {"pretension_n": 0.95}, {"zero_from": "today", "known_strain": (0.014, 2.0)}),
        ({"pretension_n": 0.95}, {"zero_from": "today", "controller": "fuzzy-pid"}),
        ({"pretension_n": 0.95}, {"zero_from": "today", "estimator": "polynomial"}),
    ],
    ids=["B", "known strain", "room", "all", "fuzzy PID", "polynomial"],
)
def test_a_corrected_loop_goes_on_in_compiled_code_with_the_numbers_of_control(
    rig: dict[str, Any], how: dict[str, Any], model: SensingModel
) -> None:
    fast, slow = both(RigConfiguration(settings=rig), model, seeds=[3], **how)
    assert (fast.compiled, slow.compiled) == (True, False)
    assert_same_numbers(fast, slow)


def test_where_b_is_too_far_away_python_runs_the_loop(model: SensingModel) -> None:
    other = replace(
        model, resistance_min_ohm=model.resistance_min_ohm / 1.016, resistance_max_ohm=model.resistance_max_ohm / 1.016
    )
    (outcome,) = control_many("simulated", other, SHORT, seeds=[3], zero_from="today").outcomes
    assert not outcome.compiled
