"""Parquet files, ours and those of pandas, Arrow and others, read in batches. Needs the extra ``parquet`` (pyarrow)."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError, argument, require_extra
from musclewire.extras.lab_files._file_table import FileTable, check_limits, damage_reported, metadata_of, one_line
from musclewire.files import BLOCK_ROWS, Cells, RowBlock, SourceColumn
from musclewire.signals import COLUMNS, FileWriter, Fill, MetadataValue

# Our files keep the metadata under this key of the schema, as JSON.
PARQUET_KEY = b"musclewire-recording"

_UNIT_KEYS = ("unit", "units", "uom")


class ParquetTable(FileTable):
    """The columns of a Parquet file that hold numbers, times or text."""

    def blocks(self, indices: Sequence[int]) -> Iterator[RowBlock]:
        """Return the rows of some columns, batch after batch; each call begins again."""
        row = 1
        with damage_reported(self.path, self.layout), _parquet_file(Path(self.path)) as file:
            known = file.schema_arrow.names
            if len(set(known)) < len(known):
                raise RecordingError(f"{self.path}: two columns have one name; give each its own")
            names = [name for name in known if _column(file.schema_arrow.field(name))]
            names = [names[index] for index in indices]
            batches = file.iter_batches(BLOCK_ROWS, columns=names, use_threads=False)
            while (batch := next(batches, None)) is not None:
                # The reader keeps the order of the file, whatever the order of the names.
                values = tuple(
                    self._cells(batch.column(name), index) for name, index in zip(names, indices, strict=True)
                )
                yield RowBlock(values, lambda number, first=row: f"row {first + number}", batch.num_rows)  # type: ignore[misc]
                row += batch.num_rows

    def _cells(self, column: Any, index: int) -> Cells:
        """Return the cells of a batch: NaN or "" where one is null, times as text in ISO 8601."""
        import pyarrow as pa

        kind = column.type
        if pa.types.is_timestamp(kind) or pa.types.is_date(kind):
            # Through a number, which leaves out the time zone: all times are in the same one.
            column = column.cast(pa.timestamp("us"), safe=False).cast(pa.int64()).cast(pa.timestamp("us"))
        if self.columns[index].is_text:
            return [one_line(value) if value is not None else "" for value in column.cast(pa.string()).to_pylist()]
        if pa.types.is_duration(kind):
            column = column.cast(pa.duration("ns"), safe=False).cast(pa.int64())
            return np.asarray(column.to_numpy(zero_copy_only=False), dtype=np.float64) * 1e-9
        column = column.cast(pa.int8()) if pa.types.is_boolean(kind) else column
        return np.asarray(column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False), dtype=np.float64)


def read_parquet_table(path: Path, group: str | None = None) -> ParquetTable:
    """Return the table in a Parquet file; nested columns are left out with a note.

    Units are those of the fields' metadata; the metadata are ours, or the texts of the schema and pandas' ``attrs``.
    Raises RecordingError for another file, MissingExtraError without pyarrow.
    """
    if group is not None:
        raise RecordingError(f"{path}: a Parquet file holds one table; leave " + argument("group") + " out")
    with damage_reported(path, "Parquet"), _parquet_file(path) as file:
        schema, rows = file.schema_arrow, file.metadata.num_rows
        check_limits(path, cells=rows * len(schema))
        metadata = _metadata(schema.metadata or {}, path)
        columns = tuple(column for each in schema if (column := _column(each)))
        left_out = [one_line(each.name) for each in schema if _column(each) is None]
    notes = tuple(f"column '{name}' was left out: it holds neither numbers nor text" for name in left_out)
    return ParquetTable("", columns, rows, metadata, notes, str(path), "Parquet")


def _parquet_file(path: Path) -> Any:
    require_extra("a Parquet file", "parquet")
    from pyarrow import parquet

    # One file, not a folder of them, and without reading ahead.
    return closing(parquet.ParquetFile(path, pre_buffer=False))


def _column(field: Any) -> SourceColumn | None:
    """Return what a field holds, None for nested ones and bytes."""
    import pyarrow as pa

    kind, types = field.type, pa.types
    kind = kind.value_type if types.is_dictionary(kind) else kind
    name = one_line(field.name) or "unnamed"
    if types.is_duration(kind):
        return SourceColumn(name, "s")
    if types.is_timestamp(kind) or types.is_date(kind):
        return SourceColumn(name, is_text=True)
    if types.is_string(kind) or types.is_large_string(kind) or types.is_string_view(kind):
        return SourceColumn(name, is_text=True)
    if types.is_integer(kind) or types.is_floating(kind) or types.is_decimal(kind) or types.is_boolean(kind):
        return SourceColumn(name, _unit(field.metadata or {}))
    return None


def _unit(metadata: Mapping[bytes, bytes]) -> str | None:
    texts = {key.decode("utf-8", "replace").lower(): value for key, value in metadata.items()}
    return next((texts[key].decode("utf-8", "replace") for key in _UNIT_KEYS if key in texts), None)


def _metadata(schema_metadata: Mapping[bytes, bytes], path: Path) -> dict[str, MetadataValue]:
    if PARQUET_KEY in schema_metadata:
        try:
            metadata = json.loads(schema_metadata[PARQUET_KEY])["metadata"]
            return {str(key): value for key, value in metadata.items()}
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            raise RecordingError(f"{path}: its musclewire metadata are damaged; use another copy") from None
    plain = {key.decode("utf-8", "replace"): value for key, value in schema_metadata.items()}
    attrs = _pandas_attrs(plain.pop("PANDAS_ATTRS", b"{}"))
    own = {"ARROW:schema", "pandas"}
    return metadata_of({**attrs, **{key: value for key, value in plain.items() if key not in own}})


def _pandas_attrs(text: bytes) -> dict[str, object]:
    try:
        return {str(key): value for key, value in json.loads(text).items()}
    except (ValueError, AttributeError, RecursionError):
        return {}


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
    schema = pa.schema(fields, metadata={PARQUET_KEY: document.encode()})
    with parquet.ParquetWriter(path, schema) as writer:
        for block in blocks:
            writer.write_table(pa.Table.from_arrays([pa.array(values) for values in block], schema=schema))


def _pyarrow() -> tuple[Any, Any]:
    require_extra("a Parquet file", "parquet")
    import pyarrow as pa
    from pyarrow import parquet

    return pa, parquet


def _fill(_version: str | None) -> Fill:
    require_extra("a Parquet file", "parquet")
    return fill_parquet


WRITER = FileWriter(_fill, fill_parquet_blocks)
