"""Recordings as Parquet files, which lab_files/parquet_table.py reads. Needs the extra ``parquet`` (pyarrow)."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from musclewire.arrays import FloatArray
from musclewire.errors import MissingExtraError
from musclewire.extras.lab_files._parquet_table import PARQUET_KEY
from musclewire.signals import COLUMNS, MetadataValue


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
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        raise MissingExtraError("a Parquet file", "parquet") from None
    return pa, parquet
