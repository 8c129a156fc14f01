"""Electrical sizing of a wire before parts are bought: the current that contracts it in time, the supply, the shunt.

The numbers come from fast simulated runs (``wire._paths``) and from the heat balance, not from measurements. A table
has every wire of the catalogue at one length, in still air; the catalogue's own current is listed next to ours.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from musclewire.errors import NumericsError
from musclewire.parameters import (
    Alloy,
    Bench,
    CatalogueCell,
    Wire,
    catalogue_names,
    catalogue_row,
    load_alloy,
    load_bench,
    load_wire,
)
from musclewire.physics import convection_coefficient_w_per_m2_k
from musclewire.wire import DrivenPath, WireConstants, WireState, constants_from, drive_path, resting_state

# A working limit, assumed: the vendor warns of overheating, but no number of the vendor's could be checked. 150 C is
# above the end of the transformation of 90 C wire under 172 MPa, and far below what anneals NiTi.
OVERHEATED_K = 423.15
# A wire counts as contracted at this fraction of its full stroke.
CONTRACTED_FRACTION = 0.9
MAX_CURRENT_A_PER_M2 = 1e9
BISECTIONS = 30
STEP_S, COARSE_STEP_S = 2e-3, 5e-3
# A wire counts as relaxed below this contraction.
RELAXED_STRAIN = 0.0025
# At this temperature no wire has martensite left; heating further only expands the metal.
HOT_K = 480.0
HOTTEST_WALL_K = 3000.0
# A shunt drops at most this fraction of the cold wire's voltage, and is rated for this multiple of its power.
SHUNT_FRACTION, RATING_FACTOR = 0.05, 3.0
SHUNT_STEPS = (1.0, 2.2, 4.7)
RATINGS_W = (0.125, 0.25, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 25.0, 50.0)


class OneSecondDrive(NamedTuple):
    """Current and voltage that contract a simulated wire by 90 % of its stroke in one second.

    ``holding_current_a`` then holds it: its steady temperature is the one reached after the second.
    """

    current_a: float
    wire_voltage_v: float
    stroke: float
    temperature_k: float
    holding_current_a: float


class ShuntChoice(NamedTuple):
    """A shunt of a standard value, its power at the current it was chosen for, and a standard rating."""

    resistance_ohm: float
    power_w: float
    rating_w: float


def heat(
    constants: WireConstants, current_a: float, seconds: float, step_s: float = STEP_S
) -> tuple[DrivenPath, WireState]:
    """Return path and final state of a cold wire at rest under a constant current, in steps of about ``step_s``."""
    samples = max(round(seconds / step_s), 1)
    return drive_path(
        constants,
        np.full(samples, current_a),
        sample_s=seconds / samples,
        state=resting_state(constants),
        regulated_current=True,
    )


def full_stroke(constants: WireConstants) -> float:
    """Return the largest contraction of a wire on its bench, spring or weight, over a complete transformation."""
    current = 1e7 * constants.area_m2
    while current < MAX_CURRENT_A_PER_M2 * constants.area_m2:
        path, state = heat(constants, current, 2.0)
        if state.temperature_k > HOT_K:
            return float(path.displacement_m.max() / constants.leg_length_m)
        current *= 1.25
    raise NumericsError(
        f"no current up to {current:.3g} A transforms this wire completely: check diameter, resistance and convection"
    )


def contracting_current_a(constants: WireConstants, seconds: float, displacement_m: float) -> float:
    """Return the smallest current [A] that contracts a cold wire by a displacement within a time, by bisection."""
    low, high = 0.0, MAX_CURRENT_A_PER_M2 * constants.area_m2
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        path, _ = heat(constants, middle, seconds)
        # A current far too large expands the hot metal again: it is enough that the displacement was reached.
        if path.displacement_m.max() >= displacement_m:
            high = middle
        else:
            low = middle
        if high - low < 1e-4 * high:
            break
    return high


def one_second_current(
    alloy: Alloy, wire: Wire, bench: Bench, *, seconds: float = 1.0, fraction: float = CONTRACTED_FRACTION
) -> OneSecondDrive:
    """Return the current that brings a cold wire to a fraction of its stroke after ``seconds`` on this bench.

    It is found by bisection, for a current source. Raises NumericsError if no current suffices.
    """
    constants = constants_from(alloy, wire, bench)
    stroke = full_stroke(constants)
    current_a = contracting_current_a(constants, seconds, fraction * stroke * constants.leg_length_m)
    path, state = heat(constants, current_a, seconds)
    power_w = constants.wire_length_m * convective_loss_w_per_m(
        state.temperature_k, wire, constants.ambient_temperature_k
    )
    return OneSecondDrive(
        current_a,
        float(path.wire_voltage_v.max()),
        stroke,
        state.temperature_k,
        math.sqrt(power_w / state.resistance_ohm),
    )


def relaxation_time_s(
    alloy: Alloy, wire: Wire, bench: Bench, drive: float, on_s: float, *, regulated_current: bool, max_s: float
) -> float:
    """Return the time [s] after ``on_s`` of a drive until a quarter percent of strain is left, at most ``max_s``.

    ``drive`` is a current [A] with ``regulated_current``, else a voltage [V].
    """
    constants = constants_from(alloy, wire, bench)
    samples = max(round(on_s / COARSE_STEP_S), 1)
    on = np.full(samples, drive)
    _, state = drive_path(constants, on, sample_s=on_s / samples, regulated_current=regulated_current)
    off = np.zeros(round(max_s / COARSE_STEP_S))
    path, _ = drive_path(constants, off, sample_s=COARSE_STEP_S, state=state)
    stretched = np.flatnonzero(path.displacement_m > RELAXED_STRAIN * constants.leg_length_m)
    return COARSE_STEP_S * (int(stretched[-1]) + 1) if stretched.size else 0.0


def convective_loss_w_per_m(wall_k: float, wire: Wire, ambient_temperature_k: float) -> float:
    """Return the heat loss of a metre of wire to still air [W/m]: Churchill and Chu times the convection factor."""
    diameter = wire.diameter_m.value
    coefficient = convection_coefficient_w_per_m2_k(wall_k, ambient_temperature_k, diameter)
    return wire.convection_factor.value * coefficient * math.pi * diameter * (wall_k - ambient_temperature_k)


def steady_temperature_k(power_w_per_m: float, wire: Wire, ambient_temperature_k: float) -> float:
    """Return the steady temperature [K] of a wire heated by this power [W/m].

    Radiation is neglected, as it is small for a thin wire.
    """
    low, high = ambient_temperature_k, HOTTEST_WALL_K
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (
            (middle, high)
            if convective_loss_w_per_m(middle, wire, ambient_temperature_k) < power_w_per_m
            else (low, middle)
        )
    return high


def suggested_shunt(cold_resistance_ohm: float, current_a: float) -> ShuntChoice:
    """Return the largest standard shunt that drops at most a twentieth of the cold wire's voltage, and its rating."""
    wanted = SHUNT_FRACTION * cold_resistance_ohm
    decade = 10.0 ** math.floor(math.log10(wanted))
    resistance = max(step * decade for step in SHUNT_STEPS if step * decade <= wanted * (1.0 + 1e-9))
    resistance = float(f"{resistance:.3g}")  # 0.22, not 0.22000000000000003
    power = current_a**2 * resistance
    rating = next((size for size in RATINGS_W if size >= RATING_FACTOR * power), RATINGS_W[-1])
    return ShuntChoice(resistance, power, rating)


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
    bench = load_bench(BENCH).with_values(wire_length_m=length_m, pretension_n=pull_n, ambient_temperature_k=ambient_k)
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
