"""A wire whose protection is tried: its limits, and the voltages that a resistance gives."""

from __future__ import annotations

from musclewire.controllers import ProtectionLimits

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
    maximum_temperature_k=373.15,
)
Reading = tuple[float, float, float]


def of_wire(drive_v: float, ohm: float) -> Reading:
    """Drive, wire and shunt voltage of a wire with a resistance."""
    current_a = drive_v / (ohm + 1.0)
    return drive_v, current_a * ohm, current_a
