"""A recording written to HDF5 block after block, for files that do not fit in memory."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.signals._columns import COLUMNS
from musclewire.signals._hdf5 import FORMAT, FORMAT_VERSION
from musclewire.signals._metadata import MetadataValue

_CHUNK_ROWS = 16_384


def fill_hdf5_blocks(
    names: Sequence[str],
    blocks: Iterable[tuple[FloatArray, ...]],
    metadata: Mapping[str, MetadataValue],
    path: Path,
) -> None:
    """Write blocks of columns to ``path`` directly; ``write_blocks`` makes sure that the file is complete."""
    import h5py

    rows = 0
    with h5py.File(path, "w") as file:
        for name in names:
            dataset = file.create_dataset(name, (0,), dtype="f8", maxshape=(None,), chunks=(_CHUNK_ROWS,))
            dataset.attrs["unit"] = COLUMNS[name].unit
        for block in blocks:
            stop = rows + block[0].size
            for name, values in zip(names, block, strict=True):
                file[name].resize((stop,))
                file[name][rows:stop] = values
            rows = stop
        file.attrs["format"] = FORMAT
        file.attrs["format_version"] = FORMAT_VERSION
        file.attrs["columns"] = ",".join(names)
        file.attrs.create("rows", rows, dtype=np.int64)
        for key, value in metadata.items():
            file.attrs[key] = h5py.Empty("f8") if value is None else value
