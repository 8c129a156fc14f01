"""How warm a wire is as one body in air: C dT/dt = P - G (T - T_air), without its phases.

The protection goes by it, and all that is said of a wire's warmth without simulating it. Symbols: C heat capacity, G
loss to the air, P power, T temperature.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple, Self, TypeVar

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inner
from musclewire.parameters import Alloy
from musclewire.physics import convection_coefficient_w_per_m2_k
from musclewire.signals import RunFacts
from musclewire.wire._row import CONVECTION_POINTS

# The loss of a wire is stated at the higher of these temperatures:
HOT_K = 373.15  # [K] of a contracted wire
ABOVE_K = 50.0  # [K] above the air
# How often a loss that grows with temperature is put in: each time less than a third of the error is left.
ROUNDS = 40
TABLE_START_K = 200.0  # [K] at which the table of convection begins: colder than any laboratory
TABLE_STEP_K = 2.0  # [K] between its entries
Quantity = TypeVar("Quantity", float, FloatArray)


class HeatBalance(NamedTuple):
    """Heat capacity, loss and air of a wire, of all equal wires on a drive together."""

    capacity_j_per_k: float  # C
    loss_w_per_k: float  # G
    air_k: float
    # Of a wire whose loss is that of a hot one and grows with temperature as that to still air does; None for a
    # constant loss, which is the protection's.
    diameter_m: float | None = None

    @classmethod
    def of_wire(
        cls, alloy: Alloy, diameter_m: float, length_m: float, air_k: float, factor: float = 1.0, *, wires: int = 1
    ) -> Self:
        """Return the balance of so many wires in still air, with a factor of their loss."""
        volume = math.pi / 4.0 * diameter_m**2 * length_m * wires
        coefficient = convection_coefficient_w_per_m2_k(max(HOT_K, air_k + ABOVE_K), air_k, diameter_m)
        loss = factor * coefficient * math.pi * diameter_m * length_m * wires
        capacity = volume * alloy.density_kg_per_m3.value * alloy.specific_heat_j_per_kg_k.value
        return cls(capacity, loss, air_k, diameter_m)

    @classmethod
    def stated_in(cls, facts: RunFacts) -> Self:
        """Return the balance by which a rig was protected. Raises RecordingError if its facts do not state it."""
        air_k = facts.limit_ambient_temperature_k
        return cls(facts.limit_heat_capacity_j_per_k, facts.limit_heat_loss_w_per_k, air_k)

    @property
    def lag_s(self) -> float:
        """C / G, the thermal time constant [s]."""
        return self.capacity_j_per_k / self.loss_w_per_k

    def with_loss_at(self, temperature_k: float) -> Self:
        """Return the balance with the constant loss of a wire at a temperature."""
        if self.diameter_m is None:
            return self
        here, hot = (
            convection_coefficient_w_per_m2_k(wall_k, self.air_k, self.diameter_m)
            for wall_k in (temperature_k, max(HOT_K, self.air_k + ABOVE_K))
        )
        return self._replace(loss_w_per_k=self.loss_w_per_k * here / hot, diameter_m=None)

    def power_w(self, temperature_k: float) -> float:
        """Return the power [W] that holds a wire at a temperature: what it gives off there."""
        return self.with_loss_at(temperature_k).loss_w_per_k * (temperature_k - self.air_k)

    def steady_k(self, power_w: float) -> float:
        """Return the temperature [K] that a power holds."""
        found_k = self.air_k
        for _ in range(ROUNDS):
            found_k = self.air_k + power_w / self.with_loss_at(found_k).loss_w_per_k
        return found_k

    def after_k(self, temperature_k: float, power_w: float, time_s: float) -> float:
        """Return the temperature [K] after a time at a constant power, for a constant loss."""
        return float(approached(temperature_k, self.steady_k(power_w), time_s / self.lag_s))

    def along_k(
        self, time_s: FloatArray, power_w: FloatArray, place: FloatArray, heat_j: float, begins_k: float
    ) -> FloatArray:
        """Return temperatures at times for mean powers between; from ``place`` 0 to 1 the wire takes ``heat_j``."""
        table = np.ones(CONVECTION_POINTS) if self.diameter_m is None else convection_table(self.diameter_m, self.air_k)
        losses_w_per_k = self.with_loss_at(TABLE_START_K).loss_w_per_k * (table / table[0])
        along_k = np.full(time_s.size, begins_k)
        # Copies: a recording's columns are read-only, which would be compiled apart.
        columns = tuple(np.array(one) for one in (time_s, power_w, place))
        write_temperatures(columns, (heat_j, self.capacity_j_per_k, self.air_k), losses_w_per_k, along_k)
        return along_k


@lru_cache(maxsize=64)
def convection_table(diameter_m: float, ambient_temperature_k: float) -> FloatArray:
    """Return the convection coefficient every 2 K from 200 K to 800 K at one ambient temperature, (301,)."""
    walls_k = (TABLE_START_K + TABLE_STEP_K * place for place in range(CONVECTION_POINTS))
    return np.array([convection_coefficient_w_per_m2_k(k, ambient_temperature_k, diameter_m) for k in walls_k])


def approached(value: Quantity, steady: Quantity, lags: Quantity) -> Quantity:
    """Return what has become of a value on its way to a steady one after so many time constants."""
    return steady + (value - steady) * np.exp(-lags)


approached_inside = compiled_inner(approached)


@compiled_inner
def warmed_k(above_k: float, power_w: float, dt_s: float, capacity_j_per_k: float, loss_w_per_k: float) -> float:
    """Return how far above the air a wire is [K] after a step at a constant power, without an exponential, as in C.

    Of second order, stable for any ``dt_s``, and never colder than by the exponential in a wire that cools.
    """
    rate = loss_w_per_k / capacity_j_per_k * dt_s
    rise_k = dt_s * power_w / capacity_j_per_k * (1.0 + 0.5 * rate)
    return (above_k + rise_k) / (1.0 + rate + 0.5 * rate * rate)


@compiled
def write_temperatures(
    columns: tuple[FloatArray, ...],
    numbers: tuple[float, float, float],
    losses_w_per_k: FloatArray,
    temperature_k: FloatArray,
) -> None:
    """Write the temperatures [K] after the given first one; a loss that grows is that of a step's beginning."""
    (time_s, power_w, place), (heat_j, capacity, air_k) = columns, numbers
    for row in range(1, time_s.size):
        spot = min(max((temperature_k[row - 1] - TABLE_START_K) / TABLE_STEP_K, 0.0), CONVECTION_POINTS - 2.0)
        low = int(spot)
        loss = losses_w_per_k[low] + (spot - low) * (losses_w_per_k[low + 1] - losses_w_per_k[low])
        dt_s, taken_j = time_s[row] - time_s[row - 1], heat_j * (place[row] - place[row - 1])
        if dt_s <= 0.0:  # a clock that is rounded: the limit of what follows
            temperature_k[row] = temperature_k[row - 1] - taken_j / capacity
            continue
        given_w = 0.5 * (power_w[row] + power_w[row - 1]) - taken_j / dt_s
        steady_k = air_k + given_w / loss
        temperature_k[row] = approached_inside(temperature_k[row - 1], steady_k, dt_s * loss / capacity)
