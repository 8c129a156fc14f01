"""The simulated wire of the comparisons that only a checkout has: many at once, and one period by one call."""

from __future__ import annotations

import numpy as np

from musclewire.app import paper_wire
from musclewire.wire import CHOSEN, StepControl, WireBatch, WireConstants, WireState, advance, fixed_steps

__all__ = ["different_wires", "one_period"]

# How far the numbers of the wires of a batch are from each other.
SPREAD = 0.1


def one_period(
    state: WireState, wire: WireConstants, drive_voltage_v: float, period_s: float, stepping: StepControl = CHOSEN
) -> WireState:
    """Return the state after one period of a drive."""
    return advance(state, wire, drive_voltage_v, period_s, stepping)[0]


def different_wires(count: int, step_s: float, threads: int | None) -> WireBatch:
    """Return so many wires on springs, all numbers different, in fixed steps."""
    scales = np.random.default_rng(1).uniform(1.0 - SPREAD, 1.0 + SPREAD, count)
    wires = [paper_wire(scale=float(scale)) for scale in scales]
    return WireBatch(wires, stepping=fixed_steps(step_s), threads=threads)
