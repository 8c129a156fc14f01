"""How files of one program are read, remembered as a TOML file for next time.

format = "musclewire-mapping"
version = 1
sample_period = "10 ms"             for files without a clock
ignore = ["Humidity"]               columns that are left out
group = "Measured"                  group, sheet or struct of a file that holds several tables
drop_missing = true                 leave out rows in which a number is missing
zero = true                         count displacement, strain and force from the first row
trust_mapping = true                units below hold against those that the file states
invert = true                       the sensor reads backwards: negate displacement and strain

[columns]                           NAME = "HEADER" or "HEADER:UNIT"; "#2" is the second. No other column is taken.
time_s = "Time:ms"

[metadata]                          added to those of the file
shunt_resistance_ohm = 1.0
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from musclewire.errors import CallerError, RecordingError, argument, nearest_hint
from musclewire.signals import MetadataValue, checked_metadata, known_column, parse_quantity, write_text_whole
from musclewire.small_files import read_toml, toml_value

_FORMAT = "musclewire-mapping"
_SWITCHES = ("drop_missing", "zero", "invert", "trust_mapping")
_KEYS = ("format", "version", "sample_period", "ignore", "group", *_SWITCHES, "columns", "metadata")


class CurableError(RecordingError):
    """A file cannot be read as it is, and ``cure`` is what would read it, or the next step to it; None if unknown."""

    def __init__(self, message: str, cure: ImportMapping | None = None) -> None:
        """Keep what is to be added to the mapping."""
        super().__init__(message)
        self.cure = cure


@dataclass(frozen=True)
class ImportMapping:
    """How the columns of a file of another program are read.

    Parameters
    ----------
    columns
        NAME -> "HEADER" or "HEADER:UNIT" as in :func:`~musclewire.read_recording`. Empty by default: names that are
        recognised need none.
    ignore
        Headers of columns to leave out; none by default.
    sample_period_s
        Time between two rows [s] of a file without a clock; None by default, for a file that has one or states it.
    drop_missing
        Whether to leave out rows in which a used column has no number; by default such a row is an error, because a
        hole in the data is never filled or skipped without being asked.
    zero
        Whether to count displacement, strain and force from the first row; False by default.
    invert
        Whether the sensor reads backwards, so that displacement and strain are negated; False by default.
    metadata
        Added to those of the file, and used instead of them if both state a key; empty by default.
    only_mapped
        Whether all columns that are not in ``columns`` are left out, as with a mapping file; False by default.
    group
        Group, sheet or struct of a file that holds several tables; None by default, for the only one.
    trust_mapping
        Whether a unit in ``columns`` holds against another one that the file states; by default the two are refused.

    Raises
    ------
    CallerError
        If the sample period is not above 0 s.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    ignore: tuple[str, ...] = ()
    sample_period_s: float | None = None
    drop_missing: bool = False
    zero: bool = False
    invert: bool = False
    metadata: Mapping[str, MetadataValue] = field(default_factory=dict)
    only_mapped: bool = False
    group: str | None = None
    trust_mapping: bool = False

    def __post_init__(self) -> None:
        """Check the sample period."""
        period_s = self.sample_period_s
        if period_s is not None and not 0.0 < period_s < float("inf"):
            raise CallerError(f"sample_period_s is {period_s}; give the time between two rows, above 0 s")

    def without(self, columns: Collection[str], ignore: Collection[str]) -> ImportMapping:
        """Return this mapping without some of its columns and ignored headers.

        Parameters
        ----------
        columns
            Names that are left out.
        ignore
            Ignored headers that are left out.

        Returns
        -------
        The rest.
        """
        kept = {name: wanted for name, wanted in self.columns.items() if name not in columns}
        return dataclasses.replace(
            self, columns=kept, ignore=tuple(header for header in self.ignore if header not in ignore)
        )

    def joined(self, other: ImportMapping) -> ImportMapping:
        """Return this mapping with what another adds to it or says instead.

        Parameters
        ----------
        other
            What a caller adds to a mapping file.

        Returns
        -------
        Both together.
        """
        period_s = self.sample_period_s if other.sample_period_s is None else other.sample_period_s
        return ImportMapping(
            {**self.columns, **other.columns},
            (*self.ignore, *other.ignore),
            period_s,
            self.drop_missing or other.drop_missing,
            self.zero or other.zero,
            self.invert or other.invert,
            {**self.metadata, **other.metadata},
            self.only_mapped or other.only_mapped,
            self.group if other.group is None else other.group,
            self.trust_mapping or other.trust_mapping,
        )


def load_mapping(path: str | Path) -> ImportMapping:
    """Return a mapping file. Raises CallerError if it cannot be read, or has an unknown key or a value of no use."""
    where = f"mapping {path}"
    data = read_toml(Path(path), "mapping", "; " + argument("save_mapping") + " writes one")
    for key in data:
        if key not in _KEYS:
            raise CallerError(f"{where}: unknown key '{key}'{nearest_hint(key, _KEYS)}")
    if data.get("format") != _FORMAT or data.get("version") != 1:
        raise CallerError(f'{where}: begins with format = "{_FORMAT}" and version = 1; this file does not')
    try:
        return _mapping_of(data)
    except CallerError as problem:
        raise CallerError(f"{where}: {problem}") from None


def save_mapping(mapping: ImportMapping, path: str | Path) -> None:
    """Write a mapping as a TOML file, whole or not at all.

    Parameters
    ----------
    mapping
        The mapping.
    path
        The file; one of this name is replaced.

    Raises
    ------
    CallerError
        If the folder cannot be written to.
    """
    lines = [f'format = "{_FORMAT}"', "version = 1"]
    if mapping.sample_period_s is not None:
        lines.append(f"sample_period = {toml_value(f'{mapping.sample_period_s!r} s')}")
    if mapping.ignore:
        lines.append(f"ignore = {toml_value(mapping.ignore)}")
    if mapping.group is not None:
        lines.append(f"group = {toml_value(mapping.group)}")
    lines += [f"{key} = true" for key in _SWITCHES if getattr(mapping, key)]
    lines += ["", "[columns]", *(f"{name} = {toml_value(wanted)}" for name, wanted in mapping.columns.items())]
    if mapping.metadata:
        stated = {key: value for key, value in mapping.metadata.items() if value is not None}
        lines += ["", "[metadata]", *(f"{toml_value(key)} = {toml_value(value)}" for key, value in stated.items())]
    write_text_whole(Path(path), "\n".join(lines) + "\n")


def _mapping_of(data: Mapping[str, Any]) -> ImportMapping:
    columns = _typed(data, "columns", dict, {})
    for name, wanted in columns.items():
        known_column(name)
        if not isinstance(wanted, str) or not wanted.strip():
            raise CallerError(f'columns.{name} is {wanted!r}; write "HEADER" or "HEADER:UNIT"')
    ignore = _typed(data, "ignore", list, [])
    if not all(isinstance(header, str) for header in ignore):
        raise CallerError('ignore is a list of headers, as ["Humidity"]')
    period, group = _typed(data, "sample_period", str, None), _typed(data, "group", str, None)
    metadata = checked_metadata(_typed(data, "metadata", dict, {}))
    switches = {key: _typed(data, key, bool, False) for key in _SWITCHES}
    period_s = None if period is None else parse_quantity(period, "s")
    return dataclasses.replace(
        ImportMapping(columns, tuple(ignore), period_s, metadata=metadata, only_mapped=True, group=group), **switches
    )


def _typed(data: Mapping[str, Any], key: str, kind: type, default: Any) -> Any:
    words = {dict: "a table", list: "a list", str: "text", bool: "true or false"}
    value = data.get(key, default)
    if value is not default and not isinstance(value, kind):
        raise CallerError(f"{key} is {value!r}; it must be {words[kind]}")
    return value
