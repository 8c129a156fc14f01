"""The page reference/circuits of the site: the table of wires, and each circuit's wiring table and parts."""

from __future__ import annotations

from musclewire.extras.board import load_parts
from musclewire.extras.supply import PULL_STRESS_PA, table_text, wire_table

LENGTH_M, AMBIENT_K = 0.14, 295.15
HEAD = """# Circuits

For whoever builds or changes a circuit of the wiring guides: which current a wire takes, what is joined to what, and
why each part is there, from the parts lists in `src/musclewire/extras/board/parts_lists`, which the tests hold the
drawings and the KiCad files to.

## Wires: currents and shunts

`musclewire simulate --table --wire-length "140 mm"` prints:
"""
COLUMNS = """- **1 s** contracts by 90 % in a second; then lower it to what **holds**. **For long** settles at 150 C at
  most in still air, also where the wire is kept from contracting.
- **Supply** is across wire and shunt. The board's stage needs 6 V more (D1 0.8 V, U3 and R8 3.2 V, T1 1 V, RCL 0.7 V),
  the card's amplifier 4 V.
- **Sense, slow sine, highest, V pulls, shunt** are a rig file's `sense_voltage`, `drive_amplitude`, `maximum_voltage`,
  `pretension` and `shunt`; the firmware for a wire of this name is built with them. Slow sine and highest hold the wire
  at 140 C and 150 C at most, and the sense voltage is an eighth of the amplitude.
"""
PINS = {
    "board": "`U1.3` is pin 3 of U1. Numbers of M1 are a Nano's; on an Uno follow the names. The wire's upper crimp "
    "joins OUTPUT and TAP."
}


def page() -> str:
    """Return the whole page."""
    circuits = {"board": "board's circuit", "button": "push button's circuit", "ni-card": "card's circuit"}
    tables = [part for circuit, title in circuits.items() for part in sections(circuit, title)]
    return "\n".join([HEAD, wires_block(), "", COLUMNS, *tables])


def sections(circuit: str, title: str) -> tuple[str, str]:
    """Return a circuit's wiring table and its parts, each below a heading."""
    note = f"{PINS[circuit]}\n\n" if circuit in PINS else ""
    return (
        f"## Wiring of the {title}\n\n{note}{wiring_block(circuit)}\n",
        f"## Parts of the {title}\n\n{reasons_block(circuit)}\n",
    )


def wires_block() -> str:
    """Return the table of wires as the command prints it, as a block of text."""
    table = table_text(wire_table(LENGTH_M, PULL_STRESS_PA, AMBIENT_K), LENGTH_M, PULL_STRESS_PA, AMBIENT_K)
    return "\n".join(f"    {line}".rstrip() for line in table.splitlines())


def wiring_block(circuit: str) -> str:
    """Return what each net joins: parts, their pin numbers, and the pins' names where they have one."""
    lines = ["| Net | Joins |", "|---|---|"]
    for net, pins in load_parts(circuit).nets().items():
        joined = ", ".join(f"{label}.{pin.pin}" + (f" ({pin.name})" if pin.name else "") for label, pin in pins)
        lines.append(f"| {net} | {joined} |")
    return "\n".join(lines)


def reasons_block(circuit: str) -> str:
    """Return what to buy, why each part is there, where its numbers come from, and the sum of the estimated prices."""
    parts = load_parts(circuit)
    lines = [
        f"For {parts.wire}. Prices are estimates of {parts.prices_of} for one piece; none was looked up in a shop.",
        "",
        "| Part | Value | What | Why | Source | EUR |",
        "|---|---|---|---|---|---|",
        *(
            f"| {one.label} | {one.value} | {one.what} | {one.why} | {one.source} | {one.price_eur:.2f} |"
            for one in parts.part
        ),
        f"| together | | | | | {parts.total_eur:.2f} |",
    ]
    return "\n".join(lines)
