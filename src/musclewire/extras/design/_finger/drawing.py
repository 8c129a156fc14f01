"""The finger as a drawing to be cut or printed, one to one: unloaded, with a block that holds it at the palm.

The holes for the tendon run along the finger, within the sheet: they are drilled and not in the outline.
"""

from __future__ import annotations

from pathlib import Path

from musclewire.extras.design._drawing import Drawing, DrawnHole, OutlineVertex, write_drawing
from musclewire.extras.design._finger.chain import finger_chain
from musclewire.extras.design._finger.geometry import HOLE_RADIUS_M, FingerGeometry
from musclewire.extras.design._finger.shape import finger_shape

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
