"""Air that takes less heat than still air: found by the power with which a wire passes B, in a slow loop or in a run.

A wire that begins to contract is as warm as its alloy says. If less power has made it so warm than still air needs, it
loses less heat than the protection counts with: it is in a sleeve, in foam, in a still corner or in warm air. Or its
first grains turn below the alloy's temperature, as those of most drawn wires do in still air: nothing in a run tells
the two apart, so the wire counts as the hotter one until its user states the loss.
"""

from __future__ import annotations

import logging
import math

import numpy as np

from musclewire.errors import CallerError
from musclewire.parameters import load_alloy, load_wire
from musclewire.rigs import HasTrueState, Rig, ability
from musclewire.sensing import SensingModel
from musclewire.signals import RawSample
from musclewire.wire import approached

LOGGER = logging.getLogger("musclewire.rigs")
# Below this fraction of the power that still air needs, B was passed in calmer or warmer air. By the alloy's numbers
# wires of the catalogue pass it with 0.82 to 0.95 of that power.
CALM_FRACTION = 0.75
# In a run B is past when the resistance has fallen by this fraction, for the wire's own noise moves it by less. By then
# still air needs more power than at B.
FALL = 0.03
# A wire is cold, and the next B is one, when its power has been this fraction of that at B for long enough: less than
# the least heat loss below needs there, and so much that the noise of a reading, less at more current, is no fall.
COLD_FRACTION = 0.15
# Samples over which a mean of the resistance is taken, about.
SMOOTHED_OVER = 4.0
# Fractions of the heat loss whose temperatures are followed through a run, the protection's own last.
FRACTIONS = np.linspace(0.2, 1.0, 17)


def still_air_b_power_w(rig: Rig) -> float | None:
    """Return the power [W] at which a wire passes B in still air, where its first grains turn; None if not known."""
    facts, limits = rig.metadata(), rig.protection_limits
    name, force_n = facts.get("wire"), facts.get("pretension_n")
    try:
        wire = load_wire(str(name))
    except CallerError:
        return None
    alloy = load_alloy(wire.alloy)
    legs = max(1, round(float(facts.get("wire_length_m") or rig.leg_length_m) / rig.leg_length_m))
    leg_force_n = force_n / legs if isinstance(force_n, float) else wire.nominal_force_n.value
    stress_pa = leg_force_n / (0.25 * math.pi * wire.diameter_m.value**2)
    balance_k = alloy.martensite_temperature_k.value + wire.temperature_shift_k.value
    balance_k += stress_pa / alloy.martensite_stress_rate_pa_per_k.value
    return max(0.0, limits.heat.power_w(balance_k))


def heed_air(rig: Rig, model: SensingModel) -> None:
    """Lower what a rig's protection allows if a model's slow loop passed B with less power than still air needs."""
    needed_w, passed_w, rig.air_is_known = still_air_b_power_w(rig), model.b_power_w, True
    if needed_w is not None and not rig.air_is_stated and 0.0 < passed_w < CALM_FRACTION * needed_w:
        loss_w_per_k = rig.protection_limits.heat_loss_w_per_k * passed_w / needed_w
        rig.lower_heat_loss(loss_w_per_k, passed(passed_w, needed_w, "the model's slow loop"))


class AirWatch:
    """Watches a run from sample to sample for a wire that passes B with less power than still air needs.

    Temperatures are followed by the heat balance of the protection, with its heat loss and with less: that which is at
    B's temperature when the wire passes B has the wire's loss, however quickly it was heated.
    """

    def __init__(self, rig: Rig) -> None:
        """Begin with a wire that is as warm as its protection takes it to be; say once that still air is assumed."""
        if rig.paced and not (rig.air_is_known or rig.air_is_stated) and ability(rig, HasTrueState) is None:
            LOGGER.warning(
                "the wire is protected as a bare one in still air: if it is in a sleeve, in foam or in warmer air, "
                "state loss_factor or ambient_temperature in the rig file before it is heated"
            )
        rig.air_is_known = True
        self._rig, self._shunt_ohm = rig, rig.shunt_resistance_ohm
        self._needed_w = None if rig.air_is_stated else still_air_b_power_w(rig)
        limits = rig.protection_limits
        self._losses_w_per_k = FRACTIONS * limits.heat_loss_w_per_k
        self._rates_per_s = self._losses_w_per_k / limits.heat_capacity_j_per_k
        self._warmer_k = np.full(FRACTIONS.size, rig.protection.temperature_k - limits.ambient_temperature_k)
        # Highest resistance since the wire was cold, NaN until it is; and the temperatures there.
        self._ohm, self._highest_ohm, self._highest_k = 0.0, math.nan, self._warmer_k
        self._time_s: float | None = None

    def see(self, sample: RawSample) -> None:
        """Take a sample; lower what the protection allows, for as long as the rig is open, if B is past in calm air."""
        passed_s = self._rig.sample_period_s if self._time_s is None else sample.time_s - self._time_s
        self._time_s = sample.time_s
        wire_v, shunt_v = sample.wire_voltage_v, sample.shunt_voltage_v
        if self._needed_w is None or not (wire_v > 0.0 and shunt_v > 0.0):
            return
        ohm, settled_k = wire_v / shunt_v * self._shunt_ohm, wire_v * shunt_v / self._shunt_ohm / self._losses_w_per_k
        self._warmer_k = approached(self._warmer_k, settled_k, self._rates_per_s * passed_s)
        self._ohm += (ohm - self._ohm) / SMOOTHED_OVER
        power_w = float(self._losses_w_per_k[-1] * self._warmer_k[-1])
        if power_w <= COLD_FRACTION * self._needed_w:
            self._ohm, self._highest_ohm = ohm, 0.0
        if self._ohm >= self._highest_ohm:
            self._highest_ohm, self._highest_k = self._ohm, self._warmer_k
        elif self._ohm < (1.0 - FALL) * self._highest_ohm:
            self._highest_ohm = math.nan
            if power_w < self._needed_w:
                self._past(self._needed_w)

    def _past(self, needed_w: float) -> None:
        """Lower what the protection allows if still air would have left the wire too cold for B."""
        loss_w_per_k = float(self._losses_w_per_k[-1])
        passed_w, b_k = loss_w_per_k * float(self._highest_k[-1]), needed_w / loss_w_per_k
        if passed_w < CALM_FRACTION * needed_w:
            fraction = float(np.interp(b_k, self._highest_k[::-1], FRACTIONS[::-1]))
            self._rig.lower_heat_loss(fraction * loss_w_per_k, passed(passed_w, needed_w, "the wire"))


def passed(passed_w: float, needed_w: float, what: str) -> str:
    """Return in words that B was passed with less power than still air needs."""
    return f"{what} passed B with {passed_w:.3g} W where still air needs {needed_w:.3g} W"
