"""Times as text: Python's own datetime is the oracle."""

from __future__ import annotations

import warnings
from datetime import datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import RecordingError
from musclewire.files import is_clock_text
from musclewire.files._clock_texts import ClockTexts

START = datetime(2026, 2, 28, 23, 59, 58, 250000)
STEPS = st.lists(st.integers(1, 3_600_000), min_size=1, max_size=20)


def seconds(cells: list[str]) -> list[float]:
    return ClockTexts("a.csv: {place}").seconds(cells, lambda row: f"line {row + 2}").tolist()


@given(
    STEPS,
    st.sampled_from(["%Y-%m-%dT%H:%M:%S.%f", "%Y/%m/%d %H:%M:%S.%f", "%d.%m.%Y %H:%M:%S,%f", "%d-%b-%Y %H:%M:%S.%f"]),
)
def test_dates_in_every_spelling_are_seconds_since_the_first(steps_ms: list[int], pattern: str) -> None:
    moments = [START]
    for step_ms in steps_ms:
        moments.append(moments[-1] + timedelta(milliseconds=step_ms))
    found = seconds([moment.strftime(pattern) for moment in moments])
    assert found == pytest.approx([(moment - START).total_seconds() for moment in moments], abs=1e-9)


@given(STEPS)
def test_times_of_day_go_on_over_midnight(steps_ms: list[int]) -> None:
    moments = [START]
    for step_ms in steps_ms:
        moments.append(moments[-1] + timedelta(milliseconds=step_ms))
    found = seconds([moment.strftime("%H:%M:%S.%f") for moment in moments])
    assert found == pytest.approx([(moment - START).total_seconds() for moment in moments], abs=1e-9)


@pytest.mark.parametrize(
    ("cells", "expected"),
    [
        (["11:59:59 PM", "12:00:00 AM", "12:00:01 am"], [0.0, 1.0, 2.0]),
        (["00:59.5", "01:00.5"], [0.0, 1.0]),
        (["31/12/2025 23:59:59", "01/01/2026 00:00:01"], [0.0, 2.0]),
        (["1/31/26 23:59:59", "2/1/26 00:00:01"], [0.0, 2.0]),
        (["01/02/2026 23:59:59", "02/02/2026 00:00:01"], [0.0, 2.0]),
        (["2026-03-29T01:59:59+01:00", "2026-03-29T03:00:01+02:00"], [0.0, 2.0]),
        (["2026-03-01T00:00:00", "2026-03-01T00:00:01Z"], [0.0, 1.0]),
        (["2026-03-01 00:00:00:500", "2026-03-01 00:00:01:000"], [0.0, 0.5]),
        (["125:00:00", "125:00:01"], [0.0, 1.0]),
    ],
)
def test_other_spellings(cells: list[str], expected: list[float]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert seconds(cells) == pytest.approx(expected)


@pytest.mark.parametrize("cell", ["12", "1.5", "", "noon", "2026", "1:2", "12:00 o'clock", "V_SMA"])
def test_what_is_no_time(cell: str) -> None:
    assert not is_clock_text(cell)


@pytest.mark.parametrize("cell", ["2026-02-30 00:00:00", "25:61:00", "later", ""])
def test_an_impossible_time_is_named_with_its_line(cell: str) -> None:
    with pytest.raises(RecordingError, match="line 3: "):
        seconds(["2026-03-01 00:00:00", cell])
