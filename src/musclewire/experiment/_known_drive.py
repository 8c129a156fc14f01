"""Runs whose whole drive is known beforehand: on a simulated rig they are taken in compiled code.

The recording is that of the loop in Python, and the rig goes on from the same state. Where that is not possible, the
loop in Python runs, and the recording states why in ``not_compiled``.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.rigs import HasTrueState, Rig, ability


class KnownDrive(NamedTuple):
    """The drive of each sample [V], (n_samples,), and what a policy records in addition, (n_samples, n_columns)."""

    drives_v: FloatArray
    values: FloatArray
    true_names: tuple[str, ...] = ()  # fields of the simulated wire's state that are recorded after these columns


@runtime_checkable
class KnownDrivePolicy(Protocol):
    """A policy that does not look at samples, only at their times."""

    def known_drive(self, elapsed_s: tuple[float, ...]) -> KnownDrive | None:
        """Return drives and recorded values, as by ``first_command`` and ``after``; None if not known."""
        ...


class TakenRun(NamedTuple):
    """All samples of a run taken in compiled code: columns of the rig by name, and the policy's values."""

    start_s: float
    elapsed_s: FloatArray
    columns: dict[str, FloatArray]
    values: FloatArray

    def rows(self, measured: Sequence[str]) -> FloatArray:
        """Return the rows of a recording with these columns of the rig, time first, (n_samples, n_columns)."""
        return np.column_stack([self.elapsed_s, *(self.columns[name] for name in measured[1:]), self.values])


@lru_cache(maxsize=16)
def elapsed_times_s(ends_s: tuple[float, ...], start_s: float) -> tuple[float, ...]:
    """Return the ends of samples counted from the run's start [s], rounded as the loop in Python rounds them."""
    return tuple(round(end_s - start_s, 9) for end_s in ends_s)


def run_compiled_drive(rig: Rig, policy: object, samples: int, start_s: float | None = None) -> TakenRun | str:
    """Take all samples of a run in compiled code if that is possible, otherwise return why not.

    The reason is empty if the drive is not known, or if no simulation runs: then nobody expects it. The rig is left as
    the samples leave it, without them as it was.
    """
    if not isinstance(policy, KnownDrivePolicy) or ability(rig, HasTrueState) is None:
        return ""
    # Only now: a real rig does without the simulator.
    from musclewire.rigs import CompiledLoopEnd, run_known_drive, times_on_rig_s, uncompiled

    reason = uncompiled(rig)
    if reason:
        return reason
    times_s = times_on_rig_s(rig, samples)
    start_s = float(times_s[0]) - rig.sample_period_s if start_s is None else start_s
    elapsed_s = elapsed_times_s(tuple(times_s.tolist()), start_s)
    known = policy.known_drive(elapsed_s)
    if known is None:
        return ""
    run = run_known_drive(rig, known.drives_v, known.true_names)
    if run.ended is not CompiledLoopEnd.DONE:
        return f"{run.ended.name.lower().replace('_', ' ')} at sample {run.samples + 1}"
    return TakenRun(start_s, np.array(elapsed_s), run.columns, np.hstack([known.values, run.true]))
