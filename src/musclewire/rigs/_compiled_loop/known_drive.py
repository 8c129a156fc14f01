"""A drive that is known beforehand, run on a simulated rig in compiled code; the rig goes on from its end."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.rigs._compiled_loop.kernel import RIG_COLUMNS, CompiledLoopEnd, RigArrays, run_drive
from musclewire.rigs._compiled_loop.one_wire import places_of
from musclewire.rigs._compiled_loop.running import (
    CompiledRun,
    columns_of,
    inside_of,
    require_same_clock,
    rig_arrays,
    with_endpoint,
)
from musclewire.rigs._guarded import GuardedRig
from musclewire.rigs._simulated import SimulatedDevice

__all__ = ["KnownRun", "run_known_drive"]


class KnownRun(NamedTuple):
    """How a run in compiled code ended, how many samples are complete, and the columns of the rig.

    ``true`` has what was asked of the wire's state at the end of each sample, (n_samples, n_names).
    """

    ended: CompiledLoopEnd
    samples: int
    columns: dict[str, FloatArray]
    true: FloatArray


def run_known_drive(
    rig: GuardedRig, times_s: FloatArray, drives_v: FloatArray, true_names: Sequence[str] = ()
) -> KnownRun:
    """Hold each drive for a sample, from the present state of a rig, and leave the rig as these samples leave it.

    The columns are those of the loop in Python, to the bit. A rig to which something unusual happens on the way is left
    as it was before. ``times_s`` are the ends of the samples on the rig's clock [s]. Raises CallerError for a rig that
    has no compiled form.
    """
    inside, _ = inside_of(rig)
    noise, generator = inside.instruments.noise_ahead(times_s.size)
    air = deepcopy(inside.air)
    arrays = rig_arrays(rig, times_s, noise, air)
    places = places_of(arrays.wire, true_names)
    true = np.empty((times_s.size, places.size))
    ended, complete = run_drive(arrays, drives_v, arrays.wire.states.view(np.float64), places, true)
    require_same_clock(CompiledLoopEnd(ended), arrays)
    held_m = float(arrays.slack_m[:complete].max(initial=0.0))
    error_k = float(arrays.wire.states[0]["step_error_k"])
    shown = CompiledRun(CompiledLoopEnd(ended), complete, columns_of(arrays.shown, RIG_COLUMNS), held_m, error_k)
    run = with_endpoint(shown, arrays.true_displacement_m, inside, noise)
    if run.ended is CompiledLoopEnd.DONE:
        take_over(rig, arrays, float(drives_v[-1]))
        assert isinstance(rig.device, SimulatedDevice)
        rig.device.adopt(float(run.columns["drive_voltage_v"][-1]), generator, air, held_m)
    return KnownRun(run.ended, run.samples, run.columns, true)


def take_over(rig: GuardedRig, arrays: RigArrays, last_drive_v: float) -> None:
    """Leave protection and wire as samples have left them. Raises RigError if the rig was closed meanwhile."""
    _, wire = inside_of(rig)
    rig.adopt_compiled_samples(last_drive_v, arrays.memory, float(arrays.times_s[-1]))
    wire.adopt_compiled_state(arrays.wire.states, arrays.wire.constants)
