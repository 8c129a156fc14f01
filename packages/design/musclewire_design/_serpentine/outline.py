"""A serpentine as a part to cut: one closed outline of pad, strip and connector, and its holes."""

from __future__ import annotations

import math

from musclewire_design._drawing import Drawing, DrawnHole, OutlineVertex, rounded
from musclewire_design._serpentine.geometry import CentreLineArc, SerpentineGeometry, direction

# Outer corners of pad and connector, and how far the pad's holes are from its ends.
CORNER_M, HOLE_FROM_END_M = 0.8e-3, 2.8e-3


def serpentine_drawing(geometry: SerpentineGeometry, title: str, note: str = "") -> Drawing:
    """Return the drawing of a serpentine with clamping pad and connector, the wire's axis being x = 0."""
    fittings = geometry.fittings
    half_pad, half_head = 0.5 * geometry.pad_width_m, 0.5 * fittings.connector_width_m
    top = geometry.along_m
    right = side_of_strip(geometry, -1.0)
    left = backwards(side_of_strip(geometry, 1.0))
    base = [(-half_pad, fittings.pad_height_m), (-half_pad, 0.0), (half_pad, 0.0), (half_pad, fittings.pad_height_m)]
    head = [(half_head, geometry.connector_m), (half_head, top), (-half_head, top), (-half_head, geometry.connector_m)]
    outline = [
        *corners([(left[-1].x_m, left[-1].y_m), *base, (right[0].x_m, right[0].y_m)]),
        *right,
        *corners([(right[-1].x_m, right[-1].y_m), *head, (left[0].x_m, left[0].y_m)]),
        *left,
    ]
    middle = 0.5 * fittings.pad_height_m
    holes = (
        DrawnHole(-half_pad + HOLE_FROM_END_M, middle, fittings.pad_hole_diameter_m),
        DrawnHole(half_pad - HOLE_FROM_END_M, middle, fittings.pad_hole_diameter_m),
        DrawnHole(0.0, top - 0.5 * fittings.connector_height_m, fittings.connector_hole_diameter_m),
    )
    return Drawing(tuple(outline), holes, title, note)


def side_of_strip(geometry: SerpentineGeometry, side: float) -> list[OutlineVertex]:
    """Return one edge of the strip from pad to connector: the left one for side 1, the right one for -1."""
    offset = 0.5 * side * geometry.thickness_m
    vertices: list[OutlineVertex] = []
    for piece in geometry.centre_line():
        if isinstance(piece, CentreLineArc):
            radius = piece.radius_m - math.copysign(1.0, piece.turn_rad) * offset
            if radius > 1e-9:
                vertices[-1] = vertices[-1]._replace(bulge=math.tan(0.25 * piece.turn_rad))
            continue
        way = direction(piece.start_m, piece.end_m)
        normal = (-way[1] * offset, way[0] * offset)
        for x, y in (piece.start_m, piece.end_m):
            vertex = OutlineVertex(x + normal[0], y + normal[1])
            # A corner without radius has both its edges meet in one point.
            if not vertices or math.dist(vertex[:2], vertices[-1][:2]) > 1e-9:
                vertices.append(vertex)
    return vertices


def backwards(path: list[OutlineVertex]) -> list[OutlineVertex]:
    """Return a path in reverse order: each arc turns the other way and belongs to the vertex where it now begins."""
    bulges = [0.0, *(-vertex.bulge for vertex in path[:-1])]
    return [vertex._replace(bulge=bulge) for vertex, bulge in zip(path[::-1], bulges[::-1], strict=True)]


def corners(points: list[tuple[float, float]]) -> list[OutlineVertex]:
    """Return the inner points of a path with their corners rounded."""
    found: list[OutlineVertex] = []
    for before, corner, after in zip(points, points[1:], points[2:], strict=False):
        found += rounded(corner, direction(before, corner), direction(corner, after), CORNER_M)
    return found
