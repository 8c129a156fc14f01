"""The whole of `musclewire reproduce`, run as a user runs it: its failing rows are those of the committed list."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from page_parts import Outside

from musclewire.app.report.paper_figures import FIGURES
from musclewire.experiment.reproduce import all_checks
from musclewire.parameters.known_failures import known_failures

pytestmark = pytest.mark.slow


def reproduce(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "musclewire", "reproduce", "--json", "--out", str(folder), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)


@pytest.fixture(scope="module")
def answer(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    done = reproduce(tmp_path_factory.mktemp("reproduce"))
    assert done.returncode in {0, 1}, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return {**found, "code": done.returncode, "page": Path(found["report"]).read_text("utf-8")}


def test_the_failing_rows_are_exactly_the_known_ones(answer: dict[str, Any]) -> None:
    assert {row["name"] for row in answer["rows"] if not row["ok"]} == set(known_failures())


def test_the_exit_code_says_whether_a_row_fails(answer: dict[str, Any]) -> None:
    assert answer["code"] == (1 if answer["failing"] else 0)


def test_every_check_has_its_row_and_every_row_a_number(answer: dict[str, Any]) -> None:
    assert [row["name"] for row in answer["rows"]] == [check.name for check in all_checks()]
    for row in answer["rows"]:
        assert row["problem"] is None, row
        assert math.isfinite(row["ours"])


def test_the_verdict_follows_from_the_numbers_in_the_row(answer: dict[str, Any]) -> None:
    for row in answer["rows"]:
        apart = row["ours"] - row["paper"]
        if row["compare"] == "reported":
            assert row["ok"], row["name"]
            continue
        apart = {"within": abs(apart), "at most": apart, "at least": -apart}[row["compare"]]
        assert row["ok"] == (apart <= row["tolerance"] + 1e-9 * max(1.0, abs(row["paper"]))), row["name"]


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


def test_the_same_seed_gives_the_same_numbers_and_only_does_not_change_them(
    answer: dict[str, Any], tmp_path: Path
) -> None:
    again = json.loads(reproduce(tmp_path, "--only", "table2").stdout)["rows"]
    before = [row for row in answer["rows"] if row["name"].startswith("table2.")]
    assert again == before
