"""Parts as solids: a drawing extruded by its depth, as STL for a slicer and STEP for other programs, in millimetres.

Open CASCADE builds them (the extra 'cad'): arcs and holes are exact in STEP, and in STL at most 0.005 mm off. The part
lies on the plane z = 0, its layers in the plane of bending, as it should be printed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from musclewire.errors import CallerError
from musclewire.signals import write_whole
from musclewire_design._drawing import MM, Drawing, DrawnHole, OutlineVertex

SOLID_FORMATS = (".stl", ".step")
# Largest distance of a facet from the surface, and the angle between neighbouring facets.
FACET_MM, FACET_RAD = 0.005, 0.1
# A bore is cut this much beyond its ends, so that it leaves no skin.
BEYOND_MM = 0.05
INSTALLED_BY = 'pip install "./packages/design[cad]" in the checkout'


class StraightBore(NamedTuple):
    """A straight hole within the sheet: where it begins and ends in the plane, its height and its diameter [m]."""

    start_m: tuple[float, float]
    end_m: tuple[float, float]
    height_m: float
    diameter_m: float

    @property
    def length_m(self) -> float:
        """Length [m]."""
        return math.dist(self.start_m, self.end_m)


@dataclass(frozen=True)
class Solid:
    """A part: its drawing, its depth [m], and the holes along it, each between two faces square to it."""

    drawing: Drawing
    depth_m: float
    bores: tuple[StraightBore, ...] = ()

    @property
    def volume_m3(self) -> float:
        """Volume by the areas of the drawing and its bores [m^3], to compare a file with."""
        bored = sum(0.25 * math.pi * bore.diameter_m**2 * bore.length_m for bore in self.bores)
        return self.drawing.area_m2 * self.depth_m - bored


def write_solid(solid: Solid, path: Path) -> None:
    """Write a solid in the format of its suffix, .stl or .step, whole or not at all.

    Raises CallerError for another kind of file or one that cannot be written, and without Open CASCADE.
    """
    writers = {".stl": stl_file, ".step": step_file}
    if path.suffix not in writers:
        raise CallerError(f"{path}: a solid is one of {', '.join(writers)}: end its name so")
    shape = shape_of(solid)
    write_whole(path, lambda part: writers[path.suffix](shape, part, solid.drawing.title))


def require_open_cascade() -> None:
    """Raise CallerError if Open CASCADE is not installed; it is not loaded."""
    if find_spec("OCP") is None:
        raise CallerError(f"a solid (STL or STEP) needs Open CASCADE: {INSTALLED_BY}")


@cache
def require_cad() -> None:
    """Load Open CASCADE and have it report failures only: it writes its progress on standard output.

    Raises CallerError if it is not installed.
    """
    require_open_cascade()
    from OCP.Message import Message, Message_Gravity

    for printer in Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(Message_Gravity.Message_Fail)


def shape_of(solid: Solid) -> Any:
    """Return the solid as a shape of Open CASCADE, in millimetres."""
    require_cad()
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
    from OCP.gp import gp_Vec

    face = BRepBuilderAPI_MakeFace(wire_of(solid.drawing.outline), True)
    for hole in solid.drawing.holes:
        face.Add(circle_of(hole))
    shape = BRepPrimAPI_MakePrism(face.Face(), gp_Vec(0.0, 0.0, solid.depth_m * MM)).Shape()
    for bore in solid.bores:
        shape = BRepAlgoAPI_Cut(shape, cylinder_of(bore)).Shape()
    return shape


def wire_of(ring: Sequence[OutlineVertex]) -> Any:
    """Return a ring of lines and arcs as a closed wire."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeWire

    wire = BRepBuilderAPI_MakeWire()
    for start, end in zip(ring, [*ring[1:], ring[0]], strict=True):
        wire.Add(edge_of(start, end))
    return wire.Wire()


def edge_of(start: OutlineVertex, end: OutlineVertex) -> Any:
    """Return the way from one vertex to the next: a line, or an arc through the point that its bulge says."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
    from OCP.GC import GC_MakeArcOfCircle
    from OCP.gp import gp_Pnt

    first, last = (gp_Pnt(one.x_m * MM, one.y_m * MM, 0.0) for one in (start, end))
    if not start.bulge:
        return BRepBuilderAPI_MakeEdge(first, last).Edge()
    # The arc's height over its chord is the bulge times half the chord, to the right of the way if it turns left.
    across = complex(end.x_m - start.x_m, end.y_m - start.y_m) * MM
    top = complex(start.x_m + end.x_m, start.y_m + end.y_m) * MM / 2.0 - 0.5j * start.bulge * across
    return BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(first, gp_Pnt(top.real, top.imag, 0.0), last).Value()).Edge()


def circle_of(hole: DrawnHole) -> Any:
    """Return the edge of a hole as a wire that runs clockwise, as inner edges of a face do."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeWire
    from OCP.gp import gp_Ax2, gp_Circ, gp_Dir, gp_Pnt

    axis = gp_Ax2(gp_Pnt(hole.x_m * MM, hole.y_m * MM, 0.0), gp_Dir(0.0, 0.0, 1.0))
    wire = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(gp_Circ(axis, 0.5 * hole.diameter_m * MM)).Edge()).Wire()
    wire.Reverse()
    return wire


def cylinder_of(bore: StraightBore) -> Any:
    """Return what a bore takes away."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    along = complex(bore.end_m[0] - bore.start_m[0], bore.end_m[1] - bore.start_m[1]) / bore.length_m
    begin = complex(*bore.start_m) * MM - BEYOND_MM * along
    axis = gp_Ax2(gp_Pnt(begin.real, begin.imag, bore.height_m * MM), gp_Dir(along.real, along.imag, 0.0))
    return BRepPrimAPI_MakeCylinder(axis, 0.5 * bore.diameter_m * MM, bore.length_m * MM + 2 * BEYOND_MM).Shape()


def stl_file(shape: Any, path: Path, title: str) -> None:
    """Fill a file with the surface of a shape as binary STL; the format has no place for a title."""
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.StlAPI import StlAPI_Writer

    del title
    BRepMesh_IncrementalMesh(shape, FACET_MM, False, FACET_RAD, False)
    writer = StlAPI_Writer()
    writer.ASCIIMode = False
    if not writer.Write(shape, str(path)):
        raise OSError("the STL file was not written")


def step_file(shape: Any, path: Path, title: str) -> None:
    """Fill a file with a shape as STEP (AP214), millimetres."""
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.Interface import Interface_Static
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    writer = STEPControl_Writer()
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    Interface_Static.SetCVal_s("write.step.product.name", title)
    writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
    if writer.Write(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise OSError("the STEP file was not written")
