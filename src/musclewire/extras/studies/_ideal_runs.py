"""Runs with ideal readings: wires simulated and recorded without noise, steps of a converter and limits.

The recordings have the columns and the facts of those that a rig makes, so that everything that reads recordings reads
them as well.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.extras.studies._varied_rig import VariedWire
from musclewire.signals import Recording

# Whether a wire is read without errors, or through the rig's instruments and protection.
Readings = Literal["ideal", "rig"]


class IdealRun(NamedTuple):
    """A run with ideal readings."""

    recording: Recording
    temperature_k: FloatArray  # at the end of each sample, (n_samples,)


def ideal_run(wire: VariedWire, drive_v: FloatArray) -> IdealRun:
    """Return a run of one drive voltage for each sample, with ideal readings; CallerError above the wire's maximum."""
    held_v, path = wire.driven(drive_v)
    columns = {
        "time_s": sample_times_s(held_v.size, wire.spool.bench["sample_period_s"]),
        "drive_voltage_v": held_v,
        "wire_voltage_v": path.wire_voltage_v,
        "shunt_voltage_v": path.shunt_voltage_v,
        "displacement_m": path.displacement_m,
        "force_n": path.force_n,
    }
    if wire.tendon is not None:
        columns["endpoint_displacement_m"] = wire.tendon.endpoint_m(
            path.displacement_m, wire.tendon.endpoint_force_n(path.displacement_m)
        )
    return IdealRun(Recording(columns, wire.facts()), path.temperature_k)


@lru_cache(maxsize=8)
def sample_times_s(samples: int, sample_period_s: float) -> FloatArray:
    """Return the ends of samples, counted from the beginning of a run as its recording does [s], (n_samples,)."""
    return np.array([round(sample * sample_period_s, 9) for sample in range(1, samples + 1)])
