"""Many simulated wires side by side: the only file of the environments that calls the simulator."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.interfaces.simulated_wire import SimulatedWire
from musclewire.simulate.batch import WireBatch
from musclewire.simulate.stepping import fixed_steps

__all__ = ["WireLanes"]

# A sample is divided into steps of at most this length: at a jump of the drive they err by hundredths of a kelvin.
MAX_STEP_S = 0.025


class WireLanes:
    """Wires that are advanced together, each with its own load and drive."""

    def __init__(self, wires: Sequence[SimulatedWire], sample_period_s: float) -> None:
        """Cool each wire under its pretension; a fixed step of the first one's bench is taken for all."""
        self._period_s = sample_period_s
        steps = math.ceil(sample_period_s / MAX_STEP_S - 1e-9)
        step_s = wires[0].bench["time_step_s"] or sample_period_s / steps
        self._batch = WireBatch([wire.constants for wire in wires], stepping=fixed_steps(step_s))

    def rest(self, lanes: NDArray[np.bool_]) -> None:
        """Cool some of the wires to rest."""
        self._batch.rest(lanes)

    def advance(self, drive_voltage_v: FloatArray) -> FloatArray:
        """Advance all wires by a sample; return wire voltage, shunt voltage and displacement, (3, n_lanes)."""
        return np.stack(self._batch.advance(drive_voltage_v, self._period_s)[:3])
