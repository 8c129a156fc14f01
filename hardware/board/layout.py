"""Write the board with KiCad's own pcbnew: parts where placement.toml has them, tracks, planes of ground, words.

Needs KiCad 9 with its libraries; see README.md in this folder.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from itertools import pairwise
from pathlib import Path
from typing import Any

import pcbnew
from routing import STEP_MM, Grid, Rectangle
from schematic import identity

__all__ = ["layout"]

FOOTPRINTS = Path("/usr/share/kicad/footprints")
CORNER_MM = (50.8, 50.8)
NARROW_MM, WIDE_MM, VIA_MM, DRILL_MM, CLEARANCE_MM, EDGE_MM = 0.4, 1.2, 0.9, 0.45, 0.3, 0.8


def point(x_mm: float, y_mm: float) -> Any:
    """Return a place of the board as KiCad counts."""
    return pcbnew.VECTOR2I(pcbnew.FromMM(CORNER_MM[0] + x_mm), pcbnew.FromMM(CORNER_MM[1] + y_mm))


def nets_of(netlist: Path) -> dict[tuple[str, str], str]:
    """Return the net of each pin as KiCad exports it from the schematic."""
    nets = ET.parse(netlist).getroot().iter("net")
    return {(node.get("ref", ""), node.get("pin", "")): escaped(net) for net in nets for node in net.iter("node")}


def escaped(net: ET.Element) -> str:
    """Return a net's name as boards write it: a slash within the name of a free pin is spelled out."""
    return net.get("name", "").replace("/", "{slash}")


def footprint(name: str) -> Any:
    """Return a footprint of KiCad's libraries."""
    library, _, short = name.partition(":")
    found = pcbnew.FootprintLoad(str(FOOTPRINTS / f"{library}.pretty"), short)
    found.SetFPID(pcbnew.LIB_ID(library, short))
    return found


def put_part(board: Any, part: dict[str, Any], place: list[float], nets: dict[tuple[str, str], str]) -> None:
    """Put a part on the board, and its pads on their nets."""
    item = footprint(part["footprint"])
    item.SetReference(part["reference"])
    item.SetValue(part["value"])
    item.SetPath(pcbnew.KIID_PATH(f"/{identity(part['label'], 1)}"))
    item.SetSheetname("/")
    item.SetSheetfile("board.kicad_sch")
    for name, text in (("Datasheet", ""), ("Description", part["what"])):
        item.SetField(name, text)
        item.GetFieldByName(name).SetVisible(False)
    item.SetPosition(point(place[0], place[1]))
    item.SetOrientationDegrees(place[2])
    board.Add(item)
    if (part["label"][0] in "RCDF" and part["label"] != "C5") or part["label"] == "U1":
        middle = item.GetBoundingBox(False).GetCenter()
        item.Reference().SetTextSize(pcbnew.VECTOR2I(pcbnew.FromMM(0.9), pcbnew.FromMM(0.9)))
        item.Reference().SetPosition(middle)
    for pad in item.Pads():
        if pad.GetAttribute() == pcbnew.PAD_ATTRIB_SMD:
            pad.SetLocalZoneConnection(pcbnew.ZONE_CONNECTION_FULL)
        net = nets.get((part["reference"], pad.GetNumber()))
        if net:
            pad.SetNet(net_of(board, net))


def net_of(board: Any, name: str) -> Any:
    """Return a net of the board by its name, a new one where it is not there yet."""
    found = board.FindNet(name)
    if found is None:
        found = pcbnew.NETINFO_ITEM(board, name)
        board.Add(found)
    return found


def outline(board: Any, size: list[float], holes: list[list[float]]) -> None:
    """Draw the board's edge and its holes."""
    corners = [(0.0, 0.0), (size[0], 0.0), (size[0], size[1]), (0.0, size[1]), (0.0, 0.0)]
    for start, end in pairwise(corners):
        edge = pcbnew.PCB_SHAPE(board, pcbnew.SHAPE_T_SEGMENT)
        edge.SetLayer(pcbnew.Edge_Cuts)
        edge.SetWidth(pcbnew.FromMM(0.1))
        edge.SetStart(point(*start))
        edge.SetEnd(point(*end))
        board.Add(edge)
    for index, (x, y) in enumerate(holes):
        hole = footprint("MountingHole:MountingHole_3.2mm_M3")
        hole.SetReference(f"H{index + 1}")
        hole.Reference().SetVisible(False)
        hole.SetAttributes(hole.GetAttributes() | pcbnew.FP_BOARD_ONLY | pcbnew.FP_EXCLUDE_FROM_BOM)
        hole.SetPosition(point(x, y))
        for pad in hole.Pads():
            pad.SetLocalClearance(pcbnew.FromMM(0.5))
        board.Add(hole)


def pad_copper(board: Any) -> dict[str, list[tuple[Rectangle, tuple[int, int]]]]:
    """Return the pads by net: their copper, and the grid's place nearest to their middle."""
    found: dict[str, list[tuple[Rectangle, tuple[int, int]]]] = {}
    for pad in board.GetPads():
        box, middle = pad.GetBoundingBox(), pad.GetPosition()
        edges = [pcbnew.ToMM(value) for value in (box.GetLeft(), box.GetTop(), box.GetRight(), box.GetBottom())]
        left, top, right, bottom = (value - CORNER_MM[index % 2] for index, value in enumerate(edges))
        layers = tuple(n for n, layer in enumerate((pcbnew.F_Cu, pcbnew.B_Cu)) if pad.IsOnLayer(layer)) or (0, 1)
        cell = tuple(round((pcbnew.ToMM(v) - c) / STEP_MM) for v, c in zip(middle, CORNER_MM, strict=True))
        name = pad.GetNetname() or f"none {pad.GetParentFootprint().GetReference()}.{pad.GetNumber()} {cell}"
        found.setdefault(name, []).append((Rectangle(name, left, top, right, bottom, layers), cell))
    return found


def connect(board: Any, grid: Grid, net: str, pads: list[tuple[Rectangle, tuple[int, int]]], width_mm: float) -> None:
    """Join the pads of a net by tracks, the nearest pad first."""
    joined = [pads[0]]
    reached = {(*pads[0][1], layer) for layer in pads[0][0].layers}
    left = pads[1:]
    while left:
        pad = min(left, key=lambda one: min(math.dist(one[1], other[1]) for other in joined))
        left.remove(pad)
        joined.append(pad)
        ends = {(*pad[1], layer) for layer in pad[0].layers}
        way_mm = min(width_mm, max(NARROW_MM, min(pad[0].right - pad[0].left, pad[0].bottom - pad[0].top)))
        way = grid.route(net, reached, ends, way_mm, max(VIA_MM, way_mm))
        draw(board, grid, net, way, way_mm)
        reached |= set(way) | ends


def draw(board: Any, grid: Grid, net: str, way: list[tuple[int, int, int]], width_mm: float) -> None:
    """Draw a way as tracks and vias, and remember its copper."""
    start = way[0]
    for index, (before, cell) in enumerate(pairwise(way)):
        half = 0.5 * (max(VIA_MM, width_mm) if cell[2] != before[2] else width_mm)
        x, y = grid.place(cell)
        layers = (0, 1) if cell[2] != before[2] else (cell[2],)
        grid.copper.append(Rectangle(net, x - half, y - half, x + half, y + half, layers))
        if cell[2] != before[2]:
            via = pcbnew.PCB_VIA(board)
            via.SetPosition(point(x, y))
            via.SetDrill(pcbnew.FromMM(DRILL_MM))
            via.SetFrontWidth(pcbnew.FromMM(max(VIA_MM, width_mm)))
            via.SetNet(net_of(board, net))
            board.Add(via)
            start = cell
            continue
        after = way[index + 2] if index + 2 < len(way) else None
        direction = (cell[0] - before[0], cell[1] - before[1], 0)
        if after is None or tuple(a - b for a, b in zip(after, cell, strict=True)) != direction:
            track = pcbnew.PCB_TRACK(board)
            track.SetStart(point(*grid.place(start)))
            track.SetEnd(point(x, y))
            track.SetWidth(pcbnew.FromMM(width_mm))
            track.SetLayer(pcbnew.B_Cu if cell[2] else pcbnew.F_Cu)
            track.SetNet(net_of(board, net))
            board.Add(track)
            start = cell


def ground(board: Any, size: list[float]) -> None:
    """Pour ground over what is left of both sides."""
    for layer in (pcbnew.F_Cu, pcbnew.B_Cu):
        zone = pcbnew.ZONE(board)
        zone.SetLayer(layer)
        zone.SetNet(net_of(board, "GND"))
        for x, y in ((0.5, 0.5), (size[0] - 0.5, 0.5), (size[0] - 0.5, size[1] - 0.5), (0.5, size[1] - 0.5)):
            zone.AppendCorner(point(x, y), -1)
        zone.SetLocalClearance(pcbnew.FromMM(CLEARANCE_MM))
        zone.SetMinThickness(pcbnew.FromMM(0.3))
        zone.SetThermalReliefGap(pcbnew.FromMM(0.4))
        zone.SetThermalReliefSpokeWidth(pcbnew.FromMM(0.6))
        zone.SetIslandRemovalMode(pcbnew.ISLAND_REMOVAL_MODE_ALWAYS)
        board.Add(zone)
    pcbnew.ZONE_FILLER(board).Fill(board.Zones())


def words(board: Any, text: str, x: float, y: float, size_mm: float = 1.2, turned: float = 0.0) -> None:
    """Print words on the front."""
    item = pcbnew.PCB_TEXT(board)
    item.SetText(text)
    item.SetLayer(pcbnew.F_SilkS)
    item.SetTextSize(pcbnew.VECTOR2I(pcbnew.FromMM(size_mm), pcbnew.FromMM(size_mm)))
    item.SetTextThickness(pcbnew.FromMM(0.15 * size_mm))
    item.SetTextAngleDegrees(turned)
    item.SetPosition(point(x, y))
    board.Add(item)


def layout(target: Path, parts: list[dict[str, Any]], placement: dict[str, Any], netlist: Path) -> None:
    """Write the board's file."""
    board, nets, size = pcbnew.NewBoard(str(target)), nets_of(netlist), placement["board_size_mm"]
    board.GetDesignSettings().m_CopperEdgeClearance = pcbnew.FromMM(0.5)
    for part in parts:
        put_part(board, part, placement["place"][part["label"]]["board"], nets)
    outline(board, size, placement["holes_mm"])
    grid, pads = Grid(size[0], size[1], CLEARANCE_MM, EDGE_MM), pad_copper(board)
    grid.copper += [rectangle for found in pads.values() for rectangle, _ in found]
    wide = set(placement["wide_nets"])
    order = sorted((net for net in pads if len(pads[net]) > 1 and net != "GND"), key=lambda net: spread(pads[net]))
    for net in order:
        connect(board, grid, net, pads[net], WIDE_MM if net in wide else NARROW_MM)
    ground(board, size)
    for text in placement["words"]:
        words(board, *text)
    pcbnew.SaveBoard(str(target), board)


def spread(pads: list[tuple[Rectangle, tuple[int, int]]]) -> float:
    """Return how far apart a net's pads lie: short nets are joined first."""
    columns, rows = [cell[0] for _, cell in pads], [cell[1] for _, cell in pads]
    return max(columns) - min(columns) + max(rows) - min(rows)
