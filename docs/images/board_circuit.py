"""The circuit of the board, and the push button that needs none: drawn from the parts lists."""

from __future__ import annotations

import schemdraw.elements as elm
from circuit_drawing import HOT, POWER, TAP, Circuit

from musclewire.extras.board import load_parts

__all__ = ["board", "button"]

RIGHT = 16.4  # where the node above the shunt is
EDGE = 17.8  # the screws to the wire


def board() -> Circuit:
    """An Arduino: filtered PWM, a follower behind a current source, current-sense amplifier."""
    circuit = Circuit(load_parts("board"))
    circuit.box((0.0, -1.2), (2.8, 11.8), "M1  Arduino Nano")
    names = {"12": ("D9", 9.6), "4": ("GND", 8.2), "29": ("GND", 7.4), "5": ("D2", 6.6), "21": ("A2", 5.9)}
    for number, (name, height) in (names | {"19": ("A0", 4.2), "20": ("A1", 1.4), "27": ("5V", -0.7)}).items():
        circuit.box_pin("M1", number, (2.8, height), name)
    circuit.text((0.2, 3.0), "USB to\nthe host")
    low_pass(circuit)
    header(circuit)
    supply(circuit)
    follower(circuit)
    transistors(circuit)
    taps(circuit)
    current_sense(circuit)
    circuit.margin((-0.4, -2.8), (21.8, 14.6))
    return circuit


def low_pass(circuit: Circuit) -> None:
    """Draw what turns the pulses into direct current, and what holds it at 0 V while the pin floats."""
    circuit.line((2.8, 9.6), (4.0, 9.6))
    circuit.line((2.8, 8.2), (4.0, 8.2))
    circuit.line((2.8, 7.4), (4.0, 7.4), (4.0, 8.2))
    circuit.dot((4.0, 9.6))
    circuit.dot((4.0, 8.2))
    circuit.resistor("R1", (4.0, 9.6), (4.0, 8.2), "bottom")
    circuit.ground((4.0, 7.4))
    for label, capacitor, start, end in (("R2", "C1", 4.0, 6.3), ("R3", "C2", 6.3, 8.6)):
        circuit.resistor(label, (start, 9.6), (end, 9.6))
        circuit.dot((end, 9.6))
        circuit.capacitor(capacitor, (end, 9.6))
    circuit.line((8.6, 9.6), (10.2, 9.6))


def header(circuit: Circuit) -> None:
    """Draw the pins for a button and a knob."""
    for height, number, words in ((6.6, "3", "J4.3  button to GND"), (5.9, "2", "J4.2  knob's wiper")):
        circuit.line((2.8, height), (5.0, height))
        circuit.terminal((5.0, height), words, side="right")
        circuit.pin("J4", number, (5.0, height))


def supply(circuit: Circuit) -> None:
    """Draw the way of the 12 V: screws, fuse, diode, emergency stop, current source."""
    circuit.terminal((0.8, 13.2), "J1.1\n+12 V", POWER)
    circuit.pin("J1", "1", (0.8, 13.2))
    circuit.terminal((0.8, 12.0), "J1.2\n0 V", POWER)
    circuit.pin("J1", "2", (0.8, 12.0))
    circuit.line((0.8, 12.0), (1.4, 12.0))
    circuit.ground((1.4, 12.0))
    circuit.part(elm.Fuse, "F1", (0.8, 13.2), (3.6, 13.2), color=POWER)
    circuit.part(elm.Diode, "D1", (3.6, 13.2), (5.6, 13.2), "bottom", "2 1", POWER)
    circuit.emergency_stop((5.6, 13.2), (8.0, 13.2))
    for number, x in (("1", 5.6), ("2", 8.0)):
        circuit.dot((x, 13.2), POWER)
        circuit.pin("J2", number, (x, 13.2))
        circuit.text((x, 13.55), f"J2.{number}", POWER, "center", 9)
    circuit.line((8.0, 13.2), (13.0, 13.2), color=POWER)
    for label, x in (("C5", 8.6), ("C7", 11.9)):
        circuit.dot((x, 13.2), POWER)
        circuit.capacitor(label, (x, 13.2), 1.4)
    current_source(circuit)


def current_source(circuit: Circuit) -> None:
    """Draw the regulator that limits the current whatever fails after it."""
    circuit.box((13.0, 12.6), (2.0, 1.2), circuit.value("U3"))
    for number, place, words_at, name, at in (
        ("3", (13.0, 13.2), (-0.2, 0.2), "IN", (13.35, 13.3)),
        ("2", (15.0, 13.2), (0.2, 0.2), "OUT", (14.55, 13.3)),
        ("1", (14.0, 12.6), (0.2, -0.2), "ADJ", (14.0, 12.85)),
    ):
        circuit.pin("U3", number, place, words_at)
        circuit.text(at, name, align="center", size=9)
    circuit.line((15.0, 13.2), (15.6, 13.2), color=HOT)
    circuit.resistor("R8", (15.6, 13.2), (15.6, 11.4), "bottom")
    circuit.line((14.0, 12.6), (14.0, 11.4), (15.6, 11.4))
    circuit.dot((15.6, 11.4))
    circuit.line((15.6, 11.4), (15.6, 10.0), color=HOT)
    circuit.line((15.6, 11.4), (18.6, 11.4))
    circuit.capacitor("C8", (18.6, 11.4))


def follower(circuit: Circuit) -> None:
    """Draw the amplifier and the output node with its feedback."""
    circuit.drawing.add(elm.Opamp().theta(0).flip().at((10.2, 9.6)).anchor("in2"))
    high, low = 9.6 + 0.21, 9.6 - 1.46
    circuit.text((11.5, 8.1), circuit.value("U1"))
    circuit.pin("U1", "3", (10.2, 9.6), (-0.2, 0.2))
    circuit.pin("U1", "2", (10.2, 8.35), (-0.2, 0.2))
    circuit.pin("U1", "1", (12.37, 8.98), (0.1, 0.22))
    circuit.pin("U1", "8", (10.92, high), (0.2, 0.15))
    circuit.pin("U1", "4", (10.92, low), (0.2, -0.12))
    circuit.line((10.92, high), (10.92, 13.2), color=POWER)
    circuit.dot((10.92, 13.2), POWER)
    circuit.line((10.92, low), (10.92, 7.7))
    circuit.ground((10.92, 7.7))
    circuit.text((6.9, 5.2), "U1, other half: 5 (+) to ground, 6 (-) to 7 (out)", size=9)
    circuit.resistor("R4", (12.37, 8.98), (14.2, 8.98))
    circuit.line((10.2, 8.35), (9.6, 8.35), (9.6, 6.2), (14.2, 6.2))
    circuit.line((14.2, 6.2), (15.6, 6.2), color=HOT)
    circuit.line((15.6, 6.2), (EDGE, 6.2), color=HOT)
    circuit.dot((17.3, 6.2))
    circuit.line((17.3, 6.2), (17.3, 8.6))
    circuit.resistor("R7", (17.3, 8.6), (19.0, 8.6))
    circuit.line((19.0, 8.6), (19.0, 8.2))
    circuit.ground((19.0, 8.2))


def transistors(circuit: Circuit) -> None:
    """Draw the power transistor and the one that limits its current a second time."""
    first = circuit.drawing.add(elm.BjtNpn(circle=True).theta(0).at((14.85, 8.98)).anchor("base"))
    collector = (float(first.collector.x), float(first.collector.y))
    circuit.line((14.2, 8.98), (14.85, 8.98))
    circuit.dot((14.2, 8.98))
    circuit.pin("T1", "1", (14.85, 8.98), (-0.2, 0.2))
    circuit.pin("T1", "2", collector, (0.2, 0.25))
    circuit.pin("T1", "3", (15.6, 8.28), (0.2, -0.1))
    circuit.line(collector, (15.6, 10.0), color=HOT)
    circuit.text((16.2, 9.5), circuit.value("T1"))
    circuit.line((15.6, 8.28), (15.6, 7.9), color=HOT)
    circuit.dot((15.6, 7.9))
    circuit.resistor("RCL", (15.6, 7.9), (15.6, 6.2), "bottom")
    second = circuit.drawing.add(elm.BjtNpn(circle=True).theta(0).reverse().at((14.2, 7.9)).anchor("collector"))
    base, emitter = (float(second.base.x), float(second.base.y)), (float(second.emitter.x), float(second.emitter.y))
    circuit.pin("T2", "1", (14.2, 7.9), (-0.2, 0.2))
    circuit.pin("T2", "2", base, (0.15, 0.22))
    circuit.pin("T2", "3", emitter, (-0.2, -0.1))
    circuit.line((14.2, 7.9), (14.2, 8.98))
    circuit.line(base, (15.25, base[1]), (15.25, 7.9), (15.6, 7.9))
    circuit.line(emitter, (14.2, 6.2))
    circuit.dot((14.2, 6.2))
    circuit.dot((15.6, 6.2))
    circuit.text((13.3, 7.2), circuit.value("T2"), align="right")


def taps(circuit: Circuit) -> None:
    """Draw wire, screws, the upper crimp's tap and its filter."""
    for number, height, color in (("1", 6.2, HOT), ("2", 4.2, TAP), ("3", 2.2, HOT)):
        circuit.terminal((EDGE, height), f"J3.{number}", color, "right")
        circuit.pin("J3", number, (EDGE, height))
    for number, place in (("upper", (20.2, 4.9)), ("upper tap", (20.2, 4.9)), ("lower", (20.2, 2.9))):
        circuit.pin("wire", number, place)
    circuit.drawing.add(elm.Resistor().at((20.2, 4.9)).to((20.2, 2.9)).color(HOT).label("wire", loc="bottom"))
    circuit.line((19.0, 6.2), (20.2, 6.2), (20.2, 4.9), color=HOT)
    circuit.line((19.0, 4.2), (19.5, 4.2), (19.5, 4.9), (20.2, 4.9), color=TAP)
    circuit.line((19.0, 2.2), (20.2, 2.2), (20.2, 2.9), color=HOT)
    for height in (4.9, 2.9):
        circuit.dot((20.2, height), HOT)
        circuit.text((20.5, height), "crimp", HOT, size=9)
    circuit.line((6.0, 4.2), (EDGE, 4.2), color=TAP)
    circuit.text((7.4, 4.55), "tap of the upper crimp, carries no current", TAP)
    circuit.dot((14.2, 4.2), TAP)
    circuit.resistor("R9", (14.2, 4.2), (14.2, 3.0), "bottom")
    circuit.ground((14.2, 3.0))
    filtered(circuit, "R5", "C3", 4.2)


def filtered(circuit: Circuit, resistor: str, capacitor: str, height: float) -> None:
    """Draw the filter in front of an input of the board."""
    circuit.line((2.8, height), (3.7, height))
    circuit.dot((3.7, height))
    circuit.resistor(resistor, (6.0, height), (3.7, height))
    circuit.capacitor(capacitor, (3.7, height), 1.1)


def current_sense(circuit: Circuit) -> None:
    """Draw the amplifier across the shunt, with its own supply behind F2."""
    circuit.line((EDGE, 2.2), (RIGHT, 2.2), color=HOT)
    circuit.resistor("RS", (RIGHT, 2.2), (RIGHT, 0.4), "bottom")
    circuit.line((RIGHT, 0.4), (RIGHT, 0.0), color=HOT)
    circuit.ground((RIGHT, 0.0))
    circuit.text((RIGHT + 0.6, -0.35), "where all grounds meet", size=9)
    for height in (2.2, 0.4):
        circuit.dot((RIGHT, height))
    circuit.drawing.add(elm.Opamp().theta(0).reverse().flip().at((12.4, 2.025)).anchor("in2"))
    circuit.line((12.4, 2.025), (13.2, 2.025), (13.2, 2.2), (RIGHT, 2.2), color=TAP)
    circuit.line((12.4, 0.775), (13.2, 0.775), (13.2, 0.4), (RIGHT, 0.4), color=TAP)
    circuit.pin("U2", "3", (12.4, 2.025), (0.2, 0.2))
    circuit.pin("U2", "4", (12.4, 0.775), (0.2, 0.2))
    circuit.pin("U2", "1", (10.23, 1.4), (-0.15, 0.22))
    circuit.pin("U2", "2", (11.68, 2.235), (-0.2, 0.25))
    circuit.pin("U2", "5", (11.68, 0.565), (0.2, -0.45))
    circuit.line((11.68, 2.235), (11.68, 3.1), (10.7, 3.1))
    circuit.ground((10.7, 3.1))
    circuit.line((10.23, 1.4), (6.0, 1.4))
    filtered(circuit, "R6", "C4", 1.4)
    circuit.text((9.9, 0.55), circuit.value("U2"), align="right")
    five_volts(circuit)


def five_volts(circuit: Circuit) -> None:
    """Draw the board's 5 V through its fuse to the amplifier, and to the header."""
    circuit.line((2.8, -0.7), (5.4, -0.7), color=POWER)
    circuit.dot((3.5, -0.7), POWER)
    circuit.line((3.5, -0.7), (3.5, -1.9), (4.4, -1.9), color=POWER)
    circuit.terminal((4.4, -1.9), "J4.1", POWER, "right")
    circuit.pin("J4", "1", (4.4, -1.9))
    circuit.terminal((6.0, -1.9), "J4.4", side="right")
    circuit.pin("J4", "4", (6.0, -1.9))
    circuit.line((6.0, -1.9), (6.0, -2.2))
    circuit.ground((6.0, -2.2))
    circuit.part(elm.Fuse, "F2", (5.4, -0.7), (8.0, -0.7), color=POWER)
    circuit.line((8.0, -0.7), (11.68, -0.7), (11.68, 0.565), color=POWER)
    circuit.dot((9.6, -0.7), POWER)
    circuit.capacitor("C6", (9.6, -0.7), 1.2)


def button() -> Circuit:
    """A push button and a current source: the least that moves a wire and cannot burn it."""
    circuit = Circuit(load_parts("button"))
    circuit.terminal((0.0, 3.0), "+12 V", POWER)
    circuit.part(elm.Fuse, "F1", (0.0, 3.0), (2.6, 3.0), color=POWER)
    pressed = elm.Button().at((2.6, 3.0)).to((4.8, 3.0)).color(POWER)
    circuit.drawing.add(pressed.label("S1  push button", loc="top", ofst=0.35, fontsize=11))
    circuit.pin("S1", "1", (2.6, 3.0))
    circuit.pin("S1", "2", (4.8, 3.0))
    circuit.line((4.8, 3.0), (7.2, 3.0), color=POWER)
    circuit.dot((5.6, 3.0), POWER)
    circuit.capacitor("C1", (5.6, 3.0), 1.4)
    circuit.box((7.2, 2.4), (2.0, 1.2), circuit.value("U1"))
    for number, place, words_at, name, at in (
        ("3", (7.2, 3.0), (-0.2, 0.2), "IN", (7.5, 3.0)),
        ("2", (9.2, 3.0), (0.2, 0.2), "OUT", (8.8, 3.0)),
        ("1", (8.2, 2.4), (0.2, -0.2), "ADJ", (8.2, 2.62)),
    ):
        circuit.pin("U1", number, place, words_at)
        circuit.text(at, name, align="center", size=9)
    circuit.line((9.2, 3.0), (9.8, 3.0), color=HOT)
    circuit.resistor("R1", (9.8, 3.0), (13.2, 3.0))
    circuit.line((8.2, 2.4), (8.2, 1.6), (13.2, 1.6), (13.2, 3.0))
    circuit.dot((13.2, 3.0))
    circuit.line((13.2, 3.0), (14.6, 3.0), (14.6, 2.4), color=HOT)
    circuit.part(elm.Resistor, "wire", (14.6, 2.4), (14.6, 0.6), "bottom", "upper lower", HOT)
    circuit.ground((14.6, 0.6))
    circuit.terminal((0.0, 0.6), "0 V", POWER, net="GND")
    circuit.line((0.0, 0.6), (0.8, 0.6))
    circuit.ground((0.8, 0.6))
    circuit.margin((-1.6, -0.3), (16.4, 4.6))
    return circuit
