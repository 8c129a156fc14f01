"""Runs with ideal readings: wires simulated in batches, recorded without noise, steps of a converter and limits.

The recordings have the columns and the facts of those that a rig makes, so that everything that reads recordings reads
them as well.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, Literal, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import MusclewireError
from musclewire.extras.studies._run_kind import Outcome, StudyRun, StudyRuns, each
from musclewire.rigs import VariedWire, drive_wires, held_voltages_v
from musclewire.signals import Recording

__all__ = ["IdealRun", "Readings", "by_readings", "ideal_runs", "sample_times_s"]

# Whether a wire is read without errors, or through the rig's instruments and protection.
Readings = Literal["ideal", "rig"]


class IdealRun(NamedTuple):
    """A run with ideal readings.

    Parameters
    ----------
    wire
        The wire.
    recording
        What ideal instruments read.
    temperature_k
        The wire's temperature at the end of each sample [K], (n_samples,).
    """

    wire: VariedWire
    recording: Recording
    temperature_k: FloatArray


def ideal_runs(
    runs: StudyRuns[Any], drive_of: Callable[[StudyRun[Any], VariedWire], FloatArray]
) -> list[IdealRun | MusclewireError]:
    """Return each run of a chunk with ideal readings, or the error of one that cannot be run.

    Parameters
    ----------
    runs
        The runs.
    drive_of
        Returns the drive voltages [V] of a run, one for each sample.

    Returns
    -------
    Runs and errors, in their order.
    """
    wires = runs.wires()

    def prepared(pair: tuple[StudyRun[Any], VariedWire | MusclewireError]) -> tuple[VariedWire, FloatArray]:
        run, wire = pair
        if isinstance(wire, MusclewireError):
            raise wire
        return wire, held_voltages_v(drive_of(run, wire), wire)

    ready = each(prepared, list(zip(runs.runs, wires, strict=True)))
    driven = [item for item in ready if not isinstance(item, MusclewireError)]
    paths = iter(drive_wires([wire for wire, _ in driven], [drive_v for _, drive_v in driven]))

    def recorded(item: Any) -> IdealRun:
        wire, drive_v = item
        path = next(paths)
        if isinstance(path, MusclewireError):
            raise path
        columns = {
            "time_s": sample_times_s(drive_v.size, wire.bench["sample_period_s"]),
            "drive_voltage_v": drive_v,
            "wire_voltage_v": path.wire_voltage_v,
            "shunt_voltage_v": path.shunt_voltage_v,
            "displacement_m": path.displacement_m,
            "force_n": path.force_n,
        }
        if wire.tendon is not None:
            columns["endpoint_displacement_m"] = wire.tendon.endpoint_m(
                path.displacement_m, wire.tendon.endpoint_force_n(path.displacement_m)
            )
        return IdealRun(wire, Recording(columns, wire.facts()), path.temperature_k)

    return each(recorded, ready)


def by_readings(
    runs: StudyRuns[Any],
    on_wires: Callable[[StudyRuns[Any]], Sequence[Outcome]],
    on_rig: Callable[[StudyRun[Any]], Outcome],
) -> list[Outcome]:
    """Return an outcome for each run, whose readings are its own: what the others have must not matter.

    Parameters
    ----------
    runs
        The runs; their options have ``readings``.
    on_wires
        Evaluates together those with ideal readings.
    on_rig
        Evaluates one through the rig's instruments.

    Returns
    -------
    Outcomes and errors, in the order of the runs.
    """
    ideal = [run for run in runs.runs if run.options.readings == "ideal"]
    found = iter(on_wires(replace(runs, runs=ideal)) if ideal else ())
    return [next(found) if run.options.readings == "ideal" else each(on_rig, [run])[0] for run in runs.runs]


@lru_cache(maxsize=8)
def sample_times_s(samples: int, sample_period_s: float) -> FloatArray:
    """Return the ends of samples, counted from the beginning of a run as its recording does [s], (n_samples,)."""
    return np.array([round(sample * sample_period_s, 9) for sample in range(1, samples + 1)])
