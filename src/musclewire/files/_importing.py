"""From a table of another program to a recording: what each column becomes, and every check of its numbers.

Reading, previewing and converting a file go through the same blocks, so that a preview finds what writing would.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError, argument
from musclewire.files._clocks import Clock, ClockReader, FirstRows, NoClock, find_clock, impossible, is_time_name
from musclewire.files._headers import (
    EmptyHeader,
    HeaderMatch,
    HeaderWithoutUnit,
    How,
    MatchedHeader,
    UndecidedHeader,
    index_of,
    indices_left_out,
    match_columns,
    missing_from,
    name_and_unit,
    numbered_headers,
    require_same,
)
from musclewire.files._import_mapping import CurableError, ImportMapping
from musclewire.files._long_tables import spread_series
from musclewire.files._side_by_side import stacked_branches
from musclewire.files._source_table import (
    Cells,
    RowBlock,
    SourceTable,
    differing_periods,
    doubted_clock,
    heads_of,
    rows_in,
    stated_start_s,
)
from musclewire.signals import (
    BRANCH_TABLE,
    COLUMNS,
    ISOBAR_TABLE,
    PULSE_TABLE,
    MetadataValue,
    known_column,
    largest_in,
    needs_no_clock,
    out_of_range_message,
    scale_to_si,
)

# Which rows of a block, and the numbers of some.
Rows = NDArray[np.bool_]
Places = NDArray[np.intp]

# A wire that shortens by its whole length does not exist: larger numbers are percent, not fractions.
_STRAINS = frozenset({"reference_strain", "target_strain", "strain_heating", "strain_cooling"})
# What a sensor reads that may begin anywhere or be mounted backwards.
_INVERTED = ("displacement_m", "reference_strain")
_ZEROED = (*_INVERTED, "force_n")
_TEMPERATURES = frozenset({"wire_temperature_k", "ambient_temperature_k"})
# Columns that say when and in which cycle, but nothing about a wire.
_COUNTERS = frozenset({"time_s", "cycle"})
# What moved, and what was measured of the wire: with both, the order of rows is a loop without a clock.
_MOVED = frozenset({"displacement_m", "reference_strain", "force_n"})
_OF_THE_WIRE = frozenset({"wire_resistance_ohm", "wire_voltage_v", "wire_current_a", "wire_temperature_k"})
_ELECTRICAL = _OF_THE_WIRE - {"wire_temperature_k"}
_CURRENT = frozenset({"wire_current_a", "wire_resistance_ohm"})
_MAX_STEPS = 1000
# Rows are repeated by polling if the instrument is slower than the program that reads it. That is known by:
_MIN_ROWS_OF_POLLING = 20  # rows: in fewer, repetition is chance
_MIN_REPEATS = 0.05  # of the rows that repeat the one before: fewer are chance
_MAX_REPEATS = 0.95  # of them: with more the wire rests
_STEPS_OF_A_MEASUREMENT = 20.0  # smallest steps from one measurement to the next: with fewer a column may just rest
_MAX_RUN_OF_REPEATS = 5  # repeated rows in succession: in more the wire rests
# Usual steps of the clock, by which it may go on below headers that are repeated: it is one test then.
_STEPS_OVER_HEADERS = 3.0
_MAX_BEYOND = 0.05
# Metadata: which rows an import left out, where times are not as far apart as stated, and which columns were negative.
NOTED_BY_IMPORT = LEFT_OUT, CLOCK_DOUBTED, SIGN_TURNED = "rows_left_out", "clock_doubted", "sign_turned"
# Instruments print a number for "overload" that no bench has: 9.9E37 and 9.91E37 (SCPI), 1e38, a float's largest.
_OVERLOAD_FROM = 1e30
_MAX_OTHER_SIGN = 0.1  # of the readings: a column with more of the other sign has both
_NEXT_TO_NOTHING = 0.05  # of the large readings (their 90 % quantile): the sign of a smaller one is noise
_MIN_ROWS_OF_A_SIGN = 5  # rows with both readings: fewer show no sign
_OF_CURRENT = ("wire_current_a", "shunt_voltage_v")
_RMS, _MEAN = {"rms"}, {"avg", "average", "mean"}
SHUNT_NEEDED = "nothing states the shunt's resistance, which converting the file needs"
NO_SHUNT = (
    SHUNT_NEEDED
    + ": its voltage is the only current; give it ("
    + argument("metadata", {"shunt_resistance_ohm": 1.0})
    + ")"
)
_DROP_CURE = "or leave such rows out (" + argument("drop_missing", True) + ")"


def is_overload(values: FloatArray) -> Rows:
    """Return which numbers are overload marks, (n_times,)."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.abs(values) >= _OVERLOAD_FROM)


def turned_columns(columns: Mapping[str, FloatArray]) -> tuple[str, ...]:
    """Return which of voltage and current are negative throughout where the other is positive."""
    found = []
    for name in _OF_CURRENT:
        if {"wire_voltage_v", name} <= columns.keys():
            pair = {one: columns[one] for one in (name, "wire_voltage_v")}
            there = [np.abs(values) > _NEXT_TO_NOTHING * np.quantile(np.abs(values), 0.9) for values in pair.values()]
            signs = np.sign([values[there[0] & there[1]] for values in pair.values()])
            if signs.shape[1] > _MIN_ROWS_OF_A_SIGN and _are_most(signs.prod(axis=0) < 0.0):
                found += [one for one, sign in zip(pair, signs, strict=True) if _are_most(sign < 0.0)]
    return tuple(dict.fromkeys(found))


def _are_most(rows: Rows) -> bool:
    return bool(np.mean(rows) > 1.0 - _MAX_OTHER_SIGN)


@dataclass(frozen=True)
class ImportPlan:
    """A table and what each of its columns becomes; ``problem`` is the first reason why it cannot be read, or "".

    ``no_clock`` is the column that may be the clock if more were known of it. ``row_clock`` says that the rows are
    numbered for want of a clock, ``test`` which of several tests below each other is read, from 1; None for the only
    one.
    """

    table: SourceTable
    match: HeaderMatch
    mapping: ImportMapping
    sample_period_s: float | None = None
    notes: tuple[str, ...] = ()
    problem: str = ""
    no_clock: NoClock | None = None
    row_clock: bool = False
    test: int | None = None
    clock: Clock | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The columns of the recording; a clock that is counted comes first."""
        taken = tuple(item.column for item in self.match.taken)
        return taken if self.sample_period_s is None else ("time_s", *taken)

    @property
    def is_electrical(self) -> bool:
        """Whether anything was measured of the wire's electricity, or nothing needs to be, as in isobars."""
        return bool(_ELECTRICAL & set(self.names)) or needs_no_clock(self.names)

    @property
    def lacks_shunt(self) -> bool:
        """Whether the only current is a shunt's voltage, and nothing states its resistance."""
        of_shunt = "shunt_voltage_v" in self.names and not _CURRENT & set(self.names)
        return of_shunt and self.metadata.get("shunt_resistance_ohm") is None

    @property
    def metadata(self) -> dict[str, MetadataValue]:
        """The metadata of file and mapping."""
        numbered: dict[str, MetadataValue] = {"clock": "row numbers"} if self.row_clock else {}
        return {**self.table.metadata, **numbered, **self.mapping.metadata}


@dataclass
class CheckedBlocks:
    """What the checked blocks of a table held."""

    row_count: int = 0
    dropped: int = 0
    repeated: int = 0
    start_time: str | None = None
    overloads: dict[str, int] = field(default_factory=dict)
    clock_start_s: float | None = None
    clock_doubt: str | None = None
    turned: tuple[str, ...] | None = None
    clock_notes: tuple[str, ...] = ()
    others: list[tuple[int, str]] = field(default_factory=list)
    cut_off: str = ""
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def started(self) -> dict[str, MetadataValue]:
        """When the recording began: a date, or what a clock that counts from long ago showed at the first row [s]."""
        known = {"start_time": self.start_time, "clock_start_s": self.clock_start_s}
        return {name: value for name, value in known.items() if value is not None}

    def add(self, columns: Mapping[str, FloatArray]) -> None:
        """Count a block of the recording's rows."""
        self.row_count += next(iter(columns.values())).size
        for name, values in columns.items():
            finite = values[np.isfinite(values)]
            if finite.size:
                low, high = self.ranges.get(name, (np.inf, -np.inf))
                self.ranges[name] = (min(low, float(finite.min())), max(high, float(finite.max())))

    @property
    def noted(self) -> dict[str, MetadataValue]:
        """What reading found in words, as metadata: rows with an overload mark, times that are not as stated."""
        counted = [f"{count} rows with an overload mark in {name}" for name, count in self.overloads.items()]
        found: dict[str, MetadataValue] = {LEFT_OUT: f"left out: {', '.join(counted)}"} if counted else {}
        turned = [f"{name} is negative throughout: its sign is turned" for name in self.turned or ()]
        found |= {SIGN_TURNED: "; ".join(turned)} if turned else {}
        if self.cut_off:
            found["ended"] = "cut off"
        return found | ({CLOCK_DOUBTED: self.clock_doubt} if self.clock_doubt else {})

    @property
    def notes(self) -> tuple[str, ...]:
        """What reading left out, a sentence each."""
        found = [f"{self.dropped} rows without a number left out"] if self.dropped else []
        found += [f"{self.repeated} rows left out, each the row before once more"] if self.repeated else []
        if self.others:
            number, text = self.others[0]
            count = f"{len(self.others)} lines that are no rows" if len(self.others) > 1 else "a line that is no row"
            found.append(f"{count} left out, as line {number}: '{' '.join(text.split())[:40]}'")
        found += [self.cut_off] if self.cut_off else []
        return (*found, *self.clock_notes)


def plan_import(table: SourceTable, mapping: ImportMapping, test: int | None = None) -> ImportPlan:
    """Return what each column of a table becomes; ``test`` is which of the tests below each other is read.

    Raises RecordingError and CallerError for what is wrong with the mapping itself; what is wrong with the file is in
    the plan's ``problem``.
    """
    found = missing_from(table.columns, mapping.columns, ())[0] != frozenset(mapping.columns)
    given, table = table, table if found else stacked_branches(spread_series(table))
    path, headers = table.path, tuple(column.header for column in table.columns)
    clock, no_clock = _clock_of(table, mapping)
    counts = clock is not None and clock.counts
    match = match_columns(
        table.columns,
        mapping.columns,
        path,
        mapping.ignore,
        mapping.only_mapped,
        _clock_header(clock, no_clock, table, mapping),
        () if clock is None else clock.all_indices,
        mapping.trust_mapping,
    )
    period_s = None if counts else _counted_period_s(match, table, mapping)
    stacked = table is not given and "time_s" not in {item.column for item in match.taken}
    row_clock = period_s is None and _has_row_clock(match, table, stacked)
    period_s = 1.0 if row_clock else period_s
    notes = _notes(table, mapping, period_s, row_clock, clock)
    plan = ImportPlan(
        table, match, mapping, period_s, notes, no_clock=no_clock, row_clock=row_clock, test=test, clock=clock
    )
    if not mapping.columns and headers == numbered_headers(len(headers)):
        problem = (
            f"{path}: has no headers; name the columns in the first line, such as 'time [s],wire_voltage_v', "
            "or map them by number: time_s=#1:s"
        )
        return replace(plan, problem=problem)
    return replace(plan, problem=_problem(plan, headers))


def _clock_of(table: SourceTable, mapping: ImportMapping) -> tuple[Clock | None, NoClock | None]:
    """Return the clock of a table, or the column that may be one if more were known of it."""
    columns, path = table.columns, table.path
    wanted = mapping.columns.get("time_s")
    mapped = None if wanted is None else index_of("time_s", wanted, columns, path)
    if mapped is None and mapping.only_mapped:
        return None, None
    left_out = indices_left_out(columns, mapping, path)
    if mapped is not None and mapped[0] in left_out:
        header = columns[mapped[0]].header
        raise RecordingError(f"{path}: column '{header}' is both mapped to time_s and taken or ignored; choose one")
    names = [name_and_unit(column) for column in columns]
    if mapped is not None and mapped[1] and not mapping.trust_mapping and not columns[mapped[0]].is_text:
        stated = names[mapped[0]][1]
        if stated and scale_to_si(mapped[1], "time_s", None, path) is None:
            require_same(mapped[1], stated, columns[mapped[0]].header, "time_s", path)
    period_s = mapping.sample_period_s or next(iter(table.stated_periods_s.values()), None)
    found = find_clock(FirstRows(path, columns, heads_of(table), names, period_s), mapped, left_out)
    if isinstance(found, NoClock):
        return None, None if mapping.sample_period_s is not None else found
    if found is not None and found.counts:
        found = replace(found, start_s=stated_start_s(table.metadata))
    return found, None


def _clock_header(
    clock: Clock | None, no_clock: NoClock | None, table: SourceTable, mapping: ImportMapping
) -> MatchedHeader | UndecidedHeader | None:
    """Return the clock as the headers of other columns are matched."""
    if no_clock is not None:
        header = table.columns[no_clock.index].header
        kind = HeaderWithoutUnit if no_clock.lacks_unit else UndecidedHeader
        return kind(header, no_clock.index, "time_s", no_clock.message)
    if clock is None:
        return None
    name, stated = name_and_unit(table.columns[clock.indices[0]])
    is_own = name.strip().lower() == "time_s" and not clock.is_text and clock.factor == 1.0
    how: How = "mapped" if "time_s" in mapping.columns else "own name" if is_own else "values"
    if how == "values" and is_time_name(name) and (stated or clock.is_text):
        how = "synonym"
    return MatchedHeader(
        clock.header, clock.indices[0], "time_s", clock.unit, stated is not None, clock.factor, 0.0, how, clock.is_text
    )


def checked_blocks(plan: ImportPlan, tally: CheckedBlocks) -> Iterator[dict[str, FloatArray]]:
    """Yield the recording's rows in SI, block after block, each checked; what they hold is added to ``tally``.

    Raises RecordingError with file, line or row, and column for the first number that cannot be used.
    """
    if plan.problem:
        raise RecordingError(plan.problem)
    reader = _BlockReader(plan, tally)
    for block in plan.table.blocks(reader.indices):
        if block.is_end:
            reader.end(block)
            continue
        tally.others += block.others
        columns = reader.columns_of(block)
        tally.add(columns)
        yield columns
    reader.finish()
    if tally.row_count < 2:
        raise RecordingError(f"{plan.table.path}: has {tally.row_count} rows; a recording needs 2 or more")


def _may_be_nan(column: str) -> bool:
    """Return whether a number may be missing: of what a loop computes, where it has not; else it is a gap in data."""
    return known_column(column).kind == "control"


class _BlockReader:
    """Converts and checks the blocks of a table, one after the other."""

    def __init__(self, plan: ImportPlan, tally: CheckedBlocks) -> None:
        self._plan, self._tally = plan, tally
        self._path = plan.table.path
        self._rows = 0
        self._last_time_s = -np.inf
        self._first: dict[str, float] = {}
        self._origin: float | None = None
        self._before: list[float] | None = None
        self._polled: bool | None = None
        self._test = 1
        self._clock = None if plan.clock is None else ClockReader(plan.clock, self._path)
        self._times = (np.inf, -np.inf)

    @property
    def indices(self) -> list[int]:
        """The columns of the table that are read: those taken, and then all of the clock."""
        return [item.index for item in self._plan.match.taken] + list(
            () if self._plan.clock is None else self._plan.clock.all_indices
        )

    def end(self, block: RowBlock) -> None:
        """Keep what follows the last row: a row that is cut off, or lines of something else."""
        if block.is_cut:
            self._tally.cut_off = f"the file is cut off in line {block.others[-1][0]}, which is left out"
        else:
            self._tally.others += block.others

    def finish(self) -> None:
        """Raise RecordingError if no wire can have gone through all rows in the time that the clock shows."""
        if self._clock is not None:
            self._tally.clock_notes = tuple(self._clock.notes)
            lasted_s = self._times[1] - self._times[0]
            if problem := impossible(self._clock.clock, self._tally.row_count, lasted_s, self._path):
                raise RecordingError(problem)

    def columns_of(self, block: RowBlock) -> dict[str, FloatArray]:
        """Return a block's rows as columns of a recording."""
        taken = self._plan.match.taken
        numbered = [self._numbers(item, cells, block) for item, cells in zip(taken, block.values, strict=False)]
        self._stamps = next(
            (v for item, v in zip(taken, numbered, strict=True) if item.column == "time_s"), np.zeros(0)
        )
        keep = self._kept(numbered, block) & self._not_repeated(numbered)
        rows = np.flatnonzero(keep)
        columns = {
            item.column: self._checked(item, values[keep], block, rows)
            for item, values in zip(taken, numbered, strict=True)
        }
        if self._plan.sample_period_s is not None:
            counted: FloatArray = (self._rows + rows).astype(np.float64) * self._plan.sample_period_s
            counted += 0.0 if self._plan.row_clock else stated_start_s(self._plan.table.metadata)
            columns = {"time_s": counted, **columns}
        self._rows += keep.size
        if "time_s" in columns and self._plan.test is not None:
            columns, rows = self._of_the_test(columns, rows, block)
        if "time_s" in columns:
            self._check_clock_rises(columns["time_s"], block, rows)
            if columns["time_s"].size:
                self._times = (min(self._times[0], columns["time_s"][0]), float(columns["time_s"][-1]))
        if "time_s" in columns and self._tally.clock_doubt is None:
            own = any(item.column == "time_s" and item.how == "own name" for item in taken)
            needless = own or self._plan.sample_period_s is not None
            stated = {} if needless else self._plan.table.stated_periods_s
            self._tally.clock_doubt = doubted_clock(stated, columns["time_s"])
        return self._mounted(columns)

    def _numbers(self, item: MatchedHeader, cells: Cells, block: RowBlock) -> FloatArray:
        if item.column != "time_s" or self._clock is None:
            return np.asarray(cells, dtype=np.float64)
        seconds = self._clock.seconds(block.values[len(self._plan.match.taken) :], block.place)
        self._tally.start_time, self._tally.clock_start_s = self._clock.start_time, self._clock.clock_start_s
        return seconds

    def _kept(self, numbered: Sequence[FloatArray], block: RowBlock) -> Rows:
        """Return which rows are kept: all, or those in which no number is missing."""
        size = numbered[0].size if numbered else len(block.values[0])
        keep = np.ones(size, dtype=bool)
        if self._plan.mapping.drop_missing:
            for item, values in zip(self._plan.match.taken, numbered, strict=True):
                if not _may_be_nan(item.column):
                    keep &= np.isfinite(values)
            self._tally.dropped += int(size - keep.sum())
        # A recording of musclewire's own keeps its rows; what uses it judges them.
        of_others = [pair for pair in zip(self._plan.match.taken, numbered, strict=True) if pair[0].how != "own name"]
        for item, values in of_others:
            marked = keep & np.isfinite(values) & is_overload(values)
            if item.column != "time_s":
                # A few readings beyond what any bench has are an instrument's mark, too; many are a wrong unit.
                with np.errstate(invalid="ignore"):
                    beyond_all = np.abs(item.conversion.apply(values)) > largest_in(COLUMNS[item.column].unit)
                marked |= keep & beyond_all & bool(beyond_all.mean() <= _MAX_BEYOND)
            if marked.any():
                counts = self._tally.overloads
                counts[item.column] = counts.get(item.column, 0) + int(marked.sum())
                keep &= ~marked
        return keep

    def _not_repeated(self, numbered: Sequence[FloatArray]) -> Rows:
        """Return which rows are not the row before once more, as programs write them that poll too fast."""
        columns = [item.column for item in self._plan.match.taken]
        size = numbered[0].size if numbered else 0
        measured = [number for number, column in enumerate(columns) if column not in _COUNTERS]
        if "time_s" not in columns or not measured or not size:
            return np.ones(size, dtype=bool)
        table = np.column_stack(numbered)
        first = table[0] if self._before is None else np.array(self._before)
        same = table == np.vstack([first, table[:-1]])
        same[0] &= self._before is not None
        self._before = table[-1].tolist()
        # A stamp that most rows share with the row before is that of a batch, whose rows may be alike.
        if 2 * same[:, columns.index("time_s")].sum() > size:
            return np.ones(size, dtype=bool)
        if self._polled is None:
            # A recording of musclewire's own has every row that was measured, repeated or not.
            own = self._plan.match.taken[columns.index("time_s")].how == "own name"
            self._polled = not own and is_polled(table[:, measured])
        repeated: Rows = same[:, measured].all(axis=1) if self._polled else same.all(axis=1)
        self._tally.repeated += int(repeated.sum())
        return ~repeated

    def _of_the_test(
        self, columns: dict[str, FloatArray], rows: Places, block: RowBlock
    ) -> tuple[dict[str, FloatArray], Places]:
        """Return the rows of the test that was chosen; with each that begins, the clock begins again."""
        time_s = columns["time_s"]
        before = np.concatenate(([self._last_time_s], time_s[:-1]))
        headed, counts = _first_of(rows, block.again), self._plan.clock is None
        numbers = self._test + np.cumsum(begins_again(before, time_s, headed, counts))
        if time_s.size:
            self._test, last_s = int(numbers[-1]), float(time_s[-1])
            keep = numbers == self._plan.test
            self._last_time_s = (
                last_s if not keep.any() else -np.inf if numbers[0] != self._plan.test else self._last_time_s
            )
            columns, rows = {name: values[keep] for name, values in columns.items()}, rows[keep]
        return columns, rows

    def _checked(self, item: MatchedHeader, written: FloatArray, block: RowBlock, rows: Places) -> FloatArray:
        bad = np.isinf(written) if _may_be_nan(item.column) else ~np.isfinite(written)
        if bad.any():
            row = int(np.argmax(bad))
            self._refuse_word(item, block, int(rows[row]))
            missing = np.isnan(written[row])
            what = "the cell is blank or NaN" if missing else f"{written[row]:g} is not a finite number"
            mostly_blank = missing and item.column != "time_s" and float(np.isnan(written).mean()) > 0.5
            cure = (
                "as in most rows: correct it, or leave the column out"
                if mostly_blank
                else (("correct it, " if missing else "correct it or remove the row, ") + _DROP_CURE)
            )
            message = f"{self._path}: {block.place(int(rows[row]))}, column '{item.header}': {what}; " + cure
            added = ImportMapping(ignore=(item.header,)) if mostly_blank else ImportMapping(drop_missing=True)
            raise CurableError(message, added)
        self._check_strain_is_a_fraction(item, written, block, rows)
        converted = written if item.column == "time_s" else item.conversion.apply(written)
        if item.column in _TEMPERATURES and item.how != "own name" and (converted < 0.0).any():
            row = int(np.argmax(converted < 0.0))
            where = f"{self._path}: {block.place(int(rows[row]))}, column '{item.header}'"
            what = f"{written[row]:g} {item.unit} is below absolute zero"
            raise RecordingError(f"{where}: {what}; correct the number or its unit")
        unit_si = COLUMNS[item.column].unit
        too_large = np.abs(converted) > largest_in(unit_si)
        # What musclewire has recorded was computed, and is read back whatever it is.
        if too_large.any() and item.how != "own name":
            row = int(np.argmax(too_large))
            where = f"{self._path}: {block.place(int(rows[row]))}, column '{item.header}'"
            raise RecordingError(f"{where}: {written[row]:g} {item.unit} {out_of_range_message(unit_si)}")
        return converted

    def _refuse_word(self, item: MatchedHeader, block: RowBlock, row: int) -> None:
        """Raise CurableError for a cell with a word among numbers."""
        word = block.words.get((row, item.index))
        if word is not None:
            place = block.place(row)
            cure = f"correct it or remove the {place.partition(' ')[0]}, " + _DROP_CURE
            said = f"{self._path}: {place}, column '{item.header}': '{word}' is not a number; " + cure
            raise CurableError(said, ImportMapping(drop_missing=True))

    def _check_strain_is_a_fraction(
        self, item: MatchedHeader, written: FloatArray, block: RowBlock, rows: Places
    ) -> None:
        too_large = np.abs(written) > 1.0
        if item.column not in _STRAINS or item.unit_given or not too_large.any():
            return
        row = int(np.argmax(too_large))
        raise RecordingError(
            f"{self._path}: {block.place(int(rows[row]))}, column '{item.header}': {written[row]:g} is no strain as a "
            f"fraction: write '{item.header} [%]' in the header or map it: {item.column}={item.header}:%"
        )

    def _check_clock_rises(self, time_s: FloatArray, block: RowBlock, rows: Places) -> None:
        before = np.concatenate(([self._last_time_s], time_s[:-1]))
        begins = begins_again(before, time_s, _first_of(rows, block.again), self._plan.clock is None)
        stuck = (time_s <= before) | (begins & (self._plan.test is None))
        if stuck.any():
            row = int(np.argmax(stuck))
            where = f"{self._path}: {block.place(int(rows[row]))}, column time_s: the clock does not rise, "
            where += f"{float(before[row])!r} s is followed by {float(time_s[row])!r} s"
            self._refuse_batches(where)
            self._refuse_several_tests(where, bool(begins[row]))
            raise RecordingError(f"{where}; correct the clock there or cut the file")
        if time_s.size:
            self._last_time_s = float(time_s[-1])

    def _refuse_batches(self, where: str) -> None:
        """Raise CurableError if each time stamp stands for a batch of rows."""
        clock = next((item for item in self._plan.match.taken if item.column == "time_s"), None)
        # Of all rows, those included in which something else is missing.
        period_s = None if clock is None else repeated_stamps(self._stamps)
        if clock is None or period_s is None:
            return
        header = self._plan.table.columns[clock.index].header
        message = (
            f"{where}: one time stamp for several rows: read them as a row every {period_s:g} s and ignore '{header}'"
        )
        raise CurableError(message, ImportMapping(ignore=(header,), sample_period_s=period_s))

    def _refuse_several_tests(self, where: str, begins: bool) -> None:
        """Raise CurableError with a list if several tests are below each other."""
        if not begins or self._plan.test is not None:
            return
        tests = tests_below_each_other(self._plan)
        listed = "; ".join(f"'test {n}' ({t.rows} rows, {t.first:g} to {t.last:g})" for n, t in enumerate(tests[:8], 1))
        more = f"; and {len(tests) - 8} more" if len(tests) > 8 else ""
        group = self._plan.mapping.group
        longest = 1 + max(range(len(tests)), key=lambda number: tests[number].rows)
        message = (
            f"{where}: {len(tests)} tests are below each other: choose one with "
            + argument("group", "NAME")
            + f": {listed}{more}"
        )
        raise CurableError(
            message, ImportMapping(group=f"test {longest}" if group is None else f"{group}, test {longest}")
        )

    def _mounted(self, columns: dict[str, FloatArray]) -> dict[str, FloatArray]:
        """Return columns with those of sensors turned around and counted from the first row, if asked for."""
        if self._tally.turned is None and next(iter(columns.values())).size:
            # Whoever writes our names exactly, writes what we would.
            others = {
                item.column: columns[item.column] for item in self._plan.match.taken if item.header != item.column
            }
            self._tally.turned = turned_columns(others)
        columns |= {name: -columns[name] for name in self._tally.turned or ()}
        if self._plan.mapping.invert:
            columns |= {name: -columns[name] for name in _INVERTED if name in columns}
        if self._plan.mapping.zero:
            for name in _ZEROED:
                if name in columns and columns[name].size:
                    columns[name] = columns[name] - self._first.setdefault(name, float(columns[name][0]))
        return columns


class TestBelow(NamedTuple):
    """One of several tests below each other: how many rows it has, and its clock at the first and the last."""

    rows: int
    first: float
    last: float


def tests_below_each_other(plan: ImportPlan) -> list[TestBelow]:
    """Return the tests in a table, of which each begins where the clock begins again."""
    clock = plan.clock
    blocks = [block for block in plan.table.blocks([] if clock is None else clock.all_indices) if not block.is_end]
    if clock is None:
        written = (plan.sample_period_s or 1.0) * np.arange(float(sum(block.row_count for block in blocks)))
    else:
        reader = ClockReader(clock, plan.table.path)
        written = np.concatenate([reader.seconds(block.values, block.place) for block in blocks])
    offsets = np.cumsum([0, *(block.row_count for block in blocks)])
    again = [row + offset for block, offset in zip(blocks, offsets.tolist(), strict=False) for row in block.again]
    rows = np.flatnonzero(np.isfinite(written))
    times = written[rows]
    begins = begins_again(times[:-1], times[1:], _first_of(rows, again)[1:], clock is None)
    starts = [0, *np.flatnonzero(begins) + 1, times.size]
    return [TestBelow(int(b - a), float(times[a]), float(times[b - 1])) for a, b in itertools.pairwise(starts)]


def begins_again(before: FloatArray, times: FloatArray, headed: Rows, counts: bool = False) -> Rows:
    """Return where a test begins: a clock falls and goes on from there, or does not just go on below new headers.

    A single time that is too small is damage. ``headed`` are the rows above which the headers stand once more; a clock
    that only ``counts`` rows does not show whether a test went on there.
    """
    after = np.concatenate((times[1:], times[-1:]))
    steps = times - before
    rising = steps[np.isfinite(steps) & (steps > 0.0)]
    goes_on = (steps > 0.0) & (steps <= _STEPS_OVER_HEADERS * (float(np.median(rising)) if rising.size else 0.0))
    return ((times < before) & (after < before)) | (headed & np.isfinite(before) & (counts | ~goes_on))


def _first_of(rows: Places, again: Sequence[int]) -> Rows:
    """Return which of some rows are the first at or after some places."""
    found = np.zeros(rows.size, dtype=np.bool_)
    places = np.searchsorted(rows, np.asarray(again, dtype=np.intp))
    found[places[places < rows.size]] = True
    return found


def repeated_stamps(time_s: FloatArray) -> float | None:
    """Return the time between rows [s] if stamps stand still for a number of rows that is the same within one."""
    starts = np.flatnonzero(np.diff(time_s, prepend=time_s[0] - 1.0) != 0.0)
    sizes, steps = np.diff(starts), np.diff(time_s[starts])
    if sizes.size < 2 or float(np.median(sizes)) < 2.0 or (steps <= 0.0).any():
        return None
    # The first stamp may have begun earlier, and the stamps be rounded.
    inner, step = sizes[1:] if sizes.size > 2 else sizes, float(np.median(steps))
    if int(np.ptp(inner)) > 1 or float(np.ptp(steps)) > 0.05 * step:
        return None
    return float(f"{steps[-inner.size :].sum() / inner.sum():.6g}")


def is_polled(measured: FloatArray) -> bool:
    """Return whether rows are repeated because they were read more often than measured.

    ``measured`` are the numbers of all measured columns, (n_rows, n_columns). A slow signal stands still where it
    hardly moves; one that moves by many of its smallest steps before and after stands still for no other reason.
    """
    if measured.shape[0] < _MIN_ROWS_OF_POLLING or not measured.shape[1] or not np.isfinite(measured).all():
        return False
    steps = np.abs(np.diff(measured, axis=0))
    repeated = ~steps.any(axis=1)
    ends = np.flatnonzero(np.concatenate(([True], ~repeated, [True])))
    if not _MIN_REPEATS < repeated.mean() < _MAX_REPEATS or int(np.diff(ends).max()) - 1 > _MAX_RUN_OF_REPEATS:
        return False
    beside = ~repeated & (np.roll(repeated, 1) | np.roll(repeated, -1))
    smallest = np.min(np.where(steps > 0.0, steps, np.inf), axis=0)
    return bool(np.any(np.median(steps[beside], axis=0) >= _STEPS_OF_A_MEASUREMENT * smallest))


def _has_row_clock(match: HeaderMatch, table: SourceTable, stacked: bool) -> bool:
    """Return whether rows may be numbered for want of a clock: nothing in the table depends on how fast it went."""
    found = {item.column for item in match.taken}
    clocks = [item for item in match.undecided if item.column == "time_s"]
    if "time_s" in found or clocks or needs_no_clock(found) or not found & _MOVED or not found & _OF_THE_WIRE:
        return False
    # Steps of current and what they did, one row each; a meter's record without its clock is longer, and has a voltage.
    in_steps = "wire_resistance_ohm" in found and not found & {"wire_voltage_v", "drive_voltage_v"}
    return stacked or (in_steps and rows_in(table) <= _MAX_STEPS)


def _counted_period_s(match: HeaderMatch, table: SourceTable, mapping: ImportMapping) -> float | None:
    """Return the time between rows [s] if the clock has to be counted from it, else None."""
    clock = next((item for item in match.taken if item.column == "time_s"), None)
    if mapping.sample_period_s is not None:
        if clock is not None:
            raise RecordingError(
                f"{table.path}: has a clock, column '{clock.header}', and a sample period was given; "
                f"give no sample period, or ignore '{clock.header}'"
            )
        return mapping.sample_period_s
    undecided = any(item.column == "time_s" for item in match.undecided)
    found = {item.column for item in match.taken}
    stated = next(iter(table.stated_periods_s.values()), None)
    return stated if clock is None and not undecided and not needs_no_clock(found) else None


def _notes(
    table: SourceTable, mapping: ImportMapping, period_s: float | None, row_clock: bool, clock: Clock | None
) -> tuple[str, ...]:
    if clock is not None and clock.words:
        return (*table.notes, f"'{clock.header}': {clock.words}")
    if period_s is None:
        return table.notes
    if row_clock:
        return (*table.notes, "no clock, and none is needed: time_s numbers the rows, clock = row numbers")
    source = "as given" if mapping.sample_period_s is not None else "as the file states"
    return (*table.notes, f"time_s is counted: a row every {period_s:g} s, {source}")


def _problem(plan: ImportPlan, headers: Sequence[str]) -> str:
    """Return the first reason why a table cannot be read, or ""."""
    if plan.match.undecided:
        return _undecided(plan.match.undecided, plan.table.path)
    found = set(plan.names)
    path, listed = plan.table.path, ", ".join(f"'{header}'" for header in headers[:12])
    listed += ", ..." if len(headers) > 12 else ""
    if not found - _COUNTERS and (plan.match.ignored or not found):
        what = "only the time" if found else "nothing"
        unknown = (item.header for item in plan.match.ignored if item.reason == "name not known")
        example = next(unknown, "HEADER")
        return (
            f"{path}: {what} is usable of {listed}: map what was measured, with its unit, as wire_voltage_v={example}:V"
        )
    shunt_ohm = plan.metadata.get("shunt_resistance_ohm")
    if "shunt_voltage_v" in found and isinstance(shunt_ohm, int | float) and not 0.0 < shunt_ohm < np.inf:
        return (
            f"{path}: the voltage of a shunt of {shunt_ohm:g} ohm is no current: state its resistance "
            "(shunt_resistance_ohm), or leave its column out"
        )
    empty = next(
        (item.header for item in plan.match.ignored if isinstance(item, EmptyHeader) and item.column in _ELECTRICAL),
        None,
    )
    if empty is not None and not plan.is_electrical:
        return (
            f"{path}: '{empty}' has no number, and nothing else was measured of the wire's electricity: record it "
            "again, or leave its column out (ignore)"
        )
    differing = differing_periods(plan.table.stated_periods_s)
    if differing and plan.sample_period_s is not None and plan.mapping.sample_period_s is None:
        return f"{path}: its rows have no times, and it states {differing}: give the sample period that holds"
    if mixed := _rms_and_mean(plan.match):
        return f"{path}: {mixed}"
    if "time_s" in found or needs_no_clock(found):
        return ""
    return (
        f"{path}: no column is the time (there are {listed}): name one 'time [s]' or map it: time_s=HEADER:s, or give "
        f"the sample period, as '10 ms'; without a clock a printed loop needs {', '.join(BRANCH_TABLE)}, "
        f"isobars need {', '.join(ISOBAR_TABLE)}, pulses {', '.join(PULSE_TABLE)}"
    )


def _undecided(items: Sequence[UndecidedHeader], path: str) -> str:
    """Return what has to be decided first; of several columns without a unit all at once."""
    bare = [item for item in items if isinstance(item, HeaderWithoutUnit)]
    if len(bare) < 2 or items[0] is not bare[0]:
        return items[0].message
    headers = ", ".join(f"'{item.header}'" for item in bare)
    mapped = ", ".join(f"{item.column}={item.header}:{COLUMNS[item.column].unit}" for item in bare)
    example = f"{bare[0].header} [{COLUMNS[bare[0].column].unit}]"
    return f"{path}: columns {headers} have no unit: write it in the headers, as '{example}', or map them: {mapped}"


def _rms_and_mean(match: HeaderMatch) -> str:
    """Return what is wrong with the rms of a voltage with the mean of a current, or the other way round, or ""."""
    kinds: dict[str, str] = {}
    for item in match.taken:
        words = set(re.split(r"[^a-z]+", item.header.lower()))
        if item.column in ("wire_voltage_v", "wire_current_a", "shunt_voltage_v") and words & (_RMS | _MEAN):
            kinds.setdefault("rms" if words & _RMS else "mean", item.header)
    if len(kinds) < 2:
        return ""
    return (
        f"'{kinds['rms']}' is an rms and '{kinds['mean']}' a mean: in pulses the one over the other is no resistance, "
        "it is wrong by the root of the duty cycle; map two rms values or two means, or give columns of a constant "
        "current names without the two words"
    )
