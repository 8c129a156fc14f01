"""The table of wires before parts are bought: what each wire of the catalogue needs at a length, in still air.

Currents come from fast simulated runs and from the heat balance, not from measurements; the catalogue's own current is
listed next to ours. Shunt, voltages and pretension are those that a rig gives a wire whose file states none.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from musclewire.extras.supply._one_second import one_second_current
from musclewire.parameters import CatalogueCell, catalogue_names, catalogue_row, load_alloy, load_bench, load_wire
from musclewire.rigs import OwnCircuit, own_circuit

BENCH = "dead-weight"
# A shunt is rated for this multiple of its power, by a size that is sold.
RATING_FACTOR = 3.0
RATINGS_W = (0.125, 0.25, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 25.0, 50.0)


class ShuntChoice(NamedTuple):
    """A shunt, its power at the largest current that flows through it, and a standard rating."""

    resistance_ohm: float
    power_w: float
    rating_w: float


class WireRow(NamedTuple):
    """One wire at one length under one stress; SI."""

    wire: str
    cold_resistance_ohm: float
    pull_n: float
    one_second_current_a: float  # contracts it by 90 % in a second and must then fall to ``holding_current_a``
    catalogue_current: CatalogueCell
    holding_current_a: float
    lasting_current_a: float  # largest permanent current below 150 C
    supply_v: float  # across wire and shunt at the one-second current
    power_w: float  # of the wire at it
    sense_voltage_v: float  # this and the rest are of a rig file
    amplitude_v: float  # of the slow sine
    maximum_voltage_v: float
    pretension_n: float  # of a V
    shunt: ShuntChoice


def wire_table(length_m: float, stress_pa: float, ambient_k: float) -> list[WireRow]:
    """Return all wires of the catalogue, thinnest first, LT before HT; NumericsError if no current contracts one."""
    return [wire_row(name, length_m, stress_pa, ambient_k) for name in catalogue_names()]


def wire_row(name: str, length_m: float, stress_pa: float, ambient_k: float) -> WireRow:
    """Return one wire of the catalogue."""
    wire, row = load_wire(name), catalogue_row(name)
    pull_n = stress_pa * 0.25 * math.pi * wire.diameter_m.value**2
    bench = load_bench(BENCH).with_values(wire_length_m=length_m, pretension_n=pull_n, ambient_temperature_k=ambient_k)
    best = one_second_current(load_alloy(wire.alloy), wire, bench)
    own = own_circuit(name, wire_length_m=length_m, ambient_temperature_k=ambient_k)
    return WireRow(
        wire=name,
        cold_resistance_ohm=wire.resistance_per_metre_ohm_per_m.value * length_m,
        pull_n=pull_n,
        one_second_current_a=best.current_a,
        catalogue_current=row.current_ma,
        holding_current_a=best.holding_current_a,
        lasting_current_a=own.lasting_current_a,
        supply_v=best.wire_voltage_v + best.current_a * own.shunt_ohm,
        power_w=best.wire_voltage_v * best.current_a,
        sense_voltage_v=own.sense_voltage_v,
        amplitude_v=own.amplitude_v,
        maximum_voltage_v=own.maximum_v,
        pretension_n=own.pretension_n,
        shunt=rated_shunt(own, best.current_a),
    )


def rated_shunt(own: OwnCircuit, one_second_current_a: float) -> ShuntChoice:
    """Return a wire's shunt with its power at the larger of its two currents, and the rating to buy."""
    power = max(one_second_current_a, own.lasting_current_a) ** 2 * own.shunt_ohm
    rating = next((size for size in RATINGS_W if size >= RATING_FACTOR * power), RATINGS_W[-1])
    return ShuntChoice(own.shunt_ohm, power, rating)
