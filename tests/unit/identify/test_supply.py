"""A supply too weak from cold is named beforehand: which step, by how much, and what voltage suffices."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from known_plant import LIMITS, MODEL, TAU_S, plant_settings

import musclewire as mw
from musclewire.controllers import FeedforwardSettings, staircase
from musclewire.identify import speed_limits_of
from musclewire.identify._speed_limits.plant import plant_of_gains
from musclewire.identify._speed_limits.supply import LATE_PCT, min_errors_pct, warming_s
from musclewire.signals import RunFacts, reference_quantity

PERIOD_S = 0.05


def facts(maximum_v: float) -> RunFacts:
    """Return what a rig of this maximum voltage states."""
    stated = {
        **LIMITS,
        "limit_sense_voltage_v": 0.2,
        "limit_maximum_voltage_v": maximum_v,
        "sample_period_s": PERIOD_S,
        "shunt_resistance_ohm": 1.0,
    }
    return RunFacts(stated, "the rig")


def test_a_cold_wire_without_latent_heat_warms_as_a_first_order_lag_does() -> None:
    plant = plant_of_gains(plant_settings(heat_per_unit=0.0), facts(3.0))
    cold_w, lowest_w, drive_w = (row[0] for row in (plant.lowest_power_w, plant.heating_power_w, plant.highest_power_w))
    expected_s = TAU_S * math.log((drive_w - cold_w) / (drive_w - lowest_w))
    assert warming_s(plant, 0.1) == pytest.approx(0.1 + expected_s)


def test_a_supply_that_cannot_hold_the_lowest_level_never_warms_it() -> None:
    plant = plant_of_gains(plant_settings(), facts(0.6))
    assert warming_s(plant, 0.1) == math.inf
    assert min_errors_pct(plant, staircase(), PERIOD_S, 0.1) == pytest.approx(100.0)


def test_a_weak_supply_is_named_and_the_voltage_that_is_named_suffices() -> None:
    weak = facts(3.3)
    settings = plant_settings(heat_per_unit=20.0)
    found = speed_limits_of(MODEL, staircase(), weak, settings, from_cold=True).supply
    assert found is not None
    assert found.step == 1
    assert found.error_pct > LATE_PCT
    assert found.sufficient_voltage_v is not None
    stronger = facts(1.01 * found.sufficient_voltage_v)
    assert speed_limits_of(MODEL, staircase(), stronger, settings, from_cold=True).supply is None
    # Who begins at the first target has no cold wire to warm.
    assert speed_limits_of(MODEL, staircase(), weak, settings).supply is None


@pytest.mark.parametrize("wire", ["paper-100um", "paper-200um"])
def test_the_time_from_cold_is_that_of_the_simulated_wire(wire: str) -> None:
    with mw.open_rig("simulated", seed=1, wire=wire) as rig:
        model = mw.fit(mw.characterize(rig))
    with mw.open_rig("simulated", seed=7, wire=wire) as rig:
        limits = mw.speed_limits(rig, model, from_cold=True)
        run = mw.control(rig, model)
    gains: dict[str, Any] = dict(model.gains)
    gains.pop("controller")
    stated = RunFacts(run.metadata, "the run")
    predicted_s = warming_s(plant_of_gains(FeedforwardSettings(**gains), stated), gains["dead_time_s"])
    strain = reference_quantity(run, "strain")
    assert strain is not None
    passed_s = PERIOD_S * (1 + int(np.argmax(strain >= model.quantity_min)))
    assert 0.8 * passed_s <= predicted_s <= 1.05 * passed_s
    # The 200 um wire at its 2.3 V is the one that comes late.
    assert (limits.supply is not None) == (wire == "paper-200um")
    assert ("supply is too weak for step 1" in str(run.metadata.get("speed_limits", ""))) == (wire == "paper-200um")
