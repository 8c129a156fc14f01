"""The circuit of an NI card, and a monitor chip in the place of a board's converter: drawn from the parts lists."""

from __future__ import annotations

import schemdraw.elements as elm
from circuit_drawing import HOT, POWER, TAP, Circuit, Place

from musclewire.extras.board import load_parts

__all__ = ["monitor", "ni_card"]

RIGHT = 15.2  # where wire and shunt are


def ni_card() -> Circuit:
    """An NI card, a power operational amplifier as buffer, wire and shunt with a pair of taps each."""
    circuit = Circuit(load_parts("ni-card"))
    circuit.box((0.0, -1.0), (2.8, 12.2), "NI card")
    terminals = {"22": ("ao0", 10.0), "55": ("ao gnd", 8.6), "68": ("ai0 +", 6.2), "34": ("ai0 -  (ai8)", 4.2)}
    for number, (name, height) in (
        terminals | {"33": ("ai1 +", 2.6), "66": ("ai1 -  (ai9)", 0.8), "67": ("ai gnd", -0.4)}
    ).items():
        circuit.box_pin("card", number, (2.8, height), name)
    rail(circuit, 14.6, ("F1", "1 2", "+12V"), "+12 V")
    rail(circuit, 13.0, ("F2", "3 4", "-5V"), "-5 V")
    buffer_of_the_card(circuit)
    amplifier(circuit)
    circuit.line((10.8, 9.375), (RIGHT, 9.375), (RIGHT, 6.2), color=HOT)
    wire_and_shunt(circuit)
    circuit.margin((-0.4, -2.0), (20.0, 15.6))
    return circuit


def wire_and_shunt(circuit: Circuit) -> None:
    """Draw the wire, the shunt and their pairs of taps down to the one ground."""
    circuit.part(elm.Resistor, "wire", (RIGHT, 6.2), (RIGHT, 4.2), "bottom", "upper lower", HOT)
    circuit.line((RIGHT, 4.2), (RIGHT, 2.6), color=HOT)
    circuit.resistor("RS", (RIGHT, 2.6), (RIGHT, 0.8), "bottom")
    circuit.line((RIGHT, 0.8), (RIGHT, -0.4), color=HOT)
    circuit.ground((RIGHT, -0.4))
    for height in (6.2, 4.2, 2.6, 0.8):
        circuit.line((2.8, height), (RIGHT, height), color=TAP)
        circuit.dot((RIGHT, height), TAP)
    circuit.line((2.8, -0.4), (RIGHT, -0.4))
    circuit.text((3.6, 5.2), "twisted pair, soldered to the crimps: carries no current", TAP)
    circuit.text((3.6, 1.7), "twisted pair, soldered to the shunt's ends", TAP)
    circuit.text((RIGHT + 0.6, -0.75), "where all grounds meet", size=9)
    for height in (6.2, 4.2):
        circuit.text((RIGHT + 0.3, height), "crimp", HOT, size=9)


def rail(circuit: Circuit, height: float, names: tuple[str, str, str], volts: str) -> None:
    """Draw a supply with its fuse and its contact of the emergency stop."""
    fuse, contact, net = names
    circuit.terminal((1.6, height), volts, POWER)
    circuit.part(elm.Fuse, fuse, (1.6, height), (4.0, height), color=POWER)
    ends = contact.split()
    circuit.emergency_stop((4.0, height), (6.4, height), contact, f"S1  emergency stop {ends[0]}-{ends[1]}")
    circuit.line((6.4, height), (7.2, height), color=POWER)
    circuit.terminal((7.2, height), f"{volts} to U1", POWER, "right", net)


def buffer_of_the_card(circuit: Circuit) -> None:
    """Draw what stands before the amplifier, and its limit and bypass capacitors."""
    circuit.line((2.8, 10.0), (4.2, 10.0))
    circuit.dot((4.2, 10.0))
    circuit.resistor("R1", (4.2, 10.0), (4.2, 8.6), "bottom")
    circuit.resistor("R3", (4.2, 10.0), (7.4, 10.0))
    circuit.line((2.8, 8.6), (4.2, 8.6))
    circuit.ground((4.2, 8.6))
    bypass(circuit, "C1", (12.0, 14.6), ("+12 V", "+12V"), "1 2")
    bypass(circuit, "C2", (15.6, 14.6), ("-5 V", "-5V"), "2 1")


def bypass(circuit: Circuit, label: str, top: Place, rail_name: tuple[str, str], ends: str) -> None:
    """Draw a capacitor from a rail to ground."""
    x, y = top
    words, net = rail_name
    circuit.terminal(top, words, POWER, net=net)
    circuit.part(elm.Capacitor, label, top, (x, y - 1.4), "bottom", ends)
    circuit.ground((x, y - 1.4))


def amplifier(circuit: Circuit) -> None:
    """Draw the amplifier with its supplies and limit, and diode and snubber at its output."""
    circuit.drawing.add(elm.Opamp().theta(0).flip().at((7.4, 10.0)).anchor("in2"))
    high, low, middle = 10.21, 8.54, 8.12
    circuit.text((8.8, 10.4), circuit.value("U1"))
    circuit.pin("U1", "1", (7.4, 10.0), (-0.2, 0.2))
    circuit.pin("U1", "2", (7.4, 8.75), (-0.2, 0.2))
    circuit.pin("U1", "6", (9.57, 9.375), (0.15, 0.2))
    circuit.pin("U1", "5", (middle, high), (0.2, 0.2))
    circuit.pin("U1", "4", (middle, low), (0.2, -0.15))
    circuit.line((7.4, 8.75), (6.4, 8.75), (6.4, 7.0), (10.8, 7.0), (10.8, 9.375))
    circuit.line((9.57, 9.375), (10.8, 9.375), color=HOT)
    circuit.dot((10.8, 9.375))
    circuit.line((middle, high), (middle, 11.2), color=POWER)
    circuit.terminal((middle, 11.2), "+12 V", POWER, "right", "+12V")
    circuit.line((middle, low), (middle, 7.7), color=POWER)
    circuit.terminal((middle, 7.7), "-5 V", POWER, "right", "-5V")
    circuit.pin("U1", "3", (11.6, 11.2), (-0.1, 0.25))
    circuit.terminal((11.6, 11.2), "U1 ILIM")
    circuit.resistor("RCL", (11.6, 11.2), (14.2, 11.2))
    circuit.terminal((14.2, 11.2), "-5 V", POWER, "right", "-5V")
    circuit.text((16.2, 11.2), "U1 pin 7 (E/S): open")
    circuit.dot((12.6, 9.375))
    circuit.resistor("R2", (12.6, 9.375), (12.6, 8.3), "bottom")
    circuit.part(elm.Capacitor, "C3", (12.6, 8.3), (12.6, 7.2), "bottom")
    circuit.ground((12.6, 7.2))
    circuit.line((RIGHT, 9.375), (17.2, 9.375))
    circuit.dot((RIGHT, 9.375))
    circuit.part(elm.Schottky, "D1", (17.2, 7.6), (17.2, 9.375), "bottom", "A K")
    circuit.ground((17.2, 7.6))


def monitor() -> Circuit:
    """A voltage and current monitor chip across wire and shunt, instead of two converter channels."""
    circuit = Circuit(load_parts("board"))
    rows = {"VCC": 4.9, "SDA": 3.6, "SCL": 2.3, "GND": 0.7}
    circuit.box((0.0, 0.0), (2.8, 5.6), "board, 3.3 or 5 V")
    circuit.box((5.6, 0.0), (3.4, 5.6), "INA226 module")
    for name, height in rows.items():
        circuit.line((2.8, height), (5.6, height), color=POWER if name == "VCC" else "black")
        circuit.text((2.68, height), name, align="right")
        circuit.text((5.75, height), name)
    x = 13.6
    circuit.terminal((11.0, 6.4), "J3.1", HOT)
    circuit.line((11.0, 6.4), (x, 6.4), (x, 4.9), color=HOT)
    circuit.drawing.add(elm.Resistor().at((x, 4.9)).to((x, 2.9)).color(HOT).label("wire", loc="bottom"))
    circuit.drawing.add(elm.Resistor().at((x, 2.9)).to((x, 0.9)).label("RS\n0.33 ohm\n1 %", loc="bottom", fontsize=11))
    circuit.line((x, 0.9), (x, 0.3), color=HOT)
    circuit.ground((x, 0.3))
    for name, height in {"VBUS": 4.9, "IN+": 2.9, "IN-": 0.9}.items():
        circuit.text((8.88, height), name, align="right")
        circuit.line((9.0, height), (x, height), color=TAP)
        circuit.dot((x, height), TAP)
    circuit.text((9.3, 5.25), "own lead to the crimp", TAP)
    circuit.line((4.2, 0.7), (4.2, -0.5))
    circuit.ground((4.2, -0.5))
    circuit.dot((4.2, 0.7))
    circuit.text((x + 0.6, 0.0), "where all grounds meet", size=9)
    circuit.margin((-0.4, -1.4), (18.4, 7.0))
    return circuit
