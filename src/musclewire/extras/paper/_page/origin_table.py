"""How many rows of each origin hold, as the first table of the reproduction page."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from musclewire.pages import table

if TYPE_CHECKING:
    from musclewire.extras.paper._reproduce import OriginCount

__all__ = ["MEANINGS", "origin_mark", "origin_table"]

# What a row of an origin that holds says of the simulator.
MEANINGS: dict[str, str] = {
    "predicted": "Nothing was set by it: the simulated wire had to find it.",
    "fitted": "A target of the search for the wire's parameters: says that one wire can have all of these numbers.",
    "chosen": "A spool or a setting was selected with this number in view.",
    "designed": "A part or a rule was made to have it: says that the design computes what it should.",
    "definition": "Follows from how numbers are computed, whatever the wire does: says that the code does so.",
    "input": "The number the run was made with, read back.",
}
HEADER = (
    '<thead><tr><th>origin</th><th>what it says if it holds</th><th></th><th class="number">rows</th>'
    '<th class="number">hold</th><th class="number">at the bar</th><th class="number">fail</th></tr></thead>'
)


def origin_mark(origin: str) -> str:
    """Return an origin as a small label in its colour."""
    return f'<span class="origin {origin}">{origin}</span>'


def origin_table(counts: Iterable[OriginCount]) -> str:
    """Return the table, a line for each origin with a bar of its rows."""
    found = list(counts)
    most = max((one.rows for one in found), default=1)
    return table(HEADER, "".join(line(one, most) for one in found), "origins")


def line(count: OriginCount, most: int) -> str:
    """Return the line of an origin; its bar is as long as its rows against the most that one has."""
    parts = (("holds", count.holds), ("bar", count.at_the_bar), ("fails", count.fails))
    pieces = "".join(f'<i class="{name}" style="flex-grow:{number}"></i>' for name, number in parts if number)
    bar = f'<div class="share" style="width:{100.0 * count.rows / most:.1f}%">{pieces}</div>'
    return (
        f"<tr><td>{origin_mark(count.origin)}</td><td>{MEANINGS[count.origin]}</td><td class='shares'>{bar}</td>"
        f'<td class="number">{count.rows}</td>{number(count.holds, "holds")}{number(count.at_the_bar, "bar")}'
        f"{number(count.fails, 'fails')}</tr>"
    )


def number(value: int, name: str) -> str:
    """Return a cell with a count, grey where it is none."""
    return f'<td class="number {name if value else "none"}">{value}</td>'
