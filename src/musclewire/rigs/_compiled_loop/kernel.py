"""A closed loop, or a drive known beforehand, in compiled code: the numbers of the loop in Python, to the bit.

The loop goes on as long as nothing unusual happens: commands within the range, sound readings, ticks that do not fail.
It stops at the first sample at which something does; what follows then is decided in Python.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray, IntArray
from musclewire.compiled import compiled
from musclewire.controllers import sound_command, sound_sample
from musclewire.rigs._compiled_loop.one_wire import WireArrays, advance_sample, is_resolved, slack_m, surround
from musclewire.rigs._simulated import read_sample
from musclewire.signals import CONTROLLER_ANSWERS, ESTIMATOR_ANSWERS
from musclewire.wire import Rows

__all__ = ["BENCH", "CompiledLoopEnd", "LoopArrays", "RIG_COLUMNS", "RigArrays", "run_drive", "run_loop"]

# A row of a structured array; mypy knows no fields of it.
Row = Any
# A `compiled.Callback`, which only compiled code can call.
Tick = Any

BENCH = np.dtype([(name, np.float64) for name in ("sample_period_s", "amplifier_resolution_v", "reading_period_s")])
# The columns that the loop writes first.
RIG_COLUMNS = ("time_s", "drive_voltage_v", "wire_voltage_v", "shunt_voltage_v", "displacement_m", "force_n")


class CompiledLoopEnd(IntEnum):
    """How a compiled loop ended."""

    DONE = 0
    COMMAND_NOT_SOUND = 1
    WIRE_NOT_RESOLVED = 2
    READING_NOT_SOUND = 3
    ESTIMATOR_FAILED = 4
    CONTROLLER_FAILED = 5
    BEYOND_FINGER = 6


N_ESTIMATED, N_CONTROLLED = len(ESTIMATOR_ANSWERS), len(CONTROLLER_ANSWERS)
DONE, COMMAND_NOT_SOUND, WIRE_NOT_RESOLVED = (
    int(CompiledLoopEnd.DONE),
    int(CompiledLoopEnd.COMMAND_NOT_SOUND),
    int(CompiledLoopEnd.WIRE_NOT_RESOLVED),
)
READING_NOT_SOUND = int(CompiledLoopEnd.READING_NOT_SOUND)
ESTIMATOR_FAILED, CONTROLLER_FAILED = int(CompiledLoopEnd.ESTIMATOR_FAILED), int(CompiledLoopEnd.CONTROLLER_FAILED)


class RigArrays(NamedTuple):
    """All arrays of one simulated rig in compiled code; those that change are its own.

    ``times_s`` are the ends of the samples on the rig's clock [s]. ``noise`` has a row of standard normal numbers for
    each sample, in the order in which the instruments draw them; ``air`` the temperature [K] and the convection factor
    of each sample, no rows in still air. ``shown`` has a row for each sample, which begins with ``RIG_COLUMNS``;
    ``true_displacement_m`` the true mean of the connector's displacement, ``slack_m`` by how much friction holds it
    ahead of the wire. ``readings`` and ``scales`` are those of the instruments, which overwrite the noise.
    """

    wire: WireArrays
    times_s: FloatArray
    bench: Rows
    limits: Rows
    memory: Rows
    noise: FloatArray
    air: FloatArray
    readings: int
    scales: tuple[float, float, float, float, float]
    true_displacement_m: FloatArray
    slack_m: FloatArray
    shown: FloatArray


class LoopArrays(NamedTuple):
    """All arrays of one closed loop; those that change are its own.

    ``targets`` are those at each sample's end and those that hold after it. In a row of ``rig.shown`` there are, after
    ``RIG_COLUMNS``, the estimator's numbers, target, estimate, validity, the controller's numbers.
    """

    rig: RigArrays
    targets: FloatArray
    estimator_constants: FloatArray
    estimator_state: FloatArray
    estimator_answer: FloatArray
    controller_constants: FloatArray
    controller_state: FloatArray
    controller_answer: FloatArray


@compiled
def exchange(arrays: RigArrays, row: int, drive_voltage_v: float) -> bool:
    """Hold a drive for one sample and write ``RIG_COLUMNS`` into its row; whether its steps are resolved."""
    resolution_v, shown = arrays.bench[0]["amplifier_resolution_v"], arrays.shown[row]
    output_v = resolution_v * np.rint(drive_voltage_v / resolution_v)
    if arrays.air.shape[0] > 0:
        surround(arrays.wire, arrays.air[row, 0], arrays.air[row, 1])
    means = advance_sample(arrays.wire, output_v)
    shown[0], shown[1] = arrays.times_s[row], output_v
    shown[2], shown[3], shown[4], shown[5] = read_sample(arrays.noise[row], arrays.readings, means, arrays.scales)
    arrays.true_displacement_m[row] = means[2]
    arrays.slack_m[row] = slack_m(arrays.wire)
    return is_resolved(arrays.wire)


@compiled
def is_sound(arrays: RigArrays, row: int, block: FloatArray) -> bool:
    """Whether the protection goes on after a sample."""
    bench, shown = arrays.bench[0], arrays.shown[row]
    periods_s = bench["sample_period_s"], bench["reading_period_s"]
    return sound_sample(block, arrays.memory, arrays.limits, shown[1], shown[2], shown[3], *periods_s)


@compiled
def run_loop(estimate: Tick, control: Tick, arrays: LoopArrays, first_drive_v: float) -> tuple[int, int]:
    """Run a loop on its arrays; return how it ended and how many samples are complete."""
    rig, estimated, controlled = arrays.rig, arrays.estimator_answer, arrays.controller_answer
    shown = rig.shown
    sample, given, block = np.empty(4), np.empty(6), np.zeros(4)
    target_at = 6 + estimated.shape[0] - N_ESTIMATED
    drive_v = first_drive_v
    for row in range(shown.shape[0]):
        if not sound_command(rig.limits[0], drive_v):
            return COMMAND_NOT_SOUND, row
        if not exchange(rig, row, drive_v):
            return WIRE_NOT_RESOLVED, row
        if not is_sound(rig, row, block):
            return READING_NOT_SOUND, row
        sample[:] = shown[row, :4]
        estimate(arrays.estimator_constants, arrays.estimator_state, sample, estimated)
        if estimated[4] != 0.0:
            return ESTIMATOR_FAILED, row
        given[0], given[5] = arrays.targets[1, row], rig.bench[0]["sample_period_s"]
        given[1:5] = estimated[:4]
        control(arrays.controller_constants, arrays.controller_state, given, controlled)
        if controlled[1] != 0.0:
            return CONTROLLER_FAILED, row
        drive_v = controlled[0]
        shown[row, 6:target_at] = estimated[N_ESTIMATED:]
        shown[row, target_at] = arrays.targets[0, row]
        shown[row, target_at + 1] = estimated[0]
        shown[row, target_at + 2] = estimated[2]
        shown[row, target_at + 3 :] = controlled[N_CONTROLLED:]
    return DONE, shown.shape[0]


@compiled
def run_drive(
    rig: RigArrays, drives_v: FloatArray, numbers: FloatArray, places: IntArray, true: FloatArray
) -> tuple[int, int]:
    """Hold each drive for a sample; return how the run ended and how many samples are complete.

    ``numbers`` are those of the wire's state, which the run changes; after a sample those in ``places`` are written
    into its row of ``true``.
    """
    block = np.zeros(4)
    for row in range(drives_v.size):
        if not sound_command(rig.limits[0], drives_v[row]):
            return COMMAND_NOT_SOUND, row
        if not exchange(rig, row, drives_v[row]):
            return WIRE_NOT_RESOLVED, row
        if not is_sound(rig, row, block):
            return READING_NOT_SOUND, row
        for column in range(places.size):
            true[row, column] = numbers[places[column]]
    return DONE, drives_v.size
