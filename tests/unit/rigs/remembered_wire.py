"""A wire whose temperature is kept: its limits, its board, and a moment."""

from __future__ import annotations

from musclewire.controllers import ProtectionLimits
from musclewire.rigs._remembered_temperature import Moment

__all__ = ["AMBIENT_K", "BOARD", "LIMITS", "LIMIT_K", "NOW", "REST_S", "later"]

LIMITS = ProtectionLimits(
    sense_voltage_v=0.3,
    maximum_voltage_v=3.6,
    shunt_resistance_ohm=1.0,
    minimum_current_a=0.001,
    maximum_current_a=0.4,
    maximum_power_w=1.4,
    resistance_low_ohm=10.0,
    resistance_high_ohm=26.0,
    jump_share=0.1,
    wire_range_v=5.0,
    shunt_range_v=0.3,
    readings_noisy=1.0,
    heat_capacity_j_per_k=5.4e-3,
    heat_loss_w_per_k=6e-3,
    ambient_temperature_k=295.15,
    maximum_temperature_k=473.15,
)
AMBIENT_K, LIMIT_K = LIMITS.ambient_temperature_k, LIMITS.maximum_temperature_k
BOARD, NOW = "USB 2341:0043 8573", Moment("this start", 4000.0, 0.0)
REST_S = 4.5


def later(passed_s: float) -> Moment:
    """Return a moment of the same start."""
    return NOW._replace(awake_s=NOW.awake_s + passed_s)
