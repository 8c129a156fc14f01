"""How punctual a run was, as its recording states it: percentiles in the metadata, and the same as JSON keys."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray, IntArray
from musclewire.rigs import SimulationClock, scheduling
from musclewire.signals import MetadataValue

NO_CLOCK = "none: samples came as fast as they were computed"
CLOCK = "real time"
CHANGED_CLOCK = "a clock whose speed was changed during the run"

PERCENTILES = {"p50": 50.0, "p99": 99.0, "p999": 99.9}


def percentiles(name: str, values_us: FloatArray) -> dict[str, MetadataValue]:
    """Return the percentiles of times [us] under the names of metadata; none without times."""
    if not values_us.size:
        return {}
    found = np.percentile(values_us, list(PERCENTILES.values()))
    return {f"{name}_{key}_us": round(float(value), 1) for key, value in zip(PERCENTILES, found, strict=True)}


class RunPacing:
    """What paces a run from its beginning on: nothing, real time, or a clock whose speed may change."""

    def __init__(self, sample_period_s: float, paced: bool, clock: SimulationClock | None) -> None:
        """Look at the clock as it is now."""
        self._clock, self._changes = clock, 0 if clock is None else clock.changes
        self._speed = 1.0 if clock is None else clock.speed
        self._paced = paced
        self.period_us = sample_period_s * 1e6 / self._speed

    @property
    def even(self) -> bool:
        """Whether a clock has paced all of the run at one speed."""
        return self._paced and (self._clock is None or self._clock.changes == self._changes)

    def __str__(self) -> str:
        """Say it in words."""
        if not self._paced:
            return NO_CLOCK
        if not self.even:
            return CHANGED_CLOCK
        return CLOCK if self._speed == 1.0 else f"{self._speed:g} times {CLOCK}"


def timing_metadata(
    pace: RunPacing, drive_ns: IntArray, sample_ns: IntArray, callbacks_ns: IntArray
) -> dict[str, MetadataValue]:
    """Return a run's timing for its metadata; only compute times unless a clock paced it at one speed.

    ``jitter`` is the deviation of the time between two samples from the sample period, ``latency`` from a sample to
    the next drive at the output, ``compute`` the part of it that is not a callback's: policy, protection, recorder.
    ``deadline_misses`` counts the sample periods in which no sample came, ``drift_us`` is the excess of the whole
    run's duration over its periods.
    """
    latencies = (drive_ns[1:] - sample_ns[:-1]) / 1e3
    # The run ends at its last sample, whose callback is before no drive.
    callbacks = callbacks_ns[: latencies.size] / 1e3
    compute = latencies - callbacks if callbacks.size else latencies
    found: dict[str, MetadataValue] = {"pace": str(pace), "deadline_misses": 0}
    found |= percentiles("compute", compute)
    if not pace.even or not latencies.size:
        return found
    intervals = np.diff(sample_ns) / 1e3
    # A burst after a late sample catches up: only whole periods without a sample are misses.
    empty = np.rint(intervals / pace.period_us) - 1.0
    found["scheduling"] = scheduling()
    found["deadline_misses"] = int(empty[empty > 0.0].sum())
    found["drift_us"] = round(float(intervals.sum() - intervals.size * pace.period_us), 1)
    return found | percentiles("jitter", np.abs(intervals - pace.period_us)) | percentiles("latency", latencies)


def timing_json(metadata: Mapping[str, MetadataValue]) -> dict[str, Any]:
    """Return the timing in a recording's metadata as JSON keys; None for what was not measured."""
    found: dict[str, Any] = {"deadline_misses": metadata.get("deadline_misses", 0)}
    for name in ("jitter", "latency", "compute"):
        parts = {key: metadata.get(f"{name}_{key}_us") for key in PERCENTILES}
        found[f"{name}_us"] = None if None in parts.values() else parts
    return {**found, "drift_us": metadata.get("drift_us")}
