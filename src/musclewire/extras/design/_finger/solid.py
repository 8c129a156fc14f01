"""The finger as a solid to be printed: the drawing by its depth, with the holes of the tendon's two legs.

A taut tendon lies on the side of its holes that faces away from the beam. That side stays where it is for a hole of
0.3 mm, on which all numbers are based; a larger hole, which a printer needs, grows towards the beam.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.extras.design._finger.chain import finger_chain
from musclewire.extras.design._finger.drawing import BLOCK_LENGTH_M, finger_drawing
from musclewire.extras.design._finger.geometry import HOLE_RADIUS_M, FingerGeometry
from musclewire.extras.design._finger.shape import beside, finger_shape
from musclewire.extras.design._finger.sizing import WALL_M
from musclewire.extras.design._solid import Solid, StraightBore, write_solid

# Where in the depth the two legs run.
LEGS = (0.25, 0.75)
TENDON_HOLE_M = 2.0 * HOLE_RADIUS_M


def finger_solid(geometry: FingerGeometry, tendon_hole_m: float = TENDON_HOLE_M, title: str = "finger") -> Solid:
    """Return the unloaded finger as a solid, with tendon holes of a diameter [m].

    Raises CallerError for holes that would cut the beam or leave no wall between the legs.
    """
    require_room(geometry, tendon_hole_m)
    shape = finger_shape(geometry, finger_chain(geometry).resting_angles_rad)
    high = geometry.tendon_offset_m + HOLE_RADIUS_M - 0.5 * tendon_hole_m
    ways = [np.array([[-BLOCK_LENGTH_M, high], [0.0, high]]), *(beside(column, high) for column in shape.columns)]
    bores = [
        StraightBore(point(way[0]), point(way[1]), leg * geometry.beam_depth_m, tendon_hole_m)
        for way in ways
        for leg in LEGS
    ]
    return Solid(finger_drawing(geometry, title), geometry.beam_depth_m, tuple(bores))


def point(place: FloatArray) -> tuple[float, float]:
    """Return a place (2,) as two numbers."""
    return float(place[0]), float(place[1])


def require_room(geometry: FingerGeometry, tendon_hole_m: float) -> None:
    """Raise CallerError unless there is a wall between hole and beam, and around each of the two legs."""
    beside_beam = geometry.tendon_offset_m + HOLE_RADIUS_M - 0.5 * geometry.beam_thickness_m - WALL_M
    in_depth = 0.5 * geometry.beam_depth_m - WALL_M
    for room_m, where in ((beside_beam, "between tendon and beam"), (in_depth, "for each leg in the depth")):
        if not 0.0 < tendon_hole_m <= room_m:
            raise CallerError(
                f"a tendon hole of {1e3 * tendon_hole_m:g} mm does not fit: {where} there is room for "
                f"{1e3 * room_m:.2f} mm; a smaller hole, a thinner beam or more travel"
            )


def write_finger_solid(geometry: FingerGeometry, path: Path, tendon_hole_m: float = TENDON_HOLE_M) -> None:
    """Write the solid as .stl or .step.

    Raises CallerError for another ending, holes that do not fit or a folder that cannot be written, MissingExtraError
    without the extra 'cad'.
    """
    write_solid(finger_solid(geometry, tendon_hole_m), path)
