"""The wire of a compiled loop: all that the loop knows of the simulator's kernel is in this file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray, IntArray
from musclewire.compiled import compiled_inner
from musclewire.wire import OneWire, Rows, StepControl, advance_rows, plan_of
from musclewire.wire import is_resolved as state_is_resolved


class WireArrays(NamedTuple):
    """A wire as compiled code takes it, arrays of one record each, and how a sample is divided into steps."""

    states: Rows
    constants: Rows
    cells: Rows
    load: Rows
    plan: FloatArray


def wire_arrays(wire: OneWire, stepping: StepControl, sample_period_s: float) -> WireArrays:
    """Return the arrays of a wire; what changes in a loop is a copy."""
    derived, cells, load = wire.constants.step_arrays()
    return WireArrays(wire.state.copy().row, derived.copy(), cells, load, plan_of(stepping, sample_period_s))


def places_of(wire: WireArrays, names: Sequence[str]) -> IntArray:
    """Return the places of fields among the plain numbers of a wire's state."""
    fields = wire.states.dtype.fields
    assert fields is not None  # a row is a record
    return np.array([fields[name][1] // wire.plan.itemsize for name in names], dtype=np.int64)


def sample_times_s(wire: OneWire, sample_period_s: float, samples: int) -> FloatArray:
    """Return the times at the ends of a wire's next samples [s], (n_samples,), as the kernel adds them up."""
    time_s, times = wire.time_s, np.empty(samples)
    for row in range(samples):
        time_s += sample_period_s
        times[row] = time_s
    return times


@compiled_inner
def advance_sample(wire: WireArrays, drive_voltage_v: float) -> tuple[float, float, float, float]:
    """Advance a wire by one sample; return the means of both voltages [V], displacement [m] and force [N]."""
    return advance_rows(wire.states, wire.constants, wire.cells, wire.load, drive_voltage_v, wire.plan)


@compiled_inner
def surround(wire: WireArrays, ambient_temperature_k: float, surface_factor_m2: float) -> None:
    """Change the air's temperature [K], and the wire's surface times its convection factor [m2], from now on."""
    wire.constants[0].ambient_temperature_k = ambient_temperature_k
    wire.constants[0].surface_factor_m2 = surface_factor_m2


@compiled_inner
def time_s(wire: WireArrays) -> float:
    """Time since the wire was first at rest [s]."""
    return wire.states[0].time_s


@compiled_inner
def slack_m(wire: WireArrays) -> float:
    """Length by which friction holds the connector ahead of the slack wire [m], as ``OneWire.slack_m``."""
    state = wire.states[0]
    return (state.connector_contraction - state.contraction) * wire.constants[0].leg_length_m


@compiled_inner
def is_resolved(wire: WireArrays) -> bool:
    """Whether the steps until now are what the wire does."""
    return state_is_resolved(wire.states[0])
