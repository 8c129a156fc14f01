"""Courses through a wire, for measuring the kernel's accuracy, and how the kernel and its references run along them.

The references are the ensemble of grains of tests/grain_wire, another implementation by other numerics, at 2560 grains
and a tenth of a millisecond; and the kernel itself in much finer steps. One place calls the kernel: :func:`kernel_run`.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.sensing import find_segments, hysteresis_gap
from musclewire.wire import DrivenPath, StepControl, WireState, constants_of, drive_path, fixed_steps

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from grain_wire import GrainPath, grain_wire

Array = NDArray[np.float64]
Numbers = tuple[Mapping[str, float], Mapping[str, float], Mapping[str, float]]

SAMPLE_S = 0.05
SENSE_V = 0.3
OUTPUTS = ("temperature_k", "resistance_ohm", "contraction")
# Grains of a reference. Where a loop turns before the first grains of cooling are due one at a time, its largest error
# falls so slowly with their number that twice as many do not show it: that course has eight times as many.
GRAINS, GRAINS_OF = 2560, {"minor loop, 2.75 V": 20480}


class Course(NamedTuple):
    """A drive, one voltage for each sample of 50 ms, (n_samples,)."""

    name: str
    drive_v: Array


def slow_sine_v(amplitude_v: float, period_s: float = 90.0) -> Array:
    """Return the paper's slow cycle from the sense voltage up to an amplitude and back, held over each sample."""
    middles = np.arange(0.5, round(period_s / SAMPLE_S)) * SAMPLE_S
    return SENSE_V + (amplitude_v - SENSE_V) * 0.5 * (1.0 - np.cos(2.0 * math.pi * middles / period_s))


def staircase_v() -> Array:
    """Return thirteen levels of 6 s, up and down through the transformation, as restless as a controller's output."""
    levels = np.array([1.0, 1.7, 2.0, 2.3, 2.5, 2.7, 2.9, 2.7, 2.5, 2.3, 2.0, 1.7, 1.0])
    random = np.random.default_rng(1)
    held = np.repeat(levels, round(6.0 / SAMPLE_S))
    return np.clip(held + random.normal(0.0, 0.1, held.size), SENSE_V, None)


def jumps_v(largest_v: float) -> Array:
    """Return jumps from the sense voltage to the largest drive and back, and turns amid the transformation, 12 s."""
    levels = (SENSE_V, 1.0, SENSE_V, 0.7, 0.5, 1.0, 0.0, 1.0, SENSE_V)
    seconds = (0.5, 2.0, 2.0, 1.0, 1.0, 1.0, 1.5, 0.5, 2.5)
    held = [level if level in (0.0, SENSE_V) else level * largest_v for level in levels]
    return np.repeat(held, [round(each / SAMPLE_S) for each in seconds])


COURSES = {
    course.name: course
    for course in (
        Course("slow loop", slow_sine_v(3.2)),
        Course("minor loop, 2.90 V", slow_sine_v(2.9)),
        Course("minor loop, 2.75 V", slow_sine_v(2.75)),
        Course("staircase", staircase_v()),
        Course("jumps to 3.6 V", jumps_v(3.6)),
    )
}


@lru_cache
def shipped() -> Numbers:
    """Return the numbers of the shipped alloy, the paper's wire and its bench."""
    return load_alloy("flexinol").values(), load_wire("paper-100um").values(), load_bench("paper").values()


def with_bench(numbers: Numbers, **bench: float) -> Numbers:
    """Return numbers with others for the bench."""
    return numbers[0], numbers[1], {**numbers[2], **bench}


class Run(NamedTuple):
    """What a course shows, (3, n_samples): temperature and resistance after each sample, mean contraction in it."""

    columns: Array
    path: DrivenPath | GrainPath
    leg_length_m: float
    shunt_ohm: float

    @property
    def strain_gap_pct(self) -> float:
        """The strain gap (Eq. 2) from means of samples, as an instrument takes them [%]."""
        ohm = self.path.wire_voltage_v / self.path.shunt_voltage_v * self.shunt_ohm
        found = find_segments(ohm, self.path.displacement_m / self.leg_length_m)
        return 100.0 * float(hysteresis_gap(found.heating, found.cooling))


def kernel_run(drive_v: Array, stepping: StepControl, numbers: Numbers | None = None) -> tuple[Run, WireState]:
    """Return what the kernel shows along a drive in samples of 50 ms, and the state at the end."""
    constants = constants_of(*(numbers or shipped()))
    path, end = drive_path(constants, drive_v, sample_s=SAMPLE_S, stepping=stepping)
    columns = np.array([path.temperature_k, path.resistance_ohm, path.displacement_m / constants.leg_length_m])
    return Run(columns, path, constants.leg_length_m, constants.shunt_resistance_ohm), end


def fixed(step_s: float) -> StepControl:
    """Return steps of one length."""
    return fixed_steps(step_s)


def reference_run(drive_v: Array, step_s: float, grains: int, numbers: Numbers | None = None) -> Run:
    """Return what the ensemble of grains shows along a drive in samples of 50 ms."""
    wire = grain_wire(*(numbers or shipped()), grains=grains)
    path = wire.drive(drive_v, step_s, round(SAMPLE_S / step_s))
    leg_m = wire.value("leg_length_m")
    columns = np.array([path.temperature_k, path.resistance_ohm, path.displacement_m / leg_m])
    return Run(columns, path, leg_m, wire.value("shunt_resistance_ohm"))


class Reference(NamedTuple):
    """The ensemble of grains along a course with an estimate of its own error, each (3,): largest and rms.

    Half the step and twice the grains move it by as much as the finest run is off (first order in the step, more in
    the grains), so the error is the distance from the run of twice the step plus that from half the grains.
    """

    run: Run
    largest: Array
    rms: Array


@lru_cache
def reference(name: str, step_s: float = 1e-4) -> Reference:
    """Return the reference along a course by name."""
    drive_v, grains = COURSES[name].drive_v, GRAINS_OF.get(name, GRAINS)
    best = reference_run(drive_v, step_s, grains)
    coarse = [reference_run(drive_v, 2.0 * step_s, grains), reference_run(drive_v, step_s, grains // 2)]
    found = [distance(run, best) for run in coarse]
    return Reference(best, found[0].largest + found[1].largest, found[0].rms + found[1].rms)


class Distance(NamedTuple):
    """How far two runs are apart over a course, each (3,): temperature [K], resistance [ohm], contraction."""

    largest: Array
    rms: Array


def distance(one: Run, other: Run) -> Distance:
    """Return the distance of two runs along one course."""
    off = np.abs(one.columns - other.columns)
    return Distance(off.max(axis=1), np.sqrt((off**2).mean(axis=1)))
