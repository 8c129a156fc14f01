"""Rows over several seeds: each seed its own numbers, whoever measures them, and what no seed changes only once."""

from __future__ import annotations

from typing import Any

import pytest

from musclewire.errors import CallerError, RecordingError
from musclewire.extras.paper import PaperCheck, SeedCallbacks, SeedResult, all_checks, numbers_of_seeds, selected
from musclewire.extras.paper._reproduce import reproduction
from musclewire.extras.paper._reproduce.reproduction import reproduce
from musclewire.extras.paper._reproduce.runs import RunCache

SEEDS = (3, 1, 4, 8)


def check(name: str, measure: Any) -> PaperCheck:
    return PaperCheck(name, 2.0, "ohm", 0.5, "because half is enough", "printed", measure, origin="fitted")


def seed_itself(runs: RunCache) -> float:
    if runs.seed == 4:
        raise RecordingError("no complete cycle")
    return float(runs.seed)


def test_each_seed_gives_its_own_number_or_problem_in_the_order_of_the_seeds() -> None:
    found = numbers_of_seeds([check("eq1.x", seed_itself)], SEEDS, workers=1, watching=SeedCallbacks())
    assert found.for_check("eq1.x") == [
        SeedResult(3.0), SeedResult(1.0), SeedResult(None, "no complete cycle"), SeedResult(8.0)
    ]  # fmt: skip
    assert found.for_check("eq1.x", (8, 3)) == [SeedResult(8.0), SeedResult(3.0)]


def test_what_no_seed_changes_is_measured_once() -> None:
    calls: list[RunCache] = []

    def fixed(runs: RunCache) -> float:
        calls.append(runs)
        return runs.staircase.hold_s

    found = numbers_of_seeds([check("eq1.x", fixed)], SEEDS, workers=1, watching=SeedCallbacks())
    assert found.for_check("eq1.x") == [SeedResult(6.0)] * 4
    assert len(calls) == 1


def test_whoever_watches_is_told_of_each_seed_and_may_stop() -> None:
    told: list[tuple[int, int]] = []

    class StopError(Exception):
        pass

    def stop_after_two() -> None:
        if len(told) == 2:
            raise StopError

    varying = check("eq1.x", lambda runs: float(runs.seed))
    watching = SeedCallbacks(lambda done, total: told.append((done, total)), stop_after_two)
    with pytest.raises(StopError):
        numbers_of_seeds([varying], SEEDS, workers=1, watching=watching)
    assert told == [(1, 4), (2, 4)]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"seeds": [1, 2, 1]}, "seed 1 is there twice"),
        ({"seeds": [-1]}, "must be a whole number of 0 or more"),
        ({"workers": 0}, "0 workers: at least one process"),
    ],
)
def test_seeds_that_cannot_be_are_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(CallerError, match=message):
        reproduce("table1", **given)


@pytest.mark.slow
def test_a_single_seed_has_the_same_numbers_alone_and_among_others() -> None:
    chosen = selected(all_checks(), "table1.resistance")
    many = numbers_of_seeds(chosen, (5, 6), workers=2, watching=SeedCallbacks())
    alone = reproduction.reproduce("table1.resistance", seeds=[6])
    assert alone.single_seed == 6
    assert [row.ours for row in alone.rows] == [many.for_check(row.name, (6,))[0].number for row in alone.rows]
