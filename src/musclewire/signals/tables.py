"""A table as it stands in a file, before anybody has said what its headers mean."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

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
        """What the file says about itself."""

    @property
    def row_count(self) -> int:
        """The number of rows, n_times."""

    def numbers(self, index: int) -> NDArray[np.float64]:
        """Return the column ``index`` as written, shape (n_times,); RecordingError for what is no number."""

    def place(self, row: int) -> str:
        """Say where row ``row`` (from 0) is found: "line 12"."""
