"""Tables in Parquet files. Needs the extra ``parquet`` (pyarrow)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import MissingExtraError, RecordingError
from musclewire.signals.columns import COLUMNS
from musclewire.signals.metadata import MetadataValue

__all__ = ["ParquetTable", "read_parquet_table", "fill_parquet"]

# Our files keep the metadata under this key of the schema, as JSON.
_KEY = b"musclewire-recording"


@dataclass(frozen=True)
class ParquetTable:
    """A Parquet table, its columns still as Arrow arrays of any type."""

    path: str
    arrow: Any
    metadata: Mapping[str, MetadataValue]

    @property
    def layout(self) -> str:
        """How the file is built, in words."""
        return "Parquet"

    @property
    def headers(self) -> tuple[str, ...]:
        """The names of the columns, as written; a line break in one becomes a space."""
        return tuple(" ".join(name.split()) for name in self.arrow.schema.names)

    @property
    def row_count(self) -> int:
        """The number of rows, n_times."""
        return int(self.arrow.num_rows)

    def place(self, row: int) -> str:
        """Return where row ``row`` (from 0) is in the file."""
        return f"row {row + 1}"

    def numbers(self, index: int) -> FloatArray:
        """Return a column, shape (n_times,). Raises RecordingError if a cell is blank or holds no number."""
        import pyarrow as pa

        column = self.arrow.column(index)
        where = f"column '{self.headers[index]}'"
        kind = column.type
        if pa.types.is_boolean(kind):
            column = column.cast(pa.int8())
        elif not (pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind)):
            raise RecordingError(f"{self.path}: {where} holds {kind}, not numbers; write it as float64")
        if column.null_count:
            row = int(np.argmax(column.is_null().to_numpy()))
            message = "the cell is blank; correct it or remove the row"
            raise RecordingError(f"{self.path}: {self.place(row)}, {where}: {message}")
        return np.asarray(column.cast(pa.float64(), safe=False).to_numpy(), dtype=np.float64)


def read_parquet_table(path: Path) -> ParquetTable:
    """Return the table in a Parquet file. Raises RecordingError for another file, MissingExtraError without pyarrow."""
    _, parquet = _pyarrow()
    import pyarrow as pa

    try:
        # One file, not a folder of them: a single-file reader does not guess columns from the path.
        arrow = parquet.ParquetFile(path).read()
    except (OSError, pa.ArrowException) as problem:
        reason = (str(problem).splitlines() or [""])[0]
        raise RecordingError(f"{path}: cannot be read as Parquet ({reason}); use another copy") from None
    return ParquetTable(str(path), arrow, _metadata(arrow.schema.metadata or {}, path))


def fill_parquet(columns: Mapping[str, FloatArray], metadata: Mapping[str, MetadataValue], path: Path) -> None:
    """Write columns to ``path`` with our names, units as field metadata, and the metadata as JSON."""
    pa, parquet = _pyarrow()
    fields = [pa.field(name, pa.float64(), nullable=False, metadata={"unit": COLUMNS[name].unit}) for name in columns]
    document = json.dumps({"format_version": 1, "metadata": dict(metadata)})
    schema = pa.schema(fields, metadata={_KEY: document.encode()})
    arrays = [pa.array(values) for values in columns.values()]
    parquet.write_table(pa.Table.from_arrays(arrays, schema=schema), path)


def _metadata(schema_metadata: Mapping[bytes, bytes], path: Path) -> dict[str, MetadataValue]:
    if _KEY not in schema_metadata:
        return {}
    try:
        metadata = json.loads(schema_metadata[_KEY])["metadata"]
        return {str(key): value for key, value in metadata.items()}
    except (ValueError, KeyError, TypeError, AttributeError):
        raise RecordingError(f"{path}: its musclewire metadata are damaged; use another copy") from None


def _pyarrow() -> tuple[Any, Any]:
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        raise MissingExtraError("Parquet files", "parquet") from None
    return pa, parquet
