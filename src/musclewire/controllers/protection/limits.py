"""What one wire on one circuit may do: the numbers the protection table is held against."""

from __future__ import annotations

from math import inf, isfinite
from typing import NamedTuple

from musclewire.errors import CallerError

__all__ = ["ProtectionLimits"]


class ProtectionLimits(NamedTuple):
    """Limits of a wire and ranges of its circuit, all SI. Plain numbers: the C library carries the same list.

    Attributes:
        sense_voltage_v: drive that heats by little and still lets resistance be measured.
        maximum_voltage_v: highest drive that may be commanded.
        shunt_resistance_ohm: R of Eq. 1 (Lan and Fan 2010).
        minimum_current_a: below this a driven wire counts as open.
        maximum_current_a: above this is over-current.
        maximum_power_w: above this is over-power.
        resistance_low_ohm: least resistance this wire can have, whatever its state.
        resistance_high_ohm: most resistance it can have.
        jump_share: change of resistance from one reading to the next, as a fraction of it, that no heating explains.
        wire_range_v: end of the range of the channel at the wire.
        shunt_range_v: end of the range of the channel at the shunt.
        readings_noisy: whether noise moves every reading, so that equal numbers in a row mean a frozen channel; 1 or 0.
        heat_capacity_j_per_k: m c of the wire.
        heat_loss_w_per_k: G, what the wire gives to the air.
        ambient_temperature_k: temperature of the air.
        maximum_temperature_k: highest estimated temperature allowed.
    """

    sense_voltage_v: float
    maximum_voltage_v: float
    shunt_resistance_ohm: float
    minimum_current_a: float
    maximum_current_a: float
    maximum_power_w: float
    resistance_low_ohm: float
    resistance_high_ohm: float
    jump_share: float
    wire_range_v: float
    shunt_range_v: float
    readings_noisy: float
    heat_capacity_j_per_k: float
    heat_loss_w_per_k: float
    ambient_temperature_k: float
    maximum_temperature_k: float

    def checked(self) -> ProtectionLimits:
        """Return the limits themselves. Raises CallerError where they cannot belong to a wire."""
        for name, value in self._asdict().items():
            may_be_infinite = name.startswith("maximum_") and name != "maximum_voltage_v"
            if not (value > 0.0 or name == "readings_noisy") or (not isfinite(value) and not may_be_infinite):
                raise CallerError(f"the limit {name} is {value:g} and must be above 0 and finite")
        for lower, upper in (
            ("sense_voltage_v", "maximum_voltage_v"),
            ("minimum_current_a", "maximum_current_a"),
            ("resistance_low_ohm", "resistance_high_ohm"),
            ("ambient_temperature_k", "maximum_temperature_k"),
        ):
            if not getattr(self, lower) < getattr(self, upper) <= inf:
                raise CallerError(
                    f"the limit {lower} {getattr(self, lower):g} must be below {upper} {getattr(self, upper):g}"
                )
        return self
