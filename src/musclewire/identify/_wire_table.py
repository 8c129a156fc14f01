"""Current, voltage, shunt and permanent current of every wire of the catalogue at one length.

Currents, strokes and temperatures are simulated in still air; the catalogue's own current is listed next to them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from musclewire.identify._electrical_sizing import (
    OVERHEATED_K,
    ShuntChoice,
    convective_loss_w_per_m,
    one_second_current,
    suggested_shunt,
)
from musclewire.parameters import (
    Bench,
    CatalogueCell,
    Wire,
    catalogue_names,
    catalogue_row,
    load_alloy,
    load_bench,
    load_wire,
)

BENCH = "dead-weight"
# A tenth of the holding current heats by a hundredth of the holding power: about a kelvin.
SENSE_FRACTION = 0.1


class WireRow(NamedTuple):
    """One wire at one length under one stress; SI.

    ``one_second_current_a`` contracts it by 90 % in a second and must then fall to ``holding_current_a``;
    ``lasting_current_a`` is the largest permanent current below 150 C. ``supply_v`` is across wire and
    shunt at the one-second current, ``power_w`` the wire's power at it; ``amplitude_v`` is that of the slow sine.
    """

    wire: str
    cold_resistance_ohm: float
    pull_n: float
    one_second_current_a: float
    catalogue_current: CatalogueCell
    holding_current_a: float
    lasting_current_a: float
    supply_v: float
    power_w: float
    amplitude_v: float
    sense_voltage_v: float
    shunt: ShuntChoice


def wire_table(length_m: float, stress_pa: float, ambient_k: float) -> list[WireRow]:
    """Return all wires of the catalogue, thinnest first, LT before HT.

    Raises NumericsError if no current contracts a wire at this temperature.
    """
    return [wire_row(name, length_m, stress_pa, ambient_k) for name in catalogue_names()]


def wire_row(name: str, length_m: float, stress_pa: float, ambient_k: float) -> WireRow:
    """Return one wire of the catalogue."""
    wire, row = load_wire(name), catalogue_row(name)
    pull_n = stress_pa * 0.25 * math.pi * wire.diameter_m.value**2
    bench = bench_with(load_bench(BENCH), length_m, pull_n, ambient_k)
    best = one_second_current(load_alloy(wire.alloy), wire, bench)
    cold_ohm = wire.resistance_per_metre_ohm_per_m.value * length_m
    shunt = suggested_shunt(cold_ohm, best.current_a)
    circuit_ohm = cold_ohm + shunt.resistance_ohm
    return WireRow(
        wire=name,
        cold_resistance_ohm=cold_ohm,
        pull_n=pull_n,
        one_second_current_a=best.current_a,
        catalogue_current=row.current_ma,
        holding_current_a=best.holding_current_a,
        lasting_current_a=best.holding_current_a * heat_ratio(wire, best.temperature_k, ambient_k) ** 0.5,
        supply_v=best.wire_voltage_v + best.current_a * shunt.resistance_ohm,
        power_w=best.wire_voltage_v * best.current_a,
        amplitude_v=best.holding_current_a * circuit_ohm,
        sense_voltage_v=SENSE_FRACTION * best.holding_current_a * circuit_ohm,
        shunt=shunt,
    )


def heat_ratio(wire: Wire, held_k: float, ambient_k: float) -> float:
    """Return the heat loss at the working limit over that at the temperature held; resistance hardly differs."""
    return convective_loss_w_per_m(OVERHEATED_K, wire, ambient_k) / convective_loss_w_per_m(held_k, wire, ambient_k)


def bench_with(bench: Bench, length_m: float, pull_n: float, ambient_k: float) -> Bench:
    """Return the bench at a length, a weight and a temperature."""
    values = {"wire_length_m": length_m, "pretension_n": pull_n, "ambient_temperature_k": ambient_k}
    return bench.model_copy(
        update={key: getattr(bench, key).model_copy(update={"value": value}) for key, value in values.items()}
    )
