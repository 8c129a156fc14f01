"""The generated parts of the wiring guides: parts with reasons and prices, wiring tables, and the table of wires."""

from __future__ import annotations

from musclewire.extras.board import load_parts
from musclewire.extras.design import PULL_STRESS_PA, table_text, wire_table

__all__ = ["WIRES", "block"]

# The block that is about no circuit: what ``musclewire simulate --table`` prints.
WIRES = "wires"
LENGTH_M, AMBIENT_K = 0.14, 295.15


def block(name: str) -> str:
    """Return a block by its name: ``wires``, or ``wiring`` or ``reasons`` and a circuit's name."""
    if name == WIRES:
        return wires_block()
    kind, _, circuit = name.partition(" ")
    return {"wiring": wiring_block, "reasons": reasons_block}[kind](circuit)


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
