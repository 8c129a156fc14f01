"""The folder of a study: its finished chunks as files, written whole or not at all, and which study they belong to.

study.json              the study and its fingerprint
chunks/0-200.npz        what the runs 0 to 199 yielded
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, overload
from zipfile import BadZipFile

import numpy as np

from musclewire.errors import CallerError, argument
from musclewire.extras.studies._design import StudyDesign
from musclewire.extras.studies._evaluation import Chunk, ChunkResult
from musclewire.extras.studies._plan import Plan, engine
from musclewire.extras.studies._run_kind import Overheated
from musclewire.signals import write_text_whole, write_whole

STUDY, CHUNKS, DATA = "study.json", "chunks", "data.parquet"
PAGE, TABLE = "report.html", "sensitivity.csv"
# Names in a chunk's file: a quantity must not have that of an argument of NumPy.
ERRORS, OF_QUANTITY, OF_TEXT, TOO_HOT = "errors", "quantity ", "text ", "overheated"


class StudyFolder:
    """The folder of what a study has finished; CallerError for that of another study or other content."""

    def __init__(self, path: Path, plan: Plan, overwrite: bool = False) -> None:
        """Continue in the folder where the same study was stopped."""
        self.path, self._plan = path, plan
        if overwrite and (path / STUDY).exists():
            self._clear()
        self._continue()

    @property
    def data(self) -> Path:
        """File of the whole data set."""
        return self.path / DATA

    @property
    def page(self) -> Path:
        """File of the page."""
        return self.path / PAGE

    @property
    def table(self) -> Path:
        """File of the sensitivity table."""
        return self.path / TABLE

    def _continue(self) -> None:
        file = self.path / STUDY
        if file.exists():
            known = read_identity(file)
            if known.get("fingerprint") != self._plan.fingerprint:
                raise CallerError(
                    f"{self.path} belongs to another study, to this one before its file or a file that it names was "
                    f"changed, or to another version ({known.get('engine', 'unknown')}): give another folder, or "
                    + argument("overwrite", True)
                )
            return
        if self.path.exists() and any(self.path.iterdir()):
            raise CallerError(f"{self.path} is no folder of a study and not empty: give another folder")
        try:
            (self.path / CHUNKS).mkdir(parents=True, exist_ok=True)
        except OSError as problem:
            raise CallerError(f"cannot make the folder {self.path}: {problem.strerror or problem}") from None
        identity = {"study": self._plan.file.name, "fingerprint": self._plan.fingerprint, "engine": engine()}
        write_text_whole(file, json.dumps({**identity, "runs": len(self._plan.design)}, indent=2) + "\n")

    def _clear(self) -> None:
        """Delete the results of a study; files that are not its own stay."""
        self.remove_chunks()
        for file in (self.data, self.page, self.table, self.path / STUDY):
            file.unlink(missing_ok=True)
        if (self.path / CHUNKS).is_dir() and not any((self.path / CHUNKS).iterdir()):
            (self.path / CHUNKS).rmdir()
        if any(self.path.iterdir()):
            raise CallerError(f"{self.path} has files that are not the study's: give another folder")

    def finished(self) -> list[tuple[int, int]]:
        """Return the runs that are finished, as ranges in ascending order: the first, and the one after the last."""
        names = (file.stem.partition("-") for file in (self.path / CHUNKS).glob("*-*.npz"))
        ranges = sorted((int(first), int(stop)) for first, _, stop in names if first.isdigit() and stop.isdigit())
        found: list[tuple[int, int]] = []
        for first, stop in ranges:
            # Two clients with chunks of another length may have written some runs twice; each counts once.
            if not found or first >= found[-1][1]:
                found.append((first, stop))
        return found

    def write(self, result: ChunkResult) -> None:
        """Write a finished chunk; it is on the disk when this returns. Raises CallerError if that fails."""
        named = {f"{OF_QUANTITY}{name}": column for name, column in result.columns.items()}
        texts = {f"{OF_TEXT}{name}": np.array(found) for name, found in result.texts.items()}
        columns: Any = {**named, **texts, ERRORS: np.array(result.errors)}
        if result.overheated:
            columns[TOO_HOT] = np.array(result.overheated)
        (self.path / CHUNKS).mkdir(exist_ok=True)

        def write(part: Path) -> None:
            with part.open("wb") as file:  # given a name, NumPy adds a suffix of its own
                np.savez(file, **columns)

        write_whole(self._file(result.first, result.stop), write)

    def read(self) -> Iterator[ChunkResult]:
        """Yield the finished chunks in ascending order. Raises CallerError for a file that cannot be read."""
        for first, stop in self.finished():
            yield read_chunk(self._file(first, stop), first)

    def remove_chunks(self) -> None:
        """Delete the files of the chunks, whose content the data set has."""
        chunks = self.path / CHUNKS
        # With those that a killed client has left half written.
        for file in [*chunks.glob("*-*.npz"), *chunks.glob(".*.part")]:
            file.unlink(missing_ok=True)

    def _file(self, first: int, stop: int) -> Path:
        return self.path / CHUNKS / f"{first}-{stop}.npz"


def read_identity(file: Path) -> dict[str, Any]:
    """Return the identity of a study's folder. Raises CallerError if it is damaged."""
    try:
        known = json.loads(file.read_text("utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError):
        known = None
    if not isinstance(known, dict):
        raise CallerError(f"{file} is damaged: give another folder, or " + argument("overwrite", True))
    return known


def read_chunk(file: Path, first: int) -> ChunkResult:
    """Return a finished chunk."""
    try:
        with file.open("rb") as opened, np.load(opened, allow_pickle=False) as stored:
            columns, texts = (
                {name.removeprefix(kind): stored[name] for name in stored.files if name.startswith(kind)}
                for kind in (OF_QUANTITY, OF_TEXT)
            )
            return ChunkResult(
                first,
                columns,
                tuple(stored[ERRORS].tolist()),
                {name: tuple(found.tolist()) for name, found in texts.items()},
                tuple(
                    Overheated(int(run), float(hottest_k), float(limit_k))
                    for run, hottest_k, limit_k in (stored[TOO_HOT] if TOO_HOT in stored.files else ())
                ),
            )
    except (OSError, EOFError, ValueError, KeyError, BadZipFile) as problem:
        raise CallerError(f"{file} cannot be read ({problem}): delete it, and its runs are repeated") from None


class Chunks(Sequence[Chunk]):
    """Chunks of a study, each made when it is asked for: the values of ten million runs need not be there together."""

    def __init__(self, design: StudyDesign, ranges: Sequence[tuple[int, int]]) -> None:
        """Take the ranges."""
        self._design, self._ranges = design, ranges

    def __len__(self) -> int:
        """Return the number of chunks."""
        return len(self._ranges)

    @overload
    def __getitem__(self, place: int) -> Chunk: ...
    @overload
    def __getitem__(self, place: slice) -> Chunks: ...
    def __getitem__(self, place: int | slice) -> Chunk | Chunks:
        """Return a chunk with the values of its runs, or some of the chunks."""
        if isinstance(place, slice):
            return Chunks(self._design, self._ranges[place])
        first, stop = self._ranges[place]
        return Chunk(first, self._design.rows(first, stop))


def unfinished(plan: Plan, finished: Iterable[tuple[int, int]], runs_per_chunk: int) -> Chunks:
    """Return the runs still to do in ascending chunks; what is finished may have been cut otherwise."""
    ranges, done = [], 0
    for first, stop in [*finished, (len(plan.design), len(plan.design))]:
        ranges += [(begin, min(begin + runs_per_chunk, first)) for begin in range(done, first, runs_per_chunk)]
        done = max(done, stop)
    return Chunks(plan.design, ranges)
