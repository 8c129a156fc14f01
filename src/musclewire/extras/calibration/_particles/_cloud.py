"""The hypotheses of a particle filter in memory: arrays for compiled code, and bytes as an immutable state."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.extras.calibration._particles._settings import UNKNOWNS, ParticleSettings
from musclewire.wire import Rows, WireState

N_UNKNOWNS = len(UNKNOWNS)


class SharedPlaces(NamedTuple):
    """Places of the numbers that all hypotheses share."""

    samples: int
    noise_v: int
    last_ohm: int
    last_but_one_ohm: int
    misfit: int
    kept: int


CLOCK = SharedPlaces(*range(6))


class SampleHistory(NamedTuple):
    """Rows of the samples kept since the older snapshot; the variance is that of a hypothesis's resistance."""

    power_w: int
    duration_s: int
    resistance_ohm: int
    variance_ohm2: int


HISTORY = SampleHistory(*range(4))


class ParticleCloud(NamedTuple):
    """All hypotheses, as compiled code takes them; each row is one."""

    wires: Rows  # the wire of each, (n_hypotheses,): rows of :class:`WireState`
    unknowns: FloatArray  # values of ``UNKNOWNS``, (n_hypotheses, n_unknowns)
    changed: FloatArray  # 1 where an unknown has changed, else 0, (n_hypotheses, n_unknowns)
    log_weight: FloatArray  # (n_hypotheses,)
    # Logarithm of each one's likelihood since the older and since the newer snapshot, (2, n_hypotheses).
    since: FloatArray
    old: Rows  # wires of two snapshots, drawn by their weights, (n_snapshot,)
    new: Rows
    history: FloatArray  # samples since the older snapshot, in the rows of :class:`SampleHistory`, (4, n_kept)
    clock: FloatArray  # what all share: see :class:`SharedPlaces`


def cloud_of(state: bytes, classes: int, settings: ParticleSettings) -> ParticleCloud:
    """Return a copy of a state's hypotheses, which may be changed; ``classes`` of barrier has each wire."""
    numbers = np.frombuffer(state, np.float64).copy()
    layout = WireState.layout(classes)
    width, n, kept = layout.itemsize // 8, settings.hypotheses, settings.snapshot
    sizes = [n * width, n * N_UNKNOWNS, n * N_UNKNOWNS, n, 2 * n, kept * width, kept * width]
    rest = numbers.size - len(CLOCK)
    ends = [*np.cumsum(sizes), rest]
    wires, unknowns, changed, log_weight, since, old, new, history, clock = np.split(numbers, ends)
    return ParticleCloud(
        wires.view(layout),
        unknowns.reshape(n, N_UNKNOWNS),
        changed.reshape(n, N_UNKNOWNS),
        log_weight,
        since.reshape(2, n),
        old.view(layout),
        new.view(layout),
        history.reshape(len(HISTORY), -1),
        clock,
    )


def state_of(cloud: ParticleCloud) -> bytes:
    """Return the hypotheses as an immutable state."""
    return b"".join(array.tobytes() for array in cloud)


def cloud_at_rest(rest: WireState, settings: ParticleSettings, sample_period_s: float) -> ParticleCloud:
    """Return hypotheses that nothing has changed, each with a wire at rest, within what a calibration leaves open."""
    n = settings.hypotheses
    left_open = np.random.default_rng(settings.seed).standard_normal((n, N_UNKNOWNS))
    kept = 2 * max(round(settings.restart_time_s / sample_period_s), 2)
    return ParticleCloud(
        np.repeat(rest.row, n),
        left_open * np.array(settings.spread_at_rest),
        np.zeros((n, N_UNKNOWNS)),
        np.full(n, -np.log(n)),
        np.zeros((2, n)),
        np.repeat(rest.row, settings.snapshot),
        np.repeat(rest.row, settings.snapshot),
        np.zeros((len(HISTORY), kept)),
        np.zeros(len(CLOCK)),
    )
