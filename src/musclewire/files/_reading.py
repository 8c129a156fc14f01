"""Reading recordings from files of musclewire and of other programs."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError, argument, nearest_hint
from musclewire.files._headers import missing_from, numbered_headers
from musclewire.files._import_mapping import ImportMapping, load_mapping
from musclewire.files._importing import CheckedBlocks, ImportPlan, checked_blocks, plan_import
from musclewire.files._source_table import SourceColumn, SourceTable, TableInMemory
from musclewire.manifest import absent_part, loaded, manifests
from musclewire.signals import MetadataValue, Recording, checked_metadata, is_journal, unfinished

# A test below another is chosen behind the group of the file, if it has any.
_TEST = re.compile(r"(?:(?P<group>.+), )?test (?P<test>\d{1,6})")
# Suffixes that need no part outside the core.
OWN_SUFFIXES = (".h5", ".hdf5", ".csv")


def read_recording(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    metadata: Mapping[str, MetadataValue] | None = None,
    mapping: ImportMapping | str | Path | None = None,
    group: str | None = None,
) -> Recording:
    """Read a recording of musclewire, LabVIEW, MATLAB, Excel and other programs.

    Parameters
    ----------
    path
        The file; its suffix states the format: .h5 and .hdf5 (ours or others'), text (.csv, .tsv, .txt, .dat, .asc,
        .log, .tra, .prn, .jsonl, .ndjson), .tdms, .lvm, .mat (4, 5 and 7.3), .xlsx and .xlsm, .parquet, .nc.
    columns
        NAME -> "HEADER" or "HEADER:UNIT" for headers that are not recognised by themselves, such as
        ``{"wire_voltage_v": "Vw:mV"}``; HEADER may itself carry a unit, and ``#2`` is the second column whatever it is
        called, also in a file without headers. None if all headers are recognised.
    metadata
        Added to those of the file, and used instead of them if both state a key.
    mapping
        Everything else about how the file is read: an :class:`~musclewire.files.ImportMapping`, or the path of a
        mapping file; what ``columns`` and ``metadata`` say comes first. None if there is nothing else to say.
    group
        Group, sheet or struct of a file that holds several tables. None, the default, takes the only one; where there
        are several, the error lists them.

    Returns
    -------
    The recording, its columns in SI units.

    Raises
    ------
    RecordingError
        If the file cannot be used: one line with file, column and row.
    CallerError
        For a NAME in ``columns`` that is no column, metadata that no file could keep, or a wrong mapping file.
    MissingExtraError
        For .parquet without pyarrow.
    """
    wanted = given_mapping(mapping, columns, metadata, group)
    plan, tally = import_plan(Path(path), wanted), CheckedBlocks()
    blocks = list(checked_blocks(plan, tally))
    values = {name: np.concatenate([block[name] for block in blocks]) for name in blocks[0]}
    found = {**tally.started, **plan.metadata, **tally.noted}
    return _recording(values, found, Path(path))


def mappings_of_files(paths: Sequence[str | Path], mapping: ImportMapping) -> list[ImportMapping]:
    """Return for each of several files the part of a mapping whose headers the file has.

    Raises RecordingError for a header that is in none of the files, and what reading their headers raises.
    """
    if len(paths) == 1:
        return [mapping]
    tables = [_table(Path(path), mapping.group) for path in paths]
    missing = [missing_from(table.columns, mapping.columns, mapping.ignore) for table in tables]
    names = frozenset.intersection(*(one for one, _ in missing))
    headers = frozenset.intersection(*(one for _, one in missing))
    for wanted in (*(mapping.columns[name] for name in names), *headers):
        listed = ", ".join(str(path) for path in paths)
        known = [column.header for table in tables for column in table.columns]
        raise RecordingError(f"no column '{wanted}' in any of {listed}{nearest_hint(wanted, known)}")
    return [mapping.without(*one) for one in missing]


def read_hdf5(path: str | Path) -> Recording:
    """Return a recording in musclewire's format without checks; an unfinished one has ``ended`` "running" or "cut off".

    Raises RecordingError if the file is missing, damaged, or not a musclewire recording.
    """
    from musclewire.signals import read_run

    return _recording(*read_run(Path(path)), Path(path))


def has_headers(path: str | Path) -> bool:
    """Return whether a file's first line names columns. Raises RecordingError if it cannot be read."""
    headers = tuple(column.header for column in _table(Path(path), None).columns)
    return headers != numbered_headers(len(headers))


def given_mapping(
    mapping: ImportMapping | str | Path | None,
    columns: Mapping[str, str] | None,
    metadata: Mapping[str, MetadataValue] | None,
    group: str | None,
) -> ImportMapping:
    """Return all that a caller says of how a file is read; a mapping file comes second."""
    given = load_mapping(mapping) if isinstance(mapping, str | Path) else mapping or ImportMapping()
    return given.joined(ImportMapping(columns or {}, metadata=checked_metadata(metadata or {}), group=group))


def import_plan(path: Path, mapping: ImportMapping) -> ImportPlan:
    """Return what becomes of a file's columns, in the part and the test below each other that the group names."""
    chosen = None if mapping.group is None else _TEST.fullmatch(mapping.group)
    if chosen is None:
        return plan_import(_table(path, mapping.group), mapping)
    try:
        # A group of the file may have such a name itself.
        return plan_import(_table(path, mapping.group), mapping)
    except RecordingError:
        return plan_import(_table(path, chosen["group"]), mapping, int(chosen["test"]))


def _table(path: Path, group: str | None) -> SourceTable:
    read = _reader_for(path)
    if not path.is_file() and not (is_journal(path) or unfinished(path)):
        what = "is a folder" if path.is_dir() else "no such file"
        raise RecordingError(f"{path}: {what}; give the path of a recording")
    return read(path, group)


def _reader_for(path: Path) -> Callable[[Path, str | None], SourceTable]:
    # Imported here: h5py and the readers of other formats are slow to load, and most commands read no file.
    suffix = path.suffix.lower()
    if is_journal(path) or unfinished(path):
        return lambda file, group: _own_table(without_groups(file, group))
    if suffix in {".h5", ".hdf5"}:
        return _hdf5_table
    # A part that reads text of any layout (lab_files) reads CSV, too, and comes first.
    if (read := _offered_reader(path)) is not None:
        return read
    if suffix == ".csv":
        from musclewire.files._plain_csv import read_plain_csv

        return lambda file, group: read_plain_csv(without_groups(file, group))
    if (absent := absent_part("suffixes", suffix)) is not None:
        raise absent
    if suffix == ".json":
        raise RecordingError(f"{path}: a .json file is a model, and no recording: give the recording here")
    *others, last = [*OWN_SUFFIXES, *(each for manifest in manifests() for each in manifest.suffixes_read)]
    known = f"{', '.join(others)} or {last}"
    raise RecordingError(f"{path}: files ending in '{suffix}' are not read; export it as {known}")


def _offered_reader(path: Path) -> Callable[[Path, str | None], SourceTable] | None:
    """Return what a part outside the core reads a file with, None if no part knows the file."""
    for manifest in manifests():
        for place in manifest.readers:
            read: Callable[[Path, str | None], SourceTable] | None = loaded(place)(path)
            if read is not None:
                return read
    return None


def without_groups(path: Path, group: str | None) -> Path:
    """Return the path of a file that holds one table. Raises RecordingError if a group is asked for."""
    if group is not None:
        raise RecordingError(f"{path}: holds one table, no group '{group}'; leave " + argument("group") + " out")
    return path


def _hdf5_table(path: Path, group: str | None) -> SourceTable:
    from musclewire.signals import is_recording

    if not is_recording(path):
        read = _offered_reader(path)
        if read is None:
            raise RecordingError(f"{path}: is no recording of musclewire, and the part that reads HDF5 of others "
                                 "(lab_files) is not there; export it as CSV")  # fmt: skip
        return read(path, group)
    return _own_table(without_groups(path, group))


def _own_table(path: Path) -> SourceTable:
    recording = read_hdf5(path)
    columns = tuple(SourceColumn(name) for name in recording.names)
    values = tuple(recording.whole_columns.values())
    return TableInMemory(str(path), "musclewire HDF5", columns, values, recording.metadata)


def _recording(values: Mapping[str, FloatArray], metadata: Mapping[str, MetadataValue], path: Path) -> Recording:
    try:
        return Recording(values, metadata)
    except (CallerError, RecordingError) as problem:
        # Wrong metadata in a file are the file's fault, not the caller's.
        raise RecordingError(f"{path}: " + str(problem)) from None
