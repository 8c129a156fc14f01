"""A circuit drawn on a grid by schemdraw, which knows afterwards what its lines join.

Every part, pin and ground that is drawn is remembered with its place, every line with its ends. ``nets`` follows the
lines, so a test can ask whether the drawing joins what the parts list says that it joins.
"""

from __future__ import annotations

import os
import re
from itertools import pairwise
from pathlib import Path

import matplotlib as mpl
import schemdraw
import schemdraw.elements as elm

from musclewire.extras.board import PartsList

__all__ = ["HOT", "POWER", "TAP", "Circuit", "Place"]

HERE = Path(__file__).parent
DPI = 110
SMALL, TINY = 11, 9
# Told apart by width and dashes too: the heating current is thick, a tap dashed.
HOT, TAP, POWER, BLACK, GREY = "#b3440c", "#0b5d95", "#5b2a86", "black", "#444444"
THICK = 2.6
Place = tuple[float, float]
SAME = 0.02  # of a unit: places that are nearer are one


def same(one: Place, other: Place) -> bool:
    """Whether two places are one."""
    return abs(one[0] - other[0]) < SAME and abs(one[1] - other[1]) < SAME


def on(place: Place, start: Place, end: Place) -> bool:
    """Whether a place lies on a line; all lines are level or upright."""
    low = (min(start[0], end[0]) - SAME, min(start[1], end[1]) - SAME)
    high = (max(start[0], end[0]) + SAME, max(start[1], end[1]) + SAME)
    return low[0] <= place[0] <= high[0] and low[1] <= place[1] <= high[1]


class Circuit:
    """Parts between places, lines through places, boxes, words."""

    def __init__(self, parts: PartsList) -> None:
        """Begin with the parts list that the values and nets are taken from."""
        self.drawing = schemdraw.Drawing(show=False, fontsize=12, unit=2.0, lw=1.4)
        self.parts = parts
        self.pins: list[tuple[str, str, Place]] = []
        self._values = parts.values()
        self._lines: list[tuple[Place, Place]] = []
        self._named: list[tuple[str, Place]] = []

    def nets(self) -> set[frozenset[str]]:
        """Return what the drawn lines join: sets of pins as ``U1.3``."""
        groups: list[set[int]] = []
        places = [place for _, _, place in self.pins] + [place for _, place in self._named]
        joints = [*places, *(end for line in self._lines for end in line)]
        for start, end in self._lines:
            _merge(groups, {index for index, place in enumerate(joints) if on(place, start, end)})
        for index, place in enumerate(joints):
            _merge(groups, {index} | {other for other, there in enumerate(joints) if same(place, there)})
        for name in {name for name, _ in self._named}:
            _merge(groups, {len(self.pins) + i for i, (other, _) in enumerate(self._named) if other == name})
        named = [f"{label}.{number}" for label, number, _ in self.pins]
        found = [frozenset(named[index] for index in group if index < len(named)) for group in groups]
        return {pins for pins in found if pins}

    def value(self, label: str) -> str:
        """Return a part's label with its value, up to a comma; the wire needs none."""
        return f"{label}  {self._values[label].split(',')[0]}" if label in self._values and label != "wire" else label

    def part(
        self, kind: type, label: str, start: Place, end: Place, side: str = "top", ends: str = "1 2", color: str = BLACK
    ) -> None:
        """Put a part with two ends between two places."""
        words = self.value(label)
        if start[0] == end[0]:
            words = re.sub(" (1 %|0.5 W|25 V)", r"\n\1", words.replace("  ", "\n", 1))
        drawn = kind().at(start).to(end).color(color)
        self.drawing.add(drawn.label(words, loc=side, fontsize=SMALL))
        self.pins += [(label, number, place) for number, place in zip(ends.split(), (start, end), strict=True)]

    def resistor(self, label: str, start: Place, end: Place, side: str = "top", color: str = BLACK) -> None:
        """Put a resistor between two places."""
        self.part(elm.Resistor, label, start, end, side, color=color)

    def capacitor(self, label: str, top: Place, length: float = 1.3) -> None:
        """Put a capacitor from a place down to ground."""
        x, y = top
        self.part(elm.Capacitor, label, top, (x, y - length), "bottom")
        self.ground((x, y - length))

    def line(self, *places: Place, color: str = BLACK) -> None:
        """Draw a line through places: thick for the heating current, dashed for a tap."""
        for start, end in pairwise(places):
            drawn = elm.Line().at(start).to(end).color(color)
            self.drawing.add(drawn.linewidth(THICK if color == HOT else 1.4).linestyle("--" if color == TAP else "-"))
            self._lines.append((start, end))

    def dot(self, place: Place, color: str = BLACK) -> None:
        """Mark a node."""
        self.drawing.add(elm.Dot().at(place).color(color))

    def terminal(self, place: Place, words: str, color: str = BLACK, side: str = "left", net: str = "") -> None:
        """Mark where something comes from outside, or goes on elsewhere under a net's name."""
        self.drawing.add(elm.Dot(open=True).at(place).color(color))
        away = -0.25 if side == "left" else 0.25
        self.text((place[0] + away, place[1]), words, color, "right" if side == "left" else "left")
        if net:
            self._named.append((net, place))

    def ground(self, place: Place) -> None:
        """Put the ground symbol under a place."""
        self.drawing.add(elm.Ground().at(place))
        self._named.append(("GND", place))

    def text(self, place: Place, words: str, color: str = BLACK, align: str = "left", size: int = SMALL) -> None:
        """Write words at a place, their middle at its height."""
        drawn = elm.Label().theta(0).at((place[0], place[1] - 0.1)).color(color)
        self.drawing.add(drawn.label(words, fontsize=size, halign=align, valign="center", loc="center"))

    def pin(self, label: str, number: str, place: Place, words_at: Place = (0.0, 0.0)) -> None:
        """Say that a part's pin is at a place; its number is written ``words_at`` from there where that is not zero."""
        self.parts.pin(label, number)
        self.pins.append((label, number, place))
        if words_at != (0.0, 0.0):
            self.text((place[0] + words_at[0], place[1] + words_at[1]), number, GREY, "center", TINY)

    def box(self, corner: Place, size: Place, title: str) -> None:
        """Draw the outline of a device with its name in it."""
        (x, y), (width, height) = corner, size
        ends = [(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)]
        for start, end in pairwise(ends):
            self.drawing.add(elm.Line().at(start).to(end))
        self.text((x + 0.5 * width, y + height + 0.4), title, align="center", size=13)

    def box_pin(self, label: str, number: str, place: Place, name: str) -> None:
        """Put a pin at a device's right side: its name inside, its number above the line that leaves."""
        self.text((place[0] - 0.12, place[1]), name, align="right")
        self.pin(label, number, place, (0.3, 0.2))

    def emergency_stop(self, start: Place, end: Place, ends: str = "1 2", words: str = "S1  emergency stop") -> None:
        """Draw a contact of the switch that opens when it is pressed."""
        closed = elm.Button(nc=True).at(start).to(end).color(POWER)
        self.drawing.add(closed.label(words, loc="top", ofst=0.35, fontsize=SMALL))
        self.pins += [("S1", number, place) for number, place in zip(ends.split(), (start, end), strict=True)]

    def margin(self, low: Place, high: Place) -> None:
        """Keep the drawing's edge at least at these corners."""
        for place in (low, high):
            self.drawing.add(elm.Line().at(place).to((place[0] + 0.01, place[1])).color("white"))

    def save(self, name: str) -> None:
        """Write the drawing into this folder on white, as .svg and .png, with the same bytes each time."""
        os.environ["SOURCE_DATE_EPOCH"] = "0"
        with mpl.rc_context({"svg.hashsalt": "musclewire", "svg.fonttype": "path"}):
            self.drawing.save(str(HERE / f"{name}.svg"), transparent=False)
            self.drawing.save(str(HERE / f"{name}.png"), transparent=False, dpi=DPI)


def _merge(groups: list[set[int]], joined: set[int]) -> None:
    """Join all groups that have a member in common with one more."""
    for group in [group for group in groups if group & joined]:
        joined |= group
        groups.remove(group)
    groups.append(joined)
