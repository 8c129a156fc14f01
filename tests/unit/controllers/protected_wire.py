"""A wire whose protection is tried: its limits, the voltages that a resistance gives, and states out of states.

The functions make each state from another one, which they leave alone, by the protection that every rig has.
"""

from __future__ import annotations

import numpy as np

from musclewire.controllers import (
    PROTECTION,
    Event,
    Protection,
    ProtectionLimits,
    ProtectionState,
    ProtectionTable,
)

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


def protection_in(
    state: ProtectionState, limits: ProtectionLimits = LIMITS, table: ProtectionTable | None = None
) -> Protection:
    """A protection that has come to a state."""
    protection = Protection(limits, table=table)
    protection.row[:] = np.array([tuple(state)], PROTECTION)
    return protection


def armed(limits: ProtectionLimits) -> ProtectionState:
    return Protection(limits).state


def protect_command(
    state: ProtectionState, limits: ProtectionLimits, volts: float, table: ProtectionTable | None = None
) -> ProtectionState:
    protection = protection_in(state, limits, table)
    protection.command(volts)
    return protection.state


def protect_reading(
    state: ProtectionState,
    limits: ProtectionLimits,
    drive_v: float,
    wire_v: float,
    shunt_v: float,
    dt_s: float,
    table: ProtectionTable | None = None,
) -> ProtectionState:
    protection = protection_in(state, limits, table)
    protection.reading(drive_v, wire_v, shunt_v, dt_s)
    return protection.state


def protect_missing(state: ProtectionState, event: Event, missing_s: float) -> ProtectionState:
    protection = protection_in(state)
    protection.missing(event, missing_s)
    return protection.state


def tripped_by(state: ProtectionState, event: Event) -> ProtectionState:
    protection = protection_in(state)
    protection.trip(event)
    return protection.state


def closed(state: ProtectionState) -> ProtectionState:
    protection = protection_in(state)
    protection.close()
    return protection.state


def rested(state: ProtectionState, limits: ProtectionLimits) -> ProtectionState:
    protection = protection_in(state, limits)
    protection.rest()
    return protection.state


def armed_again(state: ProtectionState, limits: ProtectionLimits) -> ProtectionState:
    protection = protection_in(state, limits)
    protection.arm()
    return protection.state


def allowed_drive_v(state: ProtectionState, limits: ProtectionLimits) -> float:
    return protection_in(state, limits).allowed_drive_v
