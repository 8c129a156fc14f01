"""A serpentine as a strip in plane stress: quadrilaterals mapped along its centre line, no mesher needed.

The strip ends at pad and connector: both are thick and hardly bend. At the pad it is held; at the connector it is
pulled by forces distributed evenly over its end, whose resultant is on the axis, so that it may turn and move sideways
as a connector on a string does; or, guided, all of its end is displaced.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray, IntArray
from musclewire.errors import CallerError
from musclewire.parameters import Material
from musclewire_design._elasticity import BodyEquilibrium, BodyLoad, load_path, solve_large, solve_linear
from musclewire_design._plane_body import PlaneBody
from musclewire_design._serpentine.closed_form import places_on
from musclewire_design._serpentine.geometry import CentreLineArc, SerpentineGeometry

# Elements across the strip: the meshes whose answers are compared.
MESHES = (1, 2, 3, 4)
FINEST = MESHES[-1]
# Elements of a straight piece are about this many times as long as wide, but at most so many per element across: the
# uniform bending of a slender strip needs few. A corner has two per element across, and two more: its sides are chords,
# and few of them would cut it.
SLENDER, MAX_ALONG, ARC_ELEMENTS, ARC_MORE = 2.0, 8, 2, 2
CURVE_STEPS, FURTHEST = 8, 2.5


class LinearAnswer(NamedTuple):
    """Small displacements: stiffness along the wire [N/m], largest von Mises stress per newton of pull [Pa/N]."""

    stiffness_n_per_m: float
    stress_pa_per_n: float
    unknowns: int


class ForceCurve(NamedTuple):
    """Large displacements: connector travel [m], pull [N] and largest von Mises stress [Pa], each (n,) from 0 up.

    ``safe_travel_m`` is the travel at which the stress reaches the allowed one, ``furthest`` the last balance computed.
    """

    travel_m: FloatArray
    force_n: FloatArray
    stress_pa: FloatArray
    safe_travel_m: float
    furthest: BodyEquilibrium

    def force_at(self, travel_m: float) -> float:
        """Return the pull [N] at a travel [m]; NaN beyond the curve."""
        return interpolated(self.travel_m, self.force_n, travel_m)

    def stress_at(self, travel_m: float) -> float:
        """Return the largest von Mises stress [Pa] at a travel [m]; NaN beyond the curve."""
        return interpolated(self.travel_m, self.stress_pa, travel_m)


def interpolated(x: FloatArray, y: FloatArray, at: float) -> float:
    """Return y at a place by a monotone cubic through the points; NaN outside."""
    from scipy.interpolate import PchipInterpolator

    return float(PchipInterpolator(x, y, extrapolate=False)(at))


def strip_mesh(geometry: SerpentineGeometry, across: int) -> Any:
    """Return the strip as a scikit-fem mesh [m] ``across`` elements thick. Raises CallerError for fewer than 1."""
    if across < 1:
        raise CallerError(f"a strip has 1 element across or more, not {across}")
    import skfem

    points, normals = sections(geometry, across)
    offsets = geometry.thickness_m * np.linspace(-0.5, 0.5, across + 1)
    nodes = points[:, None, :] + offsets[None, :, None] * normals[:, None, :]
    index = np.arange(nodes.shape[0] * nodes.shape[1]).reshape(nodes.shape[:2])
    quads = [index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]]
    return skfem.MeshQuad(nodes.reshape(-1, 2).T.copy(), np.stack([quad.ravel() for quad in quads]))


def sections(geometry: SerpentineGeometry, across: int) -> tuple[FloatArray, FloatArray]:
    """Return the points between elements along the strip (n, 2) [m], and the unit normals to its left there (n, 2)."""
    points: list[FloatArray] = []
    tangents: list[FloatArray] = []
    for piece in geometry.centre_line():
        if isinstance(piece, CentreLineArc):
            fraction = np.linspace(0.0, 1.0, ARC_ELEMENTS * across + ARC_MORE + 1)
            angle = piece.start_rad + fraction * piece.turn_rad
            tangent = math.copysign(1.0, piece.turn_rad) * np.stack([-np.sin(angle), np.cos(angle)], axis=1)
        else:
            count = math.ceil(piece.length_m * across / (SLENDER * geometry.thickness_m))
            count = min(count, MAX_ALONG * across)
            fraction = np.linspace(0.0, 1.0, max(count, 2) + 1)
            way = (np.array(piece.end_m) - np.array(piece.start_m)) / piece.length_m
            tangent = np.broadcast_to(way, (fraction.size, 2))
        first = 1 if points else 0  # a piece begins where the last one ended
        points.append(places_on(piece, fraction)[first:])
        tangents.append(tangent[first:])
    along = np.concatenate(tangents)
    return np.concatenate(points), np.stack([-along[:, 1], along[:, 0]], axis=1)


def strip_body(geometry: SerpentineGeometry, material: Material, across: int = FINEST) -> PlaneBody:
    """Return the strip as an elastic body."""
    return PlaneBody.of_mesh(
        strip_mesh(geometry, across),
        geometry.depth_m,
        material.youngs_modulus_pa.value,
        material.poisson_ratio.value,
    )


class StripEnds(NamedTuple):
    """A strip's ends: nodes held at the pad, nodes at the connector, and the weight of a pull on each of these."""

    held: IntArray
    pulled: IntArray
    weights: FloatArray

    @classmethod
    def of_body(cls, body: PlaneBody, geometry: SerpentineGeometry) -> StripEnds:
        """Find the ends of a body made by strip_body."""
        near = 1e-6 * geometry.thickness_m
        held = body.nodes_near(y_m=geometry.fittings.pad_height_m, within_m=near)
        pulled = body.nodes_near(y_m=geometry.connector_m, within_m=near)
        pulled = pulled[np.argsort(body.nodes_m[pulled, 0])]
        # Even traction on sides of quadratic elements: Simpson's 1, 4, 1, shared where elements meet.
        weights = np.full(pulled.size, 2.0)
        weights[1::2], weights[[0, -1]] = 4.0, 1.0
        return cls(held, pulled, weights / weights.sum())

    def travel_m(self, displacement_m: FloatArray) -> float:
        """Return the connector's displacement along the wire [m]."""
        return float(self.weights @ displacement_m[self.pulled, 1])

    def pulling(self, body: PlaneBody, force_n: float) -> BodyLoad:
        """Return the load of a pull along the wire."""
        forces = np.zeros_like(body.nodes_m)
        forces[self.pulled, 1] = force_n * self.weights
        return BodyLoad(BodyLoad.held(self.held), forces)


def linear_answer(
    geometry: SerpentineGeometry, material: Material, across: int = FINEST, *, guided: bool = False
) -> LinearAnswer:
    """Return stiffness and stress for small displacements; ``guided``: the end cannot turn or move sideways."""
    body = strip_body(geometry, material, across)
    ends = StripEnds.of_body(body, geometry)
    if guided:
        prescribed_m = BodyLoad.held(ends.held) | BodyLoad.moved(ends.pulled, {0: 0.0, 1: 1e-6})
        found = solve_linear(body, BodyLoad(prescribed_m))
        force, travel = float(found.reaction_n(ends.pulled)[1]), 1e-6
    else:
        force = 1.0
        found = solve_linear(body, ends.pulling(body, force))
        travel = ends.travel_m(found.displacement_m)
    return LinearAnswer(force / travel, float(found.von_mises_pa.max()) / force, body.n_dofs)


def force_curve(
    geometry: SerpentineGeometry, material: Material, min_travel_m: float, across: int = FINEST
) -> ForceCurve:
    """Return force and stress over travel with large displacements, to the safe travel and ``min_travel_m``.

    Raises NumericsError if no balance is found.
    """
    allowed = material.allowable_stress_pa.value
    linear = linear_answer(geometry, material, across)
    body = strip_body(geometry, material, across)
    ends = StripEnds.of_body(body, geometry)
    unit_n = max(allowed / linear.stress_pa_per_n, min_travel_m * linear.stiffness_n_per_m)
    rows = [(0.0, 0.0, 0.0)]

    def far_enough(state: BodyEquilibrium) -> bool:
        rows.append(
            (ends.travel_m(state.displacement_m), state.load_fraction * unit_n, float(state.von_mises_pa.max()))
        )
        return rows[-1][0] >= min_travel_m and rows[-1][2] >= allowed

    load_fractions = np.arange(1, round(FURTHEST * CURVE_STEPS) + 1) / CURVE_STEPS
    states = list(load_path(body, ends.pulling(body, unit_n), load_fractions, far_enough))
    travel, force, stress = np.array(rows).T
    safe = float(np.interp(allowed, np.maximum.accumulate(stress), travel))
    if (np.diff(stress) > 0.0).all() and stress[-1] >= allowed:
        safe = interpolated(stress, travel, allowed)
    return ForceCurve(travel, force, stress, safe, states[-1])


def pulled_strip(
    geometry: SerpentineGeometry, material: Material, force_n: float, across: int = FINEST
) -> BodyEquilibrium:
    """Return the balance under a pull [N] along the wire. Raises NumericsError if there is none."""
    body = strip_body(geometry, material, across)
    return solve_large(body, StripEnds.of_body(body, geometry).pulling(body, force_n), steps=2)
