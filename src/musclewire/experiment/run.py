"""The one loop in which a rig, a policy and a recorder meet.

The rig owns the clock, the policy is pure, and the rig ends at its sense voltage whatever a policy, a callback
or the user's Ctrl-C raises: the first thing that happens on the way out, before anything is written.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, Protocol

from musclewire.errors import CallerError
from musclewire.experiment.recorder import Recorder
from musclewire.rigs.protocol import Rig
from musclewire.signals.recording import MetadataValue, Recording
from musclewire.signals.samples import RawSample

__all__ = ["Decision", "OnSample", "Policy", "file_in", "refuse_unusable", "run_on_rig"]

OnSample = Callable[[Mapping[str, float]], None]
# Rows that may be lost to a power cut: about a second of a paced rig, a fraction of one where no clock paces.
PACED_BLOCK_ROWS, FREE_BLOCK_ROWS = 20, 200
REFERENCE_COLUMNS = RawSample._fields[4:]


class Decision(NamedTuple):
    """What a policy says after a sample: the next drive voltage and what to record beside the sample."""

    drive_voltage_v: float
    columns: Mapping[str, float]


class Policy(Protocol):
    """Chooses the drive voltage. It has no clock: time is what the samples say."""

    @property
    def columns(self) -> Sequence[str]:
        """Names of the columns its decisions add to a recording."""
        ...

    def first_drive_voltage_v(self) -> float:
        """Return the drive for the first sample period."""
        ...

    def after(self, sample: RawSample, elapsed_s: float) -> Decision:
        """Return the decision after a sample that ended ``elapsed_s`` into the run."""
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
        raise CallerError(f"{path} exists: give another name, or allow replacing it (--force, overwrite=True)")
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

    ``on_sample`` sees every recorded row; it may raise to stop the run. Any exception leaves the rig at its
    sense voltage and carries the partial recording as ``.recording``.
    Raises CallerError for a duration under one sample.
    """
    samples = round(duration_s / rig.sample_period_s)
    if samples < 1:
        raise CallerError(f"a run of {duration_s} s is shorter than one sample of {rig.sample_period_s} s")
    refuse_unusable(path, overwrite)
    try:
        drive = policy.first_drive_voltage_v()
        sample = rig.exchange(drive)
        start_s = sample.time_s - rig.sample_period_s
        # The first sample also tells which reference instruments the rig has.
        references = [name for name in REFERENCE_COLUMNS if getattr(sample, name) is not None]
        columns = [*RawSample._fields[:4], *references, *policy.columns]
        block_rows = PACED_BLOCK_ROWS if rig.paced else FREE_BLOCK_ROWS
        described = {**rig.metadata(), **(metadata or {})}
        with Recorder(columns, described, path, overwrite=overwrite, block_rows=block_rows) as recorder:
            try:
                for index in range(samples):
                    if index:
                        sample = rig.exchange(drive)
                    decision = policy.after(sample, sample.time_s - start_s)
                    # A recording counts from its own start; rounded, because the difference of clocks is not.
                    row = {**sample._asdict(), **decision.columns, "time_s": round(sample.time_s - start_s, 9)}
                    recorder.append(row)
                    if on_sample is not None:
                        on_sample(row)
                    drive = decision.drive_voltage_v
            finally:
                rig.make_safe()  # before the recorder closes its file: a slow disk must not keep a wire hot
    finally:
        rig.make_safe()
    return recorder.recording()
