"""Files that are written whole or not at all."""

from __future__ import annotations

import glob
import os
import secrets
from collections.abc import Callable
from pathlib import Path

from musclewire.errors import CallerError


def write_whole(path: Path, write: Callable[[Path], None]) -> None:
    """Call ``write`` on a temporary file next to ``path``, then rename it in one step.

    A reader finds the old file or the new one, never a part of it. Raises CallerError if the folder refuses it.
    """
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
    try:
        write(temporary)
        _to_disk(temporary)
        temporary.replace(path)
    except OSError as problem:
        raise CallerError(f"{path}: cannot be written: {problem.strerror or problem}; check the folder") from None
    finally:
        temporary.unlink(missing_ok=True)


def write_text_whole(path: Path, text: str) -> None:
    """Write a text as UTF-8, whole or not at all. Raises CallerError if the folder cannot be written to."""

    def write(temporary: Path) -> None:
        temporary.write_text(text, "utf-8")

    write_whole(path, write)


def _to_disk(path: Path) -> None:
    # Without this a power cut just after the rename can leave the new name with old, empty blocks.
    with path.open("rb+") as file:
        os.fsync(file.fileno())


def folder_to_disk(path: Path) -> None:
    """Bring the entry of a file in its folder to the disk, where folders can be opened; else the name may be lost."""
    try:
        folder = os.open(path.parent, os.O_RDONLY)
    except OSError:
        return
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def remove_parts(path: Path) -> None:
    """Remove what a process left that was killed while it wrote ``path``; only its one writer may call this."""
    for part in path.parent.glob(f".{glob.escape(path.name)}.*.part"):
        part.unlink(missing_ok=True)
