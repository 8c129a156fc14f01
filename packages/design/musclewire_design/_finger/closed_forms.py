"""Closed forms of a bent strip: under a pure moment, by straight tendon chords, by a force at its end.

They are references for :mod:`musclewire_design._finger.statics` and the first guess of the sizing.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from musclewire.errors import CallerError


class EndLoad(NamedTuple):
    """Displacement of a cantilever's end under a dead force across it, as fractions of its length, and its slope."""

    deflection: float
    shortening: float
    slope_rad: float


def bending_stiffness_n_m2(youngs_modulus_pa: float, depth_m: float, thickness_m: float) -> float:
    """Return EI [N m^2] of a strip: I = b t^3/12, free to curve across its depth as well."""
    return youngs_modulus_pa * depth_m * thickness_m**3 / 12.0


def pure_moment_stiffness_n_per_m(stiffness_n_m2: float, offset_m: float, flexible_length_m: float) -> float:
    """Return the stiffness along a tendon that follows a strip at an offset: k_f = EI/(r^2 L) [N/m].

    The tendon's force makes the moment M = F r everywhere, so the angle is F r L/EI and the travel s = r theta: exact
    at any angle for a tendon that follows the strip.
    """
    return stiffness_n_m2 / (offset_m**2 * flexible_length_m)


def pure_moment_tip_m(angle_rad: float, flexible_length_m: float, plate_length_m: float = 0.0) -> tuple[float, float]:
    """Return the position, along and across [m], of the end of a strip bent into an arc, with a straight plate.

    x = sin(theta)/kappa, y = (1 - cos(theta))/kappa for the arc; the plate leaves it along the tangent.
    """
    half = 0.5 * angle_rad
    chord = flexible_length_m * (math.sin(half) / half if half else 1.0)
    along = chord * math.cos(half) + plate_length_m * math.cos(angle_rad)
    return along, chord * math.sin(half) + plate_length_m * math.sin(angle_rad)


def chord_travel_m(angle_rad: float, offset_m: float, flexible_length_m: float, chords: int) -> float:
    """Return the travel [m] of a tendon of n straight chords over a straight strip that is bent into an arc.

    s = L - 2 n (L/theta - r) sin(theta/2n), about r theta + (L - r theta) theta^2/(24 n^2): chords cut the corners of
    the arc, the fewer the more.
    """
    if angle_rad == 0.0:
        return 0.0
    radius = flexible_length_m / angle_rad - offset_m
    return flexible_length_m - 2.0 * chords * radius * math.sin(0.5 * angle_rad / chords)


def end_loaded_cantilever(load: float) -> EndLoad:
    """Return the end of an elastic cantilever under P L^2/EI = ``load``, a dead force across its unbent axis.

    Elliptic integrals of Bisshopp and Drucker 1945, Quart. Appl. Math. 3, 272, doi 10.1090/qam/13360: with
    k^2 = (1 + sin phi)/2 and sin(a) = 1/(k sqrt 2), the slope phi at the end obeys sqrt(load) = K(k) - F(a, k).
    Raises CallerError for a load that is not above 0.
    """
    if not 0.0 < load < math.inf:
        raise CallerError(f"the load is {load:g}: give a dimensionless end force above 0")

    def missing(slope: float) -> float:
        modulus, amplitude = elliptic_of(slope)
        return float(ellipk(modulus) - ellipkinc(amplitude, modulus)) - math.sqrt(load)

    # The slope tends to a right angle under a growing load, where K has its pole.
    slope = float(brentq(missing, 1e-12, 0.5 * math.pi - 1e-12, xtol=1e-15, rtol=1e-14))
    modulus, amplitude = elliptic_of(slope)
    deflection = 1.0 - 2.0 / math.sqrt(load) * float(ellipe(modulus) - ellipeinc(amplitude, modulus))
    return EndLoad(deflection, 1.0 - math.sqrt(2.0 * math.sin(slope) / load), slope)


def elliptic_of(slope_rad: float) -> tuple[float, float]:
    """Return parameter k^2 and amplitude of the elliptic integrals for a slope at the end."""
    modulus = 0.5 * (1.0 + math.sin(slope_rad))
    return modulus, math.asin(min(1.0 / math.sqrt(2.0 * modulus), 1.0))
