"""The journal of a search: where each descent ended, so that an interrupted search continues from there."""

from __future__ import annotations

import json
import os
from pathlib import Path

from musclewire.errors import CallerError


class SearchJournal:
    """A text file with one line of numbers for each descent, after a first line that identifies the search."""

    def __init__(self, path: Path, fingerprint: str) -> None:
        """Open or create a journal. Raises CallerError for a file that belongs to another search."""
        self._path = path
        self._remembered: list[list[float]] = []
        self._position = 0
        try:
            if path.exists():
                self._remembered = read_journal(path, fingerprint)
            lines = [json.dumps({"search": fingerprint}), *(json.dumps(numbers) for numbers in self._remembered)]
            path.write_text("\n".join(lines) + "\n", "utf-8")
        except OSError as problem:
            raise CallerError(f"{path}: cannot be written: {problem.strerror or problem}; check the folder") from None

    @property
    def remembered(self) -> int:
        """Number of descents of an earlier run."""
        return len(self._remembered)

    def next(self) -> list[float] | None:
        """Return the numbers of the next descent, None after the last one of the earlier run."""
        if self._position >= len(self._remembered):
            return None
        self._position += 1
        return self._remembered[self._position - 1]

    def write(self, numbers: list[float]) -> None:
        """Add a descent; it is on the disk when this returns."""
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps([float(number) for number in numbers]) + "\n")
            file.flush()
            os.fsync(file.fileno())

    def remove(self) -> None:
        """Delete the journal of a completed search."""
        self._path.unlink(missing_ok=True)


def read_journal(path: Path, fingerprint: str) -> list[list[float]]:
    """Return the lines of a journal; an incomplete last line is dropped."""
    try:
        lines = path.read_text("utf-8").splitlines()
        belongs = json.loads(lines[0])["search"] == fingerprint
    except (IndexError, KeyError, TypeError, UnicodeDecodeError, json.JSONDecodeError):
        raise CallerError(f"{path} is not the journal of a search: give another output, or move it away") from None
    if not belongs:
        raise CallerError(
            f"{path} belongs to a search with other recordings, settings or another version: finish that one, or "
            "delete the file"
        )
    found: list[list[float]] = []
    for line in lines[1:]:
        try:
            found.append([float(number) for number in json.loads(line)])
        except json.JSONDecodeError:
            break
    return found
