"""The one loop in which a rig, a policy and a recorder meet.

The rig owns the clock, the policy is pure, and the rig ends at its sense voltage whatever a policy, a callback
or the user's Ctrl-C raises: the first thing that happens on the way out, before anything is written.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter_ns
from typing import NamedTuple, Protocol, TypedDict

from musclewire.errors import CallerError
from musclewire.experiment.recorder import Recorder
from musclewire.experiment.timing import LoopTiming
from musclewire.rigs.abilities import exchange_times_of, protection_limits_of
from musclewire.rigs.protocol import Rig
from musclewire.signals.exchange import ELECTRICAL_COLUMNS, REFERENCE_COLUMNS, Command, RawSample
from musclewire.signals.recording import MetadataValue, Recording

__all__ = ["Decision", "OnSample", "Policy", "RunOptions", "file_in", "refuse_unusable", "run_on_rig"]

OnSample = Callable[[Mapping[str, float]], None]
Exchange = Callable[[Command], RawSample]
# Rows that may be lost to a power cut: about a second of a paced rig, a fraction of one where no clock paces.
PACED_BLOCK_S, FREE_BLOCK_ROWS = 1.0, 200
# A block takes some milliseconds to write, on a busy machine over ten: in shorter periods another process writes it.
MIN_PERIOD_FOR_DISK_S = 0.02


class RunOptions(TypedDict, total=False):
    """Keywords of every run on a rig.

    ``path`` is the recording's file, none without; ``overwrite`` replaces one that exists; ``on_sample`` sees every
    recorded row and may raise to stop the run.
    """

    path: str | Path | None
    overwrite: bool
    on_sample: OnSample | None


class Decision(NamedTuple):
    """What a policy says after a sample: the next command, and what to record beside the sample."""

    command: Command
    columns: Mapping[str, float]


class Policy(Protocol):
    """Chooses what the rig is to do next. It has no clock: time is what the samples say."""

    @property
    def columns(self) -> Sequence[str]:
        """Names of the columns its decisions add to a recording."""
        ...

    def first_command(self) -> Command:
        """Return the command for the first sample period.

        Returns
        -------
        A drive voltage, or a target for a device with a closed loop of its own.
        """
        ...

    def after(self, sample: RawSample, elapsed_s: float) -> Decision:
        """Return the decision after a sample.

        Parameters
        ----------
        sample
            What the rig has just handed back.
        elapsed_s
            End of the sample, counted from the beginning of the run [s].

        Returns
        -------
        The next command, and what is recorded next to the sample.

        Raises
        ------
        RigError
            If the run cannot go on; the rig then goes to its sense voltage.
        """
        ...


def file_in(folder: str | Path, name: str) -> Path:
    """Return a file in a folder that is made if need be. Raises CallerError where that cannot be."""
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CallerError(f"cannot make the folder {folder}: {error.strerror or error}") from None
    return Path(folder) / name


def refuse_unusable(path: str | Path | None, overwrite: bool) -> None:
    """Raise CallerError where a recording could not be put, before anything is heated for it."""
    if path is None:
        return
    if Path(path).exists() and not overwrite:
        raise CallerError(f"{path} exists: give another name, or allow replacing it (--overwrite, overwrite=True)")
    if not Path(path).parent.is_dir():
        raise CallerError(f"{path}: there is no folder {Path(path).parent}")


def run_on_rig(
    rig: Rig,
    policy: Policy,
    duration_s: float,
    *,
    metadata: Mapping[str, MetadataValue] | None = None,
    path: str | Path | None = None,
    overwrite: bool = False,
    on_sample: OnSample | None = None,
) -> Recording:
    """Drive a rig by a policy for a time and return the recording.

    Any exception leaves the rig at its sense voltage and carries the partial recording as ``.recording``. How punctual
    the run was is in the metadata.

    Parameters
    ----------
    rig
        The rig, open.
    policy
        Chooses each command; it may raise to stop the run.
    duration_s
        Length of the run [s], rounded to whole samples.
    metadata
        What the recording is to say besides what the rig says.
    path
        File that is written while the run goes on; by default the recording is only returned.
    overwrite
        Whether a file that exists is replaced.
    on_sample
        Gets every recorded row; it may raise to stop the run.

    Returns
    -------
    The recording, with the columns of rig and policy.

    Raises
    ------
    CallerError
        For a duration under one sample, and a file that cannot be written, before anything is heated.
    RigError
        For whatever ends the run on the rig's side.
    """
    samples = round(duration_s / rig.sample_period_s)
    if samples < 1:
        raise CallerError(f"a run of {duration_s} s is shorter than one sample of {rig.sample_period_s} s")
    refuse_unusable(path, overwrite)
    timing = LoopTiming(rig.sample_period_s, rig.paced)
    exchange = timed_exchange(rig, timing)
    described = {**what_protects(rig), **rig.metadata(), **(metadata or {})}
    first: RawSample | None = None
    try:
        command = policy.first_command()
        instruments = rig.reference_columns
        if instruments is None:  # then the first sample shows them
            first = exchange(command)
            instruments = tuple(name for name in REFERENCE_COLUMNS if getattr(first, name) is not None)
        columns = [*ELECTRICAL_COLUMNS, *instruments, *policy.columns]
        with recorder_for(rig, columns, described, path, overwrite) as recorder, few_collections():
            try:
                first = exchange(command) if first is None else first
                follow(policy, exchange, first, samples, rig.sample_period_s, recorder, timing, on_sample)
            finally:
                rig.make_safe()  # before the recorder closes its file: a slow disk must not keep a wire hot
                # Once more: what a rig counts, lost frames for one, is known only now.
                recorder.describe({**rig.metadata(), **(metadata or {}), **timing.metadata()})
    finally:
        rig.make_safe()
    return recorder.recording()


def follow(
    policy: Policy,
    exchange: Exchange,
    sample: RawSample,
    samples: int,
    sample_period_s: float,
    recorder: Recorder,
    timing: LoopTiming,
    on_sample: OnSample | None,
) -> None:
    """Hand each sample to the policy, record both, hand the policy's command to the rig; from a first sample on."""
    start_s = sample.time_s - sample_period_s
    for left in range(samples, 0, -1):
        # A recording counts from its own start; rounded, because the difference of clocks is not, and before the policy
        # sees it, so that a replay of the recording shows it the very same time.
        elapsed_s = round(sample.time_s - start_s, 9)
        decision = policy.after(sample, elapsed_s)
        row = sample._asdict()
        row.update(decision.columns, time_s=elapsed_s)
        recorder.append(row)
        if on_sample is not None:
            called_ns = perf_counter_ns()
            on_sample(row)
            timing.called_back(perf_counter_ns() - called_ns)
        if left > 1:
            sample = exchange(decision.command)


def timed_exchange(rig: Rig, timing: LoopTiming) -> Exchange:
    """Return the rig's exchange, with its times noted: the rig's own where it tells them, as it judges each sample."""
    times = exchange_times_of(rig)
    if times is not None:

        def exchange(command: Command) -> RawSample:
            sample = rig.exchange(command)
            timing.sampled(times.drive_at_ns, times.sample_at_ns)
            return sample
    else:

        def exchange(command: Command) -> RawSample:
            drive_at_ns = perf_counter_ns()
            sample = rig.exchange(command)
            timing.sampled(drive_at_ns, perf_counter_ns())
            return sample

    return exchange


def recorder_for(
    rig: Rig, columns: Sequence[str], metadata: Mapping[str, MetadataValue], path: str | Path | None, overwrite: bool
) -> Recorder:
    """Return a recorder that a rig's pace does not have to wait for."""
    rows = max(1, round(PACED_BLOCK_S / rig.sample_period_s)) if rig.paced else FREE_BLOCK_ROWS
    apart_s = rig.sample_period_s if rig.paced and rig.sample_period_s < MIN_PERIOD_FOR_DISK_S else None
    return Recorder(columns, metadata, path, overwrite=overwrite, block_rows=rows, apart_period_s=apart_s)


def what_protects(rig: Rig) -> dict[str, MetadataValue]:
    """Return the limits a rig is protected by; a replay of the recording is held to the same."""
    protection = protection_limits_of(rig)
    limits = {} if protection is None else protection._asdict()
    return {"drive_amplitude_v": rig.drive_amplitude_v, **{f"limit_{name}": value for name, value in limits.items()}}


@contextmanager
def few_collections() -> Iterator[None]:
    """Keep the garbage collector from walking through all that was there before a run.

    A full collection over the objects of NumPy, Numba and Matplotlib takes tens of milliseconds. What the run itself
    leaves behind is little and still collected.
    """
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
