"""The whole of `musclewire reproduce`, run as a user runs it: its failing rows are those of the committed list."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from tests.published.page_parts import Outside
from tests.tools import require_package

from musclewire.extras.paper import DEFAULT_SEEDS, all_checks, known_failures
from musclewire.extras.paper._page.paper_figures import FIGURES

# The whole table takes minutes; one row of each kind is in tests of the command.
pytestmark = pytest.mark.full
require_package("musclewire_design", "pip install ./packages/design")


def reproduce(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "musclewire", "reproduce", "--json", "--output", str(folder), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)


@pytest.fixture(scope="module")
def answer(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    done = reproduce(tmp_path_factory.mktemp("reproduce"))
    assert done.returncode in {0, 1}, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return {**found, "code": done.returncode, "page": Path(found["report"]).read_text("utf-8")}


def test_the_failing_rows_are_exactly_the_known_ones(answer: dict[str, Any]) -> None:
    assert {row["name"] for row in answer["rows"] if not row["ok"]} == set(known_failures())


def test_every_check_has_its_row_and_every_row_a_number(answer: dict[str, Any]) -> None:
    assert [row["name"] for row in answer["rows"]] == [check.name for check in all_checks()]
    for row in answer["rows"]:
        assert row["problem"] is None, row
        assert row["seeds"] == len(answer["seeds"]) == DEFAULT_SEEDS
        assert math.isfinite(row["ours"])
        assert row["low"] <= row["ours"] <= row["high"]


def test_the_verdict_follows_from_the_numbers_in_the_row(answer: dict[str, Any]) -> None:
    def holds(row: dict[str, Any], ours: float) -> bool:
        apart = ours - row["paper"]
        apart = {"within": abs(apart), "at most": apart, "at least": -apart}[row["compare"]]
        return bool(apart <= row["tolerance"] + 1e-9 * max(1.0, abs(row["paper"])))

    for row in answer["rows"]:
        if row["compare"] == "reported":
            assert (row["ok"], row["verdict"]) == (True, "reported"), row["name"]
            continue
        ends = [holds(row, row[end]) for end in ("median_low", "median_high")]
        assert row["ok"] == (row["verdict"] == "holds") == all(ends), row["name"]
        assert row["verdict"] == "at the bar" or ends[0] == ends[1], row["name"]


def test_rows_are_counted_by_origin(answer: dict[str, Any]) -> None:
    for origin, counts in answer["origins"].items():
        verdicts = Counter(row["verdict"] for row in answer["rows"] if row["origin"] == origin)
        assert [counts[key] for key in ("holds", "at_the_bar", "fails")] == [
            verdicts[verdict] for verdict in ("holds", "at the bar", "fails")
        ]


def test_the_page_stands_alone_with_every_figure_and_every_row(answer: dict[str, Any]) -> None:
    page = Outside()
    page.feed(answer["page"])
    assert page.fetched == []
    assert "script" not in page.tags
    assert "@import" not in answer["page"]
    assert re.search(r"url\((?!#)", answer["page"]) is None
    assert page.tags.count("svg") == len(FIGURES)
    for row in answer["rows"]:
        assert f'title="{row["name"]}"' in answer["page"]


def test_the_same_seeds_give_the_same_numbers_and_neither_only_nor_workers_change_them(
    answer: dict[str, Any], tmp_path: Path
) -> None:
    again = json.loads(reproduce(tmp_path, "--only", "table2", "--workers", "1").stdout)["rows"]
    before = [row for row in answer["rows"] if row["name"].startswith("table2.")]
    assert again == before
