"""Ratios of turns, by a clock of the test's own; and what ``python -m benchmarks.speed`` prints."""

from __future__ import annotations

import json

import pytest
from benchmarks.speed.__main__ import main
from benchmarks.speed.cases import cases
from benchmarks.speed.measuring import TimedProgram, comparison, paired_us
from hypothesis import given
from hypothesis import strategies as st


class Clock:
    """A clock that stands still unless work is done."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.done: list[str] = []

    def __call__(self) -> float:
        return self.now_s

    def work(self, name: str, seconds: float, units: float = 1.0) -> TimedProgram:
        def run(_: object) -> None:
            self.done.append(name)
            self.now_s += seconds

        return TimedProgram(run, units)


def test_both_run_in_turns_and_change_who_is_first() -> None:
    clock = Clock()
    paired_us(clock.work("ours", 1.0), clock.work("theirs", 1.0), 3, clock)
    assert "".join(name[0] for name in clock.done) == "ot" + "ot" + "to" + "ot"


@given(st.floats(1e-6, 1e3), st.floats(1e-6, 1e3), st.integers(1, 1000), st.integers(1, 9))
def test_the_ratio_is_that_of_the_times_of_a_unit(ours_s: float, theirs_s: float, units: int, turns: int) -> None:
    clock = Clock()
    pairs = paired_us(clock.work("ours", ours_s, units), clock.work("theirs", theirs_s), turns, clock)
    row = comparison("step", "a step", "another", pairs)
    assert row.turns == turns
    assert row.ours_us == pytest.approx(1e6 * ours_s / units, rel=1e-3)
    assert row.ratio == pytest.approx(theirs_s * units / ours_s, rel=1e-3)
    assert row.ratio_low <= row.ratio <= row.ratio_high


def test_what_is_prepared_is_not_timed() -> None:
    clock = Clock()

    def prepare() -> str:
        clock.now_s += 100.0
        return "prepared"

    def run(what: str) -> None:
        assert what == "prepared"
        clock.now_s += 1.0

    assert TimedProgram(run, 1.0, prepare).time_us(clock) == pytest.approx(1e6)


def test_what_is_repeated_in_a_turn_counts_once() -> None:
    clock = Clock()
    once, often = clock.work("once", 2.0, 4.0), clock.work("often", 2.0, 4.0)
    assert TimedProgram(often.run, 4.0, repeats=10).time_us(clock) == pytest.approx(once.time_us(clock))
    assert clock.done.count("often") == 10


def test_json_is_one_document_with_the_keys_that_programs_read(capsys: pytest.CaptureFixture[str]) -> None:
    main(["--quick", "--json", "--only", "step[10ms,numba]"])
    found = json.loads(capsys.readouterr().out)
    assert set(found) == {"rows", "left_out", "machine", "quick", "wall_s"}
    (row,) = found["rows"]
    assert {"name", "ours_us", "theirs_us", "theirs", "ratio", "work", "turns"} <= set(row)
    assert min(row["ours_us"], row["theirs_us"], row["ratio"], found["machine"]["vector_flops_per_s"]) > 0.0


def test_every_kind_of_row_is_there_and_no_name_twice() -> None:
    names = [case.name for case in cases()]
    assert len(set(names)) == len(names)
    assert {"step", "slow_loop", "closed_loop_period", "exchange", "batch", "closed_loops", "judging",
            "vector_environment", "fuzzy_pid_tick",
            "first_step"} == {name.partition("[")[0] for name in names}  # fmt: skip
