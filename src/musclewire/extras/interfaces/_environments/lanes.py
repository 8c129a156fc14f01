"""Many simulated wires side by side: the only file of the environments that calls the simulator."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.errors import NumericsError
from musclewire.extras.interfaces._simulated_wire import SimulatedWire
from musclewire.wire import WireBatch, fixed_steps

__all__ = ["WireLanes"]

# Longest step of the simulation, and that as a fraction of the quickest wire's time constant: with both a jump of the
# drive errs by hundredths of a kelvin (benchmarks/vector_environment.py).
MAX_STEP_S, MAX_STEP_FRACTION = 0.025, 0.05


class WireLanes:
    """Wires that are advanced together by fixed steps, each with its own load and drive."""

    def __init__(self, wires: Sequence[SimulatedWire], sample_period_s: float) -> None:
        """Cool each wire under its pretension; a fixed step of the first one's bench is taken for all."""
        self._period_s = sample_period_s
        quickest_s = min(wire.limits.heat_capacity_j_per_k / wire.limits.heat_loss_w_per_k for wire in wires)
        steps = math.ceil(sample_period_s / min(MAX_STEP_S, MAX_STEP_FRACTION * quickest_s) - 1e-9)
        self.step_s = wires[0].stepping.fixed_s or sample_period_s / steps
        self._batch = WireBatch([wire.constants for wire in wires], stepping=fixed_steps(self.step_s))

    def rest(self, lanes: NDArray[np.bool_]) -> None:
        """Cool some of the wires to rest."""
        self._batch.rest(lanes)

    def require_resolved(self) -> None:
        """Raise NumericsError if a step of any wire since its rest was unsolved, or too long for what happened."""
        try:
            self._batch.require_resolved(self._period_s)
        except NumericsError as error:
            raise NumericsError(
                f"steps of {1e3 * self.step_s:.3g} ms do not resolve what a wire of this environment does: give it a "
                f"time_step_s that is a fraction of that ({str(error).partition(';')[0]})"
            ) from None

    def advance(self, drive_voltage_v: FloatArray) -> FloatArray:
        """Advance all wires by a sample; return wire voltage, shunt voltage and displacement, (3, n_lanes)."""
        return np.stack(self._batch.advance(drive_voltage_v, self._period_s)[:3])
