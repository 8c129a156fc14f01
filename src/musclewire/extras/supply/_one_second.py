"""Electrical sizing of a wire before parts are bought: the current that contracts it in time, how long it relaxes.

The numbers come from fast simulated runs and from the heat balance, not from measurements.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from musclewire.errors import NumericsError
from musclewire.parameters import Alloy, Bench, Wire
from musclewire.wire import DrivenPath, HeatBalance, WireConstants, WireState, constants_from, drive_path, resting_state

# A wire counts as contracted at this fraction of its full stroke.
CONTRACTED_FRACTION = 0.9
MAX_CURRENT_A_PER_M2 = 1e9
BISECTIONS = 30
STEP_S = 2e-3  # [s] of a simulation
COARSE_STEP_S = 5e-3  # [s] of one that shows only when the wire has relaxed
# A wire counts as relaxed below this contraction.
RELAXED_STRAIN = 0.0025
# At this temperature no wire has martensite left; heating further only expands the metal.
HOT_K = 480.0


class OneSecondDrive(NamedTuple):
    """Current and voltage that contract a simulated wire by 90 % of its stroke in one second."""

    current_a: float
    wire_voltage_v: float
    stroke: float
    temperature_k: float
    holding_current_a: float  # then holds it: its steady temperature is the one reached after the second


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


def one_second_current(alloy: Alloy, wire: Wire, bench: Bench) -> OneSecondDrive:
    """Return the current that brings a cold wire to a fraction of its stroke in 1 s; NumericsError if none does."""
    constants = constants_from(alloy, wire, bench)
    stroke = full_stroke(constants)
    current_a = contracting_current_a(constants, 1.0, CONTRACTED_FRACTION * stroke * constants.leg_length_m)
    path, state = heat(constants, current_a, 1.0)
    air_k, factor = constants.ambient_temperature_k, wire["convection_factor"]
    balance = HeatBalance.of_wire(alloy, wire["diameter_m"], constants.wire_length_m, air_k, factor)
    return OneSecondDrive(
        current_a,
        float(path.wire_voltage_v.max()),
        stroke,
        state.temperature_k,
        math.sqrt(balance.power_w(state.temperature_k) / state.resistance_ohm),
    )


def relaxation_time_s(
    alloy: Alloy, wire: Wire, bench: Bench, drive: float, on_s: float, *, regulated_current: bool, max_s: float
) -> float:
    """Return the time after a drive (a current [A] or a voltage [V]) until a quarter percent of strain is left."""
    constants = constants_from(alloy, wire, bench)
    samples = max(round(on_s / COARSE_STEP_S), 1)
    on = np.full(samples, drive)
    _, state = drive_path(constants, on, sample_s=on_s / samples, regulated_current=regulated_current)
    off = np.zeros(round(max_s / COARSE_STEP_S))
    path, _ = drive_path(constants, off, sample_s=COARSE_STEP_S, state=state)
    stretched = np.flatnonzero(path.displacement_m > RELAXED_STRAIN * constants.leg_length_m)
    return COARSE_STEP_S * (int(stretched[-1]) + 1) if stretched.size else 0.0
