"""Whether a loop shows the guide's friction that was asked for: over friction, presliding and step.

A wire goes slowly through one cycle on a spring whose guide rubs. While the connector slides, the wire's force differs
from that of the load without friction by the friction, in either direction, so that means over samples show it. The
pretension is above the friction by 0.6 N or more, so that the load pulls the wire back; the wire is as thick as that
takes: 90 MPa or less under the pretension, which the drive can transform.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from kernel_courses import Array, Numbers, shipped

from musclewire.wire import WireConstants, constants_of, drive_path, fixed_steps, spring_load

FRICTIONS_N = (0.01, 0.03, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 5.0)
PRESLIDINGS_M = (1e-6, 5e-6, 20e-6, 100e-6)
STEPS_S = (1e-4, 1e-3, 5e-3, 10e-3, 20e-3)
SAMPLE_S = 0.1
PERIOD_S = 60.0
LOWEST_PRETENSION_STRESS_PA = 90e6
SPRING_N_PER_M = 300.0


class Case(NamedTuple):
    """A wire on a spring with a guide that rubs, and the drive of one slow cycle."""

    constants: WireConstants
    drive_v: Array
    friction_n: float
    presliding_m: float


class Shown(NamedTuple):
    """Friction that a loop shows while it slides, as fractions of what was asked: both directions, and the worst.

    ``stroke_m`` is how far the connector went; ``samples`` how many of the loop slid.
    """

    pulling: float
    easing: float
    worst: float
    stroke_m: float
    samples: int


def case_of(friction_n: float, presliding_m: float) -> Case:
    """Return a wire thick enough for a pretension above the friction, with the drive that takes it through its loop."""
    alloy, spool, bench = shipped()
    pretension_n = max(friction_n + 0.6, 1.5)
    area_m2 = max(pretension_n / LOWEST_PRETENSION_STRESS_PA / bench["legs"], 0.25 * math.pi * 100e-6**2)
    diameter_m = math.sqrt(4.0 * area_m2 / math.pi)
    numbers: Numbers = (
        alloy,
        {**spool, "diameter_m": diameter_m},
        {
            **bench,
            "pretension_n": pretension_n,
            "guide_friction_n": friction_n,
            "guide_presliding_m": presliding_m,
            "shunt_resistance_ohm": bench["shunt_resistance_ohm"] * (100e-6 / diameter_m) ** 2,
        },
    )
    constants = constants_of(*numbers, load=spring_load(SPRING_N_PER_M))
    return Case(constants, drive_of(constants), friction_n, presliding_m)


def drive_of(constants: WireConstants, hottest_k: float = 420.0) -> Array:
    """Return a slow sine up to the voltage that holds the wire at a temperature above its transformation."""
    k = constants
    place = (hottest_k - k.convection_table_start_k) / k.convection_table_step_k
    loss_w = k.convection_factor * k.convection_table_w_per_m2_k[int(place)] * k.surface_m2
    loss_w *= hottest_k - k.ambient_temperature_k
    ohm = k.austenite_resistivity_ohm_m * 1.03 * k.austenite_length_m / k.area_m2
    amplitude_v = math.sqrt(loss_w / ohm) * (ohm + k.series_resistance_ohm)
    sense_v = 0.02 * amplitude_v
    middles = np.arange(0.5, round(PERIOD_S / SAMPLE_S)) * SAMPLE_S
    return np.sqrt(
        sense_v**2 + (amplitude_v**2 - sense_v**2) * 0.5 * (1.0 - np.cos(2.0 * math.pi * middles / PERIOD_S))
    )


def shown(case: Case, step_s: float) -> Shown:
    """Return the friction that a loop shows in steps of one length."""
    path, _ = drive_path(case.constants, case.drive_v, sample_s=SAMPLE_S, stepping=fixed_steps(step_s))
    x = path.displacement_m
    friction_n = path.force_n - case.constants.pretension_n - case.constants.spring_stiffness_n_per_m * x
    top = int(x.argmax())
    # Sliding: away from both turns by the way over which friction turns round, and a margin.
    turned_m = 2.0 * case.presliding_m + 0.02 * np.ptp(x)
    inside = (x > x[0] + turned_m) & (x < x[top] - turned_m)
    before = np.arange(x.size) < top
    pulling, easing = friction_n[inside & before] / case.friction_n, -friction_n[inside & ~before] / case.friction_n
    both = np.concatenate((pulling, easing))
    worst = float(np.abs(both - 1.0).max()) if min(pulling.size, easing.size) else math.inf
    middle = (float(np.median(side)) if side.size else math.nan for side in (pulling, easing))
    return Shown(*middle, worst, float(np.ptp(x)), int(both.size))
