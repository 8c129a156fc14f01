"""Writing columns with metadata to a file; the format follows from its suffix, and no format depends on recordings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.signals.metadata import MetadataValue
from musclewire.signals.whole_files import write_whole

__all__ = ["require_streamable", "write_blocks", "write_columns"]

Columns = Mapping[str, FloatArray]
Metadata = Mapping[str, MetadataValue]
Blocks = Iterable[tuple[FloatArray, ...]]


def write_columns(columns: Columns, metadata: Metadata, path: Path, matlab_version: str | None = None) -> None:
    """Write columns, each (n_times,), and metadata in the format of the path's suffix, whole or not at all.

    ``matlab_version`` is that of a .mat file; None is 5, or 7.3 if 5 cannot hold it. Raises CallerError for another
    suffix or version or a folder that cannot be written to, MissingExtraError for .parquet without
    pyarrow.
    """
    fill = _format_of(path, matlab_version)
    write_whole(path, lambda temporary: fill(columns, metadata, temporary))


def write_blocks(
    names: Sequence[str], blocks: Blocks, metadata: Metadata, path: Path, matlab_version: str | None = None
) -> None:
    """Write a recording block after block, whole or not at all, in the format of the path's suffix.

    Each block holds a column of shape (n_rows,) for each of ``names``. A format that cannot grow is written
    at once, from memory. Raises what ``write_columns`` raises, and what the blocks raise.
    """
    fill = _block_format_of(path)
    if fill is not None:
        write_whole(path, lambda temporary: fill(names, blocks, metadata, temporary))
        return
    collected = [np.concatenate(parts) for parts in zip(*blocks, strict=True)]
    write_columns(dict(zip(names, collected, strict=True)), metadata, path, matlab_version)


def require_streamable(path: Path, matlab_version: str | None = None) -> None:
    """Raise CallerError unless a recording can be written in the format of a path's suffix."""
    _format_of(path, matlab_version)


def _block_format_of(path: Path) -> Callable[[Sequence[str], Blocks, Metadata, Path], None] | None:
    """Return what writes a format block after block, or None."""
    suffix = path.suffix.lower()
    if suffix in {".h5", ".hdf5"}:
        from musclewire.signals.hdf5_blocks import fill_hdf5_blocks

        return fill_hdf5_blocks
    if suffix == ".csv":
        from musclewire.signals.text_tables import fill_csv_blocks

        return fill_csv_blocks
    if suffix == ".parquet":
        from musclewire.signals.parquet import fill_parquet_blocks

        return fill_parquet_blocks
    return None


def _format_of(path: Path, matlab_version: str | None) -> Callable[[Columns, Metadata, Path], None]:
    # Imported here: h5py and pyarrow take longer to load than everything else in this room.
    suffix = path.suffix.lower()
    if matlab_version is not None and suffix != ".mat":
        raise CallerError(f"{path}: a MATLAB version is that of a .mat file; end the name in .mat or leave it out")
    if suffix in {".h5", ".hdf5"}:
        from musclewire.signals.hdf5 import fill_hdf5

        return fill_hdf5
    if suffix == ".csv":
        from musclewire.signals.text_tables import fill_csv

        return fill_csv
    if suffix == ".parquet":
        from musclewire.signals.parquet import fill_parquet

        return fill_parquet
    if suffix == ".mat":
        from musclewire.signals.lab_files.matlab_export import fill_of_version

        return fill_of_version(matlab_version)
    if suffix == ".xlsx":
        from musclewire.signals.lab_files.excel_export import fill_excel

        return fill_excel
    raise CallerError(f"{path}: cannot save as '{suffix}'; end the name in .h5, .hdf5, .csv, .parquet, .mat or .xlsx")
