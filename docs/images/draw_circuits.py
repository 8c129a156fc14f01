"""Draw the circuits of docs/how-to/wire_the_circuit.md: python docs/images/draw_circuits.py

Each is written into this folder, as .svg to solder from and as .png to look at. The values come from the parts lists in
``musclewire/parameters/data/parts``, which are also written into the page, so drawing and list cannot differ. Needs
schemdraw (extra ``dev``).
"""

from __future__ import annotations

import os
import re
import sys
from itertools import pairwise
from pathlib import Path

import matplotlib as mpl
import schemdraw
import schemdraw.elements as elm

sys.path.insert(0, str(Path(__file__).parent))
import parts_page

from musclewire.parameters.parts import load_parts

HERE = Path(__file__).parent
PAGE = HERE.parent / "how-to" / "wire_the_circuit.md"
BLOCK = re.compile(r"(<!-- written by docs/images/draw_circuits\.py: ([\w-]+) -->\n).*?(<!-- end -->)", re.S)
DPI = 110
SMALL = 11
HOT, TAP, POWER = "#b03a2e", "#1f5f8b", "#6c3483"
Place = tuple[float, float]


class Circuit:
    """A drawing on a grid: parts between places, wires through places, boxes, words."""

    def __init__(self, values: dict[str, str]) -> None:
        """Take the values of the parts by their labels."""
        self.drawing = schemdraw.Drawing(show=False, fontsize=12, unit=2.0, lw=1.4)
        self._values = values

    def value(self, label: str) -> str:
        """Return a part's label with its value."""
        return f"{label}  {self._values[label]}" if label in self._values else label

    def part(self, kind: type, label: str, start: Place, end: Place, side: str = "top", color: str = "black") -> None:
        """Put a part with two ends between two places."""
        words = self.value(label)
        if start[0] == end[0]:
            words = words.replace("  ", "\n", 1)
        drawn = kind().at(start).to(end).color(color)
        self.drawing.add(drawn.label(words, loc=side, fontsize=SMALL))

    def line(self, *places: Place, color: str = "black") -> None:
        """Draw a wire through places."""
        for start, end in pairwise(places):
            self.drawing.add(elm.Line().at(start).to(end).color(color))

    def dot(self, place: Place, color: str = "black") -> None:
        """Mark a node."""
        self.drawing.add(elm.Dot().at(place).color(color))

    def terminal(self, place: Place, words: str, color: str = "black", side: str = "left") -> None:
        """Mark where something comes from outside."""
        self.drawing.add(elm.Dot(open=True).at(place).color(color))
        away = -0.25 if side == "left" else 0.25
        self.text((place[0] + away, place[1]), words, color, "right" if side == "left" else "left")

    def ground(self, place: Place) -> None:
        """Put the ground symbol under a place."""
        self.drawing.add(elm.Ground().at(place))

    def text(self, place: Place, words: str, color: str = "black", align: str = "left", size: int = SMALL) -> None:
        """Write words at a place."""
        self.drawing.add(
            elm.Label().at(place).color(color).label(words, fontsize=size, halign=align, valign="center", loc="center")
        )

    def box(self, corner: Place, size: Place, title: str, pins: dict[str, float], side: str = "right") -> None:
        """Draw a device with pins at one side, by height."""
        (x, y), (width, height) = corner, size
        self.line((x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y))
        self.text((x + 0.5 * width, y + height + 0.35), title, align="center", size=13)
        for name, at in pins.items():
            place = (x + width - 0.15, at) if side == "right" else (x + 0.15, at)
            self.text(place, name, align="right" if side == "right" else "left")

    def supply(self, left: Place, volts: str) -> Place:
        """Draw supply, fuse and emergency switch from left to right; return where they end."""
        x, y = left
        self.terminal(left, volts, POWER)
        self.part(elm.Fuse, "F1", left, (x + 2.4, y), color=POWER)
        closed = elm.Button(nc=True).at((x + 2.4, y)).to((x + 4.8, y)).color(POWER)
        self.drawing.add(closed.label(self.value("S1"), loc="top", ofst=0.35, fontsize=SMALL))
        return (x + 4.8, y)

    def bypass(self, place: Place, words: str, label: str) -> None:
        """Draw a capacitor from a supply to ground."""
        x, y = place
        self.terminal(place, words, POWER)
        self.part(elm.Capacitor, label, place, (x, y - 1.5), "bottom")
        self.ground((x, y - 1.5))

    def wire_and_shunt(self, x: float, upper: float, crimp: float, shunt: float, lower: float) -> None:
        """Draw the heated wire and its shunt, from the top down to ground."""
        self.part(elm.Resistor, "wire", (x, upper), (x, crimp), "bottom", HOT)
        if crimp != shunt:
            self.line((x, crimp), (x, shunt))
        self.part(elm.Resistor, "RS", (x, shunt), (x, lower), "bottom")
        self.line((x, lower), (x, lower - 0.6))
        self.ground((x, lower - 0.6))

    def save(self, name: str) -> None:
        """Write the drawing into this folder, as .svg and .png, with the same bytes each time."""
        os.environ["SOURCE_DATE_EPOCH"] = "0"
        with mpl.rc_context({"svg.hashsalt": "musclewire", "svg.fonttype": "path"}):
            self.drawing.save(str(HERE / f"{name}.svg"))
            self.drawing.save(str(HERE / f"{name}.png"), dpi=DPI)


def ni_card() -> Circuit:
    """An NI card, a power operational amplifier as buffer, wire and shunt with a pair of taps each."""
    circuit = Circuit(load_parts("ni-card").values())
    pins = {"ao0": 10.0, "ao gnd": 8.6, "ai0 +": 6.2, "ai0 -": 4.2, "ai1 +": 2.6, "ai1 -": 0.8}
    circuit.box((0.0, 0.0), (2.6, 11.0), "NI card", pins)
    buffer_of_the_card(circuit)
    x = 14.8
    circuit.line((10.4, 9.5), (x, 9.5), (x, 6.2), color=HOT)
    circuit.wire_and_shunt(x, 6.2, 4.2, 2.6, 0.8)
    for height in (6.2, 4.2, 2.6, 0.8):
        circuit.line((2.6, height), (x, height), color=TAP)
        circuit.dot((x, height), TAP)
    circuit.text((3.2, 5.2), "twisted pair, soldered to the crimps: carries no current", TAP)
    circuit.text((3.2, 1.7), "twisted pair, soldered to the shunt's ends", TAP)
    circuit.text((x + 0.4, 0.45), "the one point where grounds meet")
    return circuit


def buffer_of_the_card(circuit: Circuit) -> None:
    """Draw the power operational amplifier with its supplies, limit and snubber."""
    circuit.line((2.6, 10.0), (4.0, 10.0))
    circuit.dot((4.0, 10.0))
    circuit.part(elm.Resistor, "R1", (4.0, 10.0), (4.0, 8.6), "bottom")
    circuit.part(elm.Resistor, "R3", (4.0, 10.0), (7.0, 10.0))
    circuit.line((2.6, 8.6), (4.0, 8.6))
    circuit.ground((4.0, 8.6))
    amplifier = circuit.drawing.add(elm.Opamp().theta(0).flip().at((7.0, 10.0)).anchor("in2"))
    middle = float(amplifier.center.x)
    circuit.line((7.0, 9.0), (6.4, 9.0), (6.4, 7.3), (10.4, 7.3), (10.4, 9.5))
    circuit.line((float(amplifier.out.x), 9.5), (10.4, 9.5))
    circuit.dot((10.4, 9.5))
    circuit.text((middle + 0.7, 10.4), circuit.value("U1"))
    end = circuit.supply((1.6, 12.6), "+12 V")
    circuit.line(end, (middle, 12.6), (middle, 10.1), color=POWER)
    circuit.line((middle, 8.9), (middle, 8.0), color=POWER)
    circuit.terminal((middle, 8.0), "U1 V-", POWER)
    circuit.text((middle + 0.15, 12.0), "U1 V+", POWER)
    circuit.terminal((1.6, 14.4), "-5 V", POWER)
    circuit.line((1.6, 14.4), (4.0, 14.4), color=POWER)
    circuit.drawing.add(elm.Button(nc=True).at((4.0, 14.4)).to((6.4, 14.4)).color(POWER))
    circuit.text((5.2, 13.9), "S1, second contact", POWER, "center")
    circuit.line((6.4, 14.4), (8.2, 14.4), color=POWER)
    circuit.terminal((8.2, 14.4), "U1 V-", POWER, "right")
    circuit.dot((11.8, 9.5))
    circuit.part(elm.Resistor, "R2", (11.8, 9.5), (11.8, 8.2), "bottom")
    circuit.part(elm.Capacitor, "C3", (11.8, 8.2), (11.8, 7.2), "bottom")
    circuit.ground((11.8, 7.2))
    circuit.terminal((11.0, 12.9), "U1 ILIM")
    circuit.part(elm.Resistor, "RCL", (11.0, 12.9), (13.6, 12.9))
    circuit.terminal((13.6, 12.9), "U1 V-", POWER, "right")
    circuit.text((9.75, 12.2), "U1 E/S: open")
    circuit.bypass((18.2, 12.9), "U1 V+", "C1")
    circuit.bypass((18.2, 9.9), "U1 V-", "C2")


def board() -> Circuit:
    """An Arduino: filtered PWM, transistor follower with a current limit, current-sense amplifier."""
    circuit = Circuit(load_parts("board").values())
    pins = {"D9 (PWM)": 10.0, "GND": 8.6, "A0": 4.9, "A1": 1.9, "5V": 0.7}
    circuit.box((0.0, 0.0), (2.6, 11.0), "Arduino Nano or Uno", pins)
    circuit.text((0.2, 7.0), "USB to\nthe host")
    low_pass(circuit)
    follower(circuit)
    x = 23.4
    circuit.line((17.66, 5.9), (x, 5.9), (x, 4.9), color=HOT)
    circuit.wire_and_shunt(x, 4.9, 2.9, 2.9, 0.9)
    circuit.dot((x, 4.9), TAP)
    circuit.line((x, 4.9), (6.0, 4.9), color=TAP)
    filtered(circuit, "R5", "C3", 4.9)
    circuit.text((7.4, 5.2), "a lead of its own, soldered to the upper crimp: carries no current", TAP)
    current_sense(circuit, x)
    circuit.text((x + 0.4, 0.55), "the one point where\ngrounds meet")
    return circuit


def low_pass(circuit: Circuit) -> None:
    """Draw what turns the pulses into direct current, and what holds it at 0 V while the pin floats."""
    circuit.line((2.6, 10.0), (4.0, 10.0))
    circuit.line((2.6, 8.6), (4.0, 8.6))
    circuit.dot((4.0, 10.0))
    circuit.part(elm.Resistor, "R1", (4.0, 10.0), (4.0, 8.6), "bottom")
    circuit.ground((4.0, 8.6))
    for label, capacitor, start, end in (("R2", "C1", 4.0, 6.4), ("R3", "C2", 6.4, 8.8)):
        circuit.part(elm.Resistor, label, (start, 10.0), (end, 10.0))
        circuit.dot((end, 10.0))
        circuit.part(elm.Capacitor, capacitor, (end, 10.0), (end, 8.6), "bottom")
        circuit.ground((end, 8.6))


def follower(circuit: Circuit) -> None:
    """Draw the amplifier, its transistor and the output node with its feedback."""
    circuit.line((8.8, 10.0), (11.2, 10.0))
    amplifier = circuit.drawing.add(elm.Opamp().theta(0).flip().at((11.2, 10.0)).anchor("in2"))
    middle, out = float(amplifier.center.x), float(amplifier.out.x)
    circuit.text((middle + 0.4, 8.5), circuit.value("U1"))
    circuit.line((middle, 8.9), (middle, 8.0))
    circuit.ground((middle, 8.0))
    end = circuit.supply((3.4, 12.8), "+12 V")
    circuit.line(end, (17.66, 12.8), color=POWER)
    circuit.line((middle, 12.8), (middle, 10.1), color=POWER)
    circuit.dot((middle, 12.8), POWER)
    circuit.part(elm.Resistor, "R4", (out, 9.5), (15.9, 9.5))
    circuit.dot((15.9, 9.5))
    circuit.line((11.2, 9.0), (10.6, 9.0), (10.6, 5.9), (17.66, 5.9))
    for x in (15.9, 17.66, 21.0):
        circuit.dot((x, 5.9))
    circuit.part(elm.Resistor, "R7", (21.0, 5.9), (21.0, 7.6), "bottom")
    circuit.line((21.0, 7.6), (22.6, 7.6))
    circuit.ground((22.6, 7.6))
    circuit.bypass((21.4, 12.6), "behind S1", "C5")
    transistors(circuit)


def transistors(circuit: Circuit) -> None:
    """Draw the power transistor and the one that limits its current."""
    first = circuit.drawing.add(elm.BjtNpn(circle=True).theta(0).at((16.9, 9.5)).anchor("base"))
    collector, emitter = float(first.collector.x), float(first.emitter.x)
    circuit.line((15.9, 9.5), (16.9, 9.5))
    circuit.line((collector, float(first.collector.y)), (collector, 12.8), color=POWER)
    circuit.text((collector + 0.5, 9.9), circuit.value("T1"))
    circuit.line((emitter, float(first.emitter.y)), (emitter, 8.3))
    circuit.dot((emitter, 8.3))
    circuit.part(elm.Resistor, "RCL", (emitter, 8.3), (emitter, 5.9), "bottom")
    second = circuit.drawing.add(elm.BjtNpn(circle=True).theta(0).reverse().at((15.9, 7.9)).anchor("collector"))
    base = (float(second.base.x), float(second.base.y))
    circuit.line(base, (17.1, base[1]), (17.1, 8.3), (emitter, 8.3))
    circuit.line((float(second.collector.x), float(second.collector.y)), (15.9, 9.5))
    circuit.line((float(second.emitter.x), float(second.emitter.y)), (15.9, 5.9))
    circuit.text((13.4, 7.2), circuit.value("T2"))


def filtered(circuit: Circuit, resistor: str, capacitor: str, height: float) -> None:
    """Draw the filter in front of an input of the board."""
    circuit.line((2.6, height), (3.6, height))
    circuit.dot((3.6, height))
    circuit.part(elm.Resistor, resistor, (3.6, height), (6.0, height))
    circuit.part(elm.Capacitor, capacitor, (3.6, height), (3.6, height - 1.3), "bottom")
    circuit.ground((3.6, height - 1.3))


def current_sense(circuit: Circuit, x: float) -> None:
    """Draw the amplifier across the shunt."""
    amplifier = circuit.drawing.add(elm.Opamp().theta(0).reverse().flip().at((13.4, 2.4)).anchor("in2"))
    plus, minus = (float(amplifier.in2.x), float(amplifier.in2.y)), (float(amplifier.in1.x), float(amplifier.in1.y))
    out = (float(amplifier.out.x), float(amplifier.out.y))
    circuit.line(plus, (14.6, plus[1]), (14.6, 2.9), (x, 2.9), color=TAP)
    circuit.line(minus, (14.6, minus[1]), (14.6, 0.9), (x, 0.9), color=TAP)
    circuit.dot((x, 2.9), TAP)
    circuit.dot((x, 0.9), TAP)
    circuit.line(out, (6.0, out[1]))
    filtered(circuit, "R6", "C4", out[1])
    middle = float(amplifier.center.x)
    circuit.text((middle - 3.6, 1.2), circuit.value("U2"))
    circuit.line((2.6, 0.7), (3.0, 0.7), (3.0, -0.4), (middle, -0.4), (middle, out[1] - 0.6), color=POWER)
    circuit.text((5.0, -0.1), "5 V for U2; its ground to the ground of the shunt", POWER)


def monitor() -> Circuit:
    """A voltage and current monitor chip across wire and shunt, instead of two converter channels."""
    circuit = Circuit({"RS": "0.33 ohm 1 %"})
    circuit.box((0.0, 0.0), (2.8, 5.6), "board, 3.3 or 5 V", {"VCC": 4.9, "SDA": 3.6, "SCL": 2.3, "GND": 0.7})
    circuit.box((5.6, 0.0), (3.4, 5.6), "INA226 module", {"VBUS": 4.9, "IN+": 2.9, "IN-": 0.9})
    for name, height in (("VCC", 4.9), ("SDA", 3.6), ("SCL", 2.3), ("GND", 0.7)):
        circuit.line((2.8, height), (5.6, height))
        circuit.text((5.75, height), name)
    x = 13.6
    circuit.terminal((11.4, 6.6), "output of the buffer", HOT)
    circuit.line((11.4, 6.6), (x, 6.6), (x, 4.9), color=HOT)
    circuit.wire_and_shunt(x, 4.9, 2.9, 2.9, 0.9)
    for height in (4.9, 2.9, 0.9):
        circuit.line((9.0, height), (x, height), color=TAP)
        circuit.dot((x, height), TAP)
    circuit.text((9.3, 5.25), "own lead to the crimp", TAP)
    circuit.line((4.2, 0.7), (4.2, -0.5))
    circuit.ground((4.2, -0.5))
    circuit.dot((4.2, 0.7))
    circuit.text((x + 0.4, 0.45), "the one point where\ngrounds meet")
    return circuit


def main() -> None:
    """Draw every circuit and write the parts lists into the page."""
    for name, draw in {"circuit_ni_card": ni_card, "circuit_board": board, "circuit_monitor": monitor}.items():
        draw().save(name)
    if PAGE.exists():
        text = PAGE.read_text("utf-8")
        written = BLOCK.sub(lambda found: f"{found[1]}\n{parts_page.block(found[2])}\n\n{found[3]}", text)
        PAGE.write_text(written, encoding="utf-8")


if __name__ == "__main__":
    main()
