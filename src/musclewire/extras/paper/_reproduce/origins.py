"""Which rows the search for the parameters aimed at, and which a setting was picked by: one table decides."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from musclewire.extras.paper._reproduce.paper_checks import PREDICTED_OR_LISTED, Origin, PaperCheck
from musclewire.parameters import read_published

FILE = "rows_of_targets"
# A row that a target and a choice both name is fitted.
TABLES: tuple[Origin, ...] = ("fitted", "chosen")


def with_origins(checks: Sequence[PaperCheck]) -> list[PaperCheck]:
    """Return the checks, those that compare the wire's behaviour with their origin from the table."""
    names = [check.name for check in checks if check.origin == PREDICTED_OR_LISTED]
    table = read_published(FILE)
    origins: dict[str, Origin] = {}
    for origin in reversed(TABLES):
        origins |= dict.fromkeys(rows_named(table[origin], names), origin)
    return [replace(check, origin=origins.get(check.name, check.origin)) for check in checks]


def rows_named(rows_of: Mapping[str, Sequence[str]], names: Iterable[str]) -> set[str]:
    """Return which of some names the patterns of a table stand for."""
    known = list(names)
    return {name for patterns in rows_of.values() for pattern in patterns for name in matching(pattern, known)}


def matching(pattern: str, names: Iterable[str]) -> set[str]:
    """Return the names that a pattern stands for; a star is anything, all else itself."""
    wanted = re.compile(".*".join(map(re.escape, pattern.split("*"))))
    return {name for name in names if wanted.fullmatch(name)}
