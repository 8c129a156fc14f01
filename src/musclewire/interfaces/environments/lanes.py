"""Many simulated wires side by side: the only file of the environments that calls the simulator."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.simulate.wires import advance
from musclewire.wire.building import resting_state
from musclewire.wire.state import WireConstants

__all__ = ["WireLanes"]

STEP_S = 0.001


class WireLanes:
    """Wires that are advanced together, each with its own load and drive."""

    def __init__(self, constants: Sequence[WireConstants], sample_period_s: float) -> None:
        """Cool each wire under its pretension."""
        self._constants = list(constants)
        self._steps = round(sample_period_s / STEP_S)
        self._rest = [resting_state(one) for one in self._constants]
        self._states = [state.copy() for state in self._rest]
        self.means = np.zeros((3, len(self._constants)))

    def rest(self, lanes: NDArray[np.bool_]) -> None:
        """Cool some of the wires to rest."""
        for lane in np.flatnonzero(lanes):
            self._states[lane] = self._rest[lane].copy()

    def advance(self, drive_voltage_v: FloatArray) -> FloatArray:
        """Advance all wires by a sample; return wire voltage, shunt voltage and displacement, (3, n_lanes)."""
        for lane, voltage_v in enumerate(drive_voltage_v.tolist()):
            self._states[lane], means = advance(
                self._states[lane], self._constants[lane], voltage_v, STEP_S, self._steps
            )
            self.means[:, lane] = means.wire_voltage_v, means.shunt_voltage_v, means.displacement_m
        return self.means
