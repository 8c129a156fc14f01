"""Rates that a file states are compared with each other, and with its own times; a disagreement is named."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.files import stated_periods_s
from musclewire.files._source_table import differing_periods, doubted_clock

TIMES_S = 0.05 * np.arange(200)


@pytest.mark.parametrize(
    ("metadata", "periods_s"),
    [
        ({"abtastrate_hz": 20.0}, {"abtastrate_hz": 0.05}),
        ({"abtastrate_kanal_1_hz": 20.0, "ch2_sample_rate_hz": 10.0}, None),
        ({"frequency_hz": 0.01, "sampling_rate_hz": 20.0}, {"sampling_rate_hz": 0.05}),
        ({"frequency_hz": 0.01}, {"frequency_hz": 100.0}),
        ({"sample_interval_s": 0.05, "sample_rate_hz": 20.0}, {"sample_interval_s": 0.05, "sample_rate_hz": 0.05}),
        ({"fs": 20.0, "channel_1_v": 3.0, "sample_rate_hz": True}, {}),
        ({"abtastrate_hz": 0.0, "dt_s": float("inf")}, {}),
    ],
)
def test_rates_and_periods_are_known_by_their_keys(
    metadata: dict[str, float], periods_s: dict[str, float] | None
) -> None:
    expected = {"abtastrate_kanal_1_hz": 0.05, "ch2_sample_rate_hz": 0.1} if periods_s is None else periods_s
    assert stated_periods_s(metadata, unit_stated=True) == pytest.approx(expected)
    assert bool(differing_periods(expected)) is (periods_s is None)


@pytest.mark.parametrize(
    ("key", "time_s", "is_doubted"),
    [
        ("abtastrate_hz", TIMES_S, False),
        ("abtastrate_hz", 1.013 * TIMES_S, False),
        ("abtastrate_hz", 0.02 * np.round(TIMES_S / 0.02), False),
        ("abtastrate_hz", TIMES_S + 60.0 * (TIMES_S > 5.0), False),
        ("abtastrate_hz", 1e-3 * TIMES_S, True),
        ("sample_period_s", 2.0 * TIMES_S, True),
        ("frequency_hz", 2.0 * TIMES_S, False),
        ("abtastrate_hz", TIMES_S[:1], False),
    ],
)
def test_times_that_are_not_as_stated_are_doubted_but_not_for_drift_rounding_or_a_pause(
    key: str, time_s: np.ndarray, *, is_doubted: bool
) -> None:
    assert bool(doubted_clock({key: 0.05}, time_s)) is is_doubted
