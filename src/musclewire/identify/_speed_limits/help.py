"""What would let a wire follow, each by itself: moving air, a thinner wire, an antagonist, more voltage, more time.

Loss over capacity of a wire is 4 h / (rho c d). With h of Churchill and Chu, for fine wires nearly k Nu / d with a
Nusselt number that hardly changes, it is proportional to the diameter to a power of about -1.8. At the same stress and
voltage per length all else in the heat balance of a unit of volume stays: a thinner wire does what moving air does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Set
from functools import partial
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.identify._speed_limits.plant import SpeedPlant
from musclewire.identify._tuning import alloy_of, heat_balance
from musclewire.parameters import Alloy, section_m2, validity_of
from musclewire.physics import convection_coefficient_w_per_m2_k
from musclewire.sensing import SensingModel
from musclewire.signals import RunFacts

Misses = Callable[[SpeedPlant, float], FloatArray]

# Changes by more than this factor are no advice.
MAX_FACTOR, BISECTIONS = 16.0, 9
# The thinnest wire that vendors list.
THINNEST_M = 25e-6
# Temperature at which losses to the air are compared: that of a contracted wire.
HOT_K = 373.15
# Heat that a voltage without limit gives, for what only cooling limits.
AMPLE = 100.0


class SufficientChanges(NamedTuple):
    """What each change alone must be, so that the wire follows; None if it is not needed or does not suffice.

    Parameters
    ----------
    slower
        Factor by which the whole reference takes longer.
    heat_loss
        Factor on the heat loss to the air, as by moving air.
    diameter_m
        Diameter of the wire [m] at the same stress.
    diameter_power
        Power of the diameter with which loss over capacity goes, between both diameters.
    pull
        Force of that wire over the force of this one.
    antagonist_stress_pa
        Stress [Pa] that an antagonist adds while the wire cools, which raises its transformation temperatures.
    voltage
        Factor on the maximum voltage, for heating.
    """

    slower: float | None = None
    heat_loss: float | None = None
    diameter_m: float | None = None
    diameter_power: float | None = None
    pull: float | None = None
    antagonist_stress_pa: float | None = None
    voltage: float | None = None

    def text(self, direction: str) -> str:
        """Return what helps cooling or heating, in words with numbers."""
        ways = []
        if direction == "heating":
            if self.voltage is not None:
                ways.append(f"{self.voltage:.2f} times the maximum voltage, within the wire's limits")
        elif self.heat_loss is not None:
            ways.append(f"{self.heat_loss:.2g} times the heat loss (moving air)")
        if direction == "cooling" and self.diameter_m is not None and self.pull is not None:
            ways.append(
                f"a wire of {1e6 * self.diameter_m:.0f} um (loss over capacity is proportional to diameter to the "
                f"power {self.diameter_power:.1f}; its pull falls to {100 * self.pull:.0f} %)"
            )
        if direction == "cooling" and self.antagonist_stress_pa is not None:
            ways.append(f"an antagonist that adds {1e-6 * self.antagonist_stress_pa:.0f} MPa while the wire cools")
        if self.slower is not None:
            ways.append(f"a reference {self.slower:.3g} times slower")
        return ", or ".join(ways) or f"no single change by less than {MAX_FACTOR:g} times; a smaller amplitude"


def what_helps(
    plant: SpeedPlant, misses: Misses, tolerance: float, slow: Set[str], model: SensingModel, facts: RunFacts
) -> SufficientChanges:
    """Return what each change alone must be; ``misses`` are those of a plant on the reference taken slower."""
    if not slow:
        return SufficientChanges()

    def follows(changed: SpeedPlant, slower: float = 1.0, sides: Set[str] = slow) -> bool:
        missed = misses(changed, slower)
        cools = "cooling" not in sides or bool((missed <= tolerance).all())
        return cools and ("heating" not in sides or bool((missed >= -tolerance).all()))

    found = SufficientChanges(slower=smallest(partial(follows, plant), MAX_FACTOR))
    if "heating" in slow:
        heats = {"heating"}
        found = found._replace(voltage=smallest(lambda x: follows(plant.with_voltage(x), sides=heats), MAX_FACTOR))
    if "cooling" not in slow:
        return found
    cools, ample = {"cooling"}, plant.with_voltage(AMPLE)
    loss = smallest(lambda x: follows(ample.with_loss(x), sides=cools), MAX_FACTOR)
    stress = stress_pa(lambda power_w: follows(ample.with_warmer_cooling(power_w), sides=cools), model, facts)
    return found._replace(heat_loss=loss, antagonist_stress_pa=stress, **thinner(loss, facts))


def stress_pa(follows: Callable[[float], bool], model: SensingModel, facts: RunFacts) -> float | None:
    """Return the stress [Pa] by which the cooling branch is warm enough to follow, None if the vendor's is too low.

    ``follows`` takes the power [W] by which the branch is warmer: stress over C_M (Clausius-Clapeyron), times the loss.
    """
    alloy = alloy_of(model)
    per_pa = heat_balance(facts).loss_w_per_k / alloy.martensite_stress_rate_pa_per_k.value
    room_pa = room_for_stress_pa(alloy, facts)
    factor = smallest(lambda x: follows((x - 1.0) * room_pa * per_pa), 2.0)
    return None if factor is None else (factor - 1.0) * room_pa


def smallest(follows: Callable[[float], bool], largest: float) -> float | None:
    """Return the smallest factor from 1 on with which a wire follows, None if the largest is not enough."""
    if not follows(largest):
        return None
    low, high = 0.0, math.log(largest)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if follows(math.exp(middle)) else (middle, high)
    return math.exp(high)


def room_for_stress_pa(alloy: Alloy, facts: RunFacts) -> float:
    """Return the stress [Pa] that may be added to that of the pretension within the vendor's; 0 at least."""
    diameter, pretension = facts.positive_or_none("wire_diameter_m"), facts.number_or_none("pretension_n")
    working = validity_of(alloy).working_stress_pa
    if working is None:
        return 0.0
    if diameter is None or pretension is None:
        return working
    whole, leg = facts.positive_or_none("wire_length_m"), facts.leg_length_or_none_m
    legs = 1.0 if whole is None or leg is None else whole / leg
    return max(working - pretension / section_m2(diameter, legs), 0.0)


def thinner(loss: float | None, facts: RunFacts) -> dict[str, float]:
    """Return diameter, power and pull of a wire that loses heat so many times as fast; none if no wire does."""
    diameter = facts.positive_or_none("wire_diameter_m")
    ambient_k = facts.positive_or_none("limit_ambient_temperature_k")
    if loss is None or diameter is None or ambient_k is None:
        return {}
    found = diameter_for(loss, diameter, ambient_k)
    if found < THINNEST_M:
        return {}
    power = math.log(loss) / math.log(found / diameter) if found < diameter else float("nan")
    return {"diameter_m": found, "diameter_power": power, "pull": (found / diameter) ** 2}


def diameter_for(factor: float, diameter_m: float, ambient_k: float) -> float:
    """Return the diameter [m] at which loss over capacity in still air is so many times that of another one."""

    def per_capacity(one_m: float) -> float:
        return float(convection_coefficient_w_per_m2_k(HOT_K, ambient_k, one_m)) / one_m

    grid = np.geomspace(diameter_m / 32.0, diameter_m, 400)
    ratio = np.array([per_capacity(float(one)) for one in grid]) / per_capacity(diameter_m)
    return float(np.exp(np.interp(-math.log(factor), -np.log(ratio), np.log(grid))))
