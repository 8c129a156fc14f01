"""Origins of rows cannot drift from the search: one table names the rows of every target and of every choice."""

from __future__ import annotations

import sys

import pytest
from tests.places import CHECKOUT

from musclewire.extras.paper import all_checks
from musclewire.extras.paper._reproduce.all_checks import matching, rows_named
from musclewire.parameters import read_published

STUDIES = CHECKOUT / "studies"
TABLE: dict[str, dict[str, list[str]]] = read_published("rows_of_targets")
ORIGINS = {check.name: check.origin for check in all_checks()}


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
    """rows_of_targets.toml says which rows each has, or that it is a bound of physics and has none."""
    listed = {name: [pattern for pattern in TABLE["fitted"] if matching(pattern, [name])] for name in target_names}
    assert {name: patterns for name, patterns in listed.items() if len(patterns) != 1} == {}


def test_no_target_of_the_table_has_left_the_search(target_names: list[str]) -> None:
    assert [pattern for pattern in TABLE["fitted"] if not matching(pattern, target_names)] == []


@pytest.mark.parametrize("origin", ["fitted", "chosen", "interpolated", "satisfied"])
def test_every_pattern_of_the_table_names_rows(origin: str) -> None:
    patterns = [pattern for rows in TABLE[origin].values() for pattern in rows]
    assert [pattern for pattern in patterns if not matching(pattern, ORIGINS)] == []


def test_only_what_the_wire_does_is_fitted_or_chosen_and_no_such_row_is_called_predicted() -> None:
    satisfied = rows_named(TABLE["satisfied"], ORIGINS)
    fitted, chosen = (rows_named(TABLE[origin], ORIGINS) - satisfied for origin in ("fitted", "chosen"))
    assert {name: ORIGINS[name] for name in fitted} == dict.fromkeys(fitted, "fitted")
    assert {name: ORIGINS[name] for name in chosen - fitted} == dict.fromkeys(chosen - fitted, "chosen")
