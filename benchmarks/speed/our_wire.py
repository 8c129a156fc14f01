"""The simulated wire of the comparisons: the paper's on its bench, along the slow sine, and many that differ."""

from __future__ import annotations

import numpy as np
from benchmarks.speed.easier_wire import AMPLITUDE_V, PERIOD_S, SENSE_V, drive_v

from musclewire.arrays import FloatArray
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.wire import (
    CHOSEN,
    ConnectorLoad,
    StepControl,
    WireBatch,
    WireConstants,
    WireState,
    constants_of,
    drive_path,
    fixed_steps,
)

__all__ = ["PERIOD_S", "cycle", "different_wires", "drive_v", "paper_wire"]

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


def different_wires(count: int, step_s: float, threads: int | None) -> WireBatch:
    """Return so many wires on springs, all numbers different, in fixed steps."""
    scales = np.random.default_rng(1).uniform(1.0 - SPREAD, 1.0 + SPREAD, count)
    wires = [paper_wire(scale=float(scale)) for scale in scales]
    return WireBatch(wires, stepping=fixed_steps(step_s), threads=threads)


def slow_sine(sample_s: float) -> FloatArray:
    """Return one cycle of the slow sine [V], each sample's mean drive."""
    time_s = (np.arange(round(PERIOD_S / sample_s)) + 0.5) * sample_s
    drive: FloatArray = SENSE_V + (AMPLITUDE_V - SENSE_V) * 0.5 * (1.0 - np.cos(2.0 * np.pi * time_s / PERIOD_S))
    return drive


def cycle(wire: WireConstants, start: WireState, sample_s: float, stepping: StepControl = CHOSEN) -> None:
    """Follow one cycle of the slow sine in one call."""
    drive_path(wire, slow_sine(sample_s), sample_s=sample_s, stepping=stepping, state=start)
