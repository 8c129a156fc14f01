"""Equilibrium of a finger at a given tendon travel: large deflection in the plane, endpoint force, contact.

The energy of bending, EI/2 sum (turn - natural turn)^2 / length, is minimal under the constraint that the chords of the
tendon have become shorter by the travel. The multiplier of the constraint is the tendon's force, both legs together.
Newton's method on angles and multiplier, with exact second derivatives; small systems, solved densely.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, NumericsError
from musclewire.wire import ElasticObject
from musclewire_design._finger.chain import AngleChain, PlacedChain, place

NEWTON_STEPS = 40
# Of the largest moment in the chain, and of the length of the tendon between the guides.
CLOSE_ENOUGH = 1e-10
# Largest rotation of an element in one step of Newton's method, which diverges with larger steps.
MAX_TURN_RAD = 0.3


@dataclass(frozen=True)
class FingerEquilibrium:
    """A finger at rest: its angles (n_angles,) [rad], tendon and endpoint force [N], and how Newton's method ended.

    ``endpoint_displacement_m`` counts across the unloaded finger's palm axis, towards the tendon's side, from the
    unloaded endpoint. ``endpoint_force_n`` pushes back. ``tangent_n_m`` (n_angles, n_angles) is the second derivative
    of the energy at held forces, ``travel_slope_m`` (n_angles,) the gradient of the travel.
    """

    angles_rad: FloatArray
    travel_m: float
    tendon_force_n: float
    endpoint_displacement_m: float
    endpoint_force_n: float
    placed: PlacedChain
    tangent_n_m: FloatArray
    travel_slope_m: FloatArray


class EquilibriumSlopes(NamedTuple):
    """Derivatives of an equilibrium by endpoint force at held travel, and by travel at held endpoint force."""

    tendon_force_per_endpoint_force: float
    endpoint_compliance_m_per_n: float
    endpoint_per_travel: float
    tendon_stiffness_n_per_m: float


class FingerProblem:
    """A chain with its bending stiffness: the constants of Newton's method."""

    def __init__(self, chain: AngleChain, stiffness_n_m2: float, chord_weights: FloatArray | None = None) -> None:
        """Take chain and stiffness; ``chord_weights`` (n_chords,) are the chords' fractions of the palm's force."""
        self.chain = chain
        self.bending = chain.turns.T @ ((stiffness_n_m2 / chain.yielding_m)[:, None] * chain.turns)
        self.natural = chain.turns.T @ (stiffness_n_m2 / chain.yielding_m * chain.natural_turn_rad)
        self.resting = place(chain, chain.resting_angles_rad)
        self.weights = np.ones(chain.chords_m.shape[0]) if chord_weights is None else chord_weights

    def travel_m(self, placed: PlacedChain) -> float:
        """Return the shortening of the chords against the unloaded finger."""
        return float((self.resting.chord_lengths_m - placed.chord_lengths_m).sum())

    def displacement_m(self, placed: PlacedChain) -> float:
        """Return the endpoint's displacement across the palm's axis."""
        return float(placed.endpoint_m[1] - self.resting.endpoint_m[1])

    def moments(self, angles: FloatArray, placed: PlacedChain, force_n: float, push_n: float) -> FloatArray:
        """Return the residual moments under a tendon force and a push at the endpoint, (n_angles,) [N m]."""
        # The tendon's force shortens its chords: the work it does is its force times the travel.
        pulled = force_n * (self.weights @ placed.chord_slopes())
        return np.asarray(self.bending @ angles - self.natural + push_n * placed.across_slope() + pulled)

    def tangent(self, placed: PlacedChain, force_n: float, push_n: float) -> FloatArray:
        """Return the derivative of :meth:`moments` by the angles, (n_angles, n_angles)."""
        return np.asarray(self.bending + placed.curvature_of(force_n * self.weights, push_n))


def equilibrium(
    chain: AngleChain,
    stiffness_n_m2: float,
    travel_m: float,
    *,
    endpoint_force_n: float = 0.0,
    obstacle: ElasticObject | None = None,
    chord_weights: FloatArray | None = None,
    start: FingerEquilibrium | None = None,
) -> FingerEquilibrium:
    """Return the finger at one tendon travel, from the unloaded finger or from a neighbouring equilibrium.

    Parameters
    ----------
    chain
        The finger as a chain of elements, with its tendon's chords.
    stiffness_n_m2
        Bending stiffness EI of the flexible segments [N m2].
    travel_m
        Travel of the tendon [m]: by how much its chords together are shorter than without load.
    endpoint_force_n
        Force that pushes the endpoint back [N].
    obstacle
        Object in the way of the endpoint; None without one.
    chord_weights
        Tension of each chord as a fraction of that at the palm, (n_chords,); below 1 by friction, 1 if None.
    start
        A neighbouring equilibrium from which Newton's method begins; the unloaded finger if None.

    Returns
    -------
    Angles, forces and endpoint displacement of the finger at rest.

    Raises
    ------
    NumericsError
        If Newton's method does not converge: go there in smaller steps with ``start``.

    References
    ----------
    The finger of Lan and Fan 2010, Fig. 13(b).
    """
    problem = FingerProblem(chain, stiffness_n_m2, chord_weights)
    angles = chain.resting_angles_rad if start is None else start.angles_rad
    force = 0.0 if start is None else start.tendon_force_n
    free = solved(problem, travel_m, angles, force, endpoint_force_n)
    if obstacle is None or free.endpoint_displacement_m <= obstacle.clearance_m:
        return free
    push = free.endpoint_force_n if start is None else start.endpoint_force_n
    return solved(problem, travel_m, angles, force, push, obstacle, endpoint_force_n)


def equilibria(
    chain: AngleChain,
    stiffness_n_m2: float,
    travels_m: FloatArray,
    *,
    endpoint_force_n: float = 0.0,
    obstacle: ElasticObject | None = None,
) -> list[FingerEquilibrium]:
    """Return the finger along rising travels, (n_travels,), each found from the one before; loads as above."""
    found: list[FingerEquilibrium] = []
    for travel in travels_m:
        before = found[-1] if found else None
        found.append(
            equilibrium(
                chain, stiffness_n_m2, float(travel), endpoint_force_n=endpoint_force_n, obstacle=obstacle, start=before
            )
        )
    return found


def solved(
    problem: FingerProblem,
    travel_m: float,
    angles: FloatArray,
    force_n: float,
    push_n: float,
    touched: ElasticObject | None = None,
    other_push_n: float = 0.0,
) -> FingerEquilibrium:
    """Run Newton's method for one travel: at a given push, or with the push of an object that is touched.

    A touched object's force is an unknown of its own, so that a stiff object converges as well as a soft one.
    """
    count, tendon_m = angles.size, float(problem.resting.chord_lengths_m.sum())
    for _ in range(NEWTON_STEPS):
        placed = place(problem.chain, angles)
        out = problem.moments(angles, placed, force_n, push_n)
        tangent = problem.tangent(placed, force_n, push_n)
        slope = -placed.chord_slopes().sum(axis=0)
        missing = [problem.travel_m(placed) - travel_m]
        if touched is not None:
            pressed = (push_n - other_push_n) / touched.stiffness_n_per_m
            missing.append(problem.displacement_m(placed) - touched.clearance_m - pressed)
        # An unloaded finger has no moment as a scale of the residual: then the tendon's is taken.
        scale = np.abs(problem.bending @ angles).max() + np.abs(problem.natural).max() + abs(force_n) * tendon_m
        if np.abs(out).max() <= CLOSE_ENOUGH * (scale + 1e-300) and np.abs(missing).max() <= CLOSE_ENOUGH * tendon_m:
            moved = problem.displacement_m(placed)
            return FingerEquilibrium(angles, travel_m, force_n, moved, push_n, placed, tangent, slope)
        system = np.zeros((count + len(missing), count + len(missing)))
        system[:count, :count], system[count, :count] = tangent, slope
        system[:count, count] = problem.weights @ placed.chord_slopes()
        if touched is not None:
            system[:count, -1] = system[-1, :count] = placed.across_slope()
            system[-1, -1] = -1.0 / touched.stiffness_n_per_m
        step = solve_system(system, -np.append(out, missing), travel_m)
        largest = np.abs(problem.chain.turns @ step[:count]).max()
        step *= min(1.0, MAX_TURN_RAD / largest) if largest > 0.0 else 1.0
        angles, force_n = angles + step[:count], force_n + float(step[count])
        push_n += float(step[-1]) if touched is not None else 0.0
    raise lost(travel_m)


def lost(travel_m: float) -> NumericsError:
    """Return the error for a travel at which no equilibrium was found."""
    return NumericsError(
        f"no equilibrium of the finger was found at a tendon travel of {1e3 * travel_m:.3g} mm: the tendon cannot get "
        "that much shorter, or an object in the way makes the beam buckle; ask for less travel"
    )


def solve_system(system: FloatArray, right: FloatArray, travel_m: float) -> FloatArray:
    """Return the step of Newton's method."""
    try:
        step = np.asarray(np.linalg.solve(system, right))
    except np.linalg.LinAlgError:
        raise lost(travel_m) from None
    if not np.all(np.isfinite(step)):
        raise lost(travel_m)
    return step


def sensitivity(at: FingerEquilibrium) -> EquilibriumSlopes:
    """Return how an equilibrium without friction changes with a small endpoint force and a small travel.

    Both come from one factorisation of the same symmetric system, so dT/df = dy/dx holds to rounding (reciprocity:
    both are the mixed second derivative of the minimum energy by travel and endpoint force).
    """
    count = at.angles_rad.size
    system = np.zeros((count + 1, count + 1))
    system[:count, :count] = at.tangent_n_m
    system[:count, count] = system[count, :count] = -at.travel_slope_m
    across = at.placed.across_slope()
    right = np.zeros((count + 1, 2))
    right[:count, 0] = -across
    right[count, 1] = -1.0
    by_force, by_travel = np.linalg.solve(system, right).T
    return EquilibriumSlopes(
        float(by_force[count]),
        float(-(across @ by_force[:count])),
        float(across @ by_travel[:count]),
        float(by_travel[count]),
    )


def loaded_cantilever(chain: AngleChain, stiffness_n_m2: float, force_n: float, steps: int = 10) -> FingerEquilibrium:
    """Return a chain without a tendon under a dead force across its axis at its endpoint, in ``steps`` load steps.

    The same discrete statics as the finger's, for comparison with published tables. Raises CallerError for a chain that
    has a tendon.
    """
    if chain.chords_m.shape[0]:
        raise CallerError("this chain has a tendon: compute its equilibrium at a tendon travel")
    problem, angles = FingerProblem(chain, stiffness_n_m2), chain.resting_angles_rad
    for load_fraction in np.arange(1, steps + 1) / steps:
        for _ in range(NEWTON_STEPS):
            placed = place(chain, angles)
            out = problem.moments(angles, placed, 0.0, -load_fraction * force_n)
            tangent = problem.tangent(placed, 0.0, -load_fraction * force_n)
            if np.abs(out).max() <= CLOSE_ENOUGH * np.abs(problem.bending @ angles).max(initial=1e-300):
                break
            angles = angles - np.linalg.solve(tangent, out)
        else:
            raise NumericsError(
                f"the cantilever under {force_n:g} N did not come to rest: apply the force in more than {steps} steps"
            )
    moved = problem.displacement_m(placed)
    return FingerEquilibrium(angles, math.nan, 0.0, moved, -force_n, placed, tangent, np.zeros(angles.size))
