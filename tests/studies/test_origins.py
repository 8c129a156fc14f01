"""Origins of rows cannot drift from the search: one table names the rows of every target and of every choice."""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path

import pytest

from musclewire.experiment.reproduce import all_checks

STUDIES = Path(__file__).resolve().parents[2] / "studies"
TABLE: dict[str, dict[str, list[str]]] = tomllib.loads((STUDIES / "rows_of_targets.toml").read_text("utf-8"))
ORIGINS = {check.name: check.origin for check in all_checks()}


def matching(pattern: str, names: Iterable[str]) -> set[str]:
    """Return the names that a pattern stands for; a star is anything, all else itself."""
    wanted = re.compile(".*".join(map(re.escape, pattern.split("*"))))
    return {name for name in names if wanted.fullmatch(name)}


def rows_named(origin: str) -> set[str]:
    """Return every row that the table lists under an origin."""
    return {name for rows in TABLE[origin].values() for pattern in rows for name in matching(pattern, ORIGINS)}


@pytest.fixture(scope="module")
def target_names() -> list[str]:
    """The names of the search's targets, from the targets themselves at the shipped parameters."""
    sys.path.insert(0, str(STUDIES))
    try:
        from paper_wires.targets import targets
        from paper_wires.unknowns import shipped_vector

        return list(targets(shipped_vector()))
    finally:
        sys.path.remove(str(STUDIES))


def test_every_target_of_the_search_is_in_the_table_once(target_names: list[str]) -> None:
    for name in target_names:
        patterns = [pattern for pattern in TABLE["fitted"] if matching(pattern, [name])]
        assert len(patterns) == 1, f"target '{name}': {patterns}; studies/rows_of_targets.toml says which rows it has"


def test_no_target_of_the_table_has_left_the_search(target_names: list[str]) -> None:
    assert [pattern for pattern in TABLE["fitted"] if not matching(pattern, target_names)] == []


@pytest.mark.parametrize("origin", ["fitted", "chosen"])
def test_every_pattern_of_the_table_names_a_row(origin: str) -> None:
    patterns = [pattern for rows in TABLE[origin].values() for pattern in rows]
    assert [pattern for pattern in patterns if not matching(pattern, ORIGINS)] == []


def test_the_fitted_rows_are_those_of_the_targets() -> None:
    assert {name for name, origin in ORIGINS.items() if origin == "fitted"} == rows_named("fitted")


def test_the_chosen_rows_are_those_of_the_choices() -> None:
    """A row that a target and a choice both name is fitted."""
    chosen = {name for name, origin in ORIGINS.items() if origin == "chosen"}
    assert chosen == rows_named("chosen") - rows_named("fitted")
