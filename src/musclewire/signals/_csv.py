"""Writing CSV: metadata as comments, our names, every number to the last bit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from musclewire.arrays import FloatArray
from musclewire.signals._metadata import MetadataValue, value_to_text


def fill_csv(columns: Mapping[str, FloatArray], metadata: Mapping[str, MetadataValue], path: Path) -> None:
    """Write columns to ``path``: metadata as comments, our names, every number to the last bit."""
    fill_csv_blocks(tuple(columns), [tuple(columns.values())], metadata, path)


def fill_csv_blocks(
    names: Sequence[str],
    blocks: Iterable[tuple[FloatArray, ...]],
    metadata: Mapping[str, MetadataValue],
    path: Path,
) -> None:
    """Write blocks of columns to ``path``, as ``fill_csv`` does."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        for key, value in metadata.items():
            file.write(f"# {key} = {value_to_text(key, value)}\n")
        file.write(",".join(names) + "\n")
        for block in blocks:
            numbers = [values.tolist() for values in block]
            file.writelines(",".join(map(repr, row)) + "\n" for row in zip(*numbers, strict=True))
