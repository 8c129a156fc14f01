"""Shape of a finger at an equilibrium: its centre line, its outline, the path of its tendon."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from musclewire.arrays import FloatArray
from musclewire_design._finger.chain import GAUSS
from musclewire_design._finger.geometry import HOLE_RADIUS_M, FingerGeometry


@dataclass(frozen=True)
class FingerShape:
    """Places along a finger [m], palm at x = 0: frames are rows of x, y, angle.

    ``segments`` (n_columns, n_nodes, 3) run along the middle of the beam, ``columns`` (n_columns, 2, 3) are the frames
    where a column begins and ends, ``endpoint`` (3,) is that at the end of the plate.
    """

    geometry: FingerGeometry
    segments: FloatArray
    columns: FloatArray
    endpoint: FloatArray

    def tendon(self, guided: tuple[int, ...] | None = None) -> FloatArray:
        """Return the path of the tendon, (n_points, 2) [m], from the palm through the holes of the columns."""
        offset = self.geometry.tendon_offset_m
        holes = range(self.geometry.columns) if guided is None else guided
        ends = [beside(self.columns[column], offset) for column in holes]
        return np.vstack([[[0.0, offset]], *ends])

    def isolators(self) -> list[FloatArray]:
        """Return the outer parts of the columns, beyond their holes, (4, 2) [m] each."""
        low, high = self.geometry.tendon_offset_m + HOLE_RADIUS_M, self.geometry.column_height_m
        return [np.vstack([beside(column, low), beside(column[::-1], high)]) for column in self.columns]

    def outline(self) -> FloatArray:
        """Return the outline, (n_points, 2) [m]: from the palm along the back, around the plate, back over the columns.

        Open at the palm, where the caller adds the part that holds the finger.
        """
        geometry, half = self.geometry, 0.5 * self.geometry.beam_thickness_m
        plate_end = np.vstack([self.columns[-1, 1], self.endpoint])
        back = [np.vstack([part, column]) for part, column in zip(self.segments, self.columns, strict=True)]
        points = [beside(np.vstack([*back, plate_end]), -half)]
        points.append(beside(plate_end[::-1], geometry.plate_thickness_m - half))
        for part, column in zip(self.segments[::-1], self.columns[::-1], strict=True):
            points.append(beside(column[::-1], geometry.column_height_m))
            points.append(beside(part[::-1], half))
        return without_repeats(np.vstack(points))


def finger_shape(geometry: FingerGeometry, angles_rad: FloatArray) -> FingerShape:
    """Return the shape of a finger at the angles of its chain.

    Parameters
    ----------
    geometry
        Dimensions of the finger.
    angles_rad
        Angle of the beam at the end of each element [rad], (n_angles,), from palm to plate, as an equilibrium has them.

    Returns
    -------
    Places along segments, columns and plate [m], palm at x = 0.
    """
    nodes = np.concatenate([[0.0], angles_rad])
    per_segment = angles_rad.size // geometry.columns
    step = geometry.segment_length_m / per_segment
    place, segments, columns = np.zeros(2), [], []
    for column in range(geometry.columns):
        angle = nodes[column * per_segment : (column + 1) * per_segment + 1]
        at = np.add.outer(angle[:-1], np.zeros(2)) + np.multiply.outer(np.diff(angle), np.array(GAUSS))
        moves = step * np.stack([np.cos(at).mean(axis=1), np.sin(at).mean(axis=1)], axis=1)
        places = place + np.vstack([np.zeros((1, 2)), np.cumsum(moves, axis=0)])
        segments.append(np.column_stack([places, angle]))
        along = np.array([np.cos(angle[-1]), np.sin(angle[-1])])
        place = places[-1] + geometry.column_width_m * along
        columns.append(np.array([[*places[-1], angle[-1]], [*place, angle[-1]]]))
    end = place + geometry.plate_length_m * along
    return FingerShape(geometry, np.array(segments), np.array(columns), np.array([*end, angle[-1]]))


def beside(frames: FloatArray, height_m: float) -> FloatArray:
    """Return the points at a height above the middle of the beam, towards the tendon, (..., 2) [m]."""
    normal = np.stack([-np.sin(frames[..., 2]), np.cos(frames[..., 2])], axis=-1)
    return np.asarray(frames[..., :2] + height_m * normal)


def without_repeats(points: FloatArray) -> FloatArray:
    """Return points (n, 2) without consecutive duplicates."""
    moved = np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-9
    return np.asarray(points[np.concatenate([[True], moved])])
