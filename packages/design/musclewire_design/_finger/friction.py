"""Friction at the holes: the tendon's tension falls at every edge it is bent around.

Capstan law (Euler, Eytelwein): behind an edge that turns the tendon by phi the tension is multiplied by exp(-mu phi)
while pulling and by exp(mu phi) while easing. The tendon is turned where it leaves and enters a column, by the angle
between column and chord; it is fastened to its last column.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, NumericsError
from musclewire_design._finger.chain import AngleChain, PlacedChain
from musclewire_design._finger.statics import FingerEquilibrium, equilibrium

ASSUMED_FRICTION = 0.15
# Rubber on dry glass, beyond any tendon.
MAX_FRICTION = 1.0
FRICTION_SOURCE = (
    "acetal copolymer on steel, 0.15: Shackelford (ed.), Materials Science and Engineering Handbook 2001, table 399, "
    "after Lynch, CRC Handbook of Materials Science 3, 1975; a steel tendon is assumed, the paper names none"
)
ROUNDS = 60
SETTLED = 1e-11


class ConnectorFriction(NamedTuple):
    """Force at the connector [N] while pulling and while easing at the same travel, and friction's fraction of it.

    ``fraction`` is half the difference over the force without friction.
    """

    pulling_n: float
    easing_n: float
    fraction: float


def hole_turns_rad(placed: PlacedChain, angles_rad: FloatArray) -> FloatArray:
    """Return the angle by which the tendon has turned between the palm and each chord, (n_chords,) [rad].

    For a tendon that is guided by all columns.
    """
    chord = np.arctan2(placed.chord_vectors_m[:, 1], placed.chord_vectors_m[:, 0])
    column = np.concatenate([[0.0], angles_rad[list(placed.chain.column_nodes)]])
    leaving, entering = np.abs(chord - column[:-1]), np.abs(column[1:] - chord)
    return np.asarray(np.cumsum(leaving) + np.concatenate([[0.0], np.cumsum(entering)[:-1]]))


def chord_tensions(
    chain: AngleChain, stiffness_n_m2: float, travel_m: float, coefficient: float, near: FingerEquilibrium
) -> tuple[FingerEquilibrium, FloatArray]:
    """Return the finger at a travel under friction, and each chord's fraction of the connector's force, (n_chords,).

    A positive ``coefficient`` pulls, a negative one eases. The fractions depend on the shape and the shape on the
    fractions: repeated until neither changes. Raises NumericsError if that does not converge.
    """
    weights, at = np.ones(chain.chords_m.shape[0]), near
    for _ in range(ROUNDS):
        wanted = np.exp(-coefficient * hole_turns_rad(at.placed, at.angles_rad))
        if np.abs(wanted - weights).max() <= SETTLED:
            return at, weights
        weights = wanted
        at = equilibrium(chain, stiffness_n_m2, travel_m, chord_weights=weights, start=at)
    raise NumericsError(f"friction of {coefficient:g} does not converge: the tendon would lock; give a smaller one")


def friction_at(
    chain: AngleChain, stiffness_n_m2: float, free: FingerEquilibrium, coefficient: float
) -> ConnectorFriction:
    """Return the effect of friction on the connector's force at an equilibrium without friction.

    Raises CallerError for a negative coefficient or an equilibrium without travel.
    """
    if not 0.0 <= coefficient < math.inf:
        raise CallerError(f"the friction coefficient is {coefficient:g}: give 0 or more")
    if free.travel_m <= 0.0:
        raise CallerError("friction is no fraction of a force of 0: give a travel above 0")
    forces = [
        chord_tensions(chain, stiffness_n_m2, free.travel_m, sign * coefficient, free)[0].tendon_force_n
        for sign in (1.0, -1.0)
    ]
    return ConnectorFriction(forces[0], forces[1], 0.5 * (forces[0] - forces[1]) / free.tendon_force_n)
