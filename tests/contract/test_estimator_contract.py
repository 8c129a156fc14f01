"""Every estimator keeps to ``sensing.Estimator``: pure, finite, bridging dropouts, with a reason."""

from __future__ import annotations

import copy
import math
import re
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.other_estimators import DriftingEstimator

from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.sensing import (
    ESTIMATORS,
    MAX_DROPOUTS,
    Estimator,
    EstimatorSetup,
    KnownSpring,
    SensingModel,
    estimates,
    force_model,
)
from musclewire.signals import ESTIMATOR_ANSWERS, QuantityEstimate, Reason, WireSample, declared_tick
from musclewire.wire import constants_from

# A slow loop through A, B and C and back to A: time [s], power [W] and resistance [ohm] of the paths between them.
CORNERS = ((0.0, 0.01, 17.1), (20.0, 0.12, 17.5), (50.0, 0.45, 13.5), (80.0, 0.06, 17.4), (90.0, 0.01, 17.1))
CORNER_S, CORNER_W, CORNER_OHM = np.array(CORNERS).T
LOOP_S = np.linspace(0.0, 90.0, 181)
SLOW_LOOP = np.column_stack([LOOP_S, *(np.interp(LOOP_S, CORNER_S, one) for one in (CORNER_W, CORNER_OHM))])
# 4 % at 13.5 ohm, nothing at 17.5 ohm; the branches half a tenth of a percent apart.
MODEL = SensingModel(
    13.5,
    17.5,
    (0.0405, -0.04),
    (0.0395, -0.04),
    0.05,
    0.95,
    resistance_noise_ohm=0.005,
    scale_std=0.03,
    slow_loop=tuple(map(tuple, SLOW_LOOP.tolist())),
    gains={"controller": "inverse-model", "thermal_time_constant_s": 0.8, "heat_per_unit": 2.5},
)
PERIOD_S = 0.05
FACTORIES = {**{name: ESTIMATORS.find(name) for name in ESTIMATORS.names()}, "drifting": DriftingEstimator}
# The wire of a user's file, for estimators on physics: any will do for what all promise.
WIRE = constants_from(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"))
ON_PHYSICS = ("particle-filter", "filter")

every_estimator = pytest.mark.parametrize("name", FACTORIES)
# What reads a value off a curve at once; one on physics asks whether a wire can do what the resistance says.
every_curve = pytest.mark.parametrize("name", [name for name in FACTORIES if name not in ON_PHYSICS])


@cache
def made(name: str) -> Estimator:
    """Make an estimator when a test first asks for it: some compile, which no other test should wait for."""
    return FACTORIES[name](EstimatorSetup(MODEL, 1.0, PERIOD_S, wire=WIRE))


def sample(tick: int, resistance_ohm: float | None, drive_v: float = 2.0) -> WireSample:
    """What a wire of a resistance shows at a drive; None for an open circuit."""
    current_a = 0.0 if resistance_ohm is None else drive_v / (resistance_ohm + 1.0)
    return WireSample(PERIOD_S * tick, drive_v, current_a * (resistance_ohm or 0.0), current_a)


def followed(
    estimator: Estimator, resistances: list[float | None], drives_v: list[float] | None = None
) -> list[QuantityEstimate]:
    driven = drives_v or [2.0] * len(resistances)
    samples = [sample(k, ohm, drive_v) for k, (ohm, drive_v) in enumerate(zip(resistances, driven, strict=True))]
    return [estimate for estimate, _ in estimates(estimator, samples)]


resistance_lists = st.lists(st.one_of(st.floats(5.0, 40.0), st.none()), min_size=1, max_size=30)
any_volts = st.floats(allow_nan=True, allow_infinity=True)


@every_estimator
@given(resistance_lists)
def test_the_same_sample_gives_the_same_estimate_and_the_state_is_left_alone(
    name: str, resistances: list[float | None]
) -> None:
    estimator = made(name)
    state = estimator.start()
    assert state == estimator.start()
    for tick, ohm in enumerate(resistances):
        before = copy.deepcopy(state)
        once = estimator.step(state, sample(tick, ohm))
        assert estimator.step(state, sample(tick, ohm)) == once
        assert state == before
        state = once.state
        hash(state)  # immutable all through


@every_estimator
@given(st.lists(st.tuples(any_volts, any_volts), min_size=1, max_size=10))
def test_whatever_the_channels_say_value_and_deviation_are_finite_numbers(
    name: str, volts: list[tuple[float, float]]
) -> None:
    samples = [WireSample(PERIOD_S * tick, 2.0, wire, shunt) for tick, (wire, shunt) in enumerate(volts)]
    for estimate, recorded in estimates(made(name), samples):
        assert math.isfinite(estimate.value)
        assert math.isfinite(estimate.std)
        assert estimate.std >= 0.0
        assert estimate.valid == (estimate.reason is Reason.OK)
        assert len(recorded) == len(made(name).columns)
        assert all(math.isfinite(number) for number in recorded)


@every_curve
def test_a_heated_wire_is_read_as_its_model_reads_it(name: str) -> None:
    found = followed(made(name), [16.9 - 0.1 * k for k in range(20)])
    assert [estimate.reason for estimate in found[-5:]] == [Reason.OK] * 5
    read = MODEL.estimate(np.array([16.9 - 0.1 * k for k in range(20)]))
    assert [estimate.value for estimate in found] == pytest.approx(
        read.value.tolist(), abs=2.0 * MODEL.estimate(16.0).std
    )


@every_estimator
def test_a_dropout_is_bridged_by_the_last_value_and_lasting_ones_end_the_run(name: str) -> None:
    resistances: list[float | None] = [15.5] * 5 + [None] * MAX_DROPOUTS
    found = followed(made(name), resistances)
    assert [estimate.reason for estimate in found[5:]] == [Reason.NO_CURRENT] * MAX_DROPOUTS
    assert {estimate.value for estimate in found[5:]} == {found[4].value}
    assert all(estimate.std > found[4].std for estimate in found[5:])
    assert [bool(estimate.failure) for estimate in found] == [False] * (len(found) - 1) + [True]
    assert re.match(r"no current through the wire for 10 samples up to 0\.70 s at 2\.00 V", found[-1].failure)
    again = followed(made(name), [15.5] * 5 + [None] * (MAX_DROPOUTS - 1) + [15.5] + [None] * (MAX_DROPOUTS - 1))
    assert not any(estimate.failure for estimate in again)


@every_estimator
def test_the_resistance_of_another_wire_is_a_mismatch_and_ends_the_run_if_it_lasts(name: str) -> None:
    for ohm in (4.0, 30.0):
        found = followed(made(name), [15.5] * 3 + [ohm] * MAX_DROPOUTS)
        assert {estimate.reason for estimate in found[3:]} == {Reason.MISMATCH}
        assert "is not this model's wire" in found[-1].failure
        assert not any(estimate.failure for estimate in found[:-1])
    assert not any(estimate.failure for estimate in followed(made(name), [15.5, 30.0] * 20))


@every_estimator
def test_a_little_outside_of_the_valid_range_is_said_so(name: str) -> None:
    found = followed(made(name), [15.5] * 3 + [13.5])
    assert found[-1].reason is Reason.OUT_OF_RANGE


@every_estimator
def test_a_cold_wire_on_its_way_from_a_to_b_is_not_valid_yet(name: str) -> None:
    # At the sense voltage: at 2 V it could be one that cools, past B.
    found = followed(made(name), [17.0, 17.0, 17.0], [0.3] * 3)
    assert [estimate.reason for estimate in found] == [Reason.COLD] * 3


@every_estimator
def test_all_at_once_is_as_one_by_one(name: str) -> None:
    resistances: list[float | None] = [17.2, 17.0, 16.0, None, 15.0, 14.2, 30.0, 14.5]
    samples = [sample(tick, ohm) for tick, ohm in enumerate(resistances)]
    state, single = made(name).start(), []
    for one in samples:
        step = made(name).step(state, one)
        state = step.state
        single.append((step.estimate, step.recorded))
    assert list(estimates(made(name), iter(samples))) == single


@every_curve
def test_on_a_known_spring_the_friction_belongs_to_the_force(name: str) -> None:
    spring = KnownSpring(500.0, friction_n=0.2)
    force = SensingModel(13.5, 17.5, (2.0, -2.0), (2.0, -2.0), 0.05, 0.95, quantity="force")
    estimator = FACTORIES[name](EstimatorSetup(force, 1.0, PERIOD_S, spring))
    heating = [16.9 - 0.1 * k for k in range(20)]
    # A wire whose resistance rises again is one that is heated less.
    found = followed(estimator, [*heating, *heating[::-1]], [2.0] * 20 + [1.0] * 20)
    assert found[10].value - found[-11].value == pytest.approx(0.4, abs=0.02)


COMPILED = [name for name in ESTIMATORS.names() if name != "particle-filter"]


@pytest.mark.parametrize("name", COMPILED)
def test_our_own_estimators_have_a_compiled_tick(name: str) -> None:
    assert declared_tick(made(name)) is not None


@pytest.mark.parametrize("name", COMPILED)
@pytest.mark.parametrize("load", [None, KnownSpring(588.6, 0.05)])
@given(st.lists(st.tuples(st.floats(0.3, 3.6), st.one_of(st.floats(12.0, 19.0), st.none())), min_size=1, max_size=60))
def test_a_compiled_tick_is_the_step(
    name: str, load: KnownSpring | None, given: list[tuple[float, float | None]]
) -> None:
    model = MODEL if load is None else force_model(MODEL, load.stiffness_n_per_m, 0.07)
    estimator = FACTORIES[name](EstimatorSetup(model, 1.0, PERIOD_S, load))
    samples = [sample(tick, ohm, drive_v) for tick, (drive_v, ohm) in enumerate(given)]
    tick = declared_tick(estimator)
    assert tick is not None
    state, numbers = estimator.start(), tick.state.copy()
    answer = np.zeros(len(ESTIMATOR_ANSWERS) + len(estimator.columns))
    for one in samples:
        estimate, state, recorded = estimator.step(state, one)
        tick.function(tick.constants, numbers, np.array(one[:4]), answer)
        assert bool(answer[4]) == bool(estimate.failure)
        assert answer[:4].tolist() == [estimate.value, estimate.std, float(estimate.valid), float(estimate.reason)]
        assert tuple(answer[5:].tolist()) == recorded
        if estimate.failure:
            break
