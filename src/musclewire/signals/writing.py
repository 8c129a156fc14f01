"""Writing columns with metadata to a file; the format follows from its suffix, and no format depends on recordings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.signals.metadata import MetadataValue
from musclewire.signals.whole_files import write_whole

__all__ = ["write_columns"]

Columns = Mapping[str, FloatArray]
Metadata = Mapping[str, MetadataValue]


def write_columns(columns: Columns, metadata: Metadata, path: Path) -> None:
    """Write columns, each (n_times,), and metadata in the format of the path's suffix, whole or not at all.

    Raises CallerError for another suffix or a folder that cannot be written to, MissingExtraError for .parquet without
    pyarrow.
    """
    fill = _format_of(path)
    write_whole(path, lambda temporary: fill(columns, metadata, temporary))


def _format_of(path: Path) -> Callable[[Columns, Metadata, Path], None]:
    # Imported here: h5py and pyarrow take longer to load than everything else in this room.
    suffix = path.suffix.lower()
    if suffix in {".h5", ".hdf5"}:
        from musclewire.signals.hdf5 import fill_hdf5

        return fill_hdf5
    if suffix == ".csv":
        from musclewire.signals.text_tables import fill_csv

        return fill_csv
    if suffix == ".parquet":
        from musclewire.signals.parquet import fill_parquet

        return fill_parquet
    raise CallerError(f"{path}: cannot save as '{suffix}'; end the name in .h5, .hdf5, .csv or .parquet")
