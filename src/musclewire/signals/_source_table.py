"""A table of another program: its columns as they are in the file, before they are matched to ours.

Every reader of a format returns one, and ``headers.py`` matches its columns whatever the format.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

from musclewire.arrays import FloatArray
from musclewire.signals._metadata import MetadataValue

# Rows that are handed over together: enough to be fast, and few enough to take little memory.
BLOCK_ROWS = 65_536

# Under which keys programs state the time between rows, or how many there are in a second.
_PERIOD = re.compile(r"((?:sampl\w*_)?(?:interval|period|time|time_step)|dt|ts|delta_[tx]|abtastintervall)(_s)?")
_RATE = re.compile(r"((?:sampl\w*_)?(?:rate|frequency|freq)|samplerate|fs|abtastrate|abtastfrequenz|messrate)(_hz)?")

# The cells of one column: numbers (NaN in an empty cell), or text as it is written.
Cells = FloatArray | list[str]


class RowBlock(NamedTuple):
    """Some consecutive rows of a table.

    Parameters
    ----------
    values
        The cells of each column that was asked for, in this order, all of the same length.
    place
        Where a row is in the file, in words ("line 12"), by its number in this block from 0.
    row_count
        How many rows the block has, for who asks for no column; 0 by default, of a reader that does not say.
    """

    values: tuple[Cells, ...]
    place: Callable[[int], str]
    row_count: int = 0


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
    def sample_period_s(self) -> float | None:
        """Time between two rows [s] if the file states it, as files do that have no column of time; else None."""

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
    sample_period_s
        Time between two rows [s], if the file states it apart from any column; None by default.
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
    sample_period_s: float | None = None
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


def stated_period_s(metadata: Mapping[str, MetadataValue], unit_stated: bool) -> float | None:
    """Return the time between two rows [s] that the metadata of a file state, or None.

    Parameters
    ----------
    metadata
        The metadata; those of a text file carry their unit at the end of the name.
    unit_stated
        Whether only keys with a unit count; MATLAB's ``Fs`` and ``dt`` are in Hz and s without one.

    Returns
    -------
    The period [s].
    """
    for key, value in metadata.items():
        if isinstance(value, bool) or not isinstance(value, float | int) or not 0.0 < value < float("inf"):
            continue
        period, rate = _PERIOD.fullmatch(key), _RATE.fullmatch(key)
        if period is not None and (period[2] or not unit_stated):
            return float(value)
        if rate is not None and (rate[2] or not unit_stated) and 1.0 / value < float("inf"):
            return 1.0 / float(value)
    return None
