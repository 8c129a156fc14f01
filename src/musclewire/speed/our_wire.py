"""The simulated wire of the comparisons: the only file of this room that calls the simulator."""

from __future__ import annotations

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.parameters.library import load_alloy, load_bench, load_wire
from musclewire.simulate.paths import drive_path
from musclewire.simulate.stepping import fixed_steps
from musclewire.simulate.wires import advance
from musclewire.speed.easier_wire import AMPLITUDE_V, PERIOD_S, SENSE_V
from musclewire.wire.building import constants_from, resting_state
from musclewire.wire.constants import WireConstants
from musclewire.wire.loads import ConnectorLoad
from musclewire.wire.state import WireState

__all__ = ["fixed_cycle", "one_period", "paper_wire", "slow_sine", "start_of"]


def paper_wire(load: ConnectorLoad | None = None) -> WireConstants:
    """Return the paper's 100 um wire on its bench: all of the physics, on its spring or on another load."""
    return constants_from(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"), load=load)


def start_of(wire: WireConstants) -> WireState:
    """Return the wire cold and at rest."""
    return resting_state(wire)


def slow_sine(sample_s: float) -> FloatArray:
    """Return one cycle of the slow sine [V], each sample's mean drive."""
    time_s = (np.arange(round(PERIOD_S / sample_s)) + 0.5) * sample_s
    drive: FloatArray = SENSE_V + (AMPLITUDE_V - SENSE_V) * 0.5 * (1.0 - np.cos(2.0 * np.pi * time_s / PERIOD_S))
    return drive


def fixed_cycle(wire: WireConstants, start: WireState, sample_s: float, step_s: float) -> None:
    """Follow one cycle of the slow sine in one call, in steps of one length."""
    drive_path(wire, slow_sine(sample_s), sample_s=sample_s, stepping=fixed_steps(step_s), state=start)


def one_period(state: WireState, wire: WireConstants, drive_voltage_v: float, period_s: float) -> WireState:
    """Return the state after one period of a closed loop, as a program of one's own calls it."""
    return advance(state, wire, drive_voltage_v, period_s, fixed_steps(period_s))[0]
