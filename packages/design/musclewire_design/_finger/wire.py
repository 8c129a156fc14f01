"""Whether a wire has the stroke and force for a finger: the simulated wire on the finger's load, fully heated.

The load at a travel x is the pretensioner's k_p x and the tendon's force with friction while pulling; a spring of the
secant stiffness carries the same load at x, so a wire reaches x on the finger if it does on that spring.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, NumericsError
from musclewire.parameters import FingerCurve, load_alloy, load_bench, load_wire
from musclewire.wire import WireConstants, constants_of, drive_path, measured_grains, resting_state

# Temperature at which no martensite is left; further heating would only expand the metal.
HOT_K = 480.0
HEATING_S, SAMPLES = 2.0, 1000
FIRST_CURRENT_A_PER_M2, MAX_CURRENT_A_PER_M2, CURRENT_STEP = 1e7, 1e9, 1.25
BISECTIONS = 16
Stroke = Callable[[float, float | None], tuple[float, float]]


class WireOnFinger(NamedTuple):
    """Reach of a finger with a fully heated wire: travel, endpoint, forces, stress in each leg.

    ``contraction`` is the travel over one leg's length. ``wire_force_n`` is the force in both legs there: pretension,
    pretensioner and finger, friction included. ``reserve_m`` is the travel beyond the requested one.
    """

    travel_m: float
    contraction: float
    endpoint_m: float
    tendon_force_n: float
    wire_force_n: float
    wire_stress_pa: float
    reserve_m: float


def wire_on_finger(
    curve: FingerCurve,
    wire: str,
    *,
    wire_length_m: float,
    pretension_n: float,
    pretensioner_n_per_m: float,
    needed_travel_m: float,
) -> WireOnFinger:
    """Return the reach of a finger with a V-shaped wire, at 22 C in still air.

    ``wire_length_m`` is the overall length of both legs. Raises CallerError if the wire falls short of
    ``needed_travel_m``, saying by how much, or would be loaded beyond its largest allowed force.
    """
    travels = np.array(curve.tendon_travel_m)
    pulling = np.array(curve.tendon_force_n) * (1.0 + np.array(curve.friction_share))
    named = load_wire(wire)
    changed = {"wire_length_m": wire_length_m, "legs": 2.0, "pretension_n": pretension_n}
    bench = {**load_bench("finger").values(), **changed}
    metal, spool = load_alloy(named.alloy), named.values()
    alloy, grains = metal.values(), measured_grains(metal)

    def stroke(travel_m: float, current_a: float | None = None) -> tuple[float, float]:
        secant = pretensioner_n_per_m + float(np.interp(travel_m, travels, pulling)) / travel_m
        around = {**bench, "spring_stiffness_n_per_m": secant}
        return heated_stroke(constants_of(alloy, spool, around, distribution=grains), current_a)

    free, current = stroke(needed_travel_m)
    if free < needed_travel_m:
        raise CallerError(
            f"{wire}, {1e3 * wire_length_m:g} mm as a V, gives {1e3 * free:.3f} mm on this finger at a pretension of "
            f"{pretension_n:g} N; the endpoint requires {1e3 * needed_travel_m:.3f} mm, "
            f"{100 * (1 - free / needed_travel_m):.1f} % short: a longer wire, a softer finger, or another "
            "pretension"
        )
    reached = reached_travel(stroke, needed_travel_m, float(travels[-1]), current)
    endpoint, tendon = (float(np.interp(reached, travels, y)) for y in (curve.endpoint_displacement_m, pulling))
    force = pretension_n + pretensioner_n_per_m * reached + tendon
    require_allowed(wire, force, spool["maximum_force_n"])
    stress = force / (2.0 * 0.25 * math.pi * spool["diameter_m"] ** 2)
    leg = 0.5 * wire_length_m
    return WireOnFinger(reached, reached / leg, endpoint, tendon, force, stress, reached - needed_travel_m)


def require_allowed(wire: str, force_n: float, max_n: float) -> None:
    """Raise CallerError for a wire that would exceed its allowed force."""
    if force_n > max_n:
        raise CallerError(
            f"{wire} would bear {force_n:.3g} N at the end of its stroke, {force_n / max_n:.2f} times the "
            f"{max_n:.3g} N it is allowed: a thicker wire or a softer finger"
        )


def reached_travel(stroke: Stroke, low_m: float, high_m: float, current_a: float) -> float:
    """Return the travel at which the wire's stroke against the finger's load is that travel, by bisection."""
    if stroke(high_m, current_a)[0] >= high_m:
        return high_m  # the finger's curve ends before the wire does
    for _ in range(BISECTIONS):
        middle = 0.5 * (low_m + high_m)
        low_m, high_m = (middle, high_m) if stroke(middle, current_a)[0] >= middle else (low_m, middle)
    return low_m


def heated_stroke(constants: WireConstants, current_a: float | None) -> tuple[float, float]:
    """Return the largest travel [m] of a wire that a held current heats fully, and that current [A].

    Without a current the smallest of a rising series that heats it through is searched.
    """
    area = constants.area_m2
    current = FIRST_CURRENT_A_PER_M2 * area if current_a is None else current_a
    while current <= MAX_CURRENT_A_PER_M2 * area:
        drive: FloatArray = np.full(SAMPLES, current)
        path, state = drive_path(
            constants,
            drive,
            sample_s=HEATING_S / SAMPLES,
            state=resting_state(constants),
            regulated_current=True,
        )
        if state.temperature_k > HOT_K or current_a is not None:
            return float(path.displacement_m.max()), current
        current *= CURRENT_STEP
    raise NumericsError(
        f"no current up to {current:.3g} A heats this wire fully: check diameter, resistance and convection"
    )
