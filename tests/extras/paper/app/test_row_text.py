"""The numbers of a row as people read them, on the page and in the terminal."""

from __future__ import annotations

import re

import pytest

from musclewire.errors import RecordingError
from musclewire.extras.paper._page.paper_figures import FIGURES, drawn
from musclewire.extras.paper._page.paper_page import contents
from musclewire.extras.paper._page.row_names import row_name, row_words
from musclewire.extras.paper._page.row_text import (
    limit_text,
    ours_text,
    paper_text,
    reason_text,
    seeds_text,
    spread_text,
    verdict_text,
)
from musclewire.extras.paper._reproduce import PaperCheck, ReproductionRow, RunCache, SeedResult, all_checks, judged
from musclewire.extras.paper._reproduce.paper_checks import Compare, Kind, subject_of


def row(
    ours: float, paper: float, tolerance: float, compare: Compare = "within", kind: Kind = "printed"
) -> ReproductionRow:
    check = PaperCheck("fig0.x", paper, "ohm", tolerance, "because", kind, lambda _: ours, compare, origin="predicted")
    return judged(check, [SeedResult(ours)], {})


@pytest.mark.parametrize(
    ("ours", "paper", "tolerance", "text"),
    [
        (15.148649, 15.1526, 0.02, "15.1486"),  # the paper's digits
        (8.50308, 8.196, 0.5, "8.503"),
        (0.2392, 1.0, 1.0, "0.24"),
        (121.56, 126.0, 6.3, "121.6"),
        (5.9e-15, 0.0, 1e-6, "6e-15"),  # small, and not zero
        (0.0, 0.0, 1e-6, "0.000000"),
        (588.6, 588.6, 0.0, "588.6"),
    ],
)
def test_our_number_has_the_digits_that_tolerance_and_paper_ask_for(
    ours: float, paper: float, tolerance: float, text: str
) -> None:
    assert ours_text(row(ours, paper, tolerance)) == text


@pytest.mark.parametrize(
    ("tolerance", "compare", "kind", "paper", "limit"),
    [
        (0.5, "within", "printed", "2", "± 0.5"),
        (0.5, "within", "words", "–", "2 ± 0.5"),
        (0.0, "within", "input", "2", "the same"),
        (0.0, "within", "words", "–", "= 2"),
        (0.5, "at most", "printed", "2", "≤ 2.5"),
        (0.5, "at least", "equation", "–", "≥ 1.5"),
        (0.0, "reported", "printed", "2", "–"),
    ],
)
def test_what_is_allowed_is_said_so_that_it_can_be_checked_by_eye(
    tolerance: float, compare: Compare, kind: Kind, paper: str, limit: str
) -> None:
    shown = row(2.0, 2.0, tolerance, compare, kind)
    assert (paper_text(shown), limit_text(shown)) == (paper, limit)


def test_a_row_that_is_reported_says_that_it_is_not_judged() -> None:
    shown = row(31.4159, 2.0, 0.0, "reported")
    assert (ours_text(shown), verdict_text(shown)) == ("31.4", "reported, not judged")
    assert verdict_text(row(2.0, 2.0, 0.0)) == "holds"


def over_seeds(*ours: float | None) -> ReproductionRow:
    check = PaperCheck("fig0.x", 2.0, "ohm", 0.5, "because", "printed", lambda _: 0.0, origin="fitted")
    found = [SeedResult(None, "no loop") if number is None else SeedResult(number) for number in ours]
    return judged(check, found, {})


def test_the_spread_has_the_digits_of_the_median_and_is_silent_where_it_shows_nothing() -> None:
    assert spread_text(over_seeds(*(1.6 + 0.04 * seed for seed in range(21)))) == "1.64 to 2.36"
    assert spread_text(over_seeds(2.0001, 2.0002)) == ""
    assert spread_text(over_seeds(None)) == ""


def test_a_row_at_the_bar_says_so_and_between_what_its_median_lies() -> None:
    row = over_seeds(*(2.4 + 0.01 * seed for seed in range(21)))
    assert verdict_text(row) == "at the bar, new"
    assert reason_text(row) == "the median is 2.45 to 2.55 with 95 % probability: a limit is inside"


def test_seeds_that_have_no_number_are_counted_in_words() -> None:
    assert reason_text(over_seeds(*[2.0] * 20, None)) == "1 of 21 seeds have no number: no loop"


def test_a_single_seed_is_named_as_such() -> None:
    assert seeds_text([7]) == "seed 7 alone: its own numbers, no medians"
    assert seeds_text(range(1, 102)) == "medians over 101 seeds, 1 to 101"
    assert seeds_text([3, 9]) == "medians over 2 seeds, 3, 9"


def test_every_subject_has_a_title_and_every_figure_its_rows() -> None:
    subjects = {subject_of(check.name) for check in all_checks()}
    assert set(contents()["subjects"]) == subjects
    assert set(FIGURES) <= subjects


def test_every_subject_is_in_one_part_of_the_page() -> None:
    assert sorted(subject for part in contents()["parts"].values() for subject in part) == sorted(
        contents()["subjects"]
    )


def test_every_row_is_called_by_words_and_no_two_of_a_figure_alike() -> None:
    checks = {check.name: row_name(judged(check, [SeedResult(1.0)], {})) for check in all_checks()}
    keys = {name.partition(".")[2].partition("[")[0] for name in checks}
    assert keys == {key.rpartition(".")[2] for key in row_words()["words"]}
    assert [name for name, called in checks.items() if re.search(r"_(?!min|max)|\[", called.whole)] == []
    seen = [(subject_of(name), called.whole) for name, called in checks.items()]
    assert len(set(seen)) == len(seen)


@pytest.mark.parametrize(
    ("name", "condition"),
    [
        ("fig4.strain_gap_pct[125um,1.70N]", "125 µm wire, 1.70 N"),
        ("fig3a.outside_pct[2.75V,2.90V]", "2.75 V against 2.90 V"),
        ("fig17.grows_again_pct[finger-100um]", "the finger's own spool"),
        ("table2.mae_rise_pct[1.5]", "1.5 %"),
        ("table3.mae_rise_pct[2.5]", "2.5 mm"),
        ("eq1.resistance_rms_error_ohm", ""),
    ],
)
def test_conditions_are_spoken_with_their_units(name: str, condition: str) -> None:
    check = PaperCheck(name, 1.0, "ohm", 0.5, "because", "printed", lambda _: 1.0, origin="fitted")
    called = row_name(judged(check, [SeedResult(1.0)], {}))
    assert (called.condition, called.unit) == (condition, "Ω")


def test_a_figure_whose_loops_cannot_be_used_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_loop(_: RunCache) -> None:
        raise RecordingError("no <complete> cycle")

    monkeypatch.setitem(FIGURES, "fig4", no_loop)
    assert "no &lt;complete&gt; cycle" in drawn("fig4", RunCache())
    assert drawn("eq1", RunCache()) == ""
