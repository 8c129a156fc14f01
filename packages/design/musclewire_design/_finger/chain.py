"""The finger as a chain of angles: positions of its points, length of its tendon, and the derivatives of both.

Flexible segments are cut into elements whose angle runs linearly; columns and plate keep the angle of the node they are
on. Every vector of interest, the chords of the tendon and the way from palm to endpoint, is a weighted sum of unit
vectors e(angle + phase), the angles linear in the unknown node angles. So first and second derivatives are two matrix
products, and nothing is differentiated by hand twice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from musclewire.arrays import FloatArray
from musclewire_design._finger.geometry import FingerGeometry

ELEMENTS_PER_SEGMENT = 8
FOOT_THICKNESSES = 16.67 / (12.0 * math.pi)
# Two Gauss points on each element: the end of an element bent by 0.1 rad is right to 1e-8 of its length.
GAUSS = (0.5 - math.sqrt(1.0 / 12.0), 0.5 + math.sqrt(1.0 / 12.0))


@dataclass(frozen=True)
class AngleChain:
    """A chain of ``n_angles`` unknown angles [rad]; ``n_terms`` unit vectors; one chord for each flexible segment.

    ``angle_of_term`` (n_terms, n_angles) and ``phase_rad`` (n_terms,) give the angle of each unit vector, ``chords_m``
    (n_chords, n_terms) and ``endpoint_m`` (n_terms,) the weights of the vectors of interest, ``turns`` (n_elements,
    n_angles) the bend of each element, ``yielding_m`` and ``natural_turn_rad`` (n_elements,) the length with which it
    bends and its bend without load, ``column_nodes`` the index of each column's angle.
    """

    angle_of_term: FloatArray
    phase_rad: FloatArray
    chords_m: FloatArray
    endpoint_m: FloatArray
    turns: FloatArray
    yielding_m: FloatArray
    natural_turn_rad: FloatArray
    column_nodes: tuple[int, ...]

    @property
    def resting_angles_rad(self) -> FloatArray:
        """Angles of the chain with no load, (n_angles,)."""
        return np.cumsum(self.natural_turn_rad)


@dataclass(frozen=True)
class PlacedChain:
    """A chain at given angles: chord vectors (n_chords, 2) and endpoint (2,) [m], and their unit vectors."""

    chain: AngleChain
    unit: FloatArray
    chord_vectors_m: FloatArray
    endpoint_m: FloatArray

    @property
    def chord_lengths_m(self) -> FloatArray:
        """Lengths of the chords, (n_chords,) [m]."""
        return np.asarray(np.hypot(self.chord_vectors_m[:, 0], self.chord_vectors_m[:, 1]))

    def across_slope(self) -> FloatArray:
        """Return the gradient of the endpoint's place across the finger, (n_angles,) [m/rad]."""
        return np.asarray((self.chain.endpoint_m * self.unit[:, 0]) @ self.chain.angle_of_term)

    def chord_slopes(self) -> FloatArray:
        """Return the gradients of all chord lengths, (n_chords, n_angles) [m/rad]."""
        toward = self.chord_vectors_m / self.chord_lengths_m[:, None]
        turned = toward[:, 1:] * self.unit[:, 0] - toward[:, :1] * self.unit[:, 1]
        return np.asarray((self.chain.chords_m * turned) @ self.chain.angle_of_term)

    def curvature_of(self, chord_weights: FloatArray, across_weight: float) -> FloatArray:
        """Return the second derivatives of a weighted sum of chord lengths and endpoint, (n_angles, n_angles)."""
        chain, lengths = self.chain, self.chord_lengths_m
        toward = self.chord_vectors_m / lengths[:, None]
        # Along each unit vector the second derivative points back to its origin ...
        back = ((chord_weights[:, None] * chain.chords_m) * (toward @ self.unit.T)).sum(axis=0)
        back += across_weight * chain.endpoint_m * self.unit[:, 1]
        # ... and a chord that is moved sideways grows longer.
        sideways = toward[:, :1] * self.unit[:, 0] + toward[:, 1:] * self.unit[:, 1]
        side = (chain.chords_m * sideways) @ chain.angle_of_term
        grown = side.T @ ((chord_weights / lengths)[:, None] * side)
        return np.asarray(grown - chain.angle_of_term.T @ (back[:, None] * chain.angle_of_term))


def place(chain: AngleChain, angles_rad: FloatArray) -> PlacedChain:
    """Return a chain at the given angles, (n_angles,) [rad]."""
    angle = chain.angle_of_term @ angles_rad + chain.phase_rad
    unit = np.column_stack([np.cos(angle), np.sin(angle)])
    return PlacedChain(chain, unit, chain.chords_m @ unit, chain.endpoint_m @ unit)


def finger_chain(
    geometry: FingerGeometry,
    *,
    guided: tuple[int, ...] | None = None,
    elements_per_segment: int = ELEMENTS_PER_SEGMENT,
) -> AngleChain:
    """Return the chain of a finger whose tendon runs through the palm and all columns, or only those ``guided``.

    ``guided`` counts columns from 0 at the palm, rising; the tendon is fastened to its last. Two neighbouring guides
    are joined by a straight chord.
    """
    columns, count = geometry.columns, geometry.columns * elements_per_segment
    rows = TermRows(count)
    palm = rows.add({}, 0.5 * math.pi)
    tangents: list[int] = []
    normals: list[int] = []
    elements: list[list[int]] = []
    for column in range(columns):
        elements.append([])
        for element in range(elements_per_segment):
            node = column * elements_per_segment + element  # the element runs from node - 1 to node; -1 is the palm
            elements[-1] += [rows.add({node - 1: 1.0 - at, node: at}) for at in GAUSS]
        last = (column + 1) * elements_per_segment - 1
        tangents.append(rows.add({last: 1.0}))
        normals.append(rows.add({last: 1.0}, 0.5 * math.pi))
    along = np.zeros((columns, len(rows.phases)))  # each segment with the column after it
    for column in range(columns):
        along[column, elements[column]] = 0.5 * geometry.segment_length_m / elements_per_segment
        along[column, tangents[column]] = geometry.column_width_m
    endpoint = along.sum(axis=0)
    endpoint[tangents[-1]] += geometry.plate_length_m
    chords = chord_weights(
        geometry, along, tangents, [*normals, palm], tuple(range(columns)) if guided is None else guided
    )
    nodes = tuple((column + 1) * elements_per_segment - 1 for column in range(columns))
    yielding = yielding_lengths_m(geometry, elements_per_segment)
    return chain_of(rows, chords, endpoint, yielding, geometry.inward_angle_rad / count, nodes)


def chord_weights(
    geometry: FingerGeometry, along: FloatArray, tangents: list[int], normals: list[int], holes: tuple[int, ...]
) -> FloatArray:
    """Return the weights of the chords between ``holes``, (n_holes, n_terms) [m].

    ``along`` (n_columns, n_terms) leads along each segment and its column, ``tangents`` and ``normals`` are the unit
    vectors of the columns; the last of ``normals`` is the palm's.
    """
    chords = np.zeros((len(holes), along.shape[1]))
    before = -1
    for row, hole in enumerate(holes):
        chords[row] = along[before + 1 : hole + 1].sum(axis=0)
        chords[row, tangents[hole]] = 0.0  # up to where the tendon enters the hole
        chords[row, normals[hole]] += geometry.tendon_offset_m
        chords[row, normals[before]] -= geometry.tendon_offset_m
        before = hole
    return chords


def yielding_lengths_m(geometry: FingerGeometry, elements_per_segment: int) -> FloatArray:
    """Return the effective bending length of each element, (n_elements,) [m]: at a column's foot more than its own.

    The foot of a beam on an elastic body rotates under a moment M by 16.67 M/(pi E b t^2), as another 0.442 t of beam
    would: O'Donnell 1960, J. Appl. Mech. 27, 461 (a half plane; tests compare 0.442 with finite elements). The palm is
    taken as a rigid clamp. The foot is distributed over the element next to it, an eighth of a segment, about the
    beam's thickness; with four times as many elements the tendon's force is 0.2 % larger.
    """
    lengths = np.full((geometry.columns, elements_per_segment), geometry.segment_length_m / elements_per_segment)
    lengths[:, -1] += FOOT_THICKNESSES * geometry.beam_thickness_m
    lengths[1:, 0] += FOOT_THICKNESSES * geometry.beam_thickness_m
    return np.asarray(lengths.ravel())


def cantilever_chain(length_m: float, elements: int) -> AngleChain:
    """Return a plain cantilever without columns, plate or tendon, for comparison with published tables."""
    rows = TermRows(elements)
    for node in range(elements):
        for at in GAUSS:
            rows.add({node - 1: 1.0 - at, node: at})
    endpoint = np.full(2 * elements, 0.5 * length_m / elements)
    return chain_of(
        rows, np.zeros((0, 2 * elements)), endpoint, np.full(elements, length_m / elements), 0.0, (elements - 1,)
    )


class TermRows:
    """Collects unit vectors: the weights of the node angles in each, and its phase."""

    def __init__(self, n_angles: int) -> None:
        """Begin with none."""
        self.n_angles = n_angles
        self.rows: list[FloatArray] = []
        self.phases: list[float] = []

    def add(self, weights: dict[int, float], phase_rad: float = 0.0) -> int:
        """Add a unit vector and return its index; the palm's angle, node -1, is 0 and left out."""
        row = np.zeros(self.n_angles)
        for node, weight in weights.items():
            if node >= 0:
                row[node] = weight
        self.rows.append(row)
        self.phases.append(phase_rad)
        return len(self.rows) - 1


def chain_of(
    rows: TermRows,
    chords_m: FloatArray,
    endpoint_m: FloatArray,
    yielding_m: FloatArray,
    natural_turn_rad: float,
    column_nodes: tuple[int, ...],
) -> AngleChain:
    """Return the chain of collected unit vectors."""
    turns = np.eye(rows.n_angles) - np.eye(rows.n_angles, k=-1)
    return AngleChain(
        np.array(rows.rows),
        np.array(rows.phases),
        chords_m,
        endpoint_m,
        turns,
        yielding_m,
        np.full(rows.n_angles, natural_turn_rad),
        column_nodes,
    )
