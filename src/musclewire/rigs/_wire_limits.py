"""Limits of the protection from a wire and its circuit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from musclewire.controllers import ProtectionLimits
from musclewire.errors import CallerError, nearest_hint
from musclewire.parameters import Alloy, Wire, validity_of
from musclewire.wire import HeatBalance

# Bounds of a wire's resistance over that by the maker's ohm per metre.
WINDOW_LOW = 0.85 * 0.8  # a wire is within 15 % of it, and falls by up to a fifth when it contracts
WINDOW_HIGH = 1.5  # chosen: leads, contacts and age add to a wire, and a higher bound accepts another wire
# Current and power over those that the maximum voltage drives: no other wire or draught explains more.
CURRENT_MARGIN = 1.1
POWER_MARGIN = 1.1
# A tenth of the current that the sense voltage drives: less is no contact.
OPEN_FRACTION = 0.1
# Change of resistance from one sample to the next, as a fraction, from which on it is a jump.
JUMP_FRACTION = 0.1  # three times what a wire changes by in one sample of 50 ms at its maximum voltage
JUMP_PERIOD_S = 0.05  # [s], that sample: longer ones allow more in proportion
MAX_JUMP_FRACTION = 0.5  # however long a sample is
# For an alloy whose file does not state annealing_temperature: that of Flexinol's.
MAXIMUM_TEMPERATURE_K = 473.15


class WireCircuit(NamedTuple):
    """A wire's circuit and its acquisition, in SI."""

    sense_voltage_v: float
    maximum_voltage_v: float
    shunt_resistance_ohm: float
    wire_length_m: float
    ambient_temperature_k: float
    sample_period_s: float
    wire_range_v: float
    shunt_range_v: float
    readings_noisy: bool
    in_series: int = 1  # like wires on the drive
    in_parallel: int = 1
    loss_factor: float = 1.0  # what the wire loses to what surrounds it, over its loss to still air


def limits_of(
    wire: Wire, alloy: Alloy, circuit: WireCircuit, changed: Mapping[str, float] | None = None
) -> ProtectionLimits:
    """Return the limits of a wire on a circuit, with those the user has set.

    The window of resistance comes from the maker's ohm per metre, temperature from the wire's heat capacity and its
    convection in still air. Raises CallerError for an unknown limit, suggesting the nearest, and impossible numbers.
    """
    nominal_ohm = wire.resistance_per_metre_ohm_per_m.value * circuit.wire_length_m
    nominal_ohm *= circuit.in_series / circuit.in_parallel
    low_ohm, high_ohm = WINDOW_LOW * nominal_ohm, WINDOW_HIGH * nominal_ohm
    known = {} if changed is None else dict(changed)
    low_ohm = known.get("resistance_low_ohm", low_ohm)
    high_ohm = known.get("resistance_high_ohm", high_ohm)
    lowest_v = min(circuit.sense_voltage_v, circuit.maximum_voltage_v)
    air_k, wires = circuit.ambient_temperature_k, circuit.in_series * circuit.in_parallel
    factor = circuit.loss_factor * wire["convection_factor"]
    heat = HeatBalance.of_wire(alloy, wire["diameter_m"], circuit.wire_length_m, air_k, factor, wires=wires)
    limits = ProtectionLimits(
        sense_voltage_v=circuit.sense_voltage_v,
        maximum_voltage_v=circuit.maximum_voltage_v,
        shunt_resistance_ohm=circuit.shunt_resistance_ohm,
        minimum_current_a=OPEN_FRACTION * lowest_v / (high_ohm + circuit.shunt_resistance_ohm),
        maximum_current_a=CURRENT_MARGIN * circuit.maximum_voltage_v / low_ohm,
        maximum_power_w=POWER_MARGIN * circuit.maximum_voltage_v**2 / low_ohm,
        resistance_low_ohm=low_ohm,
        resistance_high_ohm=high_ohm,
        jump_share=min(JUMP_FRACTION * max(1.0, circuit.sample_period_s / JUMP_PERIOD_S), MAX_JUMP_FRACTION),
        wire_range_v=circuit.wire_range_v,
        shunt_range_v=circuit.shunt_range_v,
        readings_noisy=float(circuit.readings_noisy),
        heat_capacity_j_per_k=heat.capacity_j_per_k,
        heat_loss_w_per_k=heat.loss_w_per_k,
        ambient_temperature_k=circuit.ambient_temperature_k,
        maximum_temperature_k=highest_temperature_k(alloy),
    )
    for name in known:
        if name not in ProtectionLimits._fields:
            raise CallerError(f"unknown limit '{name}'{nearest_hint(name, ProtectionLimits._fields)}")
    return limits._replace(**known).checked()


def highest_temperature_k(alloy: Alloy) -> float:
    """Return the highest temperature [K] that the protection allows a wire of an alloy if no file says another."""
    return validity_of(alloy).annealing_temperature_k or MAXIMUM_TEMPERATURE_K
