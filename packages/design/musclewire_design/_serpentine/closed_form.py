"""Stiffness and stress of a serpentine by integrals along its centre line.

Castigliano's theorem: a pull F along the axis x = 0 bends the strip by the moment M = F x wherever the centre line is
at a distance x from the axis, and the end moves by dU/dF of the energy U = integral of M^2/(2 E I) ds. Over a beam
from -a to +a the integral of x^2 is 2 a^3/3, over a link a^2 p. N of each give

    k = 3 E I/[N a^2 (2a + 3p)],   largest M = F a in the links,   so   sigma = 6 F a/(b t^2).

This holds for square corners, a strip much thinner than long, and an end that may turn and move sideways. Also here:
the end guided so that it can do neither, rounded corners, shear and stretch, and the stress at the inner edge of a
rounded corner.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from musclewire.arrays import FloatArray
from musclewire_design._serpentine.geometry import CentreLineArc, CentreLineStraight, SerpentineGeometry

# Six Gauss points integrate the products along a straight piece exactly, and along a quarter of a circle to 1e-10.
GAUSS_POINTS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(6)


def stiffness_n_per_m(geometry: SerpentineGeometry, youngs_modulus_pa: float) -> float:
    """Return k = 3 E I/[N a^2 (2a + 3p)] [N/m]: square corners, bending only, the end free to turn."""
    n, a, p = geometry.beams, geometry.half_length_m, geometry.pitch_m
    return 3.0 * youngs_modulus_pa * geometry.second_moment_m4 / (n * a**2 * (2.0 * a + 3.0 * p))


def nominal_stress_pa(geometry: SerpentineGeometry, force_n: float) -> float:
    """Return the largest bending stress of straight strips, 6 F a/(b t^2) [Pa]: that in the links."""
    return 6.0 * force_n * geometry.half_length_m / (geometry.depth_m * geometry.thickness_m**2)


def corner_stress_factor(geometry: SerpentineGeometry) -> float:
    """Return the stress at the inner edge of a rounded corner over that of a straight strip.

    Winkler and Bach's curved beam of rectangular section: the neutral fibre is at r_n = t/ln(r_o/r_i), so the inner
    edge has M (r_n - r_i)/(b t e r_i) with e = r_c - r_n. Timoshenko 1955, Strength of Materials II, section 16.
    Infinite for a corner without radius.
    """
    t, inner = geometry.thickness_m, geometry.corner_radius_m
    if inner <= 0.0:
        return math.inf
    neutral = t / math.log1p(t / inner)
    eccentricity = inner + 0.5 * t - neutral
    return (neutral - inner) / (t * eccentricity * inner) * t**2 / 6.0


def width_parameter(geometry: SerpentineGeometry, bending_moment_n_m: float, youngs_modulus_pa: float) -> float:
    """Return Searle's b^2/(R t) for a bending moment: a measure of how much a wide strip bends like a plate.

    Below about 1 its edges are free to curl, and E I holds, as in plane stress; far above 10 they are not, and it is
    stiffer by up to 1/(1 - nu^2). Searle 1908, Experimental Elasticity; Timoshenko and Woinowsky-Krieger 1959,
    chapter 1.
    """
    curvature = abs(bending_moment_n_m) / (youngs_modulus_pa * geometry.second_moment_m4)
    return geometry.depth_m**2 * curvature / geometry.thickness_m


def line_points(geometry: SerpentineGeometry, rounded: bool) -> tuple[FloatArray, FloatArray]:
    """Return Gauss points (n, 2) along the centre line [m] and their weights in its length (n,) [m]."""
    if rounded:
        pieces = geometry.centre_line()
    else:
        corners = geometry.vertices_m()
        pieces = [CentreLineStraight(start, end) for start, end in pairwise(corners)]
    fraction = 0.5 * (1.0 + GAUSS_POINTS)
    points = [places_on(piece, fraction) for piece in pieces]
    weights = [0.5 * piece.length_m * GAUSS_WEIGHTS for piece in pieces]
    return np.concatenate(points), np.concatenate(weights)


def places_on(piece: CentreLineStraight | CentreLineArc, fraction: FloatArray) -> FloatArray:
    """Return points (n, 2) at fractions (n,) of a piece of the centre line [m]."""
    if isinstance(piece, CentreLineStraight):
        start, end = np.array(piece.start_m), np.array(piece.end_m)
        straight: FloatArray = start + fraction[:, None] * (end - start)
        return straight
    angle = piece.start_rad + fraction * piece.turn_rad
    return np.array(piece.centre_m) + piece.radius_m * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def compliance_m_per_n(
    geometry: SerpentineGeometry,
    youngs_modulus_pa: float,
    *,
    guided: bool = False,
    rounded: bool = False,
) -> float:
    """Return the bending compliance along the wire [m/N].

    A guide adds a force H across the wire and a moment M_0 of such size that the end neither moves across nor turns:
    with M = F x + H y + M_0 they follow from the integrals of the products of x, y and 1 along the strip, the short
    strips on the axis that join its beams to pad and connector among it.
    """
    points, weights = line_points(geometry, rounded)
    # Heights count from the middle: large offsets would cost precision in the differences below.
    y = points[:, 1] - 0.5 * (geometry.first_beam_m + geometry.last_beam_m)
    basis = np.stack([points[:, 0], y, np.ones_like(y)])
    gram = (basis * weights) @ basis.T
    along = gram[0, 0]
    if guided:
        along -= gram[0, 1:] @ np.linalg.solve(gram[1:, 1:], gram[1:, 0])
    return float(along / (youngs_modulus_pa * geometry.second_moment_m4))


def guided_factor(geometry: SerpentineGeometry) -> float:
    """Return how much stiffer a serpentine is when its moving end can neither turn nor move across (bending only).

    A pull along the axis does not bend the short strips that join it to pad and connector, a guide's moment does.
    """
    free, guided = (compliance_m_per_n(geometry, 1.0, guided=guide) for guide in (False, True))
    return free / guided


def rounded_stiffness_n_per_m(
    geometry: SerpentineGeometry, youngs_modulus_pa: float, poisson_ratio: float, *, guided: bool = False
) -> float:
    """Return the stiffness [N/m] with rounded corners, and with the shear and stretch of the strip.

    Along the strip's direction (c, s) a pull F along y has the normal force F s and the shear force F c; Cowper's
    coefficient for a rectangle turns shear force into shear (doi 10.1115/1.3625046). A guide's own shear is left out.
    """
    bending = compliance_m_per_n(geometry, youngs_modulus_pa, guided=guided, rounded=True)
    area = geometry.depth_m * geometry.thickness_m
    shear_modulus = youngs_modulus_pa / (2.0 * (1.0 + poisson_ratio))
    coefficient = 10.0 * (1.0 + poisson_ratio) / (12.0 + 11.0 * poisson_ratio)
    sheared = stretched = 0.0
    for piece in geometry.centre_line():
        if isinstance(piece, CentreLineArc):
            sheared += 0.5 * piece.length_m
            stretched += 0.5 * piece.length_m
        elif abs(piece.end_m[0] - piece.start_m[0]) > abs(piece.end_m[1] - piece.start_m[1]):
            sheared += piece.length_m
        else:
            stretched += piece.length_m
    rest = sheared / (coefficient * shear_modulus * area) + stretched / (youngs_modulus_pa * area)
    return 1.0 / (bending + rest)
