"""Writing a recording row by row from a script of one's own: every row is in the file before the next one comes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType

from musclewire.errors import CallerError, RecordingNotWrittenError, nearest_hint
from musclewire.signals._columns import known_column, needs_no_clock
from musclewire.signals._metadata import MetadataValue, one_line
from musclewire.signals._open_journal import OpenJournal


class RecordingWriter:
    """Writes a recording during the run; every row appended can be read, whenever the process is killed.

    Rows go to a journal next to the file, ``run.h5.journal`` for ``run.h5``. Closing makes the file of it, plain HDF5
    whose name alone stays. The journal of a run that was cut off is read by the same name, and finished by
    ``musclewire recover run.h5``.

    Parameters
    ----------
    path
        The file.
    columns
        Names from ``COLUMNS``; every row gives all of them.
    metadata
        As in ``Recording``; ``ended`` is written here, by :meth:`close`.
    block_rows
        Rows that are buffered and then written together. With 1, the default, a row is in the file when
        :meth:`append` returns, which takes some microseconds, longer if a disk is busy. A thread brings the file to
        the disk once a second: a power cut costs no more.
    overwrite
        Whether to replace an existing file, which is refused otherwise.

    Raises
    ------
    CallerError
        For an unknown or repeated column, no clock, ``block_rows`` under 1, or a file that exists or cannot be made.
    """

    def __init__(
        self,
        path: str | Path,
        columns: Sequence[str],
        metadata: Mapping[str, MetadataValue] | None = None,
        block_rows: int = 1,
        overwrite: bool = False,
    ) -> None:
        """Create the journal, which has no rows yet."""
        if block_rows < 1:
            raise CallerError(f"block_rows is {block_rows}; give 1 or more")
        self._names = _checked_names(columns)
        self._block_rows = block_rows
        self._ended = "running"
        self._journal = OpenJournal(path, self._names, metadata or {}, overwrite)

    @property
    def path(self) -> Path:
        """The file that is there once the recording is closed."""
        return self._journal.path

    @property
    def rows_written(self) -> int:
        """Rows that survive a kill."""
        return self._journal.rows_written

    @property
    def ended(self) -> str:
        """``"running"`` until closed, then why it ended."""
        return self._ended

    def append(self, row: Mapping[str, float]) -> None:
        """Add one row; every ``block_rows`` rows are written.

        Parameters
        ----------
        row
            A number for each column, by name, SI.

        Raises
        ------
        CallerError
            For a row that lacks a column, names another or gives no number, or after :meth:`close`.
        RecordingNotWrittenError
            If the disk takes no more; what it took stays in the journal.
        """
        if self._ended != "running":
            raise CallerError(f"{self.path}: the recording is closed ('{self._ended}'); start another one")
        # One call: a Ctrl-C falls before it or after it.
        self._journal.values.fromlist(_checked_row(row, self._names))
        if len(self._journal.values) >= (self.rows_written + self._block_rows) * len(self._names):
            try:
                self._journal.write_rows()
            except OSError as problem:
                raise self._given_up(problem) from None

    def close(self, ended: str = "done", metadata: Mapping[str, MetadataValue] | None = None) -> None:
        """Write the remaining rows and why the recording ended, as plain HDF5. Closing twice does nothing.

        Parameters
        ----------
        ended
            Why, in one line; "done" for a run that reached its end.
        metadata
            Entries that were not known when the file was created.

        Raises
        ------
        RecordingNotWrittenError
            If the disk takes no more; the journal then is the recording, with all rows that it took.
        """
        if self._ended != "running":
            return
        self._ended = one_line(ended) or "done"
        try:
            self._journal.close(self._ended, metadata or {})
        except OSError as problem:
            raise self._given_up(problem) from None

    def __enter__(self) -> RecordingWriter:
        """Return the writer itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file, with the reason if an exception was raised; the exception propagates."""
        if kind is None:
            self.close()
        elif issubclass(kind, (KeyboardInterrupt, SystemExit)):
            self.close("interrupted")
        else:
            self.close(f"{kind.__name__}: {problem}")

    def _given_up(self, problem: OSError) -> RecordingNotWrittenError:
        self._ended = one_line(f"OSError: {problem.strerror or problem}")
        rows = self._journal.leave(self._ended)
        kept = f"; {rows} rows are in {self._journal.journal}"
        return RecordingNotWrittenError(f"cannot write {self.path}: {problem.strerror or problem}{kept}")


def _checked_names(columns: Sequence[str]) -> tuple[str, ...]:
    names = tuple(known_column(name).name for name in columns)
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise CallerError(f"column '{repeated[0]}' is given twice; name each column once")
    if "time_s" not in names and not needs_no_clock(names):
        raise CallerError("a recording needs the column time_s; add it to columns")
    return names


def _checked_row(row: Mapping[str, float], names: tuple[str, ...]) -> list[float]:
    if len(row) != len(names):
        for name in row:
            if name not in names:
                raise CallerError(
                    f"a row gives '{name}', which this recording does not keep{nearest_hint(name, names)}"
                )
    try:
        return [float(row[name]) for name in names]
    except KeyError as missing:
        raise CallerError(f"a row lacks {missing}; every row must give {', '.join(names)}") from None
    except (TypeError, ValueError):
        wrong = next(name for name in names if not _is_number(row[name]))
        raise CallerError(f"a row gives {wrong} = {row[wrong]!r}; give a number") from None


def _is_number(value: object) -> bool:
    try:
        float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False
    return True
