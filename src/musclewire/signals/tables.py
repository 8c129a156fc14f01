"""A table as it is in a file, before its headers are matched to columns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from musclewire.arrays import FloatArray
from musclewire.signals.metadata import MetadataValue

__all__ = ["Table"]


class Table(Protocol):
    """Headers, rows of numbers and metadata, whatever the file format."""

    @property
    def layout(self) -> str:
        """How the file is built, in words: "CSV, separated by semicolons, decimal comma"."""

    @property
    def headers(self) -> tuple[str, ...]:
        """The headers, as written."""

    @property
    def metadata(self) -> Mapping[str, MetadataValue]:
        """The metadata in the file."""

    @property
    def row_count(self) -> int:
        """The number of rows, n_times."""

    def numbers(self, index: int) -> FloatArray:
        """Return a column as written, in its own unit.

        Parameters
        ----------
        index
            Which column, from 0.

        Returns
        -------
        Its numbers, shape (n_times,).

        Raises
        ------
        RecordingError
            If a cell holds no number; it names the line.
        """

    def place(self, row: int) -> str:
        """Return where a row is found in the file, in words: "line 12".

        Parameters
        ----------
        row
            Which row, from 0.

        Returns
        -------
        The words.
        """
