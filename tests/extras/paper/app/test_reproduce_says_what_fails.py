"""`musclewire reproduce` with checks of our own making: what it prints, writes and ends with."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.command_line import CommandLine

from musclewire.errors import RecordingError
from musclewire.extras.paper import PaperCheck
from musclewire.extras.paper._reproduce import all_checks, reproduction
from musclewire.extras.paper._reproduce.runs import RunCache

KEYS = {
    *("name", "paper", "ours", "low", "high", "median_low", "median_high", "seeds", "unit", "tolerance", "compare"),
    *("ok", "verdict", "known_failure", "known_reason", "why", "kind", "origin", "problem"),
}


def no_loop(_: RunCache) -> float:
    raise RecordingError("no complete cycle")


def check(name: str, measure: Callable[[RunCache], float]) -> PaperCheck:
    return PaperCheck(name, 2.0, "ohm", 0.5, "because half is enough", "printed", measure, origin="predicted")


GOOD, REPAIRED = check("eq1.good", lambda _: 2.1), check("eq1.repaired", lambda _: 2.0)
REPORTED = PaperCheck(
    "eq1.reported", 2.0, "ohm", 0.0, "for comparison only", "printed", lambda _: 31.0, "reported", origin="predicted"
)
KNOWN, NEW = check("eq2.known", lambda _: 9.0), check("eq2.new[125um,1.70N]", no_loop)


@pytest.fixture
def checks(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    def use(*chosen: PaperCheck) -> None:
        for room in (all_checks, reproduction):
            monkeypatch.setattr(room, "all_checks", lambda: list(chosen))
        known = {"eq2.known": "too <soft> by far", "eq1.repaired": "was too hard"}
        monkeypatch.setattr(reproduction, "known_failures", lambda: known)

    return use


def test_rows_that_hold_end_with_zero_and_one_that_is_reported_counts_neither_way(
    checks: Callable[..., None], musclewire: CommandLine, tmp_path: Path
) -> None:
    checks(GOOD, REPORTED)
    folder = tmp_path / "new" / "folder"
    code, out, _ = musclewire("reproduce", "--output", str(folder))
    assert code == 0
    assert "1 of 1 rows hold; 1 more are reported and not judged" in out
    assert "reported, not judged" in (folder / "reproduce.html").read_text("utf-8")
    document = json.loads((folder / "reproduce.json").read_text("utf-8"))
    assert [(row["compare"], row["ok"]) for row in document["rows"]] == [("within", True), ("reported", True)]
    assert document["failing"] == []


def test_the_json_is_one_document_beside_a_page_that_shows_every_verdict(
    checks: Callable[..., None], musclewire: CommandLine, tmp_path: Path
) -> None:
    checks(GOOD, REPAIRED, KNOWN, NEW)
    code, out, err = musclewire("reproduce", "--json", "--output", str(tmp_path))
    document: dict[str, Any] = json.loads(out)
    assert (code, err) == (1, "")
    assert document == json.loads((tmp_path / "reproduce.json").read_text("utf-8"))
    assert document["failing"] == ["eq2.known", "eq2.new[125um,1.70N]"]
    assert document["new_failures"] == ["eq2.new[125um,1.70N]"]
    assert document["repaired"] == ["eq1.repaired"]
    assert all(set(row) == KEYS for row in document["rows"])
    good, _, known, new = document["rows"]
    assert (good["paper"], good["ours"], good["ok"], good["known_failure"]) == (2.0, 2.1, True, False)
    assert (known["ok"], known["known_failure"], known["known_reason"]) == (False, True, "too <soft> by far")
    assert (new["ours"], new["problem"]) == (None, "no complete cycle")
    page = (tmp_path / "reproduce.html").read_text("utf-8")
    for text in ("2 rows of 4 fail", "fails, known", "fails, new", "holds, listed as failing", "too &lt;soft&gt;"):
        assert text in page


def test_a_single_seed_is_named_in_json_and_on_the_page_and_only_keeps_what_begins_so(
    checks: Callable[..., None], musclewire: CommandLine, tmp_path: Path
) -> None:
    checks(check("eq1.seed", lambda runs: 2.0 + 0.01 * runs.seed), KNOWN)
    options = ("--output", str(tmp_path), "--only", "eq1", "--seed", "7", "--json")
    code, out, _ = musclewire("reproduce", *options)
    document = json.loads(out)
    assert (code, document["seed"], document["seeds"]) == (0, 7, [7])
    assert [(row["name"], row["ours"]) for row in document["rows"]] == [("eq1.seed", 2.07)]
    assert "seed 7 alone" in (tmp_path / "reproduce.html").read_text("utf-8")


def test_many_seeds_give_the_median_with_its_spread_and_the_page_says_which(
    checks: Callable[..., None], musclewire: CommandLine, tmp_path: Path
) -> None:
    checks(check("eq1.seed", lambda runs: 2.0 + 0.01 * runs.seed))
    options = ("--output", str(tmp_path), "--seeds", "21", "--first-seed", "10", "--workers", "1", "--json")
    document = musclewire("reproduce", *options).json
    row = document["rows"][0]
    assert (document["seed"], document["seeds"]) == (None, list(range(10, 31)))
    assert [row[key] for key in ("low", "ours", "high")] == pytest.approx([2.11, 2.2, 2.29])
    assert document["origins"] == {"predicted": {"holds": 1, "at_the_bar": 0, "fails": 0}}
    page = (tmp_path / "reproduce.html").read_text("utf-8")
    assert "2.11 to 2.29" in page
    assert "21 seeds, 10 to 30" in page


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--seed", "7", "--seeds", "3", "--output", "OUT"), "--seed runs a single seed"),
        (("--only", "fig44", "--output", "OUT"), "no row or figure begins with 'fig44'; did you mean 'fig4'?"),
        (("--output", "FILE/under"), "cannot make the folder"),
    ],
)
def test_wrong_usage_is_one_line_exit_code_two_and_nothing_written(
    arguments: tuple[str, ...], says: str, musclewire: CommandLine, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("x")
    places = {"OUT": str(tmp_path / "out"), "FILE/under": str(tmp_path / "file" / "under")}
    assert says in musclewire("reproduce", *[places.get(item, item) for item in arguments]).refusal
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
