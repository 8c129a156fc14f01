"""Loggers with different clocks: known delays are found within their stated uncertainty, or refused."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest

from musclewire.errors import CallerError, RecordingError
from musclewire.identify import join_recordings
from musclewire.signals import Recording

Shape = Callable[[np.ndarray], np.ndarray]


def step(time_s: np.ndarray) -> np.ndarray:
    return (time_s > 12.3).astype(float)


def steps(time_s: np.ndarray) -> np.ndarray:
    return np.searchsorted([3.1, 7.7, 9.2, 15.5, 21.0, 24.4], time_s) % 3 * 1.0


def chirp(time_s: np.ndarray) -> np.ndarray:
    return np.sin(2.0 * np.pi * (0.05 * time_s + 0.01 * time_s**2))


def sine(time_s: np.ndarray) -> np.ndarray:
    return np.sin(2.0 * np.pi * time_s / 3.0)


def two_loggers(
    shape: Shape,
    delay_s: float,
    periods_s: tuple[float, float] = (0.01, 0.023),
    stretch: float = 1.0,
    noise: float = 0.0,
) -> tuple[Recording, Recording]:
    """The same command by two loggers; the second one begins later, ends earlier and records a force, which is time."""
    first_s, second_s = np.arange(0.0, 30.0, periods_s[0]), np.arange(1.234, 28.0, periods_s[1])
    random = np.random.default_rng(len(first_s))
    first = Recording({"time_s": first_s, "drive_voltage_v": shape(first_s)})
    second = Recording(
        {
            "time_s": stretch * second_s + delay_s,
            "drive_voltage_v": shape(second_s) + noise * random.standard_normal(second_s.size),
            "force_n": second_s,
        }
    )
    return first, second


@pytest.mark.parametrize("delay_s", [-31.7, 0.0, 4.2371, 1000.0])
@pytest.mark.parametrize("noise", [0.0, 0.1])
@pytest.mark.parametrize("shape", [step, steps, chirp])
def test_a_known_delay_is_found_within_three_standard_deviations(shape: Shape, noise: float, delay_s: float) -> None:
    joined = join_recordings(*two_loggers(shape, delay_s, noise=noise))
    assert joined.delay_std_s is not None
    assert abs(joined.delay_s - delay_s) < 3.0 * joined.delay_std_s
    assert joined.delay_std_s < 0.05
    # The force was the second logger's own time, so that it must be the first one's time now.
    late_s = joined.recording["force_n"] - joined.recording["time_s"]
    assert np.abs(late_s).max() < 3.0 * joined.delay_std_s
    assert joined.recording.metadata["join_delay_s"] == joined.delay_s


def test_rows_are_those_of_the_first_recording_within_the_second() -> None:
    first, second = two_loggers(steps, 5.0)
    joined = join_recordings(first, second)
    assert set(joined.recording["time_s"]) <= set(first["time_s"])
    assert joined.recording["time_s"][0] == pytest.approx(1.234, abs=0.05)
    assert any("2675 of 3000 rows kept" in note or "of 3000 rows kept" in note for note in joined.notes)


def test_two_columns_that_follow_each_other_will_do_even_with_opposite_signs() -> None:
    first, second = two_loggers(steps, 5.0)
    second = Recording({"time_s": second["time_s"], "displacement_m": -1e-3 * second["drive_voltage_v"]})
    joined = join_recordings(first, second, ("drive_voltage_v", "displacement_m"))
    assert joined.delay_s == pytest.approx(5.0, abs=3.0 * joined.delay_std_s)


@pytest.mark.parametrize(
    ("first", "second", "words"),
    [
        (*two_loggers(sine, 5.0), "record a single step or pulse"),
        (*two_loggers(np.zeros_like, 5.0), "does not change"),
        (two_loggers(steps, 5.0)[0], two_loggers(np.random.default_rng(1).permutation, 5.0)[1], "cannot be joined"),
    ],
    ids=["periodic", "constant", "unrelated"],
)
def test_what_does_not_determine_a_delay_is_refused(first: Recording, second: Recording, words: str) -> None:
    with pytest.raises(RecordingError, match=words):
        join_recordings(first, second)


@pytest.mark.parametrize("stretch", [0.985, 1.02])
def test_clocks_that_drift_apart_are_refused_with_the_size_of_the_drift(stretch: float) -> None:
    with pytest.raises(RecordingError, match=r"the clocks drift apart by \S+ s a minute") as caught:
        join_recordings(*two_loggers(chirp, 3.0, stretch=stretch))
    ppm, std_ppm = map(float, re.findall(r"\((-?\d+) \+- (\d+) ppm\)", str(caught.value))[0])
    assert ppm == pytest.approx(1e6 * (stretch - 1.0), abs=0.2e6 * abs(stretch - 1.0))
    assert 0.0 < std_ppm < 1e3


def test_a_drift_within_a_sample_period_is_in_the_deviation() -> None:
    joined = join_recordings(*two_loggers(chirp, 3.0, periods_s=(0.1, 0.23), stretch=1.001))
    late_s = joined.recording["force_n"] - joined.recording["time_s"]
    assert joined.delay_std_s is not None
    assert np.abs(late_s).max() < 3.0 * joined.delay_std_s
    assert joined.delay_std_s < 0.03
    assert (joined.rate, joined.recording.metadata["join_delay_std_s"]) == (1.0, joined.delay_std_s)


def test_errors_of_drawn_delays_are_as_large_as_their_deviations() -> None:
    """Steps and chirps by recorders of 3 to 100 Hz, with noise: the errors over the deviations scatter by about 1."""
    found: list[float] = []
    for seed in range(40):
        random = np.random.default_rng(seed)
        edges, levels = np.sort(random.uniform(2.0, 26.0, 9)), random.uniform(0.0, 2.0, 10)
        delay_s = float(random.uniform(-30.0, 30.0))

        def drawn_steps(time_s: np.ndarray, edges_s: np.ndarray = edges, levels: np.ndarray = levels) -> np.ndarray:
            return levels[np.searchsorted(edges_s, time_s)]

        periods_s = (0.01 * 33.0 ** random.random(), 0.01 * 33.0 ** random.random())
        noise = 0.1 * float(random.random())
        joined = join_recordings(*two_loggers(chirp if seed % 2 else drawn_steps, delay_s, periods_s, noise=noise))
        found.append((joined.delay_s - delay_s) / (joined.delay_std_s or np.nan))
    assert 0.4 < np.sqrt(np.mean(np.square(found))) < 1.3
    assert np.abs(found).max() < 4.0


def test_a_delay_that_is_given_and_a_clock_that_is_shared_need_no_correlation() -> None:
    first, second = two_loggers(sine, 5.0)
    for joined in (join_recordings(first, second, delay_s=5.0), join_recordings(*two_loggers(sine, 0.0), "time_s")):
        assert (joined.columns, joined.correlation, joined.delay_std_s) == ((), None, None)
        assert joined.recording["force_n"] == pytest.approx(joined.recording["time_s"], abs=1e-9)


def test_clocks_that_count_from_one_moment_need_no_column_in_common() -> None:
    time_s = np.arange(0.0, 10.0, 0.1)
    for facts in ({"clock_start_s": 1.7e9}, {"start_time": "2026-02-17T12:21:00"}):
        later = {"clock_start_s": 1.7e9 + 2.0} if "clock_start_s" in facts else {"start_time": "2026-02-17T12:21:02"}
        first = Recording({"time_s": time_s, "wire_current_a": time_s}, facts)
        second = Recording({"time_s": time_s, "force_n": time_s + 2.0}, later)
        joined = join_recordings(first, second)
        assert joined.delay_s == pytest.approx(-2.0)
        assert joined.recording["force_n"] == pytest.approx(joined.recording["wire_current_a"])


def test_what_is_shared_is_asked_for_if_it_is_not_the_only_column() -> None:
    first, second = two_loggers(steps, 0.0)
    with pytest.raises(CallerError, match="both have drive_voltage_v, force_n: name the columns"):
        join_recordings(first.with_columns(force_n=first["drive_voltage_v"]), second)
    with pytest.raises(CallerError, match="no column in common"):
        join_recordings(first, Recording({"time_s": second["time_s"], "force_n": second["force_n"]}))
    with pytest.raises(CallerError, match="the second recording has no wire_voltage_v"):
        join_recordings(first, second, ("drive_voltage_v", "wire_voltage_v"))
    with pytest.raises(CallerError, match="adds no column"):
        join_recordings(first, Recording({"time_s": second["time_s"], "drive_voltage_v": second["drive_voltage_v"]}))


def test_a_minor_loop_of_the_second_file_is_no_part_of_the_cycles() -> None:
    """It is one of both, on the first one's clock."""
    first, second = two_loggers(steps, 0.0)
    until_s = 0.6 * float(second["time_s"][-1])
    cut = Recording(second.columns, {"minor_loop_from_s": until_s})
    assert cut.minor_loop is not None
    joined = join_recordings(first, cut).recording
    assert joined.minor_loop is not None
    assert joined["time_s"][-1] == pytest.approx(until_s, abs=0.05)
    assert joined.minor_loop["time_s"][-1] == pytest.approx(second["time_s"][-1], abs=0.05)
