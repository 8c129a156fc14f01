"""The paper's numbers next to ours as text: counts by origin, every row, and which fail."""

from __future__ import annotations

from collections.abc import Mapping
from io import StringIO
from typing import TYPE_CHECKING

from musclewire.extras.paper._page.row_text import (
    limit_text,
    ours_text,
    paper_text,
    reason_text,
    seeds_text,
    spread_text,
    verdict_text,
)

if TYPE_CHECKING:
    from rich.table import Table

    from musclewire.extras.paper._reproduce.reproduction import Reproduction

TABLE_WIDTH = 150


def rows_text(result: Reproduction) -> str:
    """Return all rows as a table; on a terminal those that fail are red."""
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("row", overflow="fold")
    table.add_column("origin", no_wrap=True)
    for name in ("paper", "ours", "5 to 95 %", "allowed"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    table.add_column("", no_wrap=True)
    for row in result.rows:
        style = None if row.ok and not row.known_failure else "red" if not row.ok else "yellow"
        cells = (
            *(row.name, row.origin, paper_text(row), ours_text(row), spread_text(row), limit_text(row), row.unit),
            verdict_text(row),
        )
        table.add_row(*map(escape, cells), style=style)
    return drawn(table)


def summary_text(result: Reproduction) -> str:
    """Return how many rows of each origin hold, and the names of the failures by whether they are known."""
    from musclewire.extras.paper._reproduce.verdicts import CANNOT_FAIL

    reported = len(result.rows) - len(result.judged_rows)
    apart = len(result.judged_rows) - len(result.counted_rows)
    worse = sum(row.is_worse for row in result.counted_rows)
    said = f"{result.holding} of {len(result.counted_rows)} rows hold"
    said += f", {worse} of them only by their tolerance, worse than the paper's" if worse else ""
    said += f"; {apart} more cannot fail ({', '.join(CANNOT_FAIL)}) and are not counted" if apart else ""
    said += f"; {reported} more are reported and not judged" if reported else ""
    lines = ["", seeds_text(result.seeds), origins_text(result), said, *lacking_lines(result.lacking)]
    groups = (
        ("known failures", [row for row in result.failing if row.known_failure]),
        ("new failures, not on the committed list", result.new_failures),
        ("repaired: on the committed list, and they hold", result.repaired),
    )
    for title, rows in groups:
        lines += [f"{title}:"] if rows else []
        for row in rows:
            reason = reason_text(row)
            lines.append(f"  {row.name}" + (f": {reason}" if reason else ""))
    return "\n".join(lines)


def lacking_lines(lacking: Mapping[str, str]) -> list[str]:
    """Return the rows that are left out, below what is not installed."""
    return [
        line
        for absent in dict.fromkeys(lacking.values())
        for line in (f"left out: {absent}", *(f"  {name}" for name, why in lacking.items() if why == absent))
    ]


def origins_text(result: Reproduction) -> str:
    """Return how many rows of each origin hold, are at the bar, and fail."""
    from rich.table import Table

    from musclewire.extras.paper._reproduce.verdicts import counts_by_origin

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("origin")
    for name in ("rows", "hold", "at the bar", "fail"):
        table.add_column(name, justify="right")
    for one in counts_by_origin(result.rows):
        table.add_row(one.origin, *map(str, (one.rows, one.holds, one.at_the_bar, one.fails)))
    return drawn(table)


def drawn(table: Table) -> str:
    """Return a table as it is on stdout, on a pipe wide enough for it."""
    from rich.console import Console

    out, text = Console(), StringIO()
    width = out.width if out.is_terminal else max(out.width, TABLE_WIDTH)
    Console(file=text, highlight=False, force_terminal=out.is_terminal, width=width).print(table)
    return text.getvalue().removesuffix("\n")
