"""Every check, in the order of the paper: the table rows.toml, whose head says what its keys are."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any

from musclewire.extras.paper._reproduce.paper_checks import PREDICTED_OR_LISTED, Origin, PaperCheck
from musclewire.parameters import read_published
from musclewire.small_files import read_toml

FILE = "rows_of_targets"
# A row that a target and a choice both name is fitted.
TABLES: tuple[Origin, ...] = ("fitted", "chosen", "interpolated")


def with_origins(checks: Sequence[PaperCheck]) -> list[PaperCheck]:
    """Return the checks with the origins of the table: of what cannot fail, and of what the wire does."""
    names = [check.name for check in checks if check.origin == PREDICTED_OR_LISTED]
    table = read_published(FILE)
    origins: dict[str, Origin] = {}
    for origin in reversed(TABLES):
        origins |= dict.fromkeys(rows_named(table[origin], names), origin)
    origins |= dict.fromkeys(rows_named(table["satisfied"], [check.name for check in checks]), "satisfied")
    return [replace(check, origin=origins.get(check.name, check.origin)) for check in checks]


def rows_named(rows_of: Mapping[str, Sequence[str]], names: Iterable[str]) -> set[str]:
    """Return which of some names the patterns of a table stand for."""
    known = list(names)
    return {name for patterns in rows_of.values() for pattern in patterns for name in matching(pattern, known)}


def matching(pattern: str, names: Iterable[str]) -> set[str]:
    """Return the names that a pattern stands for; a star is anything, all else itself."""
    wanted = re.compile(".*".join(map(re.escape, pattern.split("*"))))
    return {name for name in names if wanted.fullmatch(name)}


TABLE = Path(__file__).parent / "rows.toml"
ISOBARS = "isobars."
# What a row has unless it says otherwise, and what one of a kind has.
DEFAULTS: dict[str, Any] = {"tolerance": 0.0, "compare": "within", "origin": PREDICTED_OR_LISTED, "needs": ""}
OF_KIND: dict[str, dict[str, Any]] = {
    "input": {"origin": "input", "why": "taken over from the paper: the number the run was made with"},
    "equation": {"paper": 0.0, "compare": "at most", "origin": "definition"},
}


@cache
def all_checks() -> tuple[PaperCheck, ...]:
    """Return every check in the order of the paper, introduction and conclusions together, the isobars last."""
    tables = read_toml(TABLE, "table of rows")
    texts = tables.pop("texts")
    return tuple(with_origins([check for name, table in tables.items() for check in checks_of(name, table, texts)]))


def tolerance_of(beginning: str) -> float:
    """Return the tolerance of the first row whose name begins so."""
    return next(check.tolerance for check in all_checks() if check.name.startswith(beginning))


def checks_of(name: str, table: Mapping[str, Any], texts: Mapping[str, str]) -> Iterator[PaperCheck]:
    """Yield the checks of a table: one, or one for each of the values in its lists."""
    each = {key: printed(found) if isinstance(found, str) else found for key, found in table.get("each", {}).items()}
    shared = {**DEFAULTS, **OF_KIND.get(table["kind"], {}), **{key: table[key] for key in table if key != "each"}}
    for values in zip(*each.values(), strict=True) if each else [()]:
        yield check_of(name, {**shared, **dict(zip(each, values, strict=True))}, texts)


def check_of(name: str, keys: dict[str, Any], texts: Mapping[str, str]) -> PaperCheck:
    """Return the check of one row; what is no key of a row is an argument of its measure."""
    row, label = name.format(**keys), keys.pop("label", "")
    paper, tolerance, measure = printed(keys.pop("paper")), keys.pop("tolerance"), keys.pop("measure")
    unit, why, kind, compare, origin, needs = (
        keys.pop(key) for key in ("unit", "why", "kind", "compare", "origin", "needs")
    )
    return PaperCheck(
        row,
        paper,
        unit,
        allowed(tolerance, paper),
        why.format(label=label, **texts).format(label=label),
        kind,
        partial(function_at(measure), **keys) if keys else function_at(measure),
        compare,
        origin=origin,
        needs=needs,
    )


def printed(value: Any) -> Any:
    """Return a number of the published results by where it stands there, or a list of them; a number is itself."""
    if not isinstance(value, str):
        return value
    found: Any = read_published("flexinol_isobars" if value.startswith(ISOBARS) else "lan_fan_2010")
    for key in value.removeprefix(ISOBARS).split("."):
        found = found[int(key)] if isinstance(found, list) else found[key]
    return found


def allowed(tolerance: float | str, paper: float) -> float:
    """Return a tolerance as a number: "5 %" of the paper's, or "up to 5.4"."""
    if not isinstance(tolerance, str):
        return tolerance
    if tolerance.endswith("%"):
        return float(tolerance.removesuffix("%")) / 100.0 * paper
    return float(tolerance.removeprefix("up to ")) - paper


def function_at(name: str) -> Any:
    """Return the measure "module.function" of this folder."""
    module, _, function = name.partition(".")
    return getattr(import_module(f"{__package__}.{module}"), function)
