"""A finger's response to a pull at its tendon, point by point, for the simulated rig; and the errors of this curve."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, NumericsError
from musclewire.parameters import FingerCurve
from musclewire.wire import ElasticObject
from musclewire_design._finger.chain import AngleChain, finger_chain
from musclewire_design._finger.friction import ASSUMED_FRICTION, friction_at
from musclewire_design._finger.geometry import FingerGeometry
from musclewire_design._finger.statics import FingerEquilibrium, equilibria, equilibrium, sensitivity

CURVE_STEP_M, MIN_STEPS, MAX_STEPS = 0.025e-3, 20, 400
# If the tendon's force is 0, friction's fraction is taken at this small travel.
SMALL_TRAVEL_M = 1e-7
BISECTIONS = 60
CURVE_POINTS = 57
# The curve extends beyond the design travel, because wires differ.
CURVE_REACH = 4.0 / 3.0


class LinearError(NamedTuple):
    """Largest error of a curve's linear response to an endpoint force against direct solutions.

    ``displacement_m`` and ``tendon_force_n`` are the largest differences, the fractions those of the largest free
    endpoint displacement and tendon force.
    """

    displacement_m: float
    displacement_fraction: float
    tendon_force_n: float
    tendon_force_fraction: float


def curve_travels_m(max_m: float) -> FloatArray:
    """Return the travels of a curve in a file, (57,) [m], from 0 to ``max_m``."""
    return np.asarray(np.linspace(0.0, max_m, CURVE_POINTS))


def finger_curve(geometry: FingerGeometry, travels_m: FloatArray, friction: float = ASSUMED_FRICTION) -> FingerCurve:
    """Return how a finger answers a pull at its tendon.

    Parameters
    ----------
    geometry
        Dimensions of the finger.
    travels_m
        Travels of the tendon [m], (n_points,), evenly spaced from 0.
    friction
        Coefficient of the capstan law for tendon on hole; by default an assumed one.

    Returns
    -------
    Force, endpoint displacement and the answer to an endpoint force, over the travels.

    Raises
    ------
    CallerError
        If the endpoint no longer rises with the travel: the finger has curled.
    NumericsError
        If there is no equilibrium at a travel.
    """
    chain, stiffness = finger_chain(geometry), geometry.stiffness_n_m2
    found = equilibria(chain, stiffness, travels_m)
    slopes = [sensitivity(at) for at in found]
    displacement = [at.endpoint_displacement_m for at in found]
    if np.any(np.diff(displacement) <= 0.0):
        worst = travels_m[1:][np.diff(displacement) <= 0.0][0]
        raise CallerError(
            f"at a travel of {1e3 * worst:.3g} mm the finger has curled until its endpoint moves back: "
            "choose a smaller travel"
        )
    moving = [equilibrium(chain, stiffness, SMALL_TRAVEL_M), *found[1:]]
    return FingerCurve(
        tendon_travel_m=[float(travel) for travel in travels_m],
        tendon_force_n=[at.tendon_force_n for at in found],
        endpoint_displacement_m=displacement,
        tendon_force_per_endpoint_force=[slope.tendon_force_per_endpoint_force for slope in slopes],
        endpoint_compliance_m_per_n=[slope.endpoint_compliance_m_per_n for slope in slopes],
        friction_share=[friction_at(chain, stiffness, at, friction).fraction for at in moving],
    )


def beam_stress_pa(geometry: FingerGeometry, at: FingerEquilibrium) -> FloatArray:
    """Return the largest stress at the faces of each element, (n_elements,) [Pa]: bending and compression.

    Bending alone is E t/2 times the change of curvature. The tendon's force presses on the beam as a whole; it is
    counted in full, which is right to the cosine of a few degrees.
    """
    bending = 0.5 * geometry.youngs_modulus_pa * geometry.beam_thickness_m * np.abs(bent_per_m(at))
    return np.asarray(bending + at.tendon_force_n / (geometry.beam_depth_m * geometry.beam_thickness_m))


def bent_per_m(at: FingerEquilibrium) -> FloatArray:
    """Return the change of curvature of each element, its moment over EI, (n_elements,) [1/m]."""
    chain = at.placed.chain
    return np.asarray((chain.turns @ at.angles_rad - chain.natural_turn_rad) / chain.yielding_m)


def travel_for_endpoint_m(
    chain: AngleChain, stiffness_n_m2: float, endpoint_m: float, max_m: float
) -> FingerEquilibrium:
    """Return the equilibrium, without load, at which the endpoint has moved by ``endpoint_m``.

    Raises CallerError if that requires more travel than ``max_m``.
    """
    steps = min(max(int(np.ceil(max_m / (2.0 * CURVE_STEP_M))), 2), MAX_STEPS)
    low = equilibrium(chain, stiffness_n_m2, 0.0)
    for travel in np.linspace(0.0, max_m, steps + 1)[1:]:
        high = equilibrium(chain, stiffness_n_m2, float(travel), start=low)
        if high.endpoint_displacement_m >= endpoint_m:
            return between(chain, stiffness_n_m2, low, high, endpoint_m)
        if high.endpoint_displacement_m <= low.endpoint_displacement_m:
            break
        low = high
    raise CallerError(
        f"the endpoint moves {1e3 * low.endpoint_displacement_m:.3f} mm at a travel of {1e3 * low.travel_m:.3f} mm: "
        f"{100 * (1 - low.endpoint_displacement_m / endpoint_m):.1f} % less than the {1e3 * endpoint_m:g} mm "
        "requested; ask for less, or give more travel"
    )


def between(
    chain: AngleChain, stiffness_n_m2: float, low: FingerEquilibrium, high: FingerEquilibrium, endpoint_m: float
) -> FingerEquilibrium:
    """Return the equilibrium with a given endpoint between two neighbours, by bisection with secants."""
    at = low
    for _ in range(BISECTIONS):
        at = low if at is high else at
        fraction = (endpoint_m - low.endpoint_displacement_m) / (
            high.endpoint_displacement_m - low.endpoint_displacement_m
        )
        travel = low.travel_m + fraction * (high.travel_m - low.travel_m)
        at = equilibrium(chain, stiffness_n_m2, travel, start=low)
        if abs(at.endpoint_displacement_m - endpoint_m) <= 1e-9 * endpoint_m:
            return at
        low, high = (at, high) if at.endpoint_displacement_m < endpoint_m else (low, at)
    raise NumericsError(
        f"no travel was found for an endpoint of {1e3 * endpoint_m:g} mm: ask for a slightly different one"
    )


def max_free_travel_m(geometry: FingerGeometry, max_m: float) -> float:
    """Return the travel [m] up to which the endpoint rises and no two columns touch, at most ``max_m``."""
    chain = finger_chain(geometry)
    before = equilibrium(chain, geometry.stiffness_n_m2, 0.0)
    steps = min(max(round(max_m / CURVE_STEP_M), MIN_STEPS), MAX_STEPS)
    for travel in np.linspace(0.0, max_m, steps + 1)[1:]:
        at = equilibrium(chain, geometry.stiffness_n_m2, float(travel), start=before)
        if at.endpoint_displacement_m <= before.endpoint_displacement_m or column_gap_m(geometry, at) <= 0.0:
            return before.travel_m
        before = at
    return before.travel_m


def column_gap_m(geometry: FingerGeometry, at: FingerEquilibrium) -> float:
    """Return the smallest gap between the outer ends of neighbouring columns, palm included [m]; negative: overlap."""
    ends = at.angles_rad[list(at.placed.chain.column_nodes)]
    turn = np.diff(ends, prepend=0.0).max()
    if turn <= 0.0:
        return geometry.segment_length_m
    return float(2.0 * (geometry.segment_length_m / turn - geometry.column_height_m) * np.sin(0.5 * turn))


def linear_error(geometry: FingerGeometry, travels_m: FloatArray, endpoint_forces_n: FloatArray) -> LinearError:
    """Return the error of the linear response to endpoint forces against direct solutions, over travels and forces."""
    chain, stiffness = finger_chain(geometry), geometry.stiffness_n_m2
    moved, forced, max_y, max_force = 0.0, 0.0, 0.0, 0.0
    for free in equilibria(chain, stiffness, travels_m):
        slope, at = sensitivity(free), free
        max_y, max_force = max(max_y, free.endpoint_displacement_m), max(max_force, free.tendon_force_n)
        for force in np.sort(endpoint_forces_n):
            at = equilibrium(chain, stiffness, free.travel_m, endpoint_force_n=float(force), start=at)
            linear_y = free.endpoint_displacement_m - slope.endpoint_compliance_m_per_n * force
            linear_force = free.tendon_force_n + slope.tendon_force_per_endpoint_force * force
            moved = max(moved, abs(at.endpoint_displacement_m - linear_y))
            forced = max(forced, abs(at.tendon_force_n - linear_force))
    return LinearError(moved, moved / max_y, forced, forced / max_force)


def reciprocity_error(geometry: FingerGeometry, travels_m: FloatArray, endpoint_force_n: float = 1e-4) -> float:
    """Return the largest relative difference of dT/df, from two direct solutions, and dy/dx along the free curve.

    Virtual work: both are the mixed second derivative of the minimum energy by travel and endpoint force. By central
    differences, independent of the analytic derivatives.
    """
    chain, stiffness, worst = finger_chain(geometry), geometry.stiffness_n_m2, 0.0
    step = 1e-3 * float(travels_m[-1])
    for free in equilibria(chain, stiffness, travels_m):
        pushed = [
            equilibrium(chain, stiffness, free.travel_m, endpoint_force_n=sign * endpoint_force_n, start=free)
            for sign in (1.0, -1.0)
        ]
        moved = [equilibrium(chain, stiffness, free.travel_m + sign * step, start=free) for sign in (1.0, -1.0)]
        by_force = (pushed[0].tendon_force_n - pushed[1].tendon_force_n) / (2.0 * endpoint_force_n)
        by_travel = (moved[0].endpoint_displacement_m - moved[1].endpoint_displacement_m) / (2.0 * step)
        worst = max(worst, abs(by_force / by_travel - 1.0))
    return worst


def touch_curve(geometry: FingerGeometry, travels_m: FloatArray, obstacle: ElasticObject) -> list[FingerEquilibrium]:
    """Return the finger along rising travels, (n_travels,), against an object."""
    return equilibria(finger_chain(geometry), geometry.stiffness_n_m2, travels_m, obstacle=obstacle)
