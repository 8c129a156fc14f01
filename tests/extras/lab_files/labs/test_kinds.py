"""The generator of layouts draws all of its values and knows the truth of what it writes; importing holds its bars."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.labs.drawn_layouts import AXES, MEASURED, VALUES, Drawn, drawn, read_as_told
from tests.labs.kinds import judged, missed, table_of, tally_of
from tests.labs.layouts import TIME

import musclewire as mw

PARTS = [range(part, len(VALUES), 8) for part in range(8)]


def differs(one: Drawn) -> str:
    """Return where a reader that is told everything finds other numbers than the truth, or ""."""
    for (columns, rows), truth in zip(read_as_told(one), one.truths, strict=True):
        kept = truth.kept[rows]
        if kept.sum() < truth.kept.sum():
            return f"{kept.sum()} rows of {truth.kept.sum()}"
        for name, true in truth.columns.items():
            error = np.abs(columns[name] - (true - true[0] if name == TIME else true)[rows])[kept]
            if not error.max() <= truth.tolerance[name] + 1e-9 * np.abs(true).max():
                return f"{name} by {error.max():g}"
    return ""


@pytest.mark.parametrize("numbers", PARTS)
def test_a_reader_that_is_told_everything_finds_the_truth_in_each_layout_and_each_value_is_drawn(
    numbers: range,
) -> None:
    for number in numbers:
        one = drawn(3, number)
        assert VALUES[number % len(VALUES)] in one.choice.values()
        assert differs(one) == "", (number, one.choice)


def test_a_seed_draws_the_same_files_again_and_another_seed_others() -> None:
    one, again, other = ([drawn(seed, number) for number in range(20)] for seed in (5, 5, 6))
    assert [file.content for file in one] == [file.content for file in again]
    assert not {file.content for file in one} & {file.content for file in other}


def test_values_have_names_of_their_own_and_are_drawn_when_they_are_named() -> None:
    assert len(VALUES) == sum(len(values) for values in AXES.values())
    assert all(value in drawn(1, 0, value).choice.values() for value in VALUES[::7])


def test_the_judge_sees_a_wrong_unit_a_wrong_clock_lost_rows_and_a_mark_and_takes_what_is_true() -> None:
    files = (drawn(1, number, "-9999") for number in range(500))
    truth = next(one for one in files if one.choice["defect"] == "whole").truths[0]
    true = dict(truth.columns)
    last = [name for name in true if name != TIME][-1]
    marked = np.where(truth.kept, true[last], 1.1 * true[last])
    good = {name: values[truth.kept] for name, values in true.items()}
    assert judged(mw.Recording(good, {}), truth) == ("", ())
    assert judged(mw.Recording({name: good[name] for name in good if name != last}, {}), truth) == ("", (last,))
    extra = next(name for name in MEASURED if name not in true)
    wrong = [
        {**good, last: 1e3 * good[last]},
        {**good, TIME: 1e3 * good[TIME]},
        {name: values[: values.size * 9 // 10] for name, values in good.items()},
        {**true, last: marked},
        {**good, extra: good[last]},
    ]
    assert all(judged(mw.Recording(columns, {}), truth)[0] for columns in wrong)
    dated, began = replace(truth, day="2026-03-01"), ("2026-03-01T23:24:14", "2026-01-03T23:24:14")
    assert [bool(judged(mw.Recording(good, {"start_time": at}), dated)[0]) for at in began] == [False, True]


@pytest.mark.slow
def test_of_60_drawn_layouts_at_most_one_in_200_is_read_wrongly_and_80_percent_are_right(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    found = tally_of(range(60), 1)
    assert missed(found) == [], table_of(found)
