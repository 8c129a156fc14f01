"""The wire of a compiled loop: all that the loop knows of the simulator's kernel is in this file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.simulate.wires import OneWire, advance_rows
from musclewire.wire.state import Rows

__all__ = ["WireArrays", "advance_sample", "is_resolved", "sample_times_s", "surround", "wire_arrays"]


class WireArrays(NamedTuple):
    """A wire as compiled code takes it: arrays of one record, its load's table, and length [s] and number of steps."""

    states: Rows
    constants: Rows
    load_table_n: FloatArray
    steps: FloatArray


def wire_arrays(wire: OneWire, bench: Mapping[str, float]) -> WireArrays:
    """Return the arrays of a wire; what changes in a loop is a copy."""
    constants = wire.constants.copy()
    return WireArrays(wire.state.copy().row, constants.row, constants.load_table_n, np.array(steps_of(bench)))


def steps_of(bench: Mapping[str, float]) -> tuple[float, float]:
    """Return length [s] and number of the steps in a sample."""
    return bench["time_step_s"], float(round(bench["sample_period_s"] / bench["time_step_s"]))


def sample_times_s(wire: OneWire, bench: Mapping[str, float], samples: int) -> FloatArray:
    """Return the times at the ends of a wire's next samples [s], (n_samples,), as the kernel adds them up."""
    step_s, steps = steps_of(bench)
    time_s, times = wire.state.time_s, np.empty(samples)
    for row in range(samples):
        time_s += steps * step_s
        times[row] = time_s
    return times


@compiled
def advance_sample(wire: WireArrays, drive_voltage_v: float) -> tuple[float, float, float, float]:
    """Advance a wire by one sample; return the means of both voltages [V], displacement [m] and force [N]."""
    step_s, steps = wire.steps
    return advance_rows(wire.states, wire.constants, wire.load_table_n, drive_voltage_v, step_s, int(steps))


@compiled
def surround(wire: WireArrays, ambient_temperature_k: float, convection_factor: float) -> None:
    """Change the air's temperature [K] and the convection factor from now on."""
    wire.constants[0].ambient_temperature_k = ambient_temperature_k
    wire.constants[0].convection_factor = convection_factor


@compiled
def is_resolved(wire: WireArrays) -> bool:
    """Whether the steps until now are what the wire does."""
    return math.isfinite(wire.states[0].temperature_k)
