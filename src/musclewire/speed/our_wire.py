"""The simulated wire of the comparisons: the only file of this room that calls the simulator."""

from __future__ import annotations

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.parameters.library import load_alloy, load_bench, load_wire
from musclewire.speed.easier_wire import AMPLITUDE_V, PERIOD_S, SENSE_V
from musclewire.wire.batch import WireBatch
from musclewire.wire.building import constants_of, resting_state
from musclewire.wire.constants import WireConstants
from musclewire.wire.loads import ConnectorLoad
from musclewire.wire.paths import drive_path
from musclewire.wire.state import WireState
from musclewire.wire.stepping import CHOSEN, Stepping, fixed_steps
from musclewire.wire.wires import OneWire, advance

__all__ = [
    "CHOSEN",
    "OneWire",
    "cycle",
    "different_wires",
    "fixed_steps",
    "one_period",
    "paper_wire",
    "running",
    "slow_sine",
    "start_of",
]

# How far the numbers of the wires of a batch are from each other.
SPREAD = 0.1


def paper_wire(load: ConnectorLoad | None = None, scale: float = 1.0) -> WireConstants:
    """Return the paper's 100 um wire on its bench: all of the physics, on its spring or on another load.

    ``scale`` multiplies pretension, length and the spread of martensite's transformation temperature, for wires that
    differ.
    """
    alloy, wire, bench = (
        load_alloy("flexinol").values(),
        load_wire("paper-100um").values(),
        load_bench("paper").values(),
    )
    alloy["martensite_spread_k"] *= scale
    bench["pretension_n"] *= scale
    bench["wire_length_m"] *= scale
    return constants_of(alloy, wire, bench, load=load)


def start_of(wire: WireConstants) -> WireState:
    """Return the wire cold and at rest."""
    return resting_state(wire)


def slow_sine(sample_s: float) -> FloatArray:
    """Return one cycle of the slow sine [V], each sample's mean drive."""
    time_s = (np.arange(round(PERIOD_S / sample_s)) + 0.5) * sample_s
    drive: FloatArray = SENSE_V + (AMPLITUDE_V - SENSE_V) * 0.5 * (1.0 - np.cos(2.0 * np.pi * time_s / PERIOD_S))
    return drive


def cycle(wire: WireConstants, start: WireState, sample_s: float, stepping: Stepping = CHOSEN) -> None:
    """Follow one cycle of the slow sine in one call."""
    drive_path(wire, slow_sine(sample_s), sample_s=sample_s, stepping=stepping, state=start)


def one_period(
    state: WireState, wire: WireConstants, drive_voltage_v: float, period_s: float, stepping: Stepping = CHOSEN
) -> WireState:
    """Return the state after one period of a drive."""
    return advance(state, wire, drive_voltage_v, period_s, stepping)[0]


def running(wire: WireConstants) -> OneWire:
    """Return the wire as a program of one's own runs it, period by period and in place."""
    return OneWire(wire)


def different_wires(count: int, step_s: float, threads: int | None) -> WireBatch:
    """Return so many wires on springs, all numbers different, in fixed steps."""
    scales = np.random.default_rng(1).uniform(1.0 - SPREAD, 1.0 + SPREAD, count)
    wires = [paper_wire(scale=float(scale)) for scale in scales]
    return WireBatch(wires, stepping=fixed_steps(step_s), threads=threads)
