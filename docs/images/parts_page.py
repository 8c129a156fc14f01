"""The generated parts of docs/how-to/wire_the_circuit.md: parts lists from the data files, the table of wires."""

from __future__ import annotations

from musclewire.app.wire_table_text import table_text
from musclewire.identify.catalogue_check import PULL_STRESS_PA
from musclewire.identify.wire_table import wire_table
from musclewire.parameters.parts import load_parts

__all__ = ["WIRES", "block"]

# The block that is no parts list: what ``musclewire simulate --table`` prints.
WIRES = "wires"
LENGTH_M, AMBIENT_K = 0.14, 295.15


def wires_block() -> str:
    """Return the table of wires as the command prints it, as a block of text."""
    table = table_text(wire_table(LENGTH_M, PULL_STRESS_PA, AMBIENT_K), LENGTH_M, PULL_STRESS_PA, AMBIENT_K)
    return "\n".join(f"    {line}".rstrip() for line in table.splitlines())


def block(name: str) -> str:
    """Return a list as a table with its total, or the table of wires."""
    if name == WIRES:
        return wires_block()
    parts = load_parts(name)
    lines = [
        f"For {parts.wire}. Prices are estimates as of {parts.prices_of} for one piece, not looked up in a shop.",
        "",
        "| Part | Value | What | Why | About EUR |",
        "|---|---|---|---|---|",
        *(f"| {one.label} | {one.value} | {one.what} | {one.why} | {one.price_eur:.2f} |" for one in parts.part),
        f"| together | | | | {parts.total_eur:.2f} |",
    ]
    boards = [one for one in parts.part if one.board]
    if boards:
        lines += ["", f"The board alone: about {sum(one.price_eur for one in boards):.2f} EUR."]
    return "\n".join(lines)
