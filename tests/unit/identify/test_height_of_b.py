"""What a model states of B, with which the first heating of a run is compared."""

from __future__ import annotations

from dataclasses import replace
from math import hypot

import numpy as np
import pytest

from musclewire.identify._use_of_model import height_of_b
from musclewire.sensing import SensingModel


def model_with(resistance_ohm: np.ndarray) -> SensingModel:
    """A model of 17 to 20 ohm with a slow loop of these resistances."""
    rows = tuple((float(row), 0.1, float(ohm)) for row, ohm in enumerate(resistance_ohm))
    return SensingModel(17.0, 20.0, (0.03, -0.03), (0.03, -0.03), 0.0, 1.0, resistance_noise_ohm=0.004, slow_loop=rows)


HEATING = np.concatenate([np.full(60, 19.8), np.linspace(19.8, 20.0, 40), np.linspace(20.0, 17.0, 60)[1:]])


def test_a_slow_loop_states_b_its_rise_and_how_far_it_repeats() -> None:
    stated = height_of_b(model_with(np.concatenate([HEATING, HEATING[::-1]])))
    assert stated["model_b_ohm"] == 20.0
    assert stated["model_c_ohm"] == 17.0
    assert stated["model_rise_ohm"] == pytest.approx(0.2, abs=1e-9)
    assert stated["model_b_std_ohm"] == pytest.approx(hypot(0.003 * 3.0, 0.004))


def test_the_cooling_of_a_loop_states_its_highest_if_it_came_to_it() -> None:
    cooled = np.concatenate([np.linspace(17.0, 19.9, 60)[1:], np.linspace(19.9, 19.7, 60)])
    stated = height_of_b(model_with(np.concatenate([HEATING, cooled])))
    assert stated["model_cooling_ohm"] == pytest.approx(19.9, abs=0.02)
    for ended in ([], cooled[:40], cooled[:57]):  # none, still warm, still rising
        stated = height_of_b(model_with(np.concatenate([HEATING, ended])))
        assert "model_cooling_ohm" not in stated
        assert "ended before its wire was cold" in str(stated["cooling_not_compared"])


def test_the_rise_is_that_of_the_cold_wire_and_not_of_its_noise() -> None:
    noisy = HEATING + np.where(np.arange(HEATING.size) < 60, 0.03 * np.random.default_rng(2).standard_normal(159), 0.0)
    assert height_of_b(model_with(noisy))["model_rise_ohm"] == pytest.approx(0.2, abs=0.02)


@pytest.mark.parametrize(
    ("model", "said"),
    [
        (replace(model_with(HEATING), slow_loop=()), "does not state its slow loop"),
        (model_with(np.linspace(20.0, 17.0, 100)), "no maximum in this model's slow loop"),
    ],
)
def test_a_model_without_b_says_why_nothing_is_compared(model: SensingModel, said: str) -> None:
    (reason,) = height_of_b(model).values()
    assert said in str(reason)
