"""Writing columns with metadata to a file; the format follows from its suffix, and no format depends on recordings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.manifest import absent_part, loaded, offered
from musclewire.signals._metadata import MetadataValue
from musclewire.signals._whole_files import write_whole

Columns = Mapping[str, FloatArray]
Metadata = Mapping[str, MetadataValue]
Blocks = Iterable[tuple[FloatArray, ...]]


Fill = Callable[[Columns, Metadata, Path], None]


class FileWriter(NamedTuple):
    """What writes files of a suffix.

    Parameters
    ----------
    fill
        Takes a version of the format, None for the usual one; returns a function of columns, metadata and path.
    fill_blocks
        Takes names, blocks, metadata and path; None for a format that cannot grow.
    """

    fill: Callable[[str | None], Fill]
    fill_blocks: Callable[[Sequence[str], Blocks, Metadata, Path], None] | None = None


def require_format(path: Path, matlab_version: str | None = None) -> None:
    """Raise CallerError for a name under which no recording is written, MissingExtraError if an extra is missing."""
    _format_of(path, matlab_version)


def write_columns(columns: Columns, metadata: Metadata, path: Path, matlab_version: str | None = None) -> None:
    """Write columns, each (n_times,), and metadata in the format of the path's suffix, whole or not at all.

    Raises CallerError for another suffix or version or a folder that refuses it, MissingExtraError without an extra.
    """
    fill = _format_of(path, matlab_version)
    write_whole(path, lambda temporary: fill(columns, metadata, temporary))


def write_blocks(
    names: Sequence[str], blocks: Blocks, metadata: Metadata, path: Path, matlab_version: str | None = None
) -> None:
    """Write blocks, a column (n_rows,) for each of ``names``, whole or not at all, in the format of the path's suffix.

    A format that cannot grow is written at once, from memory. Raises what ``write_columns`` and the blocks raise.
    """
    fill = _block_format_of(path)
    if fill is not None:
        write_whole(path, lambda temporary: fill(names, blocks, metadata, temporary))
        return
    collected = [np.concatenate(parts) for parts in zip(*blocks, strict=True)]
    write_columns(dict(zip(names, collected, strict=True)), metadata, path, matlab_version)


def _block_format_of(path: Path) -> Callable[[Sequence[str], Blocks, Metadata, Path], None] | None:
    """Return what writes a format block after block, or None."""
    suffix = path.suffix.lower()
    if suffix in {".h5", ".hdf5"}:
        from musclewire.signals._hdf5 import fill_hdf5_blocks

        return fill_hdf5_blocks
    if suffix == ".csv":
        from musclewire.signals._csv import fill_csv_blocks

        return fill_csv_blocks
    writer = _offered_writer(path)
    return None if writer is None else writer.fill_blocks


def _format_of(path: Path, matlab_version: str | None) -> Fill:
    # Imported here: h5py and pyarrow take longer to load than everything else in this room.
    suffix = path.suffix.lower()
    if matlab_version is not None and suffix != ".mat":
        raise CallerError(f"{path}: a MATLAB version is that of a .mat file; end the name in .mat or leave it out")
    if suffix in {".h5", ".hdf5"}:
        from musclewire.signals._hdf5 import fill_hdf5

        return fill_hdf5
    if suffix == ".csv":
        from musclewire.signals._csv import fill_csv

        return fill_csv
    if (writer := _offered_writer(path)) is not None:
        return writer.fill(matlab_version)
    *others, last = [".h5", ".hdf5", ".csv", *offered("writers")]
    raise absent_part("suffixes", suffix) or CallerError(
        f"{path}: cannot save as '{suffix}'; end the name in {', '.join(others)} or {last}"
    )


def _offered_writer(path: Path) -> FileWriter | None:
    """Return what a part outside the core writes a suffix with, None if no part knows it."""
    place = offered("writers").get(path.suffix.lower())
    return None if place is None else loaded(place)
