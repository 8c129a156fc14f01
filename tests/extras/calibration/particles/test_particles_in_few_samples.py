"""Properties of the particle filter that ten hypotheses and some samples show, soon enough without compilation, too."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from musclewire.errors import CallerError
from musclewire.extras.calibration._particles._cloud import ParticleCloud, cloud_of
from musclewire.extras.calibration._particles._estimator import ParticleFilter, ParticleState, particle_filter
from musclewire.extras.calibration._particles._kernel import LOAD, MIN_LOAD
from musclewire.extras.calibration._particles._settings import EXPLANATIONS, UNKNOWNS, ParticleSettings
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.sensing import EstimatorSetup, SensingModel
from musclewire.signals import EstimatorStep, Reason, WireSample
from musclewire.wire import constants_from

PERIOD_S, SHUNT_OHM = 0.05, 1.0
WIRE = constants_from(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"))
# A slow loop from cold to C and back: time [s], power [W] and resistance [ohm].
CORNERS = ((0.0, 0.01, 17.1), (20.0, 0.12, 17.5), (50.0, 0.45, 13.5), (80.0, 0.06, 17.4), (90.0, 0.01, 17.1))
LOOP_S = np.linspace(0.0, 90.0, 181)
SLOW_LOOP = np.column_stack([LOOP_S, *(np.interp(LOOP_S, *np.array(CORNERS)[:, [0, k]].T) for k in (1, 2))])
MODEL = SensingModel(
    *(13.5, 17.5, (0.0405, -0.04), (0.0395, -0.04), 0.05, 0.95),
    resistance_noise_ohm=0.005,
    slow_loop=tuple(map(tuple, SLOW_LOOP.tolist())),
)
# Snapshots after 4 samples, hypotheses started again from them after 8.
FEW = ParticleSettings(hypotheses=10, snapshot=4, restart_time_s=0.2, restarts=2)


def sample(tick: int, resistance_ohm: float, drive_v: float = 2.5) -> WireSample:
    """What a wire of a resistance shows at a drive; 0 ohm for an open circuit."""
    current_a = drive_v / (resistance_ohm + SHUNT_OHM) if resistance_ohm > 0.0 else 0.0
    return WireSample(PERIOD_S * tick, drive_v, current_a * resistance_ohm, current_a * SHUNT_OHM)


def filter_of(settings: ParticleSettings = FEW, model: SensingModel = MODEL) -> ParticleFilter:
    return particle_filter(EstimatorSetup(model, SHUNT_OHM, PERIOD_S, wire=WIRE), settings)


def followed(estimator: ParticleFilter, resistances: list[float]) -> list[EstimatorStep]:
    state, steps = estimator.start(), []
    for tick, ohm in enumerate(resistances):
        steps.append(estimator.step(state, sample(tick, ohm)))
        state = steps[-1].state
    return steps


def clouds(state: ParticleState) -> list[ParticleCloud]:
    return [cloud_of(one, WIRE.classes, FEW) for one in state.hypotheses]


# A wire that warms, a contact that jumps, a gap in the current, and a resistance that no hypothesis explains.
WARMING = [17.3 - 0.02 * tick for tick in range(14)]
JUMPING = [*WARMING, 15.9, 17.1, 15.2, 0.0, 0.0, 16.4, 14.0, 14.1, 14.0, 14.2]


def test_whatever_is_measured_the_weights_add_up_and_each_hypothesis_stays_what_can_be() -> None:
    for step in followed(filter_of(), JUMPING):
        assert math.isfinite(step.estimate.value + step.estimate.std)
        assert step.estimate.std > 0.0
        for explanation, cloud in zip(EXPLANATIONS, clouds(step.state), strict=True):
            assert np.exp(cloud.log_weight).sum() == pytest.approx(1.0)
            assert np.isfinite(cloud.unknowns).all()
            assert cloud.unknowns[:, LOAD].min() >= MIN_LOAD
            assert set(np.unique(cloud.changed)) <= {0.0, 1.0}
            kept_alike = [place for place, name in enumerate(UNKNOWNS) if name not in EXPLANATIONS[explanation]]
            assert not cloud.changed[:, kept_alike].any()


def test_a_step_is_pure_also_when_hypotheses_are_started_again() -> None:
    estimator = filter_of()
    for last in followed(estimator, JUMPING)[7::5]:
        again, twice = (estimator.step(last.state, sample(30, 15.5)) for _ in range(2))
        assert again == twice


def test_the_seed_decides_what_is_drawn_and_nothing_else() -> None:
    one, same, other = (followed(filter_of(replace(FEW, seed=seed)), JUMPING[:12])[-1] for seed in (1, 1, 2))
    assert one == same
    assert one.state.hypotheses != other.state.hypotheses


def test_resistances_far_from_the_wires_lead_to_hypotheses_with_changes() -> None:
    changed = [cloud.changed.sum() for cloud in clouds(followed(filter_of(), [16.0] * 20)[-1].state)]
    assert all(count > 0.0 for count in changed)


def test_without_current_the_power_follows_from_the_drive_and_the_value_is_kept() -> None:
    before, gone = followed(filter_of(), [*WARMING[:4], 0.0])[-2:]
    assert gone.estimate.reason is Reason.NO_CURRENT
    assert gone.estimate.value == before.estimate.value
    warmer = [np.mean([wire["temperature_k"] for wire in cloud.wires]) for cloud in clouds(gone.state)]
    colder = [np.mean([wire["temperature_k"] for wire in cloud.wires]) for cloud in clouds(before.state)]
    assert all(now > then for now, then in zip(warmer, colder, strict=True))


@pytest.mark.parametrize("quantity", ["force", "displacement"])
def test_value_and_deviation_are_in_the_unit_of_the_model(quantity: str) -> None:
    scale = {"force": 100.0, "displacement": WIRE.leg_length_m}[quantity]
    curves = [tuple(scale * number for number in row) for row in ((0.0405, -0.04), (0.0395, -0.04))]
    model = replace(MODEL, heating_coefficients=curves[0], cooling_coefficients=curves[1], quantity=quantity)
    last = followed(filter_of(model=model), WARMING[:4])[-1].estimate
    full = model.quantity_max - model.quantity_min
    assert model.quantity_min - full <= last.value <= model.quantity_max + full
    assert 0.0 < last.std <= full


def test_a_model_of_a_fingers_endpoint_is_refused() -> None:
    model = replace(MODEL, quantity="displacement", wire={"finger": "lan-fan"})
    with pytest.raises(CallerError, match="of a finger's endpoint"):
        filter_of(model=model)


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"chance": (1.0, 1.0, 0.0, 0.0, 0.0, 0.0)}, "add up to 2: they must"),
        ({"spread_changed": (1.0,)}, "needs 6 numbers of 0 or more for convection"),
        ({"hypotheses": 5}, "10 hypotheses or more"),
        ({"evidence_time_s": 0.0}, "errors and times above 0"),
    ],
)
def test_settings_that_leave_nothing_to_weigh_are_refused(numbers: dict[str, Any], message: str) -> None:
    with pytest.raises(CallerError, match=message):
        ParticleSettings(**numbers)
