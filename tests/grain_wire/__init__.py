"""The wire as an ensemble of many grains, stepped explicitly: an outside reference for the kernel of fronts.

A second implementation of the same physics by other numerics: N classes of grains, each with its own fractions, a step
of first order in time, explicit friction. Slow and simple; finer steps and more grains lead to the kernel's answer. It
imports neither `wire` nor `simulate`, and takes plain numbers by name.
"""

from grain_wire.numbers import Load, spring
from grain_wire.paths import OWN_SUPPLY, PARALLEL, SEPARATE, SERIES, Grip, Pair
from grain_wire.wires import GrainPath, GrainWalk, GrainWire, drive_pair, grain_wire

__all__ = [
    "SEPARATE",
    "OWN_SUPPLY",
    "PARALLEL",
    "SERIES",
    "GrainPath",
    "GrainWalk",
    "GrainWire",
    "Grip",
    "Load",
    "Pair",
    "drive_pair",
    "grain_wire",
    "spring",
]
