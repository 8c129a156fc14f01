"""The easier wire as a plain Numba loop of explicit steps: what one writes who knows Numba and has no need of a solver.

Euler's rule in steps so short that its error along the slow sine is that of SciPy's at its tolerances, a few mK.
"""

from __future__ import annotations

import math

import numba
import numpy as np
from benchmarks.speed.easier_wire import AMPLITUDE_V, PERIOD_S, SENSE_V, START, rates

from musclewire.arrays import FloatArray

__all__ = ["EXPLICIT_STEP_S", "compiled", "numba_batch", "numba_cycle"]

# As the package compiles, but kept nowhere: its cache is named by its own sources only, so that machine code of a file
# outside it could be that of other lines.
compiled = numba.njit(error_model="numpy", nogil=True)

# First order: 4 mK here, 40 mK in steps of 5 ms (tests/house/speed/test_easier_wires.py).
EXPLICIT_STEP_S = 1e-3

# The very lines that SciPy calls.
compiled_rates = compiled(rates)


@compiled
def numba_cycle(samples: int, steps: int) -> FloatArray:
    """Follow one cycle of the slow sine in explicit steps; return temperature [K] at each sample, (samples,)."""
    step_s = PERIOD_S / (samples * steps)
    temperature_k, martensite = START
    shown = np.empty(samples)
    for sample in range(samples):
        for part in range(steps):
            time_s = (sample * steps + part) * step_s
            voltage_v = SENSE_V + (AMPLITUDE_V - SENSE_V) * 0.5 * (1.0 - math.cos(2.0 * math.pi * time_s / PERIOD_S))
            warming, change = compiled_rates(temperature_k, martensite, voltage_v)
            temperature_k += warming * step_s
            martensite += change * step_s
        shown[sample] = temperature_k
    return shown


@compiled
def numba_batch(temperature_k: FloatArray, martensite: FloatArray, drive_v: FloatArray, steps: int) -> None:
    """Advance many wires in place, each (n_wires,), at their drives by explicit steps, wire after wire."""
    for wire in range(temperature_k.shape[0]):
        kelvin, fraction = temperature_k[wire], martensite[wire]
        for _ in range(steps):
            warming, change = compiled_rates(kelvin, fraction, drive_v[wire])
            kelvin += warming * EXPLICIT_STEP_S
            fraction += change * EXPLICIT_STEP_S
        temperature_k[wire], martensite[wire] = kelvin, fraction
