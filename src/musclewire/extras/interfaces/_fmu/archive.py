"""An FMU as a file: its texts and its binary in a zip archive that has the same bytes each time."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path

from musclewire.errors import CallerError
from musclewire.signals import write_whole

# The earliest time that a zip archive can hold: with the day of the export in it no two exports would be alike.
NO_TIME = (1980, 1, 1, 0, 0, 0)


def archive_bytes(contents: Mapping[str, bytes]) -> bytes:
    """Return the bytes of a zip archive with these files, by their path in it."""
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(contents):
            entry = zipfile.ZipInfo(path, NO_TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if path.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, contents[path])
    return written.getvalue()


def write_archive(path: Path, content: bytes, *, overwrite: bool) -> None:
    """Write an FMU whole or not at all; its folder is made if need be.

    Raises CallerError if there is another file of this name and it is not to be replaced, or the folder cannot be
    written to.
    """
    if not overwrite and path.exists() and path.read_bytes() != content:
        raise CallerError(
            f"{path} is another FMU: choose another folder or name, or allow replacing (--overwrite, overwrite=True)"
        )
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CallerError(f"cannot make the folder {path.parent}: {error.strerror or error}") from error

    def write(temporary: Path) -> None:
        temporary.write_bytes(content)

    write_whole(path, write)
