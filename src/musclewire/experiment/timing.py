"""How punctual a run was: missed deadlines, jitter, latency and compute time, for the recording's metadata."""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.rigs.real_time import scheduling
from musclewire.signals.recording import MetadataValue

__all__ = ["LoopTiming", "timing_json"]

PERCENTILES = {"p50": 50.0, "p99": 99.0, "p999": 99.9}
NO_CLOCK = "none: samples came as fast as they were computed"
CLOCK = "real time"


class LoopTiming:
    """Notes of every sample when it was there and when the next drive was handed over; it reads no clock itself.

    All times in nanoseconds of one clock that never runs back.
    """

    def __init__(self, sample_period_s: float, paced: bool) -> None:
        """Watch a run of this sample period; ``paced`` where a real clock sets its pace."""
        self._period_us = sample_period_s * 1e6
        self._paced = paced
        self._samples_ns = array("q")
        self._latencies_ns = array("q")
        self._callbacks_ns = array("q")
        self._callback_ns = 0

    def sampled(self, drive_at_ns: int, sample_at_ns: int) -> None:
        """Note one exchange: when its drive was handed to the output and when its sample was there."""
        if self._samples_ns:
            self._latencies_ns.append(drive_at_ns - self._samples_ns[-1])
            self._callbacks_ns.append(self._callback_ns)
        self._samples_ns.append(sample_at_ns)
        self._callback_ns = 0

    def called_back(self, callback_ns: int) -> None:
        """Note how long whoever watches the run kept the loop waiting after the last sample."""
        self._callback_ns = callback_ns

    def metadata(self) -> dict[str, MetadataValue]:
        """Return what a recording says of its timing; only compute times where no clock paced the run.

        ``jitter`` is how far the time between two samples was from the sample period, ``latency`` from a sample to the
        next drive at the output, ``compute`` the part of it that is not a callback's: policy, protection, recorder.
        ``deadline_misses`` counts the sample periods in which no sample came, ``drift_us`` is how much longer the whole
        run took than its periods.
        """
        latencies = np.array(self._latencies_ns, dtype=np.float64) / 1e3
        compute = latencies - np.array(self._callbacks_ns, dtype=np.float64) / 1e3
        found: dict[str, MetadataValue] = {"pace": CLOCK if self._paced else NO_CLOCK, "deadline_misses": 0}
        found |= percentiles("compute", compute)
        if not self._paced or not latencies.size:
            return found
        intervals = np.diff(np.array(self._samples_ns, dtype=np.float64)) / 1e3
        # A burst after a late sample catches up: only whole periods without a sample are misses.
        empty = np.rint(intervals / self._period_us) - 1.0
        found["scheduling"] = scheduling()
        found["deadline_misses"] = int(empty[empty > 0.0].sum())
        found["drift_us"] = round(float(intervals.sum() - intervals.size * self._period_us), 1)
        return found | percentiles("jitter", np.abs(intervals - self._period_us)) | percentiles("latency", latencies)


def percentiles(name: str, values_us: FloatArray) -> dict[str, MetadataValue]:
    """Return the percentiles of some times [us] under the names of metadata; none of no times."""
    if not values_us.size:
        return {}
    found = np.percentile(values_us, list(PERCENTILES.values()))
    return {f"{name}_{key}_us": round(float(value), 1) for key, value in zip(PERCENTILES, found, strict=True)}


def timing_json(metadata: Mapping[str, MetadataValue]) -> dict[str, Any]:
    """Return what a recording's metadata say of its timing, as programs read it; None for what was not measured."""
    found: dict[str, Any] = {"deadline_misses": metadata.get("deadline_misses", 0)}
    for name in ("jitter", "latency", "compute"):
        parts = {key: metadata.get(f"{name}_{key}_us") for key in PERCENTILES}
        found[f"{name}_us"] = None if None in parts.values() else parts
    return {**found, "drift_us": metadata.get("drift_us")}
