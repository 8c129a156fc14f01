"""Files of a session by name: nothing outside its folder can be named, and nothing in it that leads out."""

from __future__ import annotations

import re
import stat
from pathlib import Path

from musclewire.errors import CallerError
from musclewire.extras.live._server.http_messages import RecordingSummary

RECORDINGS, MODELS = (".h5",), (".json",)
# Letters and digits of ASCII first, then also blank, dot, hyphen and underscore: no separator, no drive, no "..".
NAME = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9 _-]|\.(?!\.)){0,99}")
MAX_LISTED = 500


def named_file(folder: Path, name: str, suffixes: tuple[str, ...]) -> Path:
    """Return the path of a file of a session. CallerError for anything else, with the same words whatever it is."""
    if NAME.fullmatch(name) and name.endswith(suffixes):
        path = folder / name
        if is_inside(path, folder):
            return path
    raise CallerError(
        f"no file of that name with {' or '.join(suffixes)} in the session's folder: choose one that is listed"
    )


def is_inside(path: Path, folder: Path) -> bool:
    """Return whether a path is a regular file that lies in a folder itself; a link that leads elsewhere is not."""
    try:
        real = path.resolve(strict=True)
        return real.parent == folder.resolve(strict=True) and stat.S_ISREG(real.stat().st_mode)
    except (OSError, RuntimeError):
        return False


def session_files(folder: Path, suffixes: tuple[str, ...]) -> list[RecordingSummary]:
    """Return the files of a session that can be named, the newest first."""
    found = []
    for path in folder.iterdir() if folder.is_dir() else ():
        if NAME.fullmatch(path.name) and path.name.endswith(suffixes) and is_inside(path, folder):
            status = path.stat()
            found.append(RecordingSummary(name=path.name, bytes=status.st_size, modified_s=status.st_mtime))
    return sorted(found, key=lambda one: -one.modified_s)[:MAX_LISTED]
