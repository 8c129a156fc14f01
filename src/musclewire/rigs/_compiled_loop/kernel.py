"""A closed loop of a simulated rig in compiled code, made of what the loop in Python runs too.

The loop goes on as long as nothing unusual happens: commands within the range, sound readings, ticks that do not fail.
It stops at the first sample at which something does; what follows then is decided in Python.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray, IntArray
from musclewire.compiled import compiled, compiled_inner
from musclewire.controllers import State, commanded, judged_sample
from musclewire.rigs._simulated import read_sample
from musclewire.signals import CONTROLLER_ANSWERS, CONTROLLER_INPUTS, ESTIMATOR_ANSWERS
from musclewire.wire import Rows, advance_rows, is_resolved

# A `compiled.Callback`, which only compiled code can call.
Tick = Any

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


RUN = int(State.RUN)
N_ESTIMATED, N_CONTROLLED = len(ESTIMATOR_ANSWERS), len(CONTROLLER_ANSWERS)
N_CONTROLLER_INPUTS = len(CONTROLLER_INPUTS)
DONE, COMMAND_NOT_SOUND, WIRE_NOT_RESOLVED = (
    int(CompiledLoopEnd.DONE),
    int(CompiledLoopEnd.COMMAND_NOT_SOUND),
    int(CompiledLoopEnd.WIRE_NOT_RESOLVED),
)
READING_NOT_SOUND = int(CompiledLoopEnd.READING_NOT_SOUND)
ESTIMATOR_FAILED, CONTROLLER_FAILED = int(CompiledLoopEnd.ESTIMATOR_FAILED), int(CompiledLoopEnd.CONTROLLER_FAILED)


class RigArrays(NamedTuple):
    """All that compiled code takes of one simulated rig; the arrays that change are its own."""

    states: Rows  # one record each, as of constants, cells and load
    constants: Rows
    cells: Rows
    load: Rows
    plan: FloatArray  # how a sample is divided into steps
    sample_period_s: float
    amplifier_resolution_v: float
    rules: Rows
    protection: Rows
    # A row of standard normal numbers for each sample, in the order in which the instruments draw them.
    noise: FloatArray
    air: FloatArray  # temperature [K] and surface times convection factor [m2] of each sample, no rows in still air
    readings: int
    scales: tuple[float, float, float, float, float]
    places: IntArray  # of the numbers of the wire's state that are written into ``true`` after each sample
    true: FloatArray
    true_displacement_m: FloatArray  # true mean of the connector's displacement in each sample
    held_m: FloatArray  # by how much friction held the connector ahead of the wire at most, (1,)
    shown: FloatArray  # a row for each sample, which begins with ``RIG_COLUMNS``


class LoopArrays(NamedTuple):
    """All arrays of one closed loop; those that change are its own.

    In a row of ``rig.shown`` there are, after ``RIG_COLUMNS``, the estimator's numbers, target, estimate, its deviation
    and validity, the controller's numbers.
    """

    rig: RigArrays
    elapsed_s: FloatArray  # time of each sample in the recording, by which the estimator goes
    targets: FloatArray  # those at each sample's end and those that hold after it
    estimator_constants: FloatArray
    estimator_state: FloatArray
    estimator_answer: FloatArray
    wire_places: IntArray  # where in the estimator's answer each number of a ``WireEstimate`` is; -1 for none
    controller_constants: FloatArray
    controller_state: FloatArray
    controller_answer: FloatArray


@compiled_inner
def exchange(rig: RigArrays, row: int, drive_voltage_v: float) -> bool:
    """Hold a drive for one sample and write ``RIG_COLUMNS`` into its row; whether its steps are resolved."""
    resolution_v, shown = rig.amplifier_resolution_v, rig.shown[row]
    state, constants = rig.states[0], rig.constants[0]
    output_v = resolution_v * np.rint(drive_voltage_v / resolution_v)
    if rig.air.shape[0] > 0:
        constants.ambient_temperature_k, constants.surface_factor_m2 = rig.air[row, 0], rig.air[row, 1]
    means = advance_rows(rig.states, rig.constants, rig.cells, rig.load, output_v, rig.plan)
    shown[0], shown[1] = state.time_s, output_v
    shown[2], shown[3], shown[4], shown[5] = read_sample(rig.noise[row], rig.readings, means, rig.scales)
    rig.true_displacement_m[row] = means[2]
    rig.held_m[0] = max(rig.held_m[0], (state.connector_contraction - state.contraction) * constants.leg_length_m)
    numbers = rig.states.view(np.float64)
    for column in range(rig.places.size):
        rig.true[row, column] = numbers[rig.places[column]]
    return is_resolved(state)


@compiled
def run_loop(estimate: Tick, control: Tick, arrays: LoopArrays, first_drive_v: float) -> tuple[int, int]:
    """Run a loop on its arrays; return how it ended and how many samples are complete."""
    rig, estimated, controlled = arrays.rig, arrays.estimator_answer, arrays.controller_answer
    shown, period_s = rig.shown, rig.sample_period_s
    sample, given = np.empty(4), np.full(N_CONTROLLER_INPUTS, np.nan)
    target_at = 6 + estimated.shape[0] - N_ESTIMATED
    drive_v = first_drive_v
    for row in range(shown.shape[0]):
        _, state = commanded(rig.protection, rig.rules, 0, drive_v)
        if state != RUN:
            return COMMAND_NOT_SOUND, row
        if not exchange(rig, row, drive_v):
            return WIRE_NOT_RESOLVED, row
        sample[0], sample[1:] = arrays.elapsed_s[row], shown[row, 1:4]
        ordered_v = max(drive_v, sample[1])
        if not judged_sample(rig.protection, rig.rules, 0, sample[1], sample[2], sample[3], ordered_v, period_s):
            return READING_NOT_SOUND, row
        estimate(arrays.estimator_constants, arrays.estimator_state, sample, estimated)
        if estimated[4] != 0.0:
            return ESTIMATOR_FAILED, row
        given[0], given[5] = arrays.targets[1, row], period_s
        given[1:5] = estimated[:4]
        for number, place in enumerate(arrays.wire_places):
            if place >= 0:
                given[6 + number] = estimated[place]
        control(arrays.controller_constants, arrays.controller_state, given, controlled)
        if controlled[1] != 0.0:
            return CONTROLLER_FAILED, row
        drive_v = controlled[0]
        shown[row, 6:target_at] = estimated[N_ESTIMATED:]
        shown[row, target_at] = arrays.targets[0, row]
        shown[row, target_at + 1] = estimated[0]
        shown[row, target_at + 2] = estimated[1]
        shown[row, target_at + 3] = estimated[2]
        shown[row, target_at + 4 :] = controlled[N_CONTROLLED:]
    return DONE, shown.shape[0]


@compiled
def no_estimate(_constants: FloatArray, _state: FloatArray, _given: FloatArray, answer: FloatArray) -> None:
    """Estimate nothing: for a run whose drive is known beforehand."""
    answer[:] = 0.0


@compiled
def scheduled_drive(constants: FloatArray, state: FloatArray, _given: FloatArray, answer: FloatArray) -> None:
    """Control by a schedule: the drive of each sample in turn, the last one for good."""
    state[0] = min(state[0] + 1.0, constants.size - 1.0)
    answer[0], answer[1] = constants[int(state[0])], 0.0
