"""Times that are written as text: dates with times, times of day over midnight, hours since the beginning."""

from __future__ import annotations

import datetime
import re
import warnings
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError

_MICROSECONDS = 1_000_000
_DAY_US = 86_400 * _MICROSECONDS
_TIME = (
    r"(?P<hour>\d{1,3}):(?P<minute>\d{2})(?::(?P<second>\d{2}))?(?:[.,:](?P<fraction>\d{1,9}))?"
    r"\s*(?P<half>[aApP]\.?[mM]\.?)?"
)
_ZONE = r"\s*(?P<zone>Z|UTC|GMT|[+-]\d{2}:?\d{2})?"
_YEAR_FIRST = r"(?P<year>\d{4})[-/.](?P<month>\d{1,2})[-/.](?P<day>\d{1,2})"
_YEAR_LAST = r"(?P<first>\d{1,2})(?P<sign>[-/.])(?P<second_part>\d{1,2})[-/.](?P<year>\d{4}|\d{2})"
_MONTH_WORD = r"(?P<day>\d{1,2})[- ](?P<word>[A-Za-z]{3})[a-z]*[- ,]+(?P<year>\d{4}|\d{2})"
_PATTERNS = tuple(
    re.compile(text)
    for text in (
        _TIME,
        # What pandas writes of a time difference.
        rf"(?P<days>\d+) days?,?(?: {_TIME})?",
        *(rf"{date}(?:[T ,;]+{_TIME}{_ZONE})?" for date in (_YEAR_FIRST, _YEAR_LAST, _MONTH_WORD)),
    )
)
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_PLAIN_ISO = re.compile(r"\d{4}-\d{2}-\d{2}[T ]\d{2}:\d{2}:\d{2}(?:\.\d{1,6})?")


# How a time of two numbers may be written: minutes and seconds, or hours and minutes.
WRITTEN_CLOCKS = ("mm:ss", "hh:mm")
_FORMS = {
    **dict.fromkeys(("mm:ss", "m:ss", "min:s", "min:sec"), WRITTEN_CLOCKS[0]),
    **dict.fromkeys(("hh:mm", "h:mm", "h:min"), WRITTEN_CLOCKS[1]),
}
_TWO_NUMBERS = re.compile(r"(\d{1,3}):\d{2}")


def written_clock(unit: str | None, cells: Sequence[str] = ()) -> str | None:
    """Return how times are written, "" if they state their seconds; None if two numbers may be of either form."""
    if unit is not None and unit.lower() in _FORMS:
        return _FORMS[unit.lower()]
    found = [_TWO_NUMBERS.fullmatch(cell.strip()) for cell in cells]
    if not found or None in found:
        return ""
    return WRITTEN_CLOCKS[0] if any(match is not None and int(match[1]) > 23 for match in found) else None


class _PointInTime(NamedTuple):
    """A time in microseconds, since the year 1 or since midnight."""

    microseconds: int
    has_date: bool


def is_clock_text(cell: str) -> bool:
    """Return whether a cell is a time, a date, or both."""
    return _match(cell) is not None


def is_date(cell: str) -> bool:
    """Return whether a cell is a date without a time."""
    match = _match(cell)
    return match is not None and "hour" in match.groupdict() and match["hour"] is None


def is_time_of_day(cell: str) -> bool:
    """Return whether a cell is a time without a date."""
    match = _match(cell)
    return match is not None and "year" not in match.groupdict()


def _match(cell: str) -> re.Match[str] | None:
    text = cell.strip()
    return next((match for pattern in _PATTERNS if (match := pattern.fullmatch(text))), None)


class ClockTexts:
    """Turns times as text into seconds since the first of them, block after block, over any number of midnights."""

    def __init__(self, where: str, form: str = "") -> None:
        """Remember how messages begin, and how a time of two numbers is written: one of WRITTEN_CLOCKS, or ""."""
        self._where = where
        self._in_minutes = form == WRITTEN_CLOCKS[0]
        self._origin_us: int | None = None
        self._last_us = 0
        self._midnights_us = 0
        self._day_first: bool | None = None
        self._is_ambiguous = False
        self.start_time: str | None = None

    def seconds(self, cells: Sequence[str], place: Callable[[int], str]) -> FloatArray:
        """Return the times of rows [s] since the first row of all. Raises RecordingError for a cell that is none."""
        plain = self._plain_iso(cells)
        if plain is not None:
            return plain
        if self._day_first is None:
            self._day_first, self._is_ambiguous = _day_first(cells)
        times_us = [self._microseconds(cell, place, row) for row, cell in enumerate(cells)]
        return self._since_the_first(np.array(times_us, dtype=np.int64))

    def _plain_iso(self, cells: Sequence[str]) -> FloatArray | None:
        """Return the times if all are plain ISO 8601, which NumPy reads a hundred times faster."""
        if not cells or self._midnights_us or not _PLAIN_ISO.fullmatch(cells[0].strip()):
            return None
        try:
            with warnings.catch_warnings():
                # NumPy warns of a time zone, and leaves it out.
                warnings.simplefilter("error")
                dates = np.array(cells, dtype="datetime64[us]")
        except (ValueError, UserWarning, DeprecationWarning):
            return None
        if np.isnat(dates).any():
            return None
        moments = dates.astype(np.int64)
        epoch_us = datetime.date(1970, 1, 1).toordinal() * _DAY_US
        return self._since_the_first(moments + epoch_us)

    def _since_the_first(self, times_us: np.ndarray[tuple[int], np.dtype[np.int64]]) -> FloatArray:
        if self._origin_us is None and times_us.size:
            self._origin_us = int(times_us[0])
            # Of a date whose day and month could be changed for each other nothing is said.
            if self._origin_us > 400 * _DAY_US and not self._is_ambiguous:
                whole = datetime.datetime.fromordinal(self._origin_us // _DAY_US)
                self.start_time = (whole + datetime.timedelta(microseconds=self._origin_us % _DAY_US)).isoformat()
        seconds: FloatArray = (times_us - (self._origin_us or 0)) / _MICROSECONDS
        return seconds

    def _microseconds(self, cell: str, place: Callable[[int], str], row: int) -> int:
        moment = _moment(f"0:{cell.strip()}" if self._in_minutes else cell, bool(self._day_first))
        if moment is None:
            what = f"'{cell.strip()[:40]}' is not a time" if cell.strip() else "the cell is blank"
            raise RecordingError(f"{self._where.format(place=place(row))}: {what}; correct it or remove the row")
        if moment.has_date:
            return moment.microseconds
        time_us = moment.microseconds + self._midnights_us
        if time_us < self._last_us - _DAY_US // 2:
            self._midnights_us += _DAY_US
            time_us += _DAY_US
        self._last_us = time_us
        return time_us


def _moment(cell: str, day_first: bool) -> _PointInTime | None:
    match = _match(cell)
    if match is None:
        return None
    parts = match.groupdict()
    try:
        time_us = _time_us(parts) if parts.get("hour") else 0
        if "year" not in parts:
            return _PointInTime(time_us + int(parts.get("days") or 0) * _DAY_US, False)
        day = _date(parts, day_first).toordinal()
    except ValueError:
        return None
    return _PointInTime(day * _DAY_US + time_us - _zone_us(parts.get("zone")), True)


def _time_us(parts: dict[str, str | None]) -> int:
    fraction_us = int((parts["fraction"] or "0").ljust(6, "0")[:6])
    hour, minute = int(parts["hour"] or 0), int(parts["minute"] or 0)
    if parts["second"] is None and parts["fraction"] is not None:
        # 01:02.5 is one minute and 2.5 seconds.
        return (60 * hour + minute) * _MICROSECONDS + fraction_us
    second = int(parts["second"] or 0)
    if minute > 59 or second > 60:
        raise ValueError
    half = (parts["half"] or "")[:1].lower()
    if half:
        hour = hour % 12 + (12 if half == "p" else 0)
    return (3600 * hour + 60 * minute + second) * _MICROSECONDS + fraction_us


def _date(parts: dict[str, str | None], day_first: bool) -> datetime.date:
    year = int(parts["year"] or 0)
    year += 2000 if year < 100 else 0
    if parts.get("word"):
        return datetime.date(year, _MONTHS.index(str(parts["word"]).lower()) + 1, int(parts["day"] or 0))
    if parts.get("month"):
        return datetime.date(year, int(parts["month"] or 0), int(parts["day"] or 0))
    first, second = int(parts["first"] or 0), int(parts["second_part"] or 0)
    day, month = (first, second) if day_first or parts["sign"] == "." else (second, first)
    return datetime.date(year, month, day)


def _zone_us(zone: str | None) -> int:
    if not zone or zone[0] not in "+-":
        return 0
    digits = zone[1:].replace(":", "")
    minutes = 60 * int(digits[:2]) + int(digits[2:])
    return (-1 if zone[0] == "-" else 1) * minutes * 60 * _MICROSECONDS


def _day_first(cells: Sequence[str]) -> tuple[bool, bool]:
    """Return whether the day comes before the month, by which all dates are possible and rise least, or either may."""
    totals: dict[bool, int] = {}
    for day_first in (True, False):
        times = [_moment(cell, day_first) for cell in cells]
        if None not in times:
            steps = np.diff([moment.microseconds for moment in times if moment is not None])
            totals[day_first] = int(np.abs(steps).sum()) if steps.size else 0
    if len(set(totals.values())) < len(totals):
        match = _match(cells[0])
        parts = {} if match is None else match.groupdict()  # where days have two halves, the month comes first
        return not parts.get("half"), not parts.get("half") and parts.get("sign") in ("/", "-")
    return (min(totals, key=lambda day_first: totals[day_first]) if totals else True), False
