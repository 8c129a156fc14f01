"""Drawings that a cutter or a slicer reads: closed outlines of lines and arcs, one to one in millimetres.

An outline is a ring of vertices; the way from each to the next is straight, or an arc given by its bulge, the tangent
of a quarter of the angle it turns by, left positive: DXF's definition, exact at any scale.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from xml.sax.saxutils import escape

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.signals import write_whole

FORMATS = (".svg", ".dxf")
MM = 1e3
MARGIN_MM = 2.0
# Hairlines cut, by the usage of common laser cutters.
LINE_MM = 0.1


class OutlineVertex(NamedTuple):
    """A vertex of an outline [m] and the bulge of the way to the next."""

    x_m: float
    y_m: float
    bulge: float = 0.0


class DrawnHole(NamedTuple):
    """A hole: centre and diameter [m]."""

    x_m: float
    y_m: float
    diameter_m: float


@dataclass(frozen=True)
class Drawing:
    """A part: its outline counter-clockwise, its holes, its title and a note."""

    outline: tuple[OutlineVertex, ...]
    holes: tuple[DrawnHole, ...]
    title: str
    note: str = ""

    @property
    def area_m2(self) -> float:
        """Area of the part [m^2]."""
        return ring_area_m2(self.outline) - sum(math.pi * hole.diameter_m**2 / 4.0 for hole in self.holes)


def ring_area_m2(ring: Sequence[OutlineVertex]) -> float:
    """Return the area inside a ring [m^2]: polygon and the segments of circle that its arcs add; clockwise negative."""
    area = 0.0
    for start, end in zip(ring, [*ring[1:], ring[0]], strict=True):
        area += 0.5 * (start.x_m * end.y_m - end.x_m * start.y_m)
        angle = 4.0 * math.atan(start.bulge)
        if angle:
            radius = math.dist(start[:2], end[:2]) / (2.0 * math.sin(abs(angle) / 2.0))
            area += math.copysign(0.5 * radius**2 * (abs(angle) - math.sin(abs(angle))), angle)
    return area


def rounded(
    corner: tuple[float, float], into: tuple[float, float], out: tuple[float, float], radius_m: float
) -> list[OutlineVertex]:
    """Return a square corner with a rounding: two vertices and the arc between them.

    ``into`` and ``out`` are the unit vectors of the ways to and from the corner.
    """
    if radius_m <= 0.0:
        return [OutlineVertex(*corner)]
    turn = math.copysign(1.0, into[0] * out[1] - into[1] * out[0])
    begin = (corner[0] - radius_m * into[0], corner[1] - radius_m * into[1])
    end = (corner[0] + radius_m * out[0], corner[1] + radius_m * out[1])
    return [OutlineVertex(*begin, turn * math.tan(math.pi / 8.0)), OutlineVertex(*end)]


def polyline_m(ring: Sequence[OutlineVertex], turn_rad: float = 0.1) -> FloatArray:
    """Return a ring as a closed polyline (n, 2) [m] for pictures, its arcs cut into chords of at most ``turn_rad``."""
    points: list[tuple[float, float]] = []
    for start, end in zip(ring, [*ring[1:], ring[0]], strict=True):
        points.append((start.x_m, start.y_m))
        angle = 4.0 * math.atan(start.bulge)
        if not angle:
            continue
        middle = complex(start.x_m + end.x_m, start.y_m + end.y_m) / 2.0
        chord = complex(end.x_m - start.x_m, end.y_m - start.y_m)
        centre = middle + 1j * chord / (2.0 * math.tan(angle / 2.0))
        arm, count = complex(*start[:2]) - centre, math.ceil(abs(angle) / turn_rad)
        for step in range(1, count):
            place = centre + arm * complex(math.cos(angle * step / count), math.sin(angle * step / count))
            points.append((place.real, place.imag))
    return np.array([*points, points[0]])


def bounds_m(ring: Sequence[OutlineVertex]) -> tuple[float, float, float, float]:
    """Return the bounding box of a ring's vertices [m]: minimum x and y, maximum x and y."""
    xs, ys = [vertex.x_m for vertex in ring], [vertex.y_m for vertex in ring]
    return min(xs), min(ys), max(xs), max(ys)


def svg_path(ring: Sequence[OutlineVertex], left_mm: float, top_mm: float) -> str:
    """Return a ring as an SVG path in millimetres; SVG's y points down, so a left turn becomes a right one."""
    words: list[str] = []
    for start, end in zip(ring, [*ring[1:], ring[0]], strict=True):
        if not words:
            words.append(f"M {start.x_m * MM - left_mm:.4f} {top_mm - start.y_m * MM:.4f}")
        x, y = end.x_m * MM - left_mm, top_mm - end.y_m * MM
        angle = 4.0 * math.atan(start.bulge)
        if angle:
            radius = MM * math.dist(start[:2], end[:2]) / (2.0 * math.sin(abs(angle) / 2.0))
            large, sweep = int(abs(angle) > math.pi), int(angle < 0.0)
            words.append(f"A {radius:.4f} {radius:.4f} 0 {large} {sweep} {x:.4f} {y:.4f}")
        else:
            words.append(f"L {x:.4f} {y:.4f}")
    return " ".join([*words, "Z"])


def svg_text(drawing: Drawing) -> str:
    """Return the drawing as SVG: width and height in millimetres, so that it prints and imports one to one."""
    min_x, min_y, max_x, max_y = bounds_m(drawing.outline)
    left, top = min_x * MM - MARGIN_MM, max_y * MM + MARGIN_MM
    width, height = (max_x - min_x) * MM + 2 * MARGIN_MM, (max_y - min_y) * MM + 2 * MARGIN_MM
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.3f}mm" height="{height:.3f}mm" '
        f'viewBox="0 0 {width:.3f} {height:.3f}">',
        f"  <title>{escape(drawing.title)}</title>",
        f"  <desc>{escape(drawing.note)}</desc>",
        f'  <g fill="none" stroke="#d0021b" stroke-width="{LINE_MM}">',
        f'    <path d="{svg_path(drawing.outline, left, top)}"/>',
        *(
            f'    <circle cx="{hole.x_m * MM - left:.4f}" cy="{top - hole.y_m * MM:.4f}" '
            f'r="{0.5 * hole.diameter_m * MM:.4f}"/>'
            for hole in drawing.holes
        ),
        "  </g>",
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def write_drawing(drawing: Drawing, path: Path) -> None:
    """Write a drawing in the format of its suffix: .svg or .dxf.

    Raises CallerError for another kind of file, or one that cannot be written.
    """
    writers = {".svg": write_svg, ".dxf": write_dxf}
    if path.suffix not in writers:
        raise CallerError(f"{path}: a drawing is one of {', '.join(writers)}: end its name so")
    writers[path.suffix](drawing, path)


def write_svg(drawing: Drawing, path: Path) -> None:
    """Write the drawing as SVG, whole or not at all. Raises CallerError if the file cannot be written."""
    write_whole(path, lambda part: svg_file(drawing, part))


def write_dxf(drawing: Drawing, path: Path) -> None:
    """Write the drawing as DXF (R2010, mm): one closed polyline with arcs, and circles, on the layer CUT.

    Raises CallerError if the file cannot be written.
    """
    write_whole(path, lambda part: dxf_file(drawing, part))


def svg_file(drawing: Drawing, path: Path) -> None:
    """Fill a file with the drawing as SVG."""
    path.write_text(svg_text(drawing), encoding="utf-8")


def dxf_file(drawing: Drawing, path: Path) -> None:
    """Fill a file with the drawing as DXF."""
    from ezdxf import units
    from ezdxf.filemanagement import new

    document = new("R2010", units=units.MM)
    document.layers.add("CUT", color=1)
    space = document.modelspace()
    points = [(vertex.x_m * MM, vertex.y_m * MM, vertex.bulge) for vertex in drawing.outline]
    space.add_lwpolyline(points, format="xyb", close=True, dxfattribs={"layer": "CUT"})
    for hole in drawing.holes:
        space.add_circle((hole.x_m * MM, hole.y_m * MM), 0.5 * hole.diameter_m * MM, dxfattribs={"layer": "CUT"})
    document.header.custom_vars.append("Title", drawing.title)
    document.saveas(path)
