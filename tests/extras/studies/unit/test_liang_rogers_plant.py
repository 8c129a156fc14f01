"""The example of a plant from outside, a wire of another family: against closed forms and the vendor's catalogue."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.places import EXAMPLES

from musclewire.extras.studies import Conditions
from musclewire.parameters import load_catalogue
from musclewire.rigs import open_rig
from musclewire.signals import Drive

pytestmark = pytest.mark.slow  # an example is compiled anew in each run

RIG_FILE = EXAMPLES / "plants" / "liang_rogers.toml"


@pytest.fixture(name="plants", scope="module")
def _plants() -> ModuleType:
    open_rig(RIG_FILE).close()
    return sys.modules["liang_rogers"]


def wire(plants: ModuleType, conditions: Conditions | None = None, **changed: Any) -> Any:
    """Return the plant with other keys of its rig file."""
    with open_rig(RIG_FILE) as rig:
        configuration = rig.device.of.model_copy(update=changed)
    asked = None if conditions is None else lambda _: conditions
    return plants.LiangRogersWire(configuration, conditions=asked)


def fractions(plants: ModuleType, temperatures_k: np.ndarray, stress_pa: float, begin: float) -> np.ndarray:
    """Return the fraction of martensite along temperatures at one stress."""
    material, found = plants.Material(), []
    point = plants.Point(float(temperatures_k[0]), stress_pa, begin, 0.0)
    for temperature_k in temperatures_k:
        after = plants.martensite_after(point, float(temperature_k), stress_pa, 0.0, material)
        point = plants.Point(float(temperature_k), stress_pa, after, 0.0)
        found.append(after)
    return np.array(found)


@pytest.mark.parametrize("stress_pa", [0.0, 100e6, 250e6])
def test_starts_and_ends_rise_with_stress_at_the_published_rates(plants: ModuleType, stress_pa: float) -> None:
    """Clausius-Clapeyron: the vendor's 68, 78, 52 and 42 C, moved by 1/13.8 and 1/8 K per MPa (Brinson 1993)."""
    heating_k = np.linspace(300.0, 400.0, 20001)
    heated = fractions(plants, heating_k, stress_pa, 1.0)
    shift_k = stress_pa / 13.8e6
    assert heating_k[np.argmax(heated < 1.0)] == pytest.approx(341.15 + shift_k, abs=0.02)
    assert heating_k[np.argmax(heated == 0.0)] == pytest.approx(351.15 + shift_k, abs=0.02)
    assert np.interp(346.15 + shift_k, heating_k, heated) == pytest.approx(0.5, abs=1e-3)
    cooled = fractions(plants, heating_k[::-1], stress_pa, 0.0)
    shift_k = stress_pa / 8e6
    assert heating_k[::-1][np.argmax(cooled > 0.0)] == pytest.approx(325.15 + shift_k, abs=0.02)
    assert heating_k[::-1][np.argmax(cooled == 1.0)] == pytest.approx(315.15 + shift_k, abs=0.02)


@given(
    heats_j=st.lists(st.floats(-0.1, 0.2), min_size=3, max_size=8), loads_n=st.lists(st.floats(-2.5, 1.5), min_size=8)
)
@settings(max_examples=25, deadline=None)
def test_heat_goes_into_capacity_and_latent_heat(
    plants: ModuleType, heats_j: list[float], loads_n: list[float]
) -> None:
    """While the load jumps from step to step."""
    device = wire(plants)
    point, material = device.point, device.material
    for heat_j, load_n in zip(heats_j, loads_n, strict=False):
        body = device.body._replace(force_n=1.9 + load_n)
        after = plants.heated(point, heat_j, 0.0, body, material)
        taken_j = body.capacity_j_per_k * (after.temperature_k - point.temperature_k)
        taken_j -= body.latent_j * (after.martensite - point.martensite)
        assert taken_j == pytest.approx(heat_j, abs=1e-7)
        assert 0.0 <= after.martensite <= 1.0
        point = after


@pytest.mark.parametrize(
    "conditions", [Conditions(), Conditions(load_force_n=0.9, stiffness_factor=2.0, pretension_force_n=-0.4)]
)
def test_force_is_that_of_the_spring(plants: ModuleType, conditions: Conditions) -> None:
    device = wire(plants, conditions)
    for _ in range(60):
        sample = device.exchange(Drive(2.9))
    strain = device.wire_state.strain
    force_n = 1.9 + conditions.load_force_n + conditions.pretension_force_n
    force_n += 588.6 * conditions.stiffness_factor * strain * 0.07
    assert device.wire_state.stress_pa * device.body.section_m2 == pytest.approx(force_n, abs=1e-6)
    assert sample.force_n == pytest.approx(force_n, abs=0.02)


def test_the_vendors_current_contracts_it_in_about_a_second_and_it_cools_in_the_vendors_time(
    plants: ModuleType,
) -> None:
    """The catalogue's row of 0.1 mm: 200 mA for a contraction of 1 s with 143 g, 1.1 s to cool. To 40 %: still air."""
    row = next(row for row in load_catalogue().row if row.name == "0.10")
    pull_n = 9.80665e-3 * row.pull_force_g.value
    device = wire(plants, legs=1, pretension=pull_n, spring_stiffness=0.0)
    strains = []
    while device.true_time_s < 4.0:
        heating = device.true_time_s < 2.0
        ohm = device.wire_state.resistance_ohm + device.of.shunt
        device.exchange(Drive(1e-3 * row.current_ma.value * ohm if heating else 0.0))
        strains.append(device.wire_state.strain)
    contracted = np.array(strains)
    full = contracted.max()
    rise_s = 0.05 * (1 + np.argmax(contracted > 0.9 * full))
    fall_s = 0.05 * (1 + np.argmax(contracted[40:] < 0.1 * full))
    assert rise_s == pytest.approx(1.0, rel=0.4)
    assert fall_s == pytest.approx(row.cooling_lt_s.value, rel=0.4)
