"""The ticks of our controllers, compiled: the arithmetic of their ``step`` to the bit, for loops in a batch."""

from __future__ import annotations

import math

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.controllers import _kernels as kernels
from musclewire.signals import Reason

__all__ = ["FUZZY_PID_STATE", "PID_SETTINGS", "PID_STATE", "fuzzy_tick", "pid_tick"]

FUZZY_PID_STATE = np.dtype(
    [
        (name, np.float64)
        for name in (
            "started", "drive_voltage_v", "error", "measured", "measured_rate", "error_rate", "rates_known",
        )
    ]
)  # fmt: skip
PID_SETTINGS = np.dtype(
    [
        (name, np.float64)
        for name in (
            "kp", "ki", "kd", "input_scale", "error_unit", "derivative_filter_s", "sense_voltage_v",
            "maximum_voltage_v",
        )
    ]
)  # fmt: skip
PID_STATE = np.dtype(
    [(name, np.float64) for name in ("started", "drive_voltage_v", "error", "measured", "measured_rate", "rates_known")]
)
N_SETTINGS = len(kernels.SETTINGS.names or ())
NO_CURRENT = float(Reason.NO_CURRENT)


@compiled
def fuzzy_tick(constants: FloatArray, state: FloatArray, given: FloatArray, answer: FloatArray) -> None:
    """Control by the fuzzy-tuned PID: settings and rule base in ``constants``, the gains recorded."""
    memory = state.view(FUZZY_PID_STATE)[0]
    target, measured, reason, dt_s = given[0], given[1], given[4], given[5]
    if reason == NO_CURRENT:
        if memory["started"] != 0.0:
            memory["measured_rate"] = memory["error_rate"] = memory["rates_known"] = 0.0
        answer_with(answer, memory["drive_voltage_v"], 0.0, 0.0, 0.0, 0.0)
        return
    if memory["started"] == 0.0:
        memory["started"] = memory["rates_known"] = 1.0
        memory["error"], memory["measured"] = target - measured, measured
    before = (
        memory["drive_voltage_v"], memory["error"], memory["measured"], memory["measured_rate"], memory["error_rate"],
        memory["rates_known"] != 0.0,
    )  # fmt: skip
    settings, rules = constants[:N_SETTINGS].view(kernels.SETTINGS), constants[N_SETTINGS:].view(kernels.RULES)
    after = kernels.tick(before, target, measured, dt_s, settings, rules)
    memory["drive_voltage_v"], memory["error"], memory["measured"] = after[0], after[1], after[2]
    memory["measured_rate"], memory["error_rate"], memory["rates_known"] = after[3], after[4], 1.0
    failed = 0.0 if math.isfinite(target + measured) and math.isfinite(after[3] + after[4]) and dt_s > 0.0 else 1.0
    answer_with(answer, after[0], failed, after[6], after[7], after[8])


@compiled
def pid_tick(constants: FloatArray, state: FloatArray, given: FloatArray, answer: FloatArray) -> None:
    """Control by the plain PID; its gains are recorded."""
    settings, memory = constants.view(PID_SETTINGS)[0], state.view(PID_STATE)[0]
    target, measured, reason, dt_s = given[0], given[1], given[4], given[5]
    if reason == NO_CURRENT:
        if memory["started"] != 0.0:
            memory["measured_rate"] = memory["rates_known"] = 0.0
        answer_with(answer, memory["drive_voltage_v"], 0.0, 0.0, 0.0, 0.0)
        return
    error, rate = target - measured, 0.0
    if memory["started"] == 0.0:
        memory["started"] = memory["rates_known"] = 1.0
        memory["error"], memory["measured"] = error, measured
    if memory["rates_known"] != 0.0:
        weight = dt_s / (settings["derivative_filter_s"] + dt_s)
        rate = memory["measured_rate"] + weight * ((measured - memory["measured"]) / dt_s - memory["measured_rate"])
    parts = (
        settings["kp"] * (error - memory["error"])
        + settings["ki"] * dt_s * error
        - settings["kd"] * (rate - memory["measured_rate"])
    )
    drive_v = memory["drive_voltage_v"] + settings["input_scale"] * parts / settings["error_unit"]
    failed = 0.0 if math.isfinite(drive_v) and dt_s > 0.0 else 1.0
    drive_v = min(max(drive_v, settings["sense_voltage_v"]), settings["maximum_voltage_v"])
    memory["drive_voltage_v"], memory["error"], memory["measured"] = drive_v, error, measured
    memory["measured_rate"], memory["rates_known"] = rate, 1.0
    answer_with(answer, drive_v, failed, settings["kp"], settings["ki"], settings["kd"])


@compiled
def answer_with(answer: FloatArray, drive_voltage_v: float, failed: float, kp: float, ki: float, kd: float) -> None:
    """Write the answer of a tick and the gains that are recorded with it."""
    answer[0] = drive_voltage_v
    answer[1] = failed
    answer[2] = kp
    answer[3] = ki
    answer[4] = kd
