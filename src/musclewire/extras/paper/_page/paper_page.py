"""The page of ``musclewire reproduce``: our figures next to the rows they belong to, in one HTML file."""

from __future__ import annotations

import functools
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from importlib.resources import files
from itertools import groupby
from typing import TYPE_CHECKING, Any, NamedTuple

from musclewire.extras.paper._page import row_text
from musclewire.extras.paper._page.paper_figures import drawn
from musclewire.extras.paper._reproduce.verdicts import counts_by_origin
from musclewire.pages import NumberCard, page
from musclewire.signals import write_text_whole

if TYPE_CHECKING:
    from pathlib import Path

    from musclewire.extras.paper._reproduce.reproduction import Reproduction
    from musclewire.extras.paper._reproduce.verdicts import ReproductionRow


NAME = re.compile(r"(?P<subject>\w+)\.(?P<key>\w+)(?:\[(?P<conditions>[^\]]+)\])?")
QUANTITY = re.compile(r"(?P<number>\d+(?:\.\d+)?)(?P<unit>um|N|V|MPa|x|)")
SPOKEN_UNITS = {"um": "µm wire", "x": "× the spring"}


class RowName(NamedTuple):
    """A row's name in words, its unit, and the condition it holds under, "" for none."""

    words: str
    unit: str
    condition: str

    @property
    def heading(self) -> str:
        """Words with the unit in brackets."""
        return f"{self.words} [{self.unit}]" if self.unit else self.words

    @property
    def whole(self) -> str:
        """Words and condition, without the unit."""
        return f"{self.words}: {self.condition}" if self.condition else self.words


@functools.cache
def row_words() -> Mapping[str, Mapping[str, str]]:
    """Return the file of words."""
    return tomllib.loads((files("musclewire.extras.paper._page") / "row_words.toml").read_text("utf-8"))


def row_name(row: ReproductionRow) -> RowName:
    """Return what a row is called; a row without words keeps its key, spoken."""
    found = NAME.fullmatch(row.name)
    if found is None:
        return RowName(row.name, unit_text(row.unit), "")
    words, key, subject = row_words()["words"], found["key"], found["subject"]
    spoken = words.get(f"{subject}.{key}", words.get(key, key.replace("_", " ").capitalize()))
    return RowName(spoken, unit_text(row.unit), condition_text(subject, found["conditions"] or ""))


def unit_text(unit: str) -> str:
    """Return a row's unit in symbols; "" for a plain number."""
    return row_words()["units"].get(unit, unit)


def condition_text(subject: str, conditions: str) -> str:
    """Return the conditions of a row: "125um,1.70N" is "125 µm wire, 1.70 N"; two of one kind are compared."""
    pieces = conditions.split(",") if conditions else []
    spoken = [one_condition(subject, piece) for piece in pieces]
    units = [found["unit"] for piece in pieces if (found := QUANTITY.fullmatch(piece))]
    return (" against " if len(units) == 2 and units[0] == units[1] else ", ").join(spoken)


def one_condition(subject: str, piece: str) -> str:
    """Return one condition: words of its own, or a number with its unit."""
    words = row_words()
    found = QUANTITY.fullmatch(piece)
    if piece in words["conditions"] or found is None:
        return words["conditions"].get(piece, piece)
    unit = found["unit"] or words["target_units"].get(subject, "")
    return f"{found['number']} {SPOKEN_UNITS.get(unit, unit)}".strip()


@functools.cache
def contents() -> Mapping[str, Any]:
    """Return the parts of the page with their subjects, what each subject is called, and what origins mean."""
    return tomllib.loads((files("musclewire.extras.paper._page") / "contents.toml").read_text("utf-8"))


def write_paper_page(
    result: Reproduction, path: Path, selection: str, on_figure: Callable[[str], None] = lambda _: None
) -> None:
    """Write the page, whole or not at all; ``on_figure`` is called with each subject before it is drawn."""
    rows_of = {subject: list(rows) for subject, rows in groupby(result.rows, key=lambda row: row.subject)}
    parts: dict[str, list[dict[str, Any]]] = {}
    for title, members in contents()["parts"].items():
        for subject in (member for member in members if member in rows_of):
            on_figure(subject)
            figure = drawn(subject, result.runs)
            parts.setdefault(title, []).append(section(subject, rows_of[subject], figure))
    origins = counts_by_origin(result.rows)
    text = page(
        "musclewire.extras.paper._page/paper.html",
        cards=counts(result),
        parts_of_page=parts,
        result=result,
        failing=[row_view(row) for row in result.failing],
        repaired=[row_view(row) for row in result.repaired],
        origins=origins,
        meanings=contents()["origins"],
        most_rows=max((one.rows for one in origins), default=1),
        which_seeds=row_text.seeds_text(result.seeds),
        selection=selection,
    )
    write_text_whole(path, text)


def counts(result: Reproduction) -> list[NumberCard]:
    """Return how many rows hold, fail or were repaired."""
    apart = len(result.judged_rows) - len(result.counted_rows)
    reported = len(result.rows) - len(result.judged_rows)
    known = len(result.failing) - len(result.new_failures)
    at_the_bar = sum(row.verdict == "at the bar" for row in result.rows)
    return [
        NumberCard(
            "Rows that hold",
            f"{result.holding} of {len(result.counted_rows)}",
            f"{at_the_bar} at the bar count as failing",
        ),
        *([NumberCard("Cannot fail", str(apart), "stand apart, not counted")] if apart else []),
        NumberCard("Failing, known", str(known), "on the committed list"),
        NumberCard("Failing, new", str(len(result.new_failures)), "not on the list"),
        NumberCard("Repaired", str(len(result.repaired)), "on the list, and hold"),
        *([NumberCard("Reported, not judged", str(reported), "count for no bar")] if reported else []),
        NumberCard("Computed in", f"{result.wall_s:.1f} s", "before drawing"),
    ]


def short_title(subject: str) -> str:
    """Return what stands before the colon of a title."""
    title: str = contents()["subjects"][subject]["title"]
    return "Isobars" if subject == "isobars" else title.partition(":")[0]


def section(subject: str, rows: Sequence[ReproductionRow], figure: str) -> dict[str, Any]:
    """Return what a section shows: its figure, how many of its rows hold, the rows, and why they are judged so."""
    return {
        "text": "",
        **contents()["subjects"][subject],
        "subject": subject,
        "short_title": short_title(subject),
        "figure": figure,
        "counted": sum(row.is_counted for row in rows),
        "holding": sum(row.ok for row in rows if row.is_counted),
        "rows": grouped([row_view(row) for row in rows]),
        "failing_rows": grouped([row_view(row) for row in rows if not row.ok]),
        "marks": [row.verdict for row in rows],
        "reasons": reasons(rows),
    }


def grouped(rows: Sequence[dict[str, Any]]) -> list[list[dict[str, Any]]]:
    """Return rows by quantity: those of one quantity and origin stand under one heading."""
    quantities: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in rows:
        quantities.setdefault((row["name"].heading, row["origin"]), []).append(row)
    return list(quantities.values())


def row_view(row: ReproductionRow) -> dict[str, Any]:
    """Return what the page shows of a row, as text."""
    name: RowName = row_name(row)
    return {
        "key": row.name,
        "name": name,
        "subject": row.subject,
        "short_title": short_title(row.subject),
        "origin": row.origin,
        "ok": row.ok,
        "verdict": row.verdict,
        "said": row_text.verdict_text(row),
        "paper": row_text.paper_text(row),
        "ours": row_text.ours_text(row),
        "spread": row_text.spread_text(row),
        "limit": row_text.limit_text(row),
        "reason": row_text.reason_text(row),
    }


def reasons(rows: Sequence[ReproductionRow]) -> list[tuple[str, str, str]]:
    """Return names, kind and reason of the rows: how they are measured and why the tolerance, each reason once."""
    found: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        found.setdefault((row.kind, row.why), []).append(row_name(row).words)
    return [("; ".join(dict.fromkeys(names)), kind, why) for (kind, why), names in found.items()]
