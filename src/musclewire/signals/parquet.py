"""Tables in Parquet files. Needs the extra ``parquet`` (pyarrow)."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import MissingExtraError, RecordingError
from musclewire.signals.columns import COLUMNS
from musclewire.signals.metadata import MetadataValue
from musclewire.signals.source_table import BLOCK_ROWS, Block, Cells, SourceColumn

__all__ = ["ParquetTable", "read_parquet_table", "fill_parquet", "fill_parquet_blocks"]

# Our files keep the metadata under this key of the schema, as JSON.
_KEY = b"musclewire-recording"


@dataclass(frozen=True)
class ParquetTable:
    """A Parquet file, whose rows come from it in blocks."""

    path: str
    file: Any
    columns: tuple[SourceColumn, ...]
    metadata: Mapping[str, MetadataValue]
    layout: str = "Parquet"
    sample_period_s: float | None = None
    notes: tuple[str, ...] = ()

    def blocks(self, indices: Sequence[int]) -> Iterator[Block]:
        """Return the rows of some columns, block after block. Raises RecordingError if a column holds no numbers."""
        import pyarrow as pa

        names = [self.file.schema_arrow.names[index] for index in indices]
        first = 1
        try:
            for batch in self.file.iter_batches(BLOCK_ROWS, columns=names):
                columns = zip(names, indices, strict=True)
                yield Block(tuple(self._cells(batch.column(name), index) for name, index in columns), _place(first))
                first += batch.num_rows
        except (OSError, pa.ArrowException) as problem:
            reason = _first_line(problem)
            raise RecordingError(f"{self.path}: cannot be read as Parquet ({reason}); use another copy") from None

    def _cells(self, column: Any, index: int) -> Cells:
        """Return a column's cells; NaN for a null. Raises RecordingError if it holds neither numbers nor text."""
        import pyarrow as pa

        kind = column.type
        if self.columns[index].is_text:
            return [value or "" for value in column.to_pylist()]
        if pa.types.is_boolean(kind):
            column = column.cast(pa.int8())
        elif not (pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind)):
            where = f"column '{self.columns[index].header}'"
            raise RecordingError(f"{self.path}: {where} holds {kind}, not numbers; write it as float64")
        return np.asarray(column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False), dtype=np.float64)


def read_parquet_table(path: Path) -> ParquetTable:
    """Return the table in a Parquet file. Raises RecordingError for another file, MissingExtraError without pyarrow."""
    _, parquet = _pyarrow()
    import pyarrow as pa

    try:
        # One file, not a folder of them: a single-file reader does not guess columns from the path.
        file = parquet.ParquetFile(path)
    except (OSError, pa.ArrowException) as problem:
        raise RecordingError(f"{path}: cannot be read as Parquet ({_first_line(problem)}); use another copy") from None
    schema = file.schema_arrow
    columns = tuple(SourceColumn(" ".join(one.name.split()), None, pa.types.is_string(one.type)) for one in schema)
    return ParquetTable(str(path), file, columns, _metadata(schema.metadata or {}, path))


def fill_parquet(columns: Mapping[str, FloatArray], metadata: Mapping[str, MetadataValue], path: Path) -> None:
    """Write columns to ``path`` with our names, units as field metadata, and the metadata as JSON."""
    fill_parquet_blocks(tuple(columns), [tuple(columns.values())], metadata, path)


def fill_parquet_blocks(
    names: Sequence[str],
    blocks: Iterable[tuple[FloatArray, ...]],
    metadata: Mapping[str, MetadataValue],
    path: Path,
) -> None:
    """Write blocks of columns to ``path``, as ``fill_parquet`` does."""
    pa, parquet = _pyarrow()
    fields = [pa.field(name, pa.float64(), nullable=False, metadata={"unit": COLUMNS[name].unit}) for name in names]
    document = json.dumps({"format_version": 1, "metadata": dict(metadata)})
    schema = pa.schema(fields, metadata={_KEY: document.encode()})
    with parquet.ParquetWriter(path, schema) as writer:
        for block in blocks:
            writer.write_table(pa.Table.from_arrays([pa.array(values) for values in block], schema=schema))


def _place(first: int) -> Callable[[int], str]:
    return lambda row: f"row {first + row}"


def _first_line(problem: BaseException) -> str:
    return (str(problem).splitlines() or [""])[0]


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
