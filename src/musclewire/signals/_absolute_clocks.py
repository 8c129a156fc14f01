"""Clocks that count from long ago: Excel's dates in days, Unix time in seconds, milliseconds, microseconds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray

# A clock beyond this does not count from the beginning of a recording: it would have lasted three years.
ABSOLUTE_FROM_S = 1e8


class AbsoluteClock(NamedTuple):
    """The unit of a clock that counts from long ago, and its name."""

    unit: str
    words: str


# Ranges of the numbers from 1982 to 2064, and LabVIEW's seconds since 1904; no other clock reaches them.
_CLOCKS = (
    (3.0e4, 6.0e4, AbsoluteClock("d", "Excel's dates, in days since 1900")),
    (4.0e8, 4.6e9, AbsoluteClock("s", "seconds since 1970 or 1904")),
    (4.0e11, 3.0e12, AbsoluteClock("ms", "milliseconds since 1970")),
    (4.0e14, 3.0e15, AbsoluteClock("us", "microseconds since 1970")),
    (4.0e17, 3.0e18, AbsoluteClock("ns", "nanoseconds since 1970")),
)
_MAX_EXCEL_STEP_D = 1.0 / 24.0


def absolute_clock(values: FloatArray) -> AbsoluteClock | None:
    """Return what the numbers of a column of time without a unit count, or None if they do not show it.

    Days are Excel's only if they rise by fractions, because 45000 may as well be milliseconds.
    """
    if values.size < 2 or not np.isfinite(values).all():
        return None
    for low, high, clock in _CLOCKS:
        if (values >= low).all() and (values <= high).all():
            fits = clock.unit != "d" or bool((np.abs(np.diff(values)) < _MAX_EXCEL_STEP_D).all())
            return clock if fits else None
    return None
