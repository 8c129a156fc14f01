"""How a file was understood, for whoever has to confirm it: what each header became, ranges, and what is wrong."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

from musclewire.files import (
    CheckedBlocks,
    IgnoredHeader,
    ImportMapping,
    ImportPlan,
    MatchedHeader,
    SourceTable,
    UndecidedHeader,
    heads_of,
    rows_in,
    split_header,
)
from musclewire.identify._proposed_mappings import OFFERED
from musclewire.signals import COLUMNS, MetadataValue, RunFacts, measures, one_line

# What a report shows of a file that holds more:
MAX_LISTED = 20  # ignored headers
SHOWN_ROWS = 3
SHOWN_CELLS = 12  # of each row


@dataclass(frozen=True)
class FileInterpretation:
    """How a file was understood: which header became which column, which ranges they have, and what is wrong.

    Parameters
    ----------
    path
        The file.
    layout
        How the file is built, in words: "text, separated by semicolons".
    row_count
        Number of rows, n_times; of a file with a problem, all that it holds.
    taken
        The headers that became columns, with unit and factor.
    ignored
        The headers that did not, each with the reason.
    undecided
        The headers that would be columns, each with what has to be decided first.
    metadata
        The metadata in the file.
    ranges
        Smallest and largest number of each column, in SI.
    notes
        What reading left out, counted or changed, a sentence each.
    problem
        Why the file cannot be read as a recording, in one line; "" if it can.
    mapping
        The mapping that says all this explicitly, for the next file of this kind.
    proposal
        The mapping that reads a file with a problem, or more of one without, tried; None if none is known or needed.
    first_rows
        The first rows as they were read, of a file with a problem for which no mapping is proposed; else nothing.
    """

    path: str
    layout: str
    row_count: int
    taken: tuple[MatchedHeader, ...]
    ignored: tuple[IgnoredHeader, ...]
    undecided: tuple[UndecidedHeader, ...]
    metadata: Mapping[str, MetadataValue]
    ranges: Mapping[str, tuple[float, float]]
    notes: tuple[str, ...]
    problem: str
    mapping: ImportMapping
    proposal: ImportMapping | None = None
    first_rows: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, object]:
        """Return plain values for JSON."""
        return {
            "path": self.path,
            "layout": self.layout,
            "rows": self.row_count,
            "taken": [asdict(item) for item in self.taken],
            "ignored": [{"header": item.header, "reason": item.reason} for item in self.ignored],
            "undecided": [asdict(item) for item in self.undecided],
            "metadata": dict(self.metadata),
            "ranges": {name: list(limits) for name, limits in self.ranges.items()},
            "notes": list(self.notes),
            "problem": self.problem,
        }

    def __str__(self) -> str:
        """Return the report as lines of text."""
        lines = [f"{self.path}: {self.layout}, {self.row_count} rows"]
        lines += [f"  '{item.header}' -> {item.column}{_arithmetic(item)} ({_why(item)})" for item in self.taken]
        lines += [
            f"  '{item.header}' undecided: " + item.message.removeprefix(f"{self.path}: ") for item in self.undecided
        ]
        lines += [f"  '{item.header}' ignored: {item.reason}{self._offer(item)}" for item in self.ignored[:MAX_LISTED]]
        more = len(self.ignored) - MAX_LISTED
        lines += [f"  {more} more ignored"] if more > 0 else []
        lines += [f"  read as: {row}" for row in self.first_rows]
        lines += [f"  {name}: {self._range(name)}" for name in self.ranges]
        lines += [f"  {note}" for note in self.notes]
        lines += [f"  {key} = {value}" for key, value in self.metadata.items()]
        return "\n".join(lines)

    def _range(self, name: str) -> str:
        low, high = self.ranges[name]
        unit = COLUMNS[name].unit
        return f"{low:.6g} to {high:.6g}{f' {unit}' if unit else ''}"

    def _offer(self, item: IgnoredHeader) -> str:
        """Return what a header with an unknown name could be mapped to, by its unit."""
        unit = split_header(item.header)[1]
        known = {one.column for one in self.taken} | {one.column for one in self.undecided}
        fitting = [name for name in OFFERED if name not in known and unit and measures(unit, name)]
        return f"; perhaps -c {fitting[0]}='{item.header}'" if fitting and item.reason == "name not known" else ""


def interpretation_of(
    plan: ImportPlan, tally: CheckedBlocks, judged: Sequence[str], problem: str, proposal: ImportMapping | None
) -> FileInterpretation:
    """Return the report of a plan whose blocks have been read and judged, to the end or to a problem."""
    table, match = plan.table, plan.match
    metadata = {**tally.started, **plan.metadata}
    return FileInterpretation(
        table.path,
        table.layout,
        rows_in(table) or tally.row_count if problem else tally.row_count,
        match.taken,
        match.ignored,
        match.undecided,
        metadata,
        tally.ranges,
        (*plan.notes, *tally.notes, *judged, *filter(None, [RunFacts(metadata).cut_off])),
        problem,
        _explicit(plan),
        proposal,
        _first_rows(table) if problem and proposal is None else (),
    )


def _first_rows(table: SourceTable) -> tuple[str, ...]:
    """Return the first rows of a table in words, each cell as it was read."""
    head = [cells[:SHOWN_ROWS] for cells in heads_of(table)[:SHOWN_CELLS] if len(cells)]
    more = ", ..." if len(table.columns) > SHOWN_CELLS else ""
    rows = zip(
        *([one_line(cell) if isinstance(cell, str) else f"{cell:g}" for cell in cells] for cells in head), strict=False
    )
    return tuple(", ".join(row) + more for row in rows)


def _explicit(plan: ImportPlan) -> ImportMapping:
    """Return a mapping that takes what this plan takes, whatever names will be recognised then."""
    given = plan.mapping
    headers = [column.header for column in plan.table.columns]
    columns = {item.column: _wanted(item, headers) for item in plan.match.taken}
    return ImportMapping(
        columns,
        (),
        given.sample_period_s,
        given.drop_missing,
        given.zero,
        given.invert,
        given.metadata,
        only_mapped=True,
        group=given.group,
    )


def _wanted(item: MatchedHeader, headers: Sequence[str]) -> str:
    """Return a header with its unit as a mapping names it: by its number if others have the same name."""
    own = headers[item.index]
    header = own if headers.count(own) == 1 else f"#{item.index + 1}"
    stated = item.unit and not (item.is_text and item.unit == "s")
    return f"{header}:{item.unit}" if stated else header


def _why(item: MatchedHeader) -> str:
    if item.is_text:
        return f"{item.how}, times as text from the first row on"
    return {"values": "found in its values"}.get(item.how, item.how)


def _arithmetic(item: MatchedHeader) -> str:
    if item.is_text:
        return ""
    if item.factor == 1.0 and not item.offset:
        return f" [{item.unit}]" if item.unit else ""
    offset = f" + {item.offset:g}" if item.offset else ""
    return f" [{item.unit}] x {item.factor:g}{offset}"
