"""The one loop in which a rig and a policy meet, and their recorder: the rows of the run, and its timing.

The rig owns the clock, the policy is pure, and the rig ends at its sense voltage whatever a policy, a callback or the
user's Ctrl-C raises: this happens first, before anything is written.
"""

from __future__ import annotations

import gc
import os
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from math import nan
from operator import itemgetter
from pathlib import Path
from time import perf_counter_ns
from types import TracebackType
from typing import NamedTuple, Protocol, Self, TypedDict

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingNotWrittenError
from musclewire.experiment._calm_air import AirWatch
from musclewire.experiment._endings import cause_of, first_line, rescued, software_version
from musclewire.experiment._known_drive import TakenRun, run_compiled_drive
from musclewire.experiment._run_warnings import found_in
from musclewire.experiment._timing_facts import NO_CLOCK, RunPacing, timing_metadata
from musclewire.rigs import Rig, SimulationClock, adjustable_clock_of
from musclewire.signals import (
    ELECTRICAL_COLUMNS,
    Command,
    MetadataValue,
    OpenJournal,
    RawSample,
    Recording,
    refuse_unfinished,
    with_answers_of,
)

OnSample = Callable[[Mapping[str, float]], None]
Until = Callable[[], bool]
Waveform = Callable[[float], float]
Exchange = Callable[[Command], RawSample]


class RunOptions(TypedDict, total=False):
    """Keywords of every run on a rig."""

    path: str | Path | None  # file of the recording, none without
    overwrite: bool  # a file that exists is replaced
    on_sample: OnSample | None  # sees every recorded row and may raise to stop the run
    until: Until | None  # asked after each row; ends the run early, as done


class Decision(NamedTuple):
    """A policy's answer to a sample: the next command, and a value to record for each of the policy's columns."""

    command: Command
    values: tuple[float, ...] = ()


class Policy(Protocol):
    """Chooses what the rig is to do next. It has no clock: time is what the samples say."""

    @property
    def columns(self) -> Sequence[str]:
        """Names of the columns its decisions add to a recording."""
        ...

    def first_command(self) -> Command:
        """Return the first sample period's command: a drive voltage, or a target for a device with its own loop."""
        ...

    def after(self, sample: RawSample, elapsed_s: float) -> Decision:
        """Return the next command after a sample, and what is recorded next to it.

        ``elapsed_s`` is the sample's end, counted from the beginning of the run. Raises RigError if the run cannot go
        on; the rig then goes to its sense voltage.
        """
        ...


class FollowingPart(NamedTuple):
    """What a run goes on with once its time is over: a policy, and for how long [s]."""

    policy: Policy
    duration_s: float


class Following(NamedTuple):
    """How a run goes on once its time is over."""

    begins: str  # name under which the metadata state where this segment begins
    chosen_by: Callable[[Recording], FollowingPart | None]  # chooses the segment by the recording until then, or None


def file_in(folder: str | Path, name: str) -> Path:
    """Return a file in a folder, which is created if missing. Raises CallerError if that fails."""
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CallerError(f"cannot make the folder {folder}: {error.strerror or error}") from None
    return Path(folder) / name


def refuse_unusable(path: str | Path | None, overwrite: bool) -> None:
    """Raise CallerError if a recording cannot be written, before anything is heated for it."""
    if path is None:
        return
    refuse_unfinished(path, overwrite)
    folder = Path(path).parent
    if not folder.is_dir():
        raise CallerError(f"{path}: there is no folder {folder}; make it first")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise CallerError(f"{path}: the folder {folder.absolute()} cannot be written to; give another one")


# Some 58 days at 20 samples a second: what is longer was not meant.
MAX_SAMPLES = 100_000_000


def run_on_rig(
    rig: Rig,
    policy: Policy,
    duration_s: float,
    *,
    metadata: Mapping[str, MetadataValue] | None = None,
    path: str | Path | None = None,
    overwrite: bool = False,
    on_sample: OnSample | None = None,
    until: Until | None = None,
    following: Following | None = None,
) -> Recording:
    """Drive a rig by a policy for a time, rounded to whole samples, and return the recording.

    Any exception leaves the rig at its sense voltage and carries the partial recording as ``.recording``. A drive that
    is known beforehand is run in compiled code on a simulated rig without a clock, unless ``on_sample`` or ``until`` is
    given: the recording is the same, its metadata ``compiled_loop`` or ``not_compiled`` say so. ``following`` says at
    the end what to go on with, by a policy with the same columns; the rig is at its sense voltage in between. Raises
    CallerError for a duration under one sample, and a file that cannot be written, before anything is heated. Raises
    RigError if the rig failed or was tripped.
    """
    samples = round(duration_s / rig.sample_period_s)
    if samples < 1:
        raise CallerError(
            f"a run of {duration_s} s is shorter than one sample of {rig.sample_period_s} s: give a longer one"
        )
    if samples > MAX_SAMPLES:
        raise CallerError(
            f"a run of {duration_s:.3g} s would take {samples:.3g} samples, and a recording holds {MAX_SAMPLES:.0g} at "
            "most: give a shorter one, or a longer sample period"
        )
    refuse_unusable(path, overwrite)
    # A run that is killed says when the next segment was to begin; one that ends, when it began.
    begins: dict[str, MetadataValue] = {} if following is None else {following.begins: samples * rig.sample_period_s}
    described = {**what_protects(rig), **rig.metadata(), **(metadata or {}), **begins}
    timing = LoopTiming(rig.sample_period_s, rig.paced, adjustable_clock_of(rig))
    exchange = timed_exchange(rig, timing, AirWatch(rig))
    try:
        rig.rest()
        command = policy.first_command()
        measured = (*ELECTRICAL_COLUMNS, *rig.reference_columns)
        columns = (*measured, *policy.columns)
        with Recorder(columns, described, path, overwrite=overwrite) as recorder, few_collections():
            # A callback may look at the rig after each sample: then samples are taken one by one.
            loop = RunParts(rig, exchange, recorder, measured, timing, on_sample, until)
            taken: TakenRun | str = ""
            try:
                taken = compiled_part(loop, policy, samples)
                start_s, to_its_end = take_part(loop, policy, command, samples, taken)
                if following is not None and to_its_end:
                    recorder.describe({following.begins: recorder.duration_s})
                    go_on(loop, following.chosen_by(recorder.recording()), start_s)
            finally:
                rig.make_safe()  # before the recorder closes its file: a slow disk must not keep a wire hot
                # Once more: what a rig counts, lost frames for one, is known only now.
                recorder.describe({**rig.metadata(), **(metadata or {}), **sampling_metadata(taken, timing)})
            whole = recorder.recording()
            recorder.describe(found_in(whole))
    finally:
        rig.make_safe()
    return with_answers_of(recorder.recording(), whole)


class RunParts(NamedTuple):
    """What a run has besides its policies: rig, exchange, recorder, its fields of a sample, and who looks at them."""

    rig: Rig
    exchange: Exchange
    recorder: Recorder
    measured: tuple[str, ...]
    timing: LoopTiming
    on_sample: OnSample | None = None
    until: Until | None = None


def compiled_part(loop: RunParts, policy: Policy, samples: int, start_s: float | None = None) -> TakenRun | str:
    """Return samples taken by a policy in compiled code, or why they are not; "" if a callback looks at each."""
    alone = loop.on_sample is None and loop.until is None
    return run_compiled_drive(loop.rig, policy, samples, start_s) if alone else ""


def take_part(
    loop: RunParts,
    policy: Policy,
    command: Command,
    samples: int,
    taken: TakenRun | str,
    start_s: float | None = None,
) -> tuple[float, bool]:
    """Record samples by a policy, one by one unless they are taken.

    Returns the run's start on the rig's clock [s], which is ``start_s`` if the run has begun, and whether nobody ended
    it before its time.
    """
    if isinstance(taken, TakenRun):
        loop.recorder.append_all(taken.rows(loop.measured))
        return taken.start_s, True
    sample = loop.exchange(command)
    start_s = sample.time_s - loop.rig.sample_period_s if start_s is None else start_s
    return start_s, follow(loop, policy, sample, samples, start_s)


def go_on(loop: RunParts, part: FollowingPart | None, start_s: float) -> None:
    """Go on with a part of its own, if there is one; the rig is safe in between."""
    if part is None:
        return
    loop.rig.make_safe()
    policy, samples = part.policy, round(part.duration_s / loop.rig.sample_period_s)
    taken = compiled_part(loop, policy, samples, start_s)
    take_part(loop, policy, policy.first_command(), samples, taken, start_s)


def follow(loop: RunParts, policy: Policy, sample: RawSample, samples: int, start_s: float) -> bool:
    """Let the policy answer each sample, record both, command the rig; return False if somebody ended it."""
    _, exchange, recorder, measured, timing, on_sample, until = loop
    # The time comes first and is the run's own.
    fields_of = itemgetter(*(RawSample._fields.index(name) for name in measured[1:]))
    for left in range(samples, 0, -1):
        # A recording counts from its own start; rounded, because the difference of clocks is not, and before the policy
        # sees it, so that a replay of the recording shows it the very same time.
        elapsed_s = round(sample.time_s - start_s, 9)
        decision = policy.after(sample, elapsed_s)
        recorder.append([elapsed_s, *fields_of(sample), *decision.values])
        if on_sample is not None:
            called_ns = perf_counter_ns()
            found = dict(zip(policy.columns, decision.values, strict=True))
            on_sample({**sample._asdict(), "time_s": elapsed_s, **found})
            timing.record_callback(perf_counter_ns() - called_ns)
        if until is not None and until():
            return False
        if left > 1:
            sample = exchange(decision.command)
    return True


def sampling_metadata(taken: TakenRun | str, timing: LoopTiming) -> dict[str, MetadataValue]:
    """Return the metadata on how samples were taken: in compiled code, or one by one with their times."""
    if isinstance(taken, TakenRun):
        return {"pace": NO_CLOCK, "deadline_misses": 0, "compiled_loop": True}
    return {**timing.metadata(), **({"not_compiled": taken} if taken else {})}


def timed_exchange(rig: Rig, timing: LoopTiming, air: AirWatch) -> Exchange:
    """Return the rig's exchange, with its times recorded and its air watched."""

    def exchange(command: Command) -> RawSample:
        sample = rig.exchange(command)
        timing.sampled(rig.drive_at_ns, rig.sample_at_ns)
        air.see(sample)
        return sample

    return exchange


def what_protects(rig: Rig) -> dict[str, MetadataValue]:
    """Return the limits a rig is protected by; a replay of the recording is held to the same."""
    limits = rig.protection_limits._asdict()
    return {"drive_amplitude_v": rig.drive_amplitude_v, **{f"limit_{name}": value for name, value in limits.items()}}


@contextmanager
def few_collections() -> Iterator[None]:
    """Keep the garbage collector from walking through what was there before a run, which takes tens of milliseconds."""
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


class Recorder:
    """Collects rows; with a path each is also in a file within a tenth of a second, where it survives a crash."""

    def __init__(
        self,
        columns: Sequence[str],
        metadata: Mapping[str, MetadataValue],
        path: str | Path | None = None,
        *,
        overwrite: bool = False,
    ) -> None:
        """Start an empty recording. CallerError if ``path`` cannot be written, or exists and may not be replaced."""
        self._columns = tuple(columns)
        start_time = datetime.now(UTC).isoformat(timespec="seconds")
        self._metadata = {**metadata, "software_version": software_version(), "start_time": start_time}
        self._journal: OpenJournal | None = None
        if path is not None:
            self._journal = OpenJournal(path, columns, self._metadata, overwrite, in_background=True)
        # Plain numbers in one block: a million rows make no objects for the garbage collector to walk through.
        self._values = array("d") if self._journal is None else self._journal.values
        self._ended = "running"

    def append(self, row: list[float | None]) -> None:
        """Keep one row, a value for each column in their order, None for an instrument without a reading.

        Raises ValueError for a row of another length, RecordingNotWrittenError if the disk takes no more.
        """
        if len(row) != len(self._columns):
            raise ValueError(
                f"a row of {len(row)} values for {len(self._columns)} columns, needs one for each: "
                f"{', '.join(self._columns)}"
            )
        try:
            self._values.fromlist(row)  # type: ignore[arg-type]  # unless an instrument has no reading
        except TypeError:
            self._values.fromlist([nan if value is None else value for value in row])
        if self._journal is not None and self._journal.failure is not None:
            raise not_written_error(self._journal.path, self._journal.failure)

    def append_all(self, rows: FloatArray) -> None:
        """Keep rows of a finished run, (n_samples, n_columns)."""
        self._values.frombytes(np.ascontiguousarray(rows, dtype=np.float64).tobytes())

    def describe(self, metadata: Mapping[str, MetadataValue]) -> None:
        """Add metadata that is known only at the end; the file has it once it is closed."""
        self._metadata.update(metadata)

    @property
    def duration_s(self) -> float:
        """Time of the last row [s]; IndexError without rows."""
        return self._values[(len(self) - 1) * len(self._columns) + self._columns.index("time_s")]

    def __len__(self) -> int:
        """Return the number of rows recorded."""
        return len(self._values) // len(self._columns)

    def recording(self) -> Recording:
        """Return the rows recorded until now."""
        table = np.array(self._values, dtype=np.float64).reshape(len(self), len(self._columns))
        columns = {name: table[:, place] for place, name in enumerate(self._columns)}
        return Recording(columns, {**self._metadata, "ended": self._ended})

    def __enter__(self) -> Self:
        """Return the recorder itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Write the remaining rows and how the run ended; an exception carries the partial recording."""
        # By now the rig is safe: a slow disk cannot keep a wire hot.
        self._ended = cause_of(error)
        problem = self._close_file()
        where = self._where(problem)
        if problem is None and error is None:
            return
        raised = error or problem
        raised.recording = self.recording()  # type: ignore[union-attr]
        raised.add_note(f"{len(self)} samples were recorded; they are in error.recording{where}")  # type: ignore[union-attr]
        if error is None and problem is not None:
            raise problem

    def _close_file(self) -> RecordingNotWrittenError | None:
        if self._journal is None:
            return None
        try:
            self._journal.close(self._ended, self._metadata)
        except RecordingNotWrittenError as problem:
            return problem
        except OSError as problem:
            return not_written_error(self._journal.path, problem)
        return None

    def _where(self, problem: RecordingNotWrittenError | None) -> str:
        """Return where the rows are, as the end of a note; saved elsewhere if their file has not all of them."""
        if self._journal is None:
            return ""
        if problem is None:
            return f" and in {self._journal.path}"
        rows, journal = self._journal.leave(self._ended), self._journal.journal
        if rows == len(self):
            return f" and in {journal}"
        saved = rescued(self.recording(), self._journal.path.stem)
        return f" and in {saved}" if saved else f" and in {journal} (the first {rows})"


def not_written_error(path: Path, problem: OSError) -> RecordingNotWrittenError:
    """Return the error for a file that can no longer be written."""
    return RecordingNotWrittenError(f"cannot write {path}: {problem.strerror or first_line(problem)}")


class LoopTiming:
    """Records when each sample arrived and the next drive was handed over, in ns of a clock that it does not read."""

    def __init__(self, sample_period_s: float, paced: bool, clock: SimulationClock | None = None) -> None:
        """Watch a run of this sample period; ``paced`` if a real clock sets its pace, at the speed of ``clock``."""
        self._pace = RunPacing(sample_period_s, paced, clock)
        self._drive_ns, self._sample_ns, self._callbacks_ns = array("q"), array("q"), array("q")

    def sampled(self, drive_at_ns: int, sample_at_ns: int) -> None:
        """Record one exchange: when its drive was handed to the output and when its sample arrived."""
        self._drive_ns.append(drive_at_ns)
        self._sample_ns.append(sample_at_ns)

    def record_callback(self, callback_ns: int) -> None:
        """Record how long a callback kept the loop waiting after the last sample; called after every one or never."""
        self._callbacks_ns.append(callback_ns)

    def metadata(self) -> dict[str, MetadataValue]:
        """Return the timing for a recording's metadata, as ``timing_metadata`` describes it."""
        times = (np.array(self._drive_ns), np.array(self._sample_ns), np.array(self._callbacks_ns))
        return timing_metadata(self._pace, *times)
