"""The clock of a table, found in what its columns hold, and the time of each row that it shows.

A clock is a date or a time of day, seconds and a fraction of them in another column, a number that counts in a unit of
time or since long ago, or a counter of samples whose interval is stated. Its name says no more than its unit.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError, argument
from musclewire.files._clock_texts import ClockTexts, is_clock_text, is_date, is_time_of_day, written_clock
from musclewire.files._source_table import Cells, SourceColumn
from musclewire.signals import columns_called, conversion_to_si, measures, scale_between, scale_to_si

# A clock beyond this does not count from the beginning of a recording: it would have lasted three years.
ABSOLUTE_FROM_S = 1e8
# Ranges of numbers from 1982 to 2064, and LabVIEW's seconds since 1904; no other clock reaches them.
_EPOCHS = (
    (3.0e4, 6.0e4, "d", "Excel's dates, in days since 1900"),
    (4.0e8, 4.6e9, "s", "seconds since 1970 or 1904"),
    (4.0e11, 3.0e12, "ms", "milliseconds since 1970"),
    (4.0e14, 3.0e15, "us", "microseconds since 1970"),
    (4.0e17, 3.0e18, "ns", "nanoseconds since 1970"),
)
_MAX_EXCEL_STEP_D = 1.0 / 24.0
# What counters of programs wrap at: an unsigned integer of 16 or 32 bits.
_WRAPS = (2.0**16, 2.0**32)
# A counter of a program that had run before: it is counted from the first row.
_RUNNING_FROM = 2.0**14
_DAY_S = 86_400.0
_HOUR_S = 3600.0
# Steps between a wrap, midnight or an hour set back and the rows on both sides, at most.
_MAX_STEPS_AWAY = 10.0
MIN_DURATION_S = 1e-3  # [s]: no wire goes through a loop in less, the thinnest lose heat in tens of milliseconds
_MIN_ROWS = 20  # fewer rows are no loop, whose duration shows nothing
# If no unit is stated, one of these is offered with which a loop has a usual duration and its rows a usual step.
_OFFERED_UNITS = ("s", "ms", "us", "ns", "min")
_LOOP_S = (4.0, 1e6)  # [s]
_STEP_S = (1e-4, 60.0)  # [s]
_COUNTS_BY_ONE = 0.5
_RISING = 0.9
# A fraction of a second next to a clock of whole seconds, from the largest number that it reaches.
_FRACTIONS = ((1.0, 1.0), (1e3, 1e-3), (1e6, 1e-6), (1e9, 1e-9))


@dataclass(frozen=True)
class Clock:
    """How the time of a row follows from its cells.

    ``indices`` are the columns whose cells are joined (a date and a time of day), ``fraction`` another one with what
    one of its counts is [s]; ``unit`` is that of numbers, with ``factor`` [s], or how times of two numbers are written.
    ``counts`` says that a number counts samples. ``wraps_s`` are the times after which it may begin again [s];
    ``start_s`` is the time of its first row, if it is stated apart.
    """

    header: str
    indices: tuple[int, ...]
    unit: str
    factor: float = 1.0
    is_text: bool = False
    counts: bool = False
    fraction: tuple[int, float] | None = None
    wraps_s: tuple[float, ...] = ()
    step_s: float = 0.0
    start_s: float = 0.0
    words: str = ""

    @property
    def all_indices(self) -> tuple[int, ...]:
        """All columns that are read for it."""
        return self.indices if self.fraction is None else (*self.indices, self.fraction[0])


@dataclass(frozen=True)
class NoClock:
    """Why no clock was found: a column that may be one, if more is known of it; ``offered`` is a unit that would do."""

    index: int
    message: str
    offered: str | None = None
    lacks_unit: bool = False


@dataclass
class ClockReader:
    """Turns the cells of a clock into times of rows [s], block after block; what it undid is in ``notes``."""

    clock: Clock
    path: str
    notes: list[str] = field(default_factory=list)
    start_time: str | None = None
    clock_start_s: float | None = None
    _texts: ClockTexts | None = None
    _origin: float | None = None
    _last_s: float = -np.inf
    _added_s: float = 0.0

    def seconds(self, columns: Sequence[Cells], place: Callable[[int], str]) -> FloatArray:
        """Return the times of a block's rows; ``columns`` are those of ``clock.all_indices``."""
        clock = self.clock
        if clock.is_text:
            base = self._text_seconds(columns[: len(clock.indices)], place)
        else:
            written = np.asarray(columns[0], dtype=np.float64)
            if self._origin is None and written.size:
                long_ago = clock.factor * written[0] >= ABSOLUTE_FROM_S or clock.counts
                long_ago |= bool(clock.wraps_s) and written[0] >= _RUNNING_FROM
                self._origin = float(written[0]) if long_ago else 0.0
                if clock.factor * written[0] >= ABSOLUTE_FROM_S:
                    self.clock_start_s = clock.factor * float(written[0])
            base = (written - (self._origin or 0.0)) * clock.factor + clock.start_s
        if clock.fraction is not None:
            base = base + np.asarray(columns[-1], dtype=np.float64) * clock.fraction[1]
        return self._unwrapped(base, place)

    def _text_seconds(self, columns: Sequence[Cells], place: Callable[[int], str]) -> FloatArray:
        if self._texts is None:
            header = self.clock.header.replace("{", "{{").replace("}", "}}")
            self._texts = ClockTexts(f"{self.path}: {{place}}, column '{header}'", self.clock.unit)
        cells = [" ".join(map(str, parts)) for parts in zip(*columns, strict=True)]
        seconds = self._texts.seconds(cells, place)
        self.start_time = self._texts.start_time
        return seconds

    def _unwrapped(self, times_s: FloatArray, place: Callable[[int], str]) -> FloatArray:
        """Return times without the steps back of a counter that wrapped, a day that ended, or an hour set back."""
        if not self.clock.wraps_s or not times_s.size:
            return times_s
        finite = np.isfinite(times_s)
        known = times_s[finite]
        falls = np.flatnonzero(np.diff(known, prepend=max(self._last_s, -1e300)) < 0.0)
        added = np.zeros(known.size)
        for row in falls.tolist():
            before_s = float(known[row - 1]) if row else self._last_s
            period_s = self._period_of(before_s, float(known[row]))
            if period_s:
                added[row:] += period_s
                where = place(int(np.flatnonzero(finite)[row]))
                self.notes.append(
                    f"{where}: the clock begins again after {period_s:g} s ({self._why(period_s)}): it goes on"
                )
        found = times_s.copy()
        found[finite] = known + self._added_s + added
        self._last_s, self._added_s = (
            float(known[-1]) if known.size else self._last_s,
            self._added_s + float(added[-1]) if known.size else self._added_s,
        )
        return found

    def _period_of(self, before_s: float, after_s: float) -> float:
        """Return after which time a clock began again that fell from one time to another, 0.0 if it did not go on.

        A counter wraps at the end of its range, within some of its steps; text goes on by some of its steps.
        """
        near_s = _MAX_STEPS_AWAY * self.clock.step_s
        if self.clock.is_text:
            return next((each for each in self.clock.wraps_s if 0.0 < after_s - before_s + each <= near_s), 0.0)
        begin_s = (self._origin or 0.0) * self.clock.factor
        ends = (each for each in self.clock.wraps_s if 0.0 < each - (before_s + begin_s) <= near_s)
        return next(ends, 0.0) if after_s + begin_s <= near_s else 0.0

    def _why(self, period_s: float) -> str:
        if not self.clock.is_text:
            bits = round(float(np.log2(period_s / self.clock.factor)))
            return f"a counter of {bits} bits wrapped"
        return {_DAY_S: "midnight", _HOUR_S: "an hour"}.get(period_s, "half a day")


def is_time_name(name: str) -> bool:
    """Return whether a header's name is one of time, whatever else it may be."""
    return name == "time_s" or any(column.name == "time_s" for column in columns_called(name))


@dataclass(frozen=True)
class FirstRows:
    """The first rows of a table, from which its clock is found."""

    path: str
    columns: Sequence[SourceColumn]
    cells: Sequence[Cells]  # of each column
    names: Sequence[tuple[str, str | None]]  # of each column, with the unit that it states
    period_s: float | None = None  # between two rows, as given or stated

    def numbers(self, index: int) -> FloatArray:
        """Return the cells of a column of numbers."""
        return np.asarray(self.cells[index], dtype=np.float64)

    def column(self, index: int) -> str:
        """Return how a message begins that is of a column."""
        return f"{self.path}: column '{self.columns[index].header}'"


# A clock, and its rank among several: the lowest is the best.
_Candidate = tuple[int, Clock]


def find_clock(
    rows: FirstRows, mapped: tuple[int, str | None] | None = None, left_out: frozenset[int] = frozenset()
) -> Clock | NoClock | None:
    """Return the clock of a table, why a column is none that seems to be one, or None if nothing is like a clock.

    ``mapped`` is the column that the caller says it is, and the unit that he gives; ``left_out`` are columns that are
    mapped to something else, or ignored.
    """
    others = [index for index in range(len(rows.columns)) if index not in left_out]
    wanted = others if mapped is None else [mapped[0]]
    texts = [index for index in wanted if rows.columns[index].is_text]
    times = [index for index in texts if _is_times(rows.cells[index])]
    if mapped is not None and texts and not times:
        return NoClock(mapped[0], f"{rows.column(mapped[0])} holds text that is no time")
    given = None if mapped is None else mapped[1]
    judged = [_numeric_clock(rows, index, given, mapped is not None) for index in wanted if index not in texts]
    judged += [_text_clock(rows, index, given, others) for index in times]
    if found := [one for one in judged if isinstance(one, tuple)]:
        return _with_fraction(rows, min(found, key=lambda one: one[0])[1], others)
    return next((one for one in judged if isinstance(one, NoClock)), None)


def _is_times(cells: Cells) -> bool:
    filled = [cell for cell in cells[:20] if str(cell).strip()] if isinstance(cells, list) else []
    return bool(filled) and 2 * sum(is_clock_text(str(cell)) for cell in filled) > len(filled)


def _steps_of(values: FloatArray) -> FloatArray:
    finite = values[np.isfinite(values)]
    return np.diff(finite)


def _usual_step(values: FloatArray) -> float:
    steps = _steps_of(values)
    steps = steps[steps > 0.0]
    return float(np.median(steps)) if steps.size else 0.0


def rises(values: FloatArray) -> bool:
    """Return whether numbers rise almost throughout, but for where they begin again."""
    steps = _steps_of(values)
    return bool(steps.size) and float(np.mean(steps >= 0.0)) >= _RISING and bool((steps > 0.0).any())


def _numeric_clock(rows: FirstRows, index: int, given: str | None, mapped: bool) -> _Candidate | NoClock | None:
    """Return the clock that a column of numbers is: by a unit that is given or stated, since long ago, or of rows."""
    values, header = rows.numbers(index), rows.columns[index].header
    name, stated = rows.names[index]
    named, rising, step = is_time_name(name), rises(values), _usual_step(values)
    per_count = None if given is None else scale_to_si(given, "time_s", None, rows.column(index))
    if per_count is not None:
        count_s = per_count.factor
        return 0, Clock(header, (index,), str(given), count_s, counts=True, step_s=step * count_s)
    unit = stated if given is None else given
    # A dash in a row of units says that there is none.
    unit = None if unit is not None and scale_between(unit, "") == 1.0 else unit
    if unit is None and named and len(name) > 1 and measures(name, "time_s"):
        # "Seconds" and "ms" are name and unit at once.
        unit = name
    if unit is not None:
        factor = _factor(unit)
        others = any(measures(unit, column.name) for column in columns_called(name))
        if factor is None and (mapped or (named and not others)):
            return NoClock(index, _wrong_unit(unit, rows.column(index)))
        if factor is None or not (mapped or named or rising):
            return None
        if name.strip().lower() == "time_s" and factor != 1.0:
            return NoClock(index, f"{rows.column(index)}: time_s is in s by its name, not in {unit}; rename it")
        sure = mapped or name == "time_s" or rising
        clock = Clock(header, (index,), unit, factor, step_s=step * factor)
        return 7 if not sure else 0 if named or mapped else 2, _with_wraps(clock, values)
    if not rising:
        return NoClock(index, _no_unit(rows, index), lacks_unit=True) if named and not mapped else None
    if (epoch := _epoch_of(values)) is not None:
        factor = _factor(epoch[0]) or 1.0
        return 1 if named else 3, Clock(header, (index,), epoch[0], factor, step_s=step * factor, words=epoch[1])
    whole = bool((values[np.isfinite(values)] % 1.0 == 0.0).all())
    by_one = whole and float(np.mean(_steps_of(values) == 1.0)) >= _COUNTS_BY_ONE
    if by_one and rows.period_s is not None and not mapped:
        unit, words = f"{rows.period_s:g} s", f"it counts the rows, one every {rows.period_s:g} s"
        return 6, Clock(header, (index,), unit, rows.period_s, counts=True, step_s=rows.period_s, words=words)
    if named or mapped:
        return NoClock(index, _no_unit(rows, index), _unit_offered(values, rows.period_s), lacks_unit=True)
    return None


def _factor(unit: str) -> float | None:
    return scale_between(unit, "s") if measures(unit, "time_s") else None


def _wrong_unit(unit: str, column: str) -> str:
    try:
        conversion_to_si(unit, "time_s", column)
    except RecordingError as problem:
        return str(problem)
    return ""


def _no_unit(rows: FirstRows, index: int) -> str:
    header = rows.columns[index].header
    return f"{rows.column(index)} has no unit: write '{header} [s]' in the header or map it: time_s={header}:s"


def _unit_offered(values: FloatArray, period_s: float | None) -> str | None:
    """Return the unit in which numbers of time would be those of a loop, or of the rows that are stated."""
    step, last = _usual_step(values), float(np.nanmax(values) - np.nanmin(values))
    for unit in _OFFERED_UNITS:
        factor = _factor(unit) or 1.0
        if period_s is not None and abs(step * factor / period_s - 1.0) < 0.05:
            return unit
    if period_s is not None:
        return None
    fitting = [
        unit
        for unit in _OFFERED_UNITS
        if (values.size < _MIN_ROWS or _LOOP_S[0] <= last * (_factor(unit) or 1.0) <= _LOOP_S[1])
        and _STEP_S[0] <= step * (_factor(unit) or 1.0) <= _STEP_S[1]
    ]
    return fitting[0] if fitting else None


def _epoch_of(values: FloatArray) -> tuple[str, str] | None:
    """Return the unit of numbers that can only count from long ago, and what they count; None for any other.

    Days are Excel's only if they rise by fractions, because 45000 may as well be milliseconds.
    """
    finite = values[np.isfinite(values)]
    for low, high, unit, words in _EPOCHS:
        if finite.size > 1 and (finite >= low).all() and (finite <= high).all():
            fits = unit != "d" or bool((np.abs(np.diff(finite)) < _MAX_EXCEL_STEP_D).all())
            return (unit, words) if fits else None
    return None


def _with_wraps(clock: Clock, values: FloatArray) -> Clock:
    """Return a clock with the times after which its integers begin again, if they fall in the first rows, or may."""
    finite = values[np.isfinite(values)]
    if not finite.size or (finite % 1.0 != 0.0).any() or finite.min() < 0.0:
        return clock
    return replace(clock, wraps_s=tuple(bound * clock.factor for bound in _WRAPS if finite.max() < bound))


def _text_clock(rows: FirstRows, index: int, given: str | None, others: Sequence[int]) -> _Candidate | NoClock | None:
    """Return the clock of dates or times of day; a date takes the time of day in another column."""
    cells = [str(cell) for cell in rows.cells[index]]
    first = next(cell for cell in cells if cell.strip())
    name, stated = rows.names[index]
    indices: tuple[int, ...] = (index,)
    header = rows.columns[index].header
    texts = [other for other in others if other != index and rows.columns[other].is_text and rows.cells[other]]
    if is_date(first):
        of_day = next((other for other in texts if is_time_of_day(str(rows.cells[other][0]))), None)
        if of_day is None:
            return None
        indices, header = (index, of_day), f"{header} {rows.columns[of_day].header}"
        cells = [f"{one} {two}" for one, two in zip(cells, map(str, rows.cells[of_day]), strict=True)]
    elif is_time_of_day(first) and any(is_date(str(rows.cells[other][0])) for other in texts):
        return None  # it is found from the date on
    form = written_clock(given) or written_clock(stated) or written_clock(None, cells)
    if form is None:
        message = (
            f"{rows.path}: column '{header}' may be minutes and seconds or hours and minutes; "
            f"map it as it is meant: time_s={header}:mm:ss"
        )
        return NoClock(index, message, "mm:ss")
    try:
        seconds = ClockTexts("", form).seconds(cells, str)
    except RecordingError:
        seconds = np.zeros(0)
    has_date = len(indices) > 1 or not is_time_of_day(first)
    by_halves = re.search("[ap]m", first, re.I) is not None
    wraps_s = (_HOUR_S,) if has_date or form == "mm:ss" else () if by_halves else (_DAY_S / 2.0,)
    named = is_time_name(name) or is_time_name(header)
    clock = Clock(header, indices, form or "s", is_text=True, wraps_s=wraps_s, step_s=_usual_step(seconds))
    return 4 if named else 5, clock


def _with_fraction(rows: FirstRows, clock: Clock, others: Sequence[int]) -> Clock:
    """Return a clock of whole seconds with the column that counts the fraction of each, if there is one.

    That column makes the clock rise in every row, or more evenly than it does alone.
    """
    if clock.counts or clock.factor != 1.0 or clock.header == "time_s":
        return clock
    try:
        whole_s = ClockReader(clock, rows.path).seconds([rows.cells[index] for index in clock.indices], str)
    except RecordingError:
        return clock
    if whole_s.size < 3 or not np.isfinite(whole_s).all() or (whole_s % 1.0 != 0.0).any():
        return clock
    for index in others:
        column, unit = rows.columns[index], rows.names[index][1]
        if index in clock.indices or column.is_text or column.is_empty:
            continue
        counts = rows.numbers(index)
        scale = _scale_of_fraction(counts, whole_s)
        if scale is not None and (unit is None or _factor(unit) == scale):
            step_s, header = _usual_step(whole_s + scale * counts), f"{clock.header} {column.header}"
            return replace(clock, fraction=(index, scale), header=header, step_s=step_s)
    return clock


def _scale_of_fraction(cells: FloatArray, whole_s: FloatArray) -> float | None:
    """Return what a count of a column is [s] that falls only where a clock of whole seconds goes on, else None.

    The two together rise in every row, which the clock need not do alone.
    """
    if cells.size != whole_s.size or not np.isfinite(cells).all() or cells.min() < 0.0:
        return None
    scale = next((scale for bound, scale in _FRACTIONS if cells.max() < bound), None)
    if scale is None or (scale < 1.0 and (cells % 1.0 != 0.0).any()):
        return None
    falls, alone, together = np.diff(cells) < 0.0, np.diff(whole_s), np.diff(whole_s + scale * cells)
    goes_on = (falls & (alone > 0.0)).any() and not (falls & (alone == 0.0)).any()
    if not goes_on or (together > 0.0).mean() < _RISING:
        return None
    # Without it the clock stands still, or its steps are less even.
    is_needed = (alone == 0.0).any() or float(np.ptp(together)) < 0.5 * float(np.ptp(alone))
    return scale if is_needed else None


def impossible(clock: Clock, row_count: int, lasted_s: float, path: str) -> str:
    """Return in words that no wire can have gone through a recording so fast, or ""."""
    if row_count < _MIN_ROWS or not 0.0 <= lasted_s < MIN_DURATION_S:
        return ""
    return (
        f"{path}: by column '{clock.header}' in {clock.unit} {row_count} rows last {lasted_s:.3g} s, and no wire heats "
        f"so fast: the unit of its times is another one; map it (time_s={clock.header}:s) and let the mapping hold ("
        + argument("trust_mapping", True)
        + ")"
    )
