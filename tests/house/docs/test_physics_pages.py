"""docs/explanation/physics.md and docs/reference/parameters.md say what the code and the parameter files say."""

from __future__ import annotations

import importlib
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from tests.house.docs.doc_pages import code_words, resolve, tables_of
from tests.places import CHECKOUT

FOLDER = CHECKOUT / "docs" / "images"
PHYSICS = CHECKOUT / "docs" / "explanation" / "physics.md"
FOUND = CHECKOUT / "docs" / "explanation" / "parameters.md"
TURNS = CHECKOUT / "docs" / "explanation" / "turns_and_minor_loops.md"
PARAMETERS = CHECKOUT / "docs" / "reference" / "parameters.md"
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")
AGAIN = "run python docs/images/draw.py and commit what it changes"


@pytest.fixture(scope="module")
def draw() -> Iterator[ModuleType]:
    sys.path.insert(0, str(FOLDER))
    try:
        yield importlib.import_module("draw")
    finally:
        sys.path.remove(str(FOLDER))


def last_digit(number: str) -> float:
    return 10.0 ** -len(number.partition(".")[2])


@pytest.mark.parametrize("name", ["protection", "wire_row", "faults", "rig_keys", "toml_keys", "python", "live_api"])
def test_a_page_that_a_script_writes_is_as_it_writes_it_and_every_row_says_something(
    draw: ModuleType, name: str
) -> None:
    page = getattr(draw, f"{name}_page").page()
    assert getattr(draw, f"{name.upper()}_PAGE").read_text("utf-8") == page, AGAIN
    rows = [line for line in page.splitlines() if line.startswith("| `")]
    assert [line for line in rows if line.split(" | ")[-1].strip(" |") == ""] == []


def test_the_pages_of_parameters_and_of_the_paper_are_as_their_scripts_write_them(draw: ModuleType) -> None:
    assert PARAMETERS.read_text("utf-8") == draw.parameter_page.page(), AGAIN
    page = draw.PAPER_MAP_PAGE.read_text("utf-8")
    assert page == draw.paper_map_page.page(page), AGAIN


def test_the_check_of_published_ranges_counts_what_the_page_counts(capsys: pytest.CaptureFixture[str]) -> None:
    from checks.published_ranges import main

    code = main()
    found = re.search(r"parameters outside their published range: (\d+)", capsys.readouterr().out)
    assert found is not None
    assert code == (1 if int(found[1]) else 0)
    assert f"counts: **{found[1]}** outside" in PARAMETERS.read_text("utf-8")


BLOCKS: dict[Path, Callable[[Any], dict[str, str]]] = {
    PHYSICS: lambda draw: draw.physics_blocks(draw.physics_runs.loops_of_the_sweep()),
    TURNS: lambda draw: draw.turns_numbers.blocks(),
    FOUND: lambda draw: {"alternatives": draw.alternatives_page.block()},
}


@pytest.mark.documented
@pytest.mark.parametrize("page", BLOCKS, ids=lambda page: page.stem)
def test_the_numbers_on_a_page_are_those_of_the_shipped_wire(draw: ModuleType, page: Path) -> None:
    raw = page.read_text("utf-8")
    text, fresh = " ".join(raw.split()), " ".join(draw.with_blocks(raw, BLOCKS[page](draw)).split())
    assert NUMBER.sub("#", fresh) == NUMBER.sub("#", text), AGAIN
    # Another machine may round the last bit otherwise: a unit of the last digit printed is no other result.
    for ours, printed in zip(NUMBER.findall(fresh), NUMBER.findall(text), strict=True):
        assert float(ours) == pytest.approx(float(printed), abs=1.01 * last_digit(printed)), AGAIN


def test_every_equation_of_the_page_leads_to_code() -> None:
    text = PHYSICS.read_text("utf-8")
    names = re.findall(r"`([\w.]+:[\w.]+)`", text)
    assert len(names) > 20
    for name in names:
        assert resolve(name) is not None
    rows = [row for table in tables_of(text) for row in table if "Equation" in row]
    assert all(code_words(row["Code"]) and row["Source"] for row in rows)
