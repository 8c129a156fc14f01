"""The finger as drawing and solid, to be cut or printed, one to one: unloaded, with a block that holds it at the palm.

The holes for the tendon run along the finger, within the sheet: they are drilled and not in the outline.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire_design._drawing import Drawing, DrawnHole, OutlineVertex, write_drawing
from musclewire_design._finger.chain import finger_chain
from musclewire_design._finger.geometry import HOLE_RADIUS_M, FingerGeometry
from musclewire_design._finger.shape import beside, finger_shape
from musclewire_design._finger.sizing import WALL_M
from musclewire_design._solid import Solid, StraightBore, write_solid

# The block at the palm: room for two M2 screws below the tendon's guide.
BLOCK_LENGTH_M, BLOCK_BELOW_M = 8e-3, 5e-3
SCREW_HOLE_M = 2.2e-3
MM = 1e3


def finger_drawing(geometry: FingerGeometry, title: str = "finger") -> Drawing:
    """Return the drawing of an unloaded finger with its block; lengths in metres, the palm's face at x = 0."""
    shape = finger_shape(geometry, finger_chain(geometry).resting_angles_rad)
    high = geometry.column_height_m
    block = [(0.0, high), (-BLOCK_LENGTH_M, high), (-BLOCK_LENGTH_M, -BLOCK_BELOW_M), (0.0, -BLOCK_BELOW_M)]
    ring = [(float(x), float(y)) for x, y in shape.outline()] + block
    screws = [DrawnHole(fraction * BLOCK_LENGTH_M, -0.5 * BLOCK_BELOW_M, SCREW_HOLE_M) for fraction in (-0.25, -0.75)]
    note = (
        f"{MM * geometry.beam_depth_m:.2f} mm deep; beam {MM * geometry.beam_thickness_m:.2f} mm; two tendon holes of "
        f"{2 * MM * HOLE_RADIUS_M:.1f} mm side by side through block and columns, "
        f"{MM * geometry.tendon_offset_m:.2f} mm from the middle of the beam"
    )
    return Drawing(tuple(OutlineVertex(x, y) for x, y in ring), tuple(screws), title, note)


def write_finger_drawing(geometry: FingerGeometry, path: Path, title: str = "finger") -> None:
    """Write the drawing as .svg or .dxf. Raises CallerError for another ending or a folder that cannot be written."""
    write_drawing(finger_drawing(geometry, title), path)


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

    Raises CallerError for another ending, holes that do not fit or a folder that cannot be written, and without Open
    CASCADE.
    """
    write_solid(finger_solid(geometry, tendon_hole_m), path)
