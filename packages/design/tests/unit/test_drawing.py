"""What a cutter is given: closed, one to one in millimetres, the same in both formats, and as large as it should be."""

from __future__ import annotations

import math
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from musclewire_design._drawing import Drawing, DrawnHole, OutlineVertex, ring_area_m2, svg_text
from musclewire_design._serpentine.geometry import SerpentineGeometry
from musclewire_design._serpentine.outline import CORNER_M, serpentine_drawing

GEOMETRY = SerpentineGeometry(4, 11.72e-3, 3.26e-3, 1.01e-3, 10e-3, 0.25e-3)


@settings(max_examples=40)
@given(st.integers(1, 9), st.floats(6e-3, 15e-3), st.floats(2e-3, 6e-3), st.floats(0.1e-3, 0.8e-3), st.floats(0.0, 0.5))
def test_the_part_has_the_area_of_strip_pad_and_connector(
    beams: int, half: float, pitch: float, thickness: float, radius: float
) -> None:
    geometry = SerpentineGeometry(beams, half, pitch, thickness, 5e-3, radius * thickness)
    fittings = geometry.fittings
    strip = sum(piece.length_m for piece in geometry.centre_line()) * thickness
    ends = geometry.pad_width_m * fittings.pad_height_m + fittings.connector_width_m * fittings.connector_height_m
    cut = 8.0 * (1.0 - math.pi / 4.0) * CORNER_M**2
    drawing = serpentine_drawing(geometry, "a part")
    # A corner without radius is square outside: the strip's swept area leaves that out.
    tolerance = 1e-9 if radius > 1e-4 else 1e-2
    assert ring_area_m2(drawing.outline) == pytest.approx(strip + ends - cut, rel=tolerance)
    holes = sum(math.pi / 4.0 * hole.diameter_m**2 for hole in drawing.holes)
    assert drawing.area_m2 == pytest.approx(ring_area_m2(drawing.outline) - holes)


def test_holes_are_inside_pad_and_connector() -> None:
    drawing = serpentine_drawing(GEOMETRY, "a part")
    left, right, top = drawing.holes
    for hole in (left, right):
        assert abs(hole.x_m) + hole.diameter_m < 0.5 * GEOMETRY.pad_width_m
        assert 0.0 < hole.y_m - hole.diameter_m / 2 < hole.y_m + hole.diameter_m / 2 < GEOMETRY.fittings.pad_height_m
    assert top.x_m == 0.0
    assert GEOMETRY.connector_m < top.y_m < GEOMETRY.along_m


def test_the_svg_is_one_to_one_in_millimetres_and_closed() -> None:
    drawing = Drawing(
        (OutlineVertex(0, 0), OutlineVertex(0.03, 0), OutlineVertex(0.03, 0.02), OutlineVertex(0, 0.02)),
        (DrawnHole(0.01, 0.01, 4e-3),),
        "a & b",
    )
    root = ElementTree.fromstring(svg_text(drawing))
    assert (root.get("width"), root.get("height")) == ("34.000mm", "24.000mm")
    assert root.get("viewBox") == "0 0 34.000 24.000"
    space = "{http://www.w3.org/2000/svg}"
    path = root.find(f".//{space}path")
    circle = root.find(f".//{space}circle")
    assert path is not None
    assert circle is not None
    assert path.get("d") == "M 2.0000 22.0000 L 32.0000 22.0000 L 32.0000 2.0000 L 2.0000 2.0000 L 2.0000 22.0000 Z"
    assert (circle.get("cx"), circle.get("cy"), circle.get("r")) == ("12.0000", "12.0000", "2.0000")
