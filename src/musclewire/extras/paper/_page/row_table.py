"""The rows of a figure as a table under it, narrow enough for a phone: name, paper, ours, allowed, verdict."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING

from musclewire.extras.paper._page.origin_table import origin_mark
from musclewire.extras.paper._page.row_names import row_name
from musclewire.extras.paper._page.row_text import (
    limit_text,
    ours_text,
    paper_text,
    reason_text,
    spread_text,
    verdict_text,
)
from musclewire.pages import table

if TYPE_CHECKING:
    from musclewire.extras.paper._reproduce import ReproductionRow

__all__ = ["VERDICT_CLASS", "numbers", "reasons", "rows_table"]

VERDICT_CLASS = {"holds": "holds", "at the bar": "bar", "fails": "fails", "reported": "reported"}
# Told apart by form, not by colour alone.
MARKS = {"holds": "✓", "at the bar": "◐", "fails": "✕", "reported": "–"}
HEADER = (
    '<thead><tr><th></th><th class="number">paper</th><th class="number">ours</th>'
    '<th class="number">allowed</th><th></th></tr></thead>'
)
# A table with more rows than this shows those that fail; the others are one touch away.
LONG_TABLE_ROWS = 12


def rows_table(rows: Sequence[ReproductionRow]) -> str:
    """Return the rows of a subject; of a long table those that fail, and the whole to be opened."""
    if len(rows) <= LONG_TABLE_ROWS:
        return table(HEADER, body(rows), "rows")
    failing = [row for row in rows if not row.ok]
    first = table(HEADER, body(failing), "rows") if failing else ""
    return f"{first}<details><summary>All {len(rows)} rows</summary>{table(HEADER, body(rows), 'rows')}</details>"


def body(rows: Iterable[ReproductionRow]) -> str:
    """Return table rows; those of one quantity stand under one heading."""
    quantities: dict[tuple[str, str], list[ReproductionRow]] = {}
    for row in rows:
        quantities.setdefault((row_name(row).heading, row.origin), []).append(row)
    parts = []
    for together in quantities.values():
        if len(together) == 1:
            name = row_name(together[0])
            parts.append(line(together[0], f"{escape(name.heading)}{mark(together[0])}{condition(name.condition)}"))
            continue
        parts.append(
            f'<tr class="quantity"><td colspan="5">{escape(row_name(together[0]).heading)}{mark(together[0])}</td></tr>'
        )
        parts += [line(row, f'<span class="condition">{escape(row_name(row).condition)}</span>') for row in together]
    return "".join(parts)


def condition(text: str) -> str:
    """Return a condition on a line of its own, nothing for none."""
    return f'<span class="condition">{escape(text)}</span>' if text else ""


def mark(row: ReproductionRow) -> str:
    """Return the origin of a row as a label."""
    return f" {origin_mark(row.origin)}"


def line(row: ReproductionRow, name: str) -> str:
    """Return a row, with its problem and the reason of a known failure beneath it."""
    more = reason_text(row)
    below = f'<tr class="why"><td colspan="5">{escape(more)}</td></tr>' if more else ""
    failing = "" if row.ok else " class='failing'"
    return f'<tr{failing}><td class="name" title="{escape(row.name)}">{name}</td>{cells(row)}</tr>{below}'


def cells(row: ReproductionRow) -> str:
    """Return the cells after a row's name."""
    spread = spread_text(row)
    below = f'<span class="spread">{spread}</span>' if spread else ""
    said = verdict_text(row)
    sign = f'<span role="img" aria-label="{said}" title="{said}">{MARKS[row.verdict]}</span>'
    return (
        f'<td class="number paper">{paper_text(row)}</td><td class="number">{ours_text(row)}{below}</td>'
        f'<td class="number">{limit_text(row)}</td>'
        f'<td class="{VERDICT_CLASS[row.verdict]}">{sign}{"" if said == "holds" else f" {said}"}</td>'
    )


def numbers(row: ReproductionRow) -> str:
    """Return a row's numbers as one line of text."""
    unit = row_name(row).unit
    behind = f" {unit}" if unit else ""
    spread = f" ({spread_text(row)})" if spread_text(row) else ""
    printed = f'<span class="paper">paper {paper_text(row)}</span> · ' if paper_text(row) != "–" else ""
    return f"{printed}ours <b>{ours_text(row)}</b>{spread} · allowed {limit_text(row)}{escape(behind)}"


def reasons(rows: Iterable[ReproductionRow]) -> str:
    """Return how the rows are measured and why their tolerances are so, each reason once, to be opened."""
    said: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        said.setdefault((row.kind, row.why), []).append(row_name(row).words)
    lines = "".join(
        f"<dt>{escape('; '.join(dict.fromkeys(names)))}</dt><dd>{kind} · {escape(why)}</dd>"
        for (kind, why), names in said.items()
    )
    return f"<details><summary>How they are measured, and why the tolerance</summary><dl>{lines}</dl></details>"
