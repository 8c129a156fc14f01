"""A clock is found in what columns hold, and goes on where a counter wrapped, a day ended or an hour was set back."""

from __future__ import annotations

from datetime import datetime, timedelta

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.files import Cells, SourceColumn, name_and_unit
from musclewire.files._clocks import Clock, ClockReader, FirstRows, NoClock, find_clock, impossible

TIMES_S = 0.2 * np.arange(300)
VOLTS = 1.5 - np.cos(2.0 * np.pi * TIMES_S / 60.0)
BEGAN = datetime(2026, 3, 1, 23, 59, 31, 200_000)


def found(columns: dict[str, Cells], period_s: float | None = None) -> Clock | NoClock | None:
    sources = [SourceColumn(name, is_text=isinstance(cells, list)) for name, cells in columns.items()]
    return find_clock(
        FirstRows("a.csv", sources, list(columns.values()), [name_and_unit(one) for one in sources], period_s)
    )


def read(columns: dict[str, Cells], period_s: float | None = None) -> tuple[np.ndarray, list[str]]:
    clock = found(columns, period_s)
    assert isinstance(clock, Clock)
    reader = ClockReader(clock, "a.csv")
    cells = [list(columns.values())[index] for index in clock.all_indices]
    # In two blocks, of which the second goes on where the first ended.
    parts = [reader.seconds([each[rows] for each in cells], str) for rows in (slice(0, 170), slice(170, None))]
    times = np.concatenate(parts)
    return times - times[0], reader.notes


def stamps(form: str) -> list[str]:
    moments = [BEGAN + timedelta(seconds=float(time)) for time in TIMES_S]
    return [moment.strftime(form.replace("%f", f"{moment.microsecond // 1000:03d}")) for moment in moments]


@given(bits=st.sampled_from([16, 32]), per_s=st.sampled_from([1e3, 1e6]), start=st.integers(0, 2**32))
def test_a_counter_of_16_or_32_bits_goes_on_where_it_wraps(bits: int, per_s: float, start: int) -> None:
    counts = (start % 2**bits + np.round(per_s * TIMES_S)) % 2**bits
    step = 0.2 * per_s
    if step > 2 ** (bits - 2):
        return
    times, notes = read({"millis" if per_s == 1e3 else "micros": counts, "U [V]": VOLTS})
    assert times == pytest.approx(TIMES_S, abs=1e-6)
    assert len(notes) == int((np.diff(counts) < 0.0).sum())


@pytest.mark.parametrize(
    "columns",
    [
        {"whatever": stamps("%Y-%m-%d %H:%M:%S.%f")},
        {"": stamps("%Y-%m-%dT%H:%M:%S.%f+01:00")},
        {"Zeit": stamps("%H:%M:%S.%f")},
        {"Time": stamps("%I:%M:%S.%f %p")},
        {
            "Date": stamps("%m/%d/%Y"),
            "Time": stamps("%H:%M:%S"),
            "Fraction": np.array([int(each) for each in stamps("%f")]) / 1e3,
        },
        {"Date&Time": stamps("%Y-%m-%d %H:%M:%S"), "ms": np.array([float(s) for s in stamps("%f")])},
        {"secs": np.floor(1_772_367_660.2 + TIMES_S), "nsecs": np.round(1e9 * ((0.2 + TIMES_S) % 1.0)) % 1e9},
        {"unix": 1_772_367_660.2 + TIMES_S},
        {"ts": np.round(1e3 * (1_772_367_660.2 + TIMES_S))},
        {"x-axis [second]": TIMES_S - 30.0},
    ],
    ids=lambda columns: " ".join(columns) or "no name",
)  # fmt: skip
def test_a_clock_is_found_in_whatever_columns_it_is(columns: dict[str, Cells]) -> None:
    times, _ = read({"Range": np.full(300, 20.0), **columns, "U [V]": VOLTS, "rising [mm]": TIMES_S})
    assert times == pytest.approx(TIMES_S, abs=1e-4)


def test_a_counter_keeps_its_gaps_if_its_interval_is_stated_and_is_no_clock_without() -> None:
    counts = np.setdiff1d(np.arange(219.0, 519.0), [240.0, 241.0, 300.0])
    times, _ = read({"sample": counts, "U [V]": VOLTS[:297]}, 0.2)
    assert times == pytest.approx(0.2 * (counts - 219.0))
    assert found({"sample": counts, "U [V]": VOLTS[:297]}) is None


@pytest.mark.parametrize(("times", "offered"), [(TIMES_S, "s"), (1e9 * TIMES_S, "ns"), (TIMES_S / 60.0, "min")])
def test_a_time_without_a_unit_is_asked_about_and_the_unit_in_which_a_loop_lasts_so_long_is_offered(
    times: np.ndarray, offered: str
) -> None:
    doubt = found({"timestamp": times, "U [V]": VOLTS})
    assert isinstance(doubt, NoClock)
    assert ("has no unit" in doubt.message, doubt.offered) == (True, offered)


def test_a_fall_that_is_no_wrap_is_left_to_who_looks_for_tests() -> None:
    counts = np.concatenate([2000.0 * np.arange(15), 1800.0 + 2000.0 * np.arange(30)])
    times, notes = read({"t_ms": counts, "U [V]": VOLTS[:45]})
    assert notes == []
    assert (np.diff(times) < 0.0).sum() == 1


@pytest.mark.parametrize(("lasted_s", "is_named"), [(9e-8, True), (60.0, False)])
def test_no_wire_goes_through_a_loop_in_less_than_a_microsecond(lasted_s: float, is_named: bool) -> None:
    assert bool(impossible(Clock("timestamp (ns)", (0,), "ns", 1e-9), 900, lasted_s, "a.csv")) is is_named
