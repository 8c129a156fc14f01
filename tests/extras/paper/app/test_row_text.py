"""The numbers of a row as people read them, on the page and in the terminal."""

from __future__ import annotations

import re

import pytest

from musclewire.errors import RecordingError
from musclewire.extras.paper import PaperCheck, ReproductionRow, SeedResult, all_checks, row_of_check
from musclewire.extras.paper._page.paper_figures import FIGURES, drawn
from musclewire.extras.paper._page.paper_page import contents, row_name, row_words
from musclewire.extras.paper._page.row_text import (
    limit_text,
    paper_text,
)
from musclewire.extras.paper._reproduce.paper_checks import Compare, Kind, subject_of
from musclewire.extras.paper._reproduce.runs import RunCache


def row(
    ours: float, paper: float, tolerance: float, compare: Compare = "within", kind: Kind = "printed"
) -> ReproductionRow:
    check = PaperCheck("fig0.x", paper, "ohm", tolerance, "because", kind, lambda _: ours, compare, origin="predicted")
    return row_of_check(check, [SeedResult(ours)], {})


@pytest.mark.parametrize(
    ("tolerance", "compare", "kind", "paper", "limit"),
    [
        (0.5, "within", "printed", "2", "± 0.5"),
        (0.0, "within", "words", "–", "= 2"),
        (0.5, "at most", "printed", "2", "≤ 2.5"),
        (0.5, "at least", "equation", "–", "≥ 1.5"),
    ],
)
def test_what_is_allowed_is_said_so_that_it_can_be_checked_by_eye(
    tolerance: float, compare: Compare, kind: Kind, paper: str, limit: str
) -> None:
    shown = row(2.0, 2.0, tolerance, compare, kind)
    assert (paper_text(shown), limit_text(shown)) == (paper, limit)


def test_every_subject_has_a_title_and_every_figure_its_rows() -> None:
    subjects = {subject_of(check.name) for check in all_checks()}
    assert set(contents()["subjects"]) == subjects
    assert set(FIGURES) <= subjects


def test_every_row_is_called_by_words_and_no_two_of_a_figure_alike() -> None:
    checks = {check.name: row_name(row_of_check(check, [SeedResult(1.0)], {})) for check in all_checks()}
    keys = {name.partition(".")[2].partition("[")[0] for name in checks}
    assert keys == {key.rpartition(".")[2] for key in row_words()["words"]}
    assert [name for name, called in checks.items() if re.search(r"_(?!min|max)|\[", called.whole)] == []
    seen = [(subject_of(name), called.whole) for name, called in checks.items()]
    assert len(set(seen)) == len(seen)


def test_a_figure_whose_loops_cannot_be_used_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_loop(_: RunCache) -> None:
        raise RecordingError("no <complete> cycle")

    monkeypatch.setitem(FIGURES, "fig4", no_loop)
    assert "no &lt;complete&gt; cycle" in drawn("fig4", RunCache())
    assert drawn("eq1", RunCache()) == ""
