"""The finger as a flat elastic body with large displacements, without the chain's rigid columns and thin beam.

Beam, columns and plate are one piece and all elastic. The tendon is the same: straight chords between holes, one force
along all of them; it enters as the potential of a constant force, minus force times travel.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array

from musclewire.arrays import FloatArray
from musclewire_design._elasticity import BodyEquilibrium, BodyLoad, PotentialChange, load_path
from musclewire_design._finger.geometry import HOLE_RADIUS_M, FingerGeometry
from musclewire_design._plane_body import PlaneBody

ALONG_SEGMENT, ALONG_COLUMN, ALONG_PLATE, THROUGH_BEAM, UP_COLUMN, AT_HOLE = 10, 3, 8, 2, 3, 1


class PlaneStressPoint(NamedTuple):
    """The finger under one tendon force (both legs): travel, endpoint displacement, largest stress in the segments.

    The stress is von Mises', averaged at nodes, away from the corners at the columns' feet, where it is singular
    without a fillet.
    """

    tendon_force_n: float
    travel_m: float
    endpoint_displacement_m: float
    stress_pa: float


@dataclass(frozen=True)
class FingerBody:
    """A meshed finger: the body, the nodes of the palm, of the holes and of the endpoint.

    ``holes`` (n_holes, 2, n_around) has the nodes around each hole's entry and exit, on which the tendon presses
    evenly; ``guide_m`` (2,) is the point where it leaves the palm; ``middles`` are nodes at the middle of each
    segment's faces.
    """

    body: PlaneBody
    palm: np.ndarray[Any, np.dtype[np.int64]]
    holes: np.ndarray[Any, np.dtype[np.int64]]
    endpoint: int
    guide_m: FloatArray
    middles: np.ndarray[Any, np.dtype[np.int64]]

    def chords(self, displacement_m: FloatArray) -> FloatArray:
        """Return the tendon's chords as vectors, (n_chords, 2) [m]."""
        holes = (self.body.nodes_m + displacement_m)[self.holes].mean(axis=2)
        return np.asarray(holes[:, 0] - np.vstack([self.guide_m, holes[:-1, 1]]))

    @cached_property
    def chord_maps(self) -> list[csr_array]:
        """How each chord follows the displacements: (2, n_dofs) each."""
        return [self._chord_map(index) for index in range(len(self.holes))]

    def _chord_map(self, index: int) -> csr_array:
        ends = [(1.0, self.holes[index, 0])] + ([(-1.0, self.holes[index - 1, 1])] if index else [])
        dofs = [2 * nodes + axis for _, nodes in ends for axis in (0, 1)]
        axes = [np.full(nodes.size, axis) for _, nodes in ends for axis in (0, 1)]
        weights = [np.full(nodes.size, sign / nodes.size) for sign, nodes in ends for _ in (0, 1)]
        places = (np.concatenate(axes), np.concatenate(dofs))
        return csr_array((np.concatenate(weights), places), shape=(2, self.body.n_dofs))

    def travel_m(self, displacement_m: FloatArray) -> float:
        """Return the shortening of the tendon's chords [m]."""
        before, after = self.chords(np.zeros_like(displacement_m)), self.chords(displacement_m)
        return float(np.linalg.norm(before, axis=1).sum() - np.linalg.norm(after, axis=1).sum())

    def pulled_by(self, force_n: float, displacement_m: FloatArray, load_fraction: float) -> PotentialChange:
        """Return the potential of a tendon force of ``share * force_n``: minus force times travel."""
        force, size = load_fraction * force_n, self.body.n_dofs
        gradient, hessian = np.zeros(size), csr_array((size, size))
        for chord, follow in zip(self.chords(displacement_m), self.chord_maps, strict=True):
            length = float(np.linalg.norm(chord))
            toward = chord / length
            square = csr_array(force / length * (np.eye(2) - np.outer(toward, toward)))
            gradient += force * (follow.T @ toward)
            hessian = hessian + follow.T @ square @ follow
        return PotentialChange(-force * self.travel_m(displacement_m), gradient, csr_array(hessian))


def plane_stress_path(meshed: FingerBody, force_n: float, load_fractions: FloatArray) -> Iterator[PlaneStressPoint]:
    """Yield the finger under rising fractions of a tendon force [N]. Raises NumericsError if it finds no balance."""
    load = BodyLoad(
        prescribed_m=BodyLoad.held(meshed.palm),
        potential=lambda displacement, load_fraction: meshed.pulled_by(force_n, displacement, load_fraction),
    )
    for at in load_path(meshed.body, load, load_fractions):
        yield point_of(meshed, at, force_n)


def point_of(meshed: FingerBody, at: BodyEquilibrium, force_n: float) -> PlaneStressPoint:
    """Return a body's balance as a point of the finger."""
    return PlaneStressPoint(
        at.load_fraction * force_n,
        meshed.travel_m(at.displacement_m),
        float(at.displacement_m[meshed.endpoint, 1]),
        float(at.von_mises_pa[meshed.middles].max()),
    )


def finger_body(geometry: FingerGeometry, poisson_ratio: float, refined: int = 1) -> FingerBody:
    """Return a finger cut into quadrilaterals, ``refined`` times as many along each direction.

    A straight grid without its empty parts is bent to the unloaded shape.
    """
    import skfem

    along, spans = lines_along(geometry, refined)
    across = lines_across(geometry, refined)
    whole = skfem.MeshQuad.init_tensor(along, across)
    kept = np.flatnonzero(inside(geometry, spans, *whole.p[:, whole.t].mean(axis=1)))
    straight = whole.restrict(elements=kept)
    mesh = skfem.MeshQuad(bent(geometry, spans, straight.p.T).T, straight.t)
    body = PlaneBody.of_mesh(mesh, geometry.beam_depth_m, geometry.youngs_modulus_pa, poisson_ratio)

    def nearest(s_m: float, height_m: float) -> int:
        place = bent(geometry, spans, np.array([[s_m, height_m]]))
        return int(np.argmin(np.linalg.norm(body.nodes_m - place, axis=1)))

    around = geometry.tendon_offset_m + HOLE_RADIUS_M * np.linspace(-1.0, 1.0, 4 * AT_HOLE * refined + 1)
    holes = [[[nearest(s, float(height)) for height in around] for s in span] for span in spans]
    half, segment = 0.5 * geometry.beam_thickness_m, geometry.segment_length_m
    middles = [nearest(start - 0.5 * segment, side) for start, _ in spans for side in (-half, half)]
    return FingerBody(
        body,
        np.flatnonzero(np.abs(body.nodes_m[:, 0]) < 1e-9 * geometry.overall_length_m),
        np.array(holes),
        nearest(geometry.overall_length_m, 0.0),
        np.array([0.0, geometry.tendon_offset_m]),
        np.array(middles),
    )


def lines_along(geometry: FingerGeometry, refined: int) -> tuple[FloatArray, list[tuple[float, float]]]:
    """Return the grid's lines along the finger [m], and where each column begins and ends."""
    pieces, spans, at = [np.zeros(1)], [], 0.0
    for _ in range(geometry.columns):
        foot = at + geometry.segment_length_m
        end = foot + geometry.column_width_m
        pieces += [np.linspace(at, foot, ALONG_SEGMENT * refined + 1)[1:]]
        pieces += [np.linspace(foot, end, ALONG_COLUMN * refined + 1)[1:]]
        spans.append((foot, end))
        at = end
    pieces.append(np.linspace(at, geometry.overall_length_m, ALONG_PLATE * refined + 1)[1:])
    return np.concatenate(pieces), spans


def lines_across(geometry: FingerGeometry, refined: int) -> FloatArray:
    """Return the grid's lines across the finger [m], from the beam's back to the columns' ends."""
    half = 0.5 * geometry.beam_thickness_m
    plate = geometry.plate_thickness_m - half
    low, high = geometry.tendon_offset_m - HOLE_RADIUS_M, geometry.tendon_offset_m + HOLE_RADIUS_M
    # A line too close to a hole's edge would make needles of elements: the plate ends at the hole's line instead.
    marks = [half, low, high, geometry.column_height_m]
    if min(abs(plate - mark) for mark in marks) > 0.05 * geometry.tendon_offset_m and not low < plate < high:
        marks.append(plate)
    pieces = [np.linspace(-half, half, THROUGH_BEAM * refined + 1)]
    for bottom, top in pairwise(sorted(marks)):
        count = 2 * AT_HOLE if bottom == low else UP_COLUMN
        pieces.append(np.linspace(bottom, top, count * refined + 1)[1:])
    return np.concatenate(pieces)


def inside(
    geometry: FingerGeometry, spans: list[tuple[float, float]], s_m: FloatArray, height_m: FloatArray
) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return which places of the straight grid are material, (n_places,)."""
    half = 0.5 * geometry.beam_thickness_m
    beam = height_m < half
    column = np.any([(s_m > start) & (s_m < end) for start, end in spans], axis=0)
    plate = (s_m > spans[-1][1]) & (height_m < geometry.plate_thickness_m - half)
    return np.asarray(beam | column | plate)


def bent(geometry: FingerGeometry, spans: list[tuple[float, float]], places_m: FloatArray) -> FloatArray:
    """Return places (n_places, 2) [m] of the straight finger on the unloaded one, whose segments are arcs."""
    turn, segment = geometry.inward_angle_rad / geometry.columns, geometry.segment_length_m
    found, s, height = np.zeros_like(places_m), places_m[:, 0], places_m[:, 1]
    origin, angle = np.zeros(2), 0.0
    for index, (foot, _) in enumerate(spans):
        reach = np.clip(s - (foot - segment), 0.0, segment)
        here = (s >= foot - segment) if index == 0 else (s > foot - segment)
        end = spans[index + 1][0] - segment if index + 1 < len(spans) else np.inf
        here &= s <= end
        found[here] = on_piece(origin, angle, turn, segment, reach[here], s[here] - foot, height[here])
        width = end - foot if np.isfinite(end) else 0.0
        origin = on_piece(origin, angle, turn, segment, np.array([segment]), np.array([width]), np.zeros(1))[0]
        angle += turn
    return found


def on_piece(
    origin: FloatArray,
    angle: float,
    turn: float,
    segment: float,
    reach: FloatArray,
    beyond: FloatArray,
    height: FloatArray,
) -> FloatArray:
    """Return places on one segment and the straight piece after it: ``reach`` along the arc, then ``beyond``."""
    part = turn * reach / segment
    # The chord of an arc, and the direction it has.
    chord, middle, end = reach * np.sinc(0.5 * part / np.pi), angle + 0.5 * part, angle + part
    straight = np.maximum(beyond, 0.0)
    along = origin[0] + chord * np.cos(middle) + straight * np.cos(end) - height * np.sin(end)
    return np.column_stack([along, origin[1] + chord * np.sin(middle) + straight * np.sin(end) + height * np.cos(end)])
