"""Files of other programs: read to their last row, judged, converted, and what would make one readable."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.files import (
    NO_SHUNT,
    SHUNT_NEEDED,
    CheckedBlocks,
    CurableError,
    ImportMapping,
    checked_blocks,
    given_mapping,
    import_plan,
)
from musclewire.identify._file_interpretation import FileInterpretation, interpretation_of
from musclewire.identify._proposed_mappings import columns_offered, proposed_addition
from musclewire.judge import JudgedReadings, ReadingsOfBlocks
from musclewire.signals import MetadataValue, checked_metadata, require_format, write_blocks

# Blocks of rows that are read before a file is written.
BUFFERED_BLOCKS = 8
# Each step of a proposal cures one thing: columns, clock, missing numbers, the test.
MAX_STEPS_OF_A_PROPOSAL = 8
# A proposal that leaves out more of the rows is none.
MAX_LEFT_OUT = 0.05


def import_recording(
    path: str | Path,
    output: str | Path | None = None,
    columns: Mapping[str, str] | None = None,
    metadata: Mapping[str, MetadataValue] | None = None,
    mapping: ImportMapping | str | Path | None = None,
    group: str | None = None,
    matlab_version: str | None = None,
) -> FileInterpretation:
    """Check a recording of another program to its last row, and convert it if an output is given.

    The file is read block after block, so that its size does not matter.

    Parameters
    ----------
    path
        The file.
    output
        The file to write: .h5, .hdf5, .csv, .parquet, .mat or .xlsx, of which the last two are collected in memory
        first; one of this name is replaced. None, the default, only checks.
    columns
        As in :func:`read_recording`.
    metadata
        As in :func:`read_recording`.
    mapping
        As in :func:`read_recording`.
    group
        As in :func:`read_recording`.
    matlab_version
        As in :meth:`Recording.save`, of an output that ends in .mat.

    Returns
    -------
    How the file was understood. Without an output a file that cannot be used has a ``problem``.

    Raises
    ------
    RecordingError
        If the file cannot be read at all, and with an output if it cannot be used, also for want of the resistance of a
        shunt; nothing is written then.
    CallerError
        For a NAME in ``columns`` that is no column, a wrong mapping file, or an output that cannot be written.
    MissingExtraError
        For .parquet without pyarrow.
    """
    wanted = given_mapping(mapping, columns, metadata, group)
    if output is not None:
        require_format(Path(output), matlab_version)
    file = JudgedFile(Path(path), wanted)
    if file.plan.lacks_shunt:
        if output is not None and not file.plan.problem:
            raise RecordingError(f"{path}: " + NO_SHUNT)
        file.plan = replace(file.plan, notes=(*file.plan.notes, SHUNT_NEEDED))
    if output is not None:
        file.write(Path(output), matlab_version)
        problem = None
    else:
        problem = file.first_problem()
    # A file may be readable, and what was measured of the wire may have names that are not known.
    proposal = _read_by(Path(path), wanted, file.cure(problem))
    said = (*(file.judged_readings.findings if file.judged_readings is not None else ()), *file.readings.notes)
    return interpretation_of(file.plan, file.tally, said, "" if problem is None else str(problem), proposal)


def proposed_mapping(path: str | Path, mapping: ImportMapping, problem: RecordingError) -> ImportMapping | None:
    """Return what was given and what has to be added to read a file that was refused, tried to its last row."""
    return _read_by(Path(path), mapping, problem.cure if isinstance(problem, CurableError) else None)


def _read_by(path: Path, mapping: ImportMapping, cure: ImportMapping | None) -> ImportMapping | None:
    """Return a mapping with what has to be added, a step after the other; None if it is not known or not sound."""
    for _ in range(MAX_STEPS_OF_A_PROPOSAL):
        if cure is None or cure == ImportMapping():
            return None
        mapping = mapping.joined(cure)
        try:
            file = JudgedFile(path, mapping)
        except RecordingError as refused:
            cure = refused.cure if isinstance(refused, CurableError) else None
            continue
        problem = file.first_problem()
        cure = file.cure(problem)
        if problem is None and cure is None:
            return mapping if file.is_sound else None
    return None


class JudgedFile:
    """A file of another program by one mapping, and what its rows held as far as they were read."""

    def __init__(self, path: Path, mapping: ImportMapping) -> None:
        """Read the first rows. Raises RecordingError and CallerError if the mapping does not fit the file."""
        self.plan = import_plan(path, mapping)
        self.tally, self.readings = CheckedBlocks(), ReadingsOfBlocks()

    @property
    def is_sound(self) -> bool:
        """Whether nearly all rows were measurements, and those of a wire."""
        left_out = self.tally.dropped / (self.tally.dropped + self.tally.row_count)
        return left_out <= MAX_LEFT_OUT and self.readings.is_of_a_wire(self.plan.metadata)

    @cached_property
    def judged_readings(self) -> JudgedReadings | None:
        """Which of the rows read are measurements; None if there are none to judge, or too many."""
        return self.readings.judge({**self.plan.metadata, **self.tally.noted})

    def cure(self, problem: RecordingError | None) -> ImportMapping | None:
        """Return what to add to the mapping against a problem, or for what more of a file without one may be read."""
        if problem is None:
            offered = columns_offered(self.plan.table, self.plan.match)
            return offered if offered.columns else None
        if self.plan.problem:
            return proposed_addition(self.plan)
        return problem.cure if isinstance(problem, CurableError) else None

    def first_problem(self) -> RecordingError | None:
        """Read the file to its end and return why it cannot be used, or None."""
        try:
            for _ in self._blocks():
                pass
            self._refuse_unusable()
        except RecordingError as problem:
            return problem
        return None

    def write(self, output: Path, matlab_version: str | None) -> None:
        """Convert the file. Raises RecordingError if it cannot be used."""
        blocks = self._blocks()
        # When a file with dates begins, and which readings are no measurements, belongs to the metadata, which come
        # first.
        buffered = list(itertools.islice(blocks, BUFFERED_BLOCKS))
        judged = self.readings.judge(self.plan.metadata) if len(buffered) < BUFFERED_BLOCKS else None
        found = "; ".join(judged.findings) if judged is not None else ""
        noted = {**self.tally.noted, **({"unusable_readings": found} if found else {})}
        metadata = checked_metadata({**self.tally.started, **self.plan.metadata, **noted})

        def rows() -> Iterator[tuple[FloatArray, ...]]:
            for block in itertools.chain(buffered, blocks):
                yield tuple(block[name] for name in self.plan.names)
            self._refuse_unusable()

        write_blocks(self.plan.names, rows(), metadata, output, matlab_version)

    def _blocks(self) -> Iterator[dict[str, FloatArray]]:
        for block in checked_blocks(self.plan, self.tally):
            self.readings.add(block)
            yield block

    def _refuse_unusable(self) -> None:
        path, ranges = self.plan.table.path, self.tally.ranges
        none = next((name for name in ("shunt_voltage_v", "wire_current_a") if ranges.get(name) == (0.0, 0.0)), None)
        if none is not None:
            raise RecordingError(f"{path}: {none} is 0 in every row: no current was measured, record it again")
        if self.judged_readings is not None and self.judged_readings.contradiction:
            raise RecordingError(f"{path}: {self.judged_readings.contradiction}")
