"""A recording: columns of numbers over time, and the metadata of the run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError, require_extra
from musclewire.pages import notebook_table
from musclewire.signals._columns import (
    BRANCH_TABLE,
    COLUMNS,
    ISOBAR_TABLE,
    PULSE_TABLE,
    declare_column,
    known_column,
    needs_no_clock,
)
from musclewire.signals._metadata import MetadataValue, checked_metadata, fact_in_words
from musclewire.signals._plots import PLOTS, usual_plot
from musclewire.signals._run_facts import RunFacts
from musclewire.signals._writing import write_columns

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure


Answer = TypeVar("Answer")
Known = TypeVar("Known", bound="Recording")
# The metadata that state from when on [s] rows are no part of the run before them:
MINOR_LOOP_FROM = "minor_loop_from_s"  # the minor loop after the cycles,
COOLING_FROM = "cooling_from_s"  # or how the wire cooled after the loop
# The number of their cycle, where cycles are numbered; later rows of a recording that was put together, with the
# metadata of its first part, have another.
NO_CYCLE = 0.0
# The facts of a run that a person reads first, in this order; .metadata has all.
READ_FIRST = (
    "experiment",
    "wire",
    "wire_length_m",
    "wire_diameter_m",
    "leg_length_m",
    "pretension_n",
    "spring_stiffness_n_per_m",
    "shunt_resistance_ohm",
    "sample_period_s",
    "rig",
    "seed",
    "start_time",
    "source",
    "note",
)


@dataclass(frozen=True, eq=False, repr=False)
class Recording:
    """Columns of equal length in SI units, with metadata. It never changes; ``with_...`` makes another.

    A recording has a clock, ``time_s``, with three exceptions: a printed loop (``is_branch_table``), whose rows are
    resistances, isobars (``is_isobar_table``), whose rows are in the order in which the temperatures were reached, and
    pulses (``is_pulse_table``), a row each: current, length, resistance at its end, largest stroke. Where only the
    order of rows counts and no clock is known, ``time_s`` may be row numbers; the metadata say so,
    ``clock = "row numbers"``.

    The last rows, later than the metadata's ``minor_loop_from_s`` or ``cooling_from_s`` and with 0 in a column
    ``cycle``, are a segment of their own, :attr:`minor_loop` or :attr:`cooling`: columns and number of rows are those
    of the run before it, as if it had ended there. Files keep both.

    Parameters
    ----------
    columns
        Name -> values of shape (n_times,); the names and their units are those of ``COLUMNS``.
    metadata
        What is known of the run: wire, wire_length_m, shunt_resistance_ohm, pretension_n, rig, ..., ended. Empty by
        default, as in a file of another program that states nothing; :attr:`facts` reads them.

    Raises
    ------
    CallerError
        For an unknown column name, or a metadata key or value that no file could keep.
    RecordingError
        If columns are of unequal length, or there is neither a clock nor a table that needs none.

    Examples
    --------
    >>> import musclewire as mw
    >>> recording = mw.Recording({"time_s": [0.0, 0.1], "wire_voltage_v": [1.2, 1.3]}, {"pretension_n": 1.7})
    >>> recording["wire_voltage_v"]
    array([1.2, 1.3])
    >>> recording.duration_s, recording.metadata["pretension_n"]
    (0.1, 1.7)
    """

    columns: Mapping[str, FloatArray]
    metadata: Mapping[str, MetadataValue] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check columns and metadata, and replace them by read-only copies."""
        columns = {known_column(name).name: _read_only(name, self.columns[name]) for name in self.columns}
        _check_equal_lengths(columns)
        _check_rows_are_ordered(columns)
        metadata = checked_metadata(self.metadata)
        rows = _rows_of_run(columns, metadata)
        object.__setattr__(self, "_whole", MappingProxyType(columns))
        object.__setattr__(self, "columns", MappingProxyType({name: one[:rows] for name, one in columns.items()}))
        object.__setattr__(self, "metadata", metadata)

    def __getitem__(self, name: str) -> FloatArray:
        """Return one column, shape (n_times,), read-only.

        Raises CallerError for a name no recording has, RecordingError for a column this recording lacks.
        """
        if name in self.columns:
            return self.columns[name]
        known_column(name)
        raise RecordingError(f"this recording has no column '{name}'; it has {', '.join(self.names)}")

    def __contains__(self, name: object) -> bool:
        """Return whether this recording has the column ``name``."""
        return name in self.columns

    def __len__(self) -> int:
        """Return the number of rows, n_times."""
        return int(next(iter(self.columns.values())).size)

    def __bool__(self) -> bool:
        """Return True: a recording without rows is still a recording."""
        return True

    def __eq__(self, other: object) -> bool:
        """Return whether columns and metadata are the same, number by number; NaN equals NaN here."""
        if not isinstance(other, Recording):
            return NotImplemented
        one, another = self.whole_columns, other.whole_columns
        same_columns = self.names == other.names and all(
            np.array_equal(one[name], another[name], equal_nan=True) for name in self.names
        )
        return same_columns and dict(self.metadata) == dict(other.metadata)

    __hash__ = None  # type: ignore[assignment]  # equal by content, and the content is large

    def __reduce__(self) -> tuple[object, ...]:
        """Return the parts from which pickle rebuilds a recording: read-only mappings cannot be pickled."""
        return _unpickled, (dict(self.whole_columns), dict(self.metadata))

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the columns, in their order."""
        return tuple(self.columns)

    @property
    def whole_columns(self) -> Mapping[str, FloatArray]:
        """The columns as a file has them, with the rows of the segment that followed, (n_file_rows,)."""
        whole: Mapping[str, FloatArray] = self._whole  # type: ignore[attr-defined]  # set with the columns
        return whole

    @cached_property
    def minor_loop(self) -> Recording | None:
        """The minor loop that was recorded after the cycles, on their clock; None without one."""
        return self._followed_by(MINOR_LOOP_FROM)

    @cached_property
    def cooling(self) -> Recording | None:
        """How the wire cooled at the sense voltage after a closed loop, on its clock; None if nobody looked."""
        return self._followed_by(COOLING_FROM)

    def _followed_by(self, begins: str) -> Recording | None:
        """Return the segment that followed the run, if its beginning is stated under this name."""
        rows = {name: values[len(self) :] for name, values in self.whole_columns.items()}
        is_there = follows_from(self.metadata) == begins and next(iter(rows.values())).size
        return Recording(rows, _of_run(self.metadata)) if is_there else None

    @cached_property
    def with_minor_loop(self) -> Recording:
        """All rows as one recording, in which nothing separates the segment that followed from the run."""
        return Recording(self.whole_columns, _of_run(self.metadata))

    @cached_property
    def facts(self) -> RunFacts:
        """The facts of the run, each checked when it is read: ``recording.facts.sample_period_s`` [s], for one."""
        known = [str(self.metadata[key]) for key in ("wire", "experiment", "start_time") if self.metadata.get(key)]
        return RunFacts(self.metadata, f"this recording ({', '.join([f'{len(self)} rows', *known])})")

    @property
    def duration_s(self) -> float:
        """Time from the first row to the last [s]; 0 for fewer than two rows. RecordingError with no clock."""
        time_s = self["time_s"]
        return float(time_s[-1] - time_s[0]) if len(self) else 0.0

    @property
    def is_branch_table(self) -> bool:
        """True for a printed loop: both branches against resistance, and no clock."""
        return "time_s" not in self and all(name in self for name in BRANCH_TABLE)

    @property
    def is_isobar_table(self) -> bool:
        """True for strain against temperature under stress, row after row, and no clock."""
        return "time_s" not in self and all(name in self for name in ISOBAR_TABLE)

    @property
    def is_pulse_table(self) -> bool:
        """Whether its rows are pulses."""
        return "time_s" not in self and all(name in self for name in PULSE_TABLE)

    def with_columns(self, columns: Mapping[str, ArrayLike] | None = None, /, **more: ArrayLike) -> Recording:
        """Return a recording in which columns are added or replaced, without what followed the run.

        Parameters
        ----------
        columns
            Name -> values of shape (n_times,), SI.
        **more
            The same, by keyword.

        Returns
        -------
        The other recording, with the same metadata.
        """
        added = {**(columns or {}), **more}
        return Recording({**self.columns, **added}, _of_run(self.metadata))  # type: ignore[dict-item]

    def with_metadata(self, metadata: Mapping[str, MetadataValue] | None = None, /, **more: MetadataValue) -> Recording:
        """Return a recording in which metadata are added or replaced.

        Parameters
        ----------
        metadata
            Key -> text, number, bool or None.
        **more
            The same, by keyword.

        Returns
        -------
        The other recording, with the same columns.
        """
        return Recording(self.whole_columns, {**self.metadata, **(metadata or {}), **more})

    def between(self, start: int | None = None, stop: int | None = None) -> Recording:
        """Return some of the rows, without what followed the run.

        Parameters
        ----------
        start
            First row, counted as in a Python slice; None is the first of all.
        stop
            Row after the last; None is the end.

        Returns
        -------
        A recording of rows ``start`` to ``stop``, not included.

        Raises
        ------
        CallerError
            If one is no whole number, as a time would be.
        """
        for row in (start, stop):
            if row is not None and not isinstance(row, (int, np.integer)):
                raise CallerError(f"between() counts rows, got {row!r}; use numpy.searchsorted on time_s for times")
        return Recording({name: values[start:stop] for name, values in self.columns.items()}, _of_run(self.metadata))

    def to_pandas(self) -> pd.DataFrame:
        """Return a pandas DataFrame with the metadata in ``attrs``; a segment that followed makes one of its own.

        Returns
        -------
        One row a sample, one column a column; copies.

        Raises
        ------
        MissingExtraError
            Without pandas.
        """
        require_extra("Recording.to_pandas()", "pandas")
        import pandas as pd

        frame = pd.DataFrame({name: values.copy() for name, values in self.columns.items()})
        frame.attrs.update(self.metadata)
        return frame

    def to_xarray(self) -> xr.Dataset:
        """Return an xarray data set, whose variables carry their units; a segment that followed makes one of its own.

        Returns
        -------
        A variable for each column over the coordinate ``time_s``, with the attributes ``units`` (SI, "1" without one)
        and ``long_name``; over ``row`` for a table without a clock. The metadata are the attributes of the data set,
        except those that are None, which no netCDF file can keep.

        Raises
        ------
        MissingExtraError
            Without xarray.
        """
        require_extra("Recording.to_xarray()", "xarray")
        import xarray as xr

        axis = "time_s" if "time_s" in self else "row"
        variables = {name: (axis, values.copy(), _attributes(name)) for name, values in self.columns.items()}
        attributes = {key: value for key, value in self.metadata.items() if value is not None}
        return xr.Dataset(variables, attrs=attributes)

    def save(self, path: str | Path, matlab_version: str | None = None) -> None:
        """Write the recording with its minor loop, whole or not at all; a file of that name is replaced.

        Parameters
        ----------
        path
            The file; its suffix says the format: .h5, .hdf5, .csv, .parquet, .mat (MATLAB 5, or 7.3 if it is too
            large for it) or .xlsx.
        matlab_version
            "5" or "7.3" for a .mat file. None, the default, is 5, which everything reads, or 7.3 if a column is too
            large for it.

        Raises
        ------
        CallerError
            For another suffix or version, a folder that cannot be written to, or more rows than a sheet holds.
        MissingExtraError
            For .parquet without pyarrow, for .xlsx without openpyxl.
        """
        write_columns(self.whole_columns, self.metadata, Path(path), matlab_version)

    def plot(self, kind: str | None = None, *, style: str = "screen") -> Figure:
        """Draw the recording.

        Parameters
        ----------
        kind
            "loop" (movement over resistance and over drive voltage, with points A, B and C), "control" (target,
            estimate, measurement, errors, drive), "estimate" (estimate with its standard deviation and
            reference, over time and resistance), "time" (every quantity over time) or "table" (a printed loop,
            isobars). None, the default, is what fits the columns: "control" with a target, "estimate" with an estimate,
            "loop" with resistance and movement, "table" without a clock, else "time".
        style
            Size and fonts of the figure: "screen", "slides", or a journal's column, as "ieee-single",
            "elsevier-double", "nature".

        Returns
        -------
        A matplotlib figure, which a notebook shows; ``figure.savefig("run.pdf")`` writes it.

        Raises
        ------
        CallerError
            For an unknown kind or style; the message suggests the nearest.
        RecordingError
            If the recording lacks the columns for this kind.
        """
        return PLOTS.find(usual_plot(self.names) if kind is None else kind)(self, style)

    def __repr__(self) -> str:
        """Return one line: number of rows, duration, how the run ended, and the columns."""
        return f"Recording({self._summary()}: {', '.join(self.names)})"

    def _summary(self) -> str:
        parts = [f"{len(self)} rows"]
        if "time_s" in self:
            parts.append(f"{self.duration_s:.6g} s")
        else:
            parts.append(
                "branch table" if self.is_branch_table else "isobar table" if self.is_isobar_table else "pulses"
            )
        if "ended" in self.metadata:
            parts.append(f"ended '{self.metadata['ended']}'")
        return ", ".join(parts)

    def _repr_html_(self) -> str:
        """Return a table of the columns with unit and range, and the main facts of the run, for a notebook."""
        rows = [_column_row(name, values) for name, values in self.columns.items()]
        shown = [key for key in READ_FIRST if key in self.metadata]
        facts = ", ".join(" ".join(fact_in_words(key, self.metadata[key])) for key in shown)
        if rest := len(self.metadata) - len(shown):
            facts += f"{'; ' if facts else ''}{rest} more in .metadata"
        return notebook_table(f"Recording ({self._summary()})", ("column", "unit", "minimum", "maximum"), rows, facts)


def asked_once(recording: Recording, question: Callable[[Recording], Answer]) -> Answer:
    """Return what a function says of a recording, asked once: it never changes. No answer may hold the recording."""
    answers: dict[Callable[[Recording], Any], Any] = vars(recording).setdefault("_answers", {})
    if question not in answers:
        answers[question] = question(recording)
    answer: Answer = answers[question]
    return answer


def with_answers_of(recording: Known, other: Recording) -> Known:
    """Return a recording with the answers to what was asked of another, the same but for facts that no answer reads."""
    vars(recording)["_answers"] = vars(other).setdefault("_answers", {})
    return recording


def _attributes(name: str) -> dict[str, str]:
    return {"units": COLUMNS[name].unit or "1", "long_name": COLUMNS[name].description}


def _read_only(name: str, values: ArrayLike) -> FloatArray:
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise CallerError(f"column '{name}' must be numbers; got {type(values).__name__} of something else") from None
    if array.ndim != 1:
        raise CallerError(f"column '{name}' has shape {array.shape}; give one number per row, shape (n_times,)")
    if array.flags.writeable:
        # The caller keeps its array; the recording's copy must not change while it is read.
        array = array.copy()
        array.setflags(write=False)
    return array


def _unpickled(columns: dict[str, FloatArray], metadata: dict[str, MetadataValue]) -> Recording:
    """Return a recording of another process, which may know estimators that this one does not."""
    for name in columns:
        declare_column(name)
    return Recording(columns, metadata)


def follows_from(metadata: Mapping[str, MetadataValue]) -> str:
    """Return under which name metadata state where the segment after the run begins; "" if they state none."""
    return next((name for name in (MINOR_LOOP_FROM, COOLING_FROM) if name in metadata), "")


def _rows_of_run(columns: Mapping[str, FloatArray], metadata: Mapping[str, MetadataValue]) -> int | None:
    """Return how many rows come before the segment that ends a recording; None without one."""
    from_s, time_s = metadata.get(follows_from(metadata)), columns.get("time_s")
    if time_s is None or isinstance(from_s, (bool, str)) or from_s is None:
        return None
    before = np.flatnonzero(~((time_s > from_s) & (columns.get("cycle", NO_CYCLE) == NO_CYCLE)))
    return int(before[-1]) + 1 if before.size else None


def _of_run(metadata: Mapping[str, MetadataValue]) -> dict[str, MetadataValue]:
    """Return metadata without the beginning of what followed: of rows that have none, or a clock of their own."""
    return {key: value for key, value in metadata.items() if key not in (MINOR_LOOP_FROM, COOLING_FROM)}


def _check_equal_lengths(columns: Mapping[str, FloatArray]) -> None:
    lengths = {name: values.shape[0] for name, values in columns.items()}
    if len(set(lengths.values())) > 1:
        counted = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise RecordingError(f"columns differ in length ({counted}); give every column one value per row")


def _check_rows_are_ordered(columns: Mapping[str, FloatArray]) -> None:
    if "time_s" not in columns and not needs_no_clock(columns):
        needs = (
            f"needs time_s, or {', '.join(BRANCH_TABLE)} for a printed loop, or {', '.join(ISOBAR_TABLE)} for isobars, "
            f"or {', '.join(PULSE_TABLE)} for pulses"
        )
        raise RecordingError(f"a recording {needs}; got {', '.join(columns) or 'no columns'}")


def _column_row(name: str, values: FloatArray) -> tuple[str, ...]:
    finite = values[np.isfinite(values)]
    minimum, maximum = (f"{finite.min():.6g}", f"{finite.max():.6g}") if finite.size else ("", "")
    return name, COLUMNS[name].unit, minimum, maximum
