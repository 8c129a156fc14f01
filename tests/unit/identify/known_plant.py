"""A wire whose loss and branches are straight lines, for the tests of tuning and of speed limits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from musclewire.controllers import FeedforwardSettings, sampled_reference
from musclewire.sensing import SensingModel

__all__ = ["COOLING_W", "HEATING_W", "LIMITS", "MODEL", "TAU_S", "plant_settings", "sine"]

TAU_S, COOLING_W, HEATING_W = 0.8, (0.25, 0.40), (0.35, 0.50)
LIMITS: dict[str, Any] = {
    "limit_heat_capacity_j_per_k": 0.0044,
    "limit_heat_loss_w_per_k": 0.0055,
    "limit_maximum_temperature_k": 473.15,
    "limit_ambient_temperature_k": 295.15,
}
MODEL = SensingModel(15.0, 17.5, (0.035, -0.03), (0.035, -0.03), 0.0, 1.0)


def plant_settings(**changed: Any) -> FeedforwardSettings:
    """Return the gains of the wire, with some of them changed."""
    known: dict[str, Any] = {
        "lowest": 0.005,
        "highest": 0.035,
        "heating_power_w": tuple(np.linspace(*HEATING_W, 33)),
        "cooling_power_w": tuple(np.linspace(*COOLING_W, 33)),
        "resistance_ohm": tuple(np.linspace(17.4, 15.2, 33)),
        "shunt_resistance_ohm": 1.0,
        "thermal_time_constant_s": TAU_S,
        "heat_per_unit": 0.0,
        "closed_loop_time_s": 0.1,
        "dead_time_s": 0.1,
        "integral_time_s": 0.8,
        "maximum_steady_power_w": 0.98,
    }
    return FeedforwardSettings(**{**known, **changed})


def sine(frequency_hz: float, amplitude: float = 0.0075) -> Any:
    time_s = np.arange(0.0, 6.0 / frequency_hz, 0.05)
    return sampled_reference(time_s, 0.02 + amplitude * np.sin(2.0 * math.pi * frequency_hz * time_s))
