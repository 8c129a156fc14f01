"""A table of another program: its columns as they are in the file, before they are matched to ours.

Every reader of a format returns one, and ``_headers`` matches its columns whatever the format.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import NamedTuple, Protocol

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.signals import MetadataValue

# Rows that are handed over together: enough to be fast, and few enough to take little memory.
BLOCK_ROWS = 65_536

# Under which keys programs state the time between rows, or how many there are in a second, of a channel or of all.
_PERIODS = (
    r"sampl\w*_(?:interval|period|time|time_step)|time_step|dt|ts|delta_[tx]|abtastintervall"
    r"|increment|tinc|h_?resolution|x_?incr\w*"
)
_RATES = r"sampl\w*_(?:rate|frequency|freq)|samplerate|fs|abtastrate|abtastfrequenz|messrate"
_CHANNEL = r"(?:second|(?:ch|chan|channel|kanal)_?[a-z0-9]{1,3})"
_OF_SAMPLES = re.compile(rf"(?:{_CHANNEL}_)?(?:({_PERIODS})|({_RATES}))(?:_{_CHANNEL})?(_s|_hz)?")
_OF_A_SCOPE = re.compile(r"increment|tinc|h_?resolution|x_?incr\w*|samplerate")
# These may as well be those of the drive: they count where nothing else is stated.
_OF_ANYTHING = re.compile(r"(?:(interval|period|time)|(rate|frequency|freq))(_s|_hz)?")
# Stated times between rows that differ by more are different ones.
_SAME_PERIOD = 1e-3
# Rows are as far apart as stated within this part: clocks drift.
_AS_STATED = 0.05

# The cells of one column: numbers (NaN in an empty cell), or text as it is written.
Cells = FloatArray | list[str]


class RowBlock(NamedTuple):
    """Some consecutive rows of a table."""

    values: tuple[Cells, ...]  # of each column that was asked for, in this order, all of the same length
    place: Callable[[int], str]  # where a row is in the file, in words ("line 12"), by its number in this block from 0
    row_count: int = 0  # for who asks for no column; 0 of a reader that does not say
    others: tuple[tuple[int, str], ...] = ()  # lines between its rows that are none, each with its number
    is_end: bool = False  # the file ends with these lines,
    is_cut: bool = False  # because it is cut off in the last of them
    words: Mapping[tuple[int, int], str] = MappingProxyType({})  # in place of a number, by row and column
    again: tuple[int, ...] = ()  # the rows above which the headers stand once more


@dataclass(frozen=True)
class SourceColumn:
    """A column of a source table.

    Parameters
    ----------
    header
        As written in the file.
    unit
        The unit's text if the file states it apart from the header, "" for a number without one; None if the file
        does not, and the header may carry it.
    is_text
        Whether the cells are text; else they are float64.
    is_empty
        Whether no cell of the first rows holds anything.
    """

    header: str
    unit: str | None = None
    is_text: bool = False
    is_empty: bool = False


class SourceTable(Protocol):
    """Columns and rows of a file, whatever its format."""

    @property
    def path(self) -> str:
        """The file, as messages name it."""

    @property
    def layout(self) -> str:
        """How the file is built, in words: "text, separated by semicolons, decimal comma"."""

    @property
    def columns(self) -> tuple[SourceColumn, ...]:
        """The columns."""

    @property
    def metadata(self) -> Mapping[str, MetadataValue]:
        """The metadata in the file."""

    @property
    def stated_periods_s(self) -> Mapping[str, float]:
        """Times between two rows [s] that the file states apart from any column, by where it does."""

    @property
    def notes(self) -> tuple[str, ...]:
        """What reading left out or changed, a sentence each."""

    def blocks(self, indices: Sequence[int]) -> Iterator[RowBlock]:
        """Return the rows of some columns, block after block from the first row on; each call begins again.

        Parameters
        ----------
        indices
            Which columns, from 0.

        Returns
        -------
        Blocks of consecutive rows.

        Raises
        ------
        RecordingError
            If the file is damaged there, or a cell of a column of numbers holds text; it names the place.
        """


@dataclass(frozen=True, eq=False)
class TableInMemory:
    """A table that was read as a whole.

    Parameters
    ----------
    path
        The file, as messages name it.
    layout
        How the file is built, in words.
    columns
        The columns.
    values
        Their cells, all of the same length: arrays of float64 with NaN for an empty cell, or lists of text.
    metadata
        The metadata in the file; empty by default, for a file without any.
    stated_periods_s
        Times between two rows [s] that the file states apart from any column, by where it does; none by default.
    notes
        What reading left out or changed; nothing by default.
    row_word
        What messages call a row: "row" by default, "line" in text.
    first_row
        Number of the first row in messages; 1 by default.
    """

    path: str
    layout: str
    columns: tuple[SourceColumn, ...]
    values: tuple[Cells, ...]
    metadata: Mapping[str, MetadataValue] = field(default_factory=dict)
    stated_periods_s: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    row_word: str = "row"
    first_row: int = 1

    def blocks(self, indices: Sequence[int]) -> Iterator[RowBlock]:
        """Return the rows of some columns as one block.

        Parameters
        ----------
        indices
            Which columns, from 0.

        Returns
        -------
        The only block.
        """
        yield RowBlock(
            tuple(self.values[index] for index in indices),
            lambda row: f"{self.row_word} {self.first_row + row}",
            len(self.values[0]) if self.values else 0,
        )


def rows_in(table: SourceTable) -> int:
    """Return how many rows a file has, whatever is in them."""
    return sum(block.row_count for block in table.blocks([]))


def head_of(table: SourceTable, index: int) -> Cells:
    """Return the first cells of a column, none if the table is empty."""
    first = next(iter(table.blocks([index])), None)
    return [] if first is None else first.values[0]


def heads_of(table: SourceTable) -> list[Cells]:
    """Return the first cells of each column; nothing of one that is damaged there."""
    indices = range(len(table.columns))
    try:
        first = next(iter(table.blocks(indices)), None)
    except RecordingError:
        return [_head_or_nothing(table, index) for index in indices]
    return [[] for _ in indices] if first is None or first.is_end else list(first.values)


def _head_or_nothing(table: SourceTable, index: int) -> Cells:
    try:
        return head_of(table, index)
    except RecordingError:
        return np.zeros(0)


# Under which keys instruments state when the first sample was, relative to a trigger.
_STARTS = re.compile(r"(?:start|t0|x0|t_?start|h_?offset|x_?zero|time_offset)(?:_s)?")


def stated_start_s(metadata: Mapping[str, MetadataValue]) -> float:
    """Return the time of the first sample [s] that a file states of counted rows, 0.0 if it does not."""
    numbers = (value for key, value in metadata.items() if _STARTS.fullmatch(key))
    return next((float(value) for value in numbers if isinstance(value, int | float)), 0.0)


def stated_periods_s(metadata: Mapping[str, MetadataValue], unit_stated: bool) -> dict[str, float]:
    """Return the times between two rows [s] that the metadata of a file state, of all channels or of each, by key.

    With ``unit_stated`` only keys that end in a unit count; MATLAB's ``Fs`` and ``dt`` are in Hz and s without one.
    """
    found: dict[str, float] = {}
    for sign in (_OF_SAMPLES, _OF_ANYTHING):
        for key, value in metadata.items():
            match = sign.fullmatch(key)
            if match is None or isinstance(value, bool) or not isinstance(value, float | int):
                continue
            is_period, unit = match[1] is not None, match[3]
            # What a scope prints of its own axis is in seconds, as a rate is in hertz.
            fits = unit == ("_s" if is_period else "_hz") or (
                unit is None and (not unit_stated or _OF_A_SCOPE.fullmatch(key))
            )
            if fits and 0.0 < value < float("inf") and 1.0 / value < float("inf"):
                found[key] = float(value) if is_period else 1.0 / float(value)
        if found:
            return found
    return found


def differing_periods(periods_s: Mapping[str, float]) -> str:
    """Return in words which times between rows a file states if they differ, else ""."""
    if not periods_s or max(periods_s.values()) <= (1.0 + _SAME_PERIOD) * min(periods_s.values()):
        return ""
    return ", ".join(f"{key} a row every {period_s:g} s" for key, period_s in periods_s.items())


def doubted_clock(periods_s: Mapping[str, float], time_s: FloatArray) -> str:
    """Return in words that rows are not as far apart as the file states of its samples, "" if they are."""
    steps_s = np.diff(time_s)
    for key, period_s in periods_s.items():
        if steps_s.size and _OF_SAMPLES.fullmatch(key):
            # Of times that are rounded the mean is as stated, of times with gaps the median.
            usual = (float(np.median(steps_s)), float(steps_s.mean()))
            if all(abs(step_s / period_s - 1.0) > _AS_STATED for step_s in usual):
                return (
                    f"{key} states a row every {period_s:g} s, by the column of times there is one every {usual[0]:g} "
                    "s: check the unit of the times"
                )
    return ""
