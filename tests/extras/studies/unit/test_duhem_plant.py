"""The example of a wire with Duhem's hysteresis: against its outer loop, the balance of heat, and its spring."""

from __future__ import annotations

import math
import sys
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.places import EXAMPLES

from musclewire.rigs import open_rig
from musclewire.signals import Drive

pytestmark = pytest.mark.slow  # an example is compiled anew in each run

RIG_FILE = EXAMPLES / "plants" / "duhem.toml"


@pytest.fixture(name="plants", scope="module")
def _plants() -> ModuleType:
    open_rig(RIG_FILE).close()
    return sys.modules["duhem"]


def wire(plants: ModuleType, **changed: Any) -> Any:
    """Return the plant with other keys of its rig file."""
    with open_rig(RIG_FILE) as rig:
        configuration = rig.device.of.model_copy(update=changed)
    return plants.DuhemWire(configuration)


def warmed_to(plants: ModuleType, device: Any, temperatures_k: np.ndarray) -> np.ndarray:
    """Return the fraction of austenite of a wire without a spring along temperatures, in small steps."""
    body = device.body._replace(spring_n_per_m=0.0)
    phase, found = device.point, []
    for temperature_k in temperatures_k:
        while abs(temperature_k - phase.temperature_k) > 1e-9:
            change_k = float(np.clip(temperature_k - phase.temperature_k, -0.02, 0.02))
            slope = plants.slope_of(phase, change_k > 0.0, 0.0, device.material)
            heat_j = (body.capacity_j_per_k + body.latent_j * slope) * change_k
            phase = plants.warmed(phase, heat_j, 0.0, body, device.material)
        found.append(phase.austenite)
    return np.array(found)


def test_from_cold_to_hot_and_back_it_is_on_the_two_outer_curves(plants: ModuleType) -> None:
    """Dutta and Ghorbel 2005: both branches are distribution functions of temperature, here at the weight's stress."""
    device = wire(plants)
    material, shift_k = device.material, device.point.stress_pa / device.material.rate_pa_per_k

    def curve(temperature_k: np.ndarray, middle_k: float, spread_k: float) -> list[float]:
        away = (temperature_k - shift_k - middle_k) / spread_k
        return [0.5 * (1.0 + math.erf(one / math.sqrt(2.0))) for one in away]

    up_k = np.arange(330.0, 420.0, 5.0) + shift_k
    heated = warmed_to(plants, device, up_k)
    assert heated == pytest.approx(curve(up_k, material.heating_middle_k, material.heating_spread_k), abs=5e-3)
    down_k = up_k[::-1]
    both = warmed_to(plants, device, np.concatenate([up_k, down_k]))
    cooled = both[up_k.size :]
    assert cooled == pytest.approx(curve(down_k, material.cooling_middle_k, material.cooling_spread_k), abs=5e-3)


def test_a_small_cycle_stays_between_the_outer_curves(plants: ModuleType) -> None:
    device = wire(plants)
    middle_k = device.material.heating_middle_k + device.point.stress_pa / device.material.rate_pa_per_k
    cycle_k = [middle_k, middle_k - 8.0, middle_k, middle_k - 8.0, middle_k]
    at_turns = warmed_to(plants, device, np.array(cycle_k))
    assert np.all((at_turns >= 0.0) & (at_turns <= 1.0))
    assert at_turns[2] > at_turns[1]
    assert at_turns[0] == pytest.approx(0.5, abs=0.01)


@given(heats_j=st.lists(st.floats(-2e-3, 4e-3), min_size=20, max_size=60))
@settings(max_examples=25, deadline=None)
def test_heat_goes_into_capacity_and_latent_heat(plants: ModuleType, heats_j: list[float]) -> None:
    device = wire(plants)
    start = phase = device.point
    for heat_j in heats_j:
        phase = plants.warmed(phase, heat_j, 0.0, device.body, device.material)
        assert 0.0 <= phase.austenite <= 1.0
    taken_j = device.body.capacity_j_per_k * (phase.temperature_k - start.temperature_k)
    taken_j += device.body.latent_j * (phase.austenite - start.austenite)
    assert taken_j == pytest.approx(sum(heats_j), abs=1e-9 + 2e-3 * sum(map(abs, heats_j)))


def test_force_is_that_of_the_spring_and_the_hysteresis_that_of_the_rig_file(plants: ModuleType) -> None:
    device = wire(plants, hysteresis=12.0)
    for _ in range(60):
        sample = device.exchange(Drive(2.9))
    force_n = 1.9 + 588.6 * device.wire_state.strain * 0.07
    assert sample.force_n == pytest.approx(force_n, abs=0.02)
    assert device.material.heating_middle_k - device.material.cooling_middle_k == pytest.approx(12.0)


@pytest.mark.parametrize("name", ["duhem", "liang_rogers"])
def test_heat_comes_after_the_dead_time(name: str) -> None:
    """A step of the drive from rest: the resistance of a wire with 0.2 s of dead time is that of one without, later."""

    def resistance_ohm(dead_time_s: float) -> np.ndarray:
        with open_rig(EXAMPLES / "plants" / f"{name}.toml") as rig:
            device = type(rig.device)(rig.device.of.model_copy(update={"dead_time": dead_time_s}))
        samples = [device.exchange(Drive(3.0)) for _ in range(30)]
        return np.array([one.wire_voltage_v / one.shunt_voltage_v for one in samples])

    now, late = resistance_ohm(0.0), resistance_ohm(0.2)
    assert late[4:] == pytest.approx(now[:-4], abs=0.03)
