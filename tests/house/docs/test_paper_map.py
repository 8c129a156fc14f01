"""docs/reference/paper_map.md names everything the paper has, and nothing that does not exist."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from tests.house.docs.doc_pages import code_words, resolve, tables_of
from tests.places import CHECKOUT

from musclewire.extras.paper import all_checks, selected

ROWS = [
    row
    for table in tables_of((CHECKOUT / "docs/reference/paper_map.md").read_text("utf-8"))
    for row in table
    if "Paper" in row
]
IDS = [row["Paper"] for row in ROWS]

SECTIONS = [f"Section {name}" for name in ("I", "2.1", "2.2", "2.3", "III", "4.1", "4.2", "4.3", "V")]
EQUATIONS = [f"Eq. {number}" for number in range(1, 10)]
FIGURES = [f"Fig. {number}" for number in range(1, 19)]
TABLES = [f"Table {number}" for number in range(1, 4)]
DEVICES = [
    *("Load cell (Futek LSB 200)", "LVDT", "NI PCI-6229", "Buffer amplifier", "External resistor R"),
    *("Helical bias spring (588.60 N/m)", "Linear stage", "Laser (LK-081)", "Pretensioner", "Flexural finger"),
    *("Linear stage 1", "Linear stage 2"),
]


def test_everything_of_the_paper_is_listed_once_and_nothing_that_it_has_not() -> None:
    assert len(IDS) == len(set(IDS))
    assert {re.sub(r"(?<=\d)\([a-d]\)$", "", name) for name in IDS} == {
        *SECTIONS, *EQUATIONS, *FIGURES, *TABLES, *DEVICES
    }  # fmt: skip


@pytest.mark.parametrize("row", ROWS, ids=IDS)
def test_every_object_command_and_test_named_exists(row: dict[str, str], commands: dict[str, Any]) -> None:
    for name in code_words(row["Code"]):
        assert resolve(name) is not None
    for words in code_words(row["Command"]):
        program, command = words.split(maxsplit=1)
        assert program == "musclewire"
        assert command in commands
    for name in code_words(row["Test"]):
        file, _, function = name.partition("::")
        path: Path = CHECKOUT / file
        assert path.is_file()
        assert not function or f"def {function}(" in path.read_text("utf-8")


@pytest.mark.parametrize("row", ROWS, ids=IDS)
def test_the_rows_named_exist_and_an_entry_without_names_its_own_command_and_test(row: dict[str, str]) -> None:
    beginnings = code_words(row["Rows"])
    assert all(selected(all_checks(), beginning) for beginning in beginnings)
    assert beginnings or (row["Command"] and row["Test"])


def test_every_row_of_the_paper_belongs_to_an_entry() -> None:
    """Isobars are in another publication."""
    checks = all_checks()
    listed = {
        check.name for row in ROWS for beginning in code_words(row["Rows"]) for check in selected(checks, beginning)
    }
    assert [check.name for check in checks if check.name not in listed and not check.name.startswith("isobars.")] == []
