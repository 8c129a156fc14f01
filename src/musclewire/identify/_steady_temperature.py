"""What a wire in still air gives off, and where it settles at a power: the heat balance of a steady wire."""

from __future__ import annotations

import math

from musclewire.parameters import Wire
from musclewire.physics import convection_coefficient_w_per_m2_k

HOTTEST_WALL_K = 3000.0


def convective_loss_w_per_m(wall_k: float, wire: Wire, ambient_temperature_k: float) -> float:
    """Return the heat loss of a metre of wire to still air [W/m]: Churchill and Chu times the convection factor."""
    diameter = wire.diameter_m.value
    coefficient = convection_coefficient_w_per_m2_k(wall_k, ambient_temperature_k, diameter)
    return wire.convection_factor.value * coefficient * math.pi * diameter * (wall_k - ambient_temperature_k)


def steady_temperature_k(power_w_per_m: float, wire: Wire, ambient_temperature_k: float) -> float:
    """Return the steady temperature [K] of a wire heated by this power [W/m].

    Radiation is neglected, as it is small for a thin wire.
    """
    low, high = ambient_temperature_k, HOTTEST_WALL_K
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (
            (middle, high)
            if convective_loss_w_per_m(middle, wire, ambient_temperature_k) < power_w_per_m
            else (low, middle)
        )
    return high
