"""The arithmetic of the fuzzy-tuned PID, compiled: memberships, inference, Eq. 6 and one tick of the velocity form.

All in this one file, in strict IEEE arithmetic and without allocation of unknown size, so that a C translation can
equal it to the bit. Rule base, settings and limits are one structured array of length 1, whose fields ``FUZZY_PID``
names: every array passed from Python costs about 100 ns of the tick.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inner
from musclewire.signals import Reason

# A structured array of length 1, or its only row; mypy knows no fields of either.
Rows = NDArray[np.void]
Row = Any

UNIVERSE_END = 3.0  # the published tables live on -3..3; integer corners keep both directions exactly alike
UNIVERSE_POINTS = 101
# Ways of inference, as compiled code compares them.
CONSTANT = 0
PRODUCT_WEIGHTED_SUM = 1
MIN_MAX_CENTROID = 2
# Shapes of fuzzy sets, as compiled code compares them.
TRIANGLE = 0
FALLING = 1
RISING = 2

FUZZY_PID = np.dtype(
    [
        ("inference", np.int64),  # CONSTANT, PRODUCT_WEIGHTED_SUM or MIN_MAX_CENTROID
        ("mirrored", np.float64),  # +1 or -1: the half of the tables that is read; 0: all of them
        ("set_shapes", np.int64, 7),  # TRIANGLE, FALLING or RISING of each input set
        ("set_points", np.float64, (7, 3)),
        ("kp_table", np.float64, (7, 7)),  # error down, change of error across
        ("ki_table", np.float64, (7, 7)),
        ("kd_table", np.float64, (7, 7)),
        ("output_sets", np.float64, (7, UNIVERSE_POINTS)),  # sampled
        *(
            (name, np.float64)
            for name in (
                "kp_minimum", "kp_maximum", "ki_minimum", "ki_maximum", "kd_minimum", "kd_maximum", "input_scale",
                "error_unit", "error_range", "change_range", "derivative_filter_s", "sense_voltage_v",
                "maximum_voltage_v",
            )
        ),
    ]
)  # fmt: skip
NO_CURRENT = float(Reason.NO_CURRENT)


class PidState(NamedTuple):
    """What a PID remembers, in the unit of the controlled quantity; in compiled code a plain tuple in this order."""

    started: float  # 1 once there has been an estimate; until then only the drive counts
    drive_voltage_v: float  # as it was clamped
    error: float
    measured: float
    measured_rate: float  # filtered, per second
    error_rate: float  # filtered, per second
    rates_known: float  # 0 after a sample without current: the last measurement is then too old to make a rate with


Numbers = tuple[float, float, float, float, float, float, float]


@compiled
def membership(shape: int, first: float, second: float, third: float, x: float) -> float:
    """Return the grade in [0, 1] of ``x`` in one set; z and s shapes use ``first`` and ``second`` only."""
    if shape == TRIANGLE:
        if x <= first or x >= third:
            return 0.0
        if x <= second:
            return (x - first) / (second - first)
        return (third - x) / (third - second)
    if x <= first:
        rising = 0.0
    elif x >= second:
        rising = 1.0
    elif x <= (first + second) / 2.0:
        part = (x - first) / (second - first)
        rising = 2.0 * (part * part)
    else:
        part = (x - second) / (second - first)
        rising = 1.0 - 2.0 * (part * part)
    return rising if shape == RISING else 1.0 - rising


@compiled
def grade_inputs(rule: Row, ratio: float, grades: FloatArray) -> None:
    """Write the grades of an input in [-1, 1] (clipped) in the seven input sets into ``grades``."""
    clipped = min(max(ratio, -1.0), 1.0)
    x = clipped * UNIVERSE_END
    shapes, points = rule["set_shapes"], rule["set_points"]
    for index in range(7):
        grades[index] = membership(shapes[index], points[index, 0], points[index, 1], points[index, 2], x)


@compiled
def weigh_rules(rules: Rows, error_ratio: float, change_ratio: float, weights: FloatArray) -> None:
    """Write how strongly each rule fires into ``weights``, (7, 7): sets of the error down, of its change across."""
    rule = rules[0]
    half = rule["mirrored"]
    if half != 0.0:
        sign = half if error_ratio > 0.0 else (-half if error_ratio < 0.0 else 0.0)
        error_ratio, change_ratio = sign * error_ratio, sign * change_ratio
    error_grades = np.empty(7)
    change_grades = np.empty(7)
    grade_inputs(rule, error_ratio, error_grades)
    grade_inputs(rule, change_ratio, change_grades)
    product = rule["inference"] == PRODUCT_WEIGHTED_SUM
    for row in range(7):
        for column in range(7):
            error, change = error_grades[row], change_grades[column]
            weights[row, column] = error * change if product else min(error, change)


@compiled_inner
def product_weighted_sum(rule: Row, weights: FloatArray) -> tuple[float, float, float]:
    """Return (kp, ki, kd) ratios after Zhao, Tomizuka, Isaka 1993, doi 10.1109/21.260670.

    A rule fires with mu, the product of its two grades. Inverting mu_S = -ln(x)/4 and mu_B = -ln(1-x)/4 gives the
    values of Small and Big at that mu; the integral table holds its ratio already.
    """
    kp_table, ki_table, kd_table = rule["kp_table"], rule["ki_table"], rule["kd_table"]
    kp = ki = kd = 0.0
    for row in range(7):
        for column in range(7):
            mu = weights[row, column]
            if mu == 0.0:
                continue
            small = math.exp(-4.0 * mu)
            big = 1.0 - small
            kp += mu * (big if kp_table[row, column] == 1.0 else small)
            ki += mu * ki_table[row, column]
            kd += mu * (big if kd_table[row, column] == 1.0 else small)
    return min(max(kp, 0.0), 1.0), min(max(ki, 0.0), 1.0), min(max(kd, 0.0), 1.0)


@compiled_inner
def fire_labels(table: FloatArray, weights: FloatArray, fired: FloatArray) -> None:
    """Write how strongly each output set of one table fires into ``fired``: that of its strongest rule."""
    for label in range(7):
        fired[label] = 0.0
    for row in range(7):
        for column in range(7):
            label = int(table[row, column])
            fired[label] = max(fired[label], weights[row, column])


@compiled_inner
def centroid_ratio(output_sets: FloatArray, fired: FloatArray, joined: FloatArray) -> float:
    """Return (1 + x)/2 for the centroid x (in units of the universe) of the output sets cut at ``fired``.

    The joined set is piecewise linear between the 101 points, and its area and moment are exact: the two end points
    carry half a cell, whose centre is a third of the spacing inwards.
    """
    for point in range(UNIVERSE_POINTS):
        joined[point] = 0.0
    for label in range(7):
        strength = fired[label]
        if strength == 0.0:
            continue
        for point in range(UNIVERSE_POINTS):
            grade = output_sets[label, point]
            cut = grade if grade < strength else strength
            joined[point] = cut if cut > joined[point] else joined[point]
    spacing = 2.0 / (UNIVERSE_POINTS - 1)
    left, right = 0.5 * joined[0], 0.5 * joined[UNIVERSE_POINTS - 1]
    area = left + right
    moment = (right - left) * (1.0 - spacing / 3.0)
    for point in range(1, UNIVERSE_POINTS - 1):
        area += joined[point]
        moment += joined[point] * (spacing * (point - UNIVERSE_POINTS // 2))
    ratio = 0.5 if area == 0.0 else (1.0 + moment / area) / 2.0
    return min(max(ratio, 0.0), 1.0)


@compiled
def infer(rules: Rows, error_ratio: float, change_ratio: float) -> tuple[float, float, float]:
    """Return the (kp, ki, kd) ratios in [0, 1] for two inputs, each clipped to [-1, 1]."""
    rule = rules[0]
    if rule["inference"] == CONSTANT:
        return rule["kp_table"][0, 0], rule["ki_table"][0, 0], rule["kd_table"][0, 0]
    weights = np.empty((7, 7))
    weigh_rules(rules, error_ratio, change_ratio, weights)
    if rule["inference"] == PRODUCT_WEIGHTED_SUM:
        return product_weighted_sum(rule, weights)
    fired = np.empty(7)
    joined = np.empty(UNIVERSE_POINTS)
    fire_labels(rule["kp_table"], weights, fired)
    kp = centroid_ratio(rule["output_sets"], fired, joined)
    fire_labels(rule["ki_table"], weights, fired)
    ki = centroid_ratio(rule["output_sets"], fired, joined)
    fire_labels(rule["kd_table"], weights, fired)
    kd = centroid_ratio(rule["output_sets"], fired, joined)
    return kp, ki, kd


@compiled
def infer_many(rules: Rows, error_ratios: FloatArray, change_ratios: FloatArray, ratios: FloatArray) -> None:
    """Write the three ratios for each pair of inputs into ``ratios``, shape (3, n)."""
    for index in range(error_ratios.shape[0]):
        kp, ki, kd = infer(rules, error_ratios[index], change_ratios[index])
        ratios[0, index] = kp
        ratios[1, index] = ki
        ratios[2, index] = kd


@compiled
def gain_from_ratio(ratio: float, minimum: float, maximum: float) -> float:
    """Return the gain for a fuzzy ratio of 0 to 1 (Eq. 6): K = (K_max - K_min) ratio + K_min, in the limits' unit.

    References
    ----------
    Lan and Fan 2010, Eq. 6; Zhao, Tomizuka and Isaka 1993, doi 10.1109/21.260670.
    """
    return (maximum - minimum) * ratio + minimum


@compiled
def rule_inputs(constants: Rows, error: float, error_rate: float) -> tuple[float, float]:
    """Return the two inputs of the rules: an error and its filtered rate, each over its range."""
    setting = constants[0]
    unit = setting["error_unit"]
    return error / unit / setting["error_range"], error_rate / unit / setting["change_range"]


@compiled
def fuzzy_pid_step(
    state: Numbers, target: float, measured: float, reason: float, dt_s: float, constants: Rows
) -> tuple[Numbers, float, tuple[float, float, float]]:
    """Advance by a tick of ``_fuzzy_pid``'s law; return next state, whether it failed (0 or 1), and the gains.

    Without current the drive stays, the rates are forgotten and no gains are used.
    """
    started, drive_voltage_v, error_before, measured_before, measured_rate_before, error_rate_before, rates_known = (
        state
    )
    if reason == NO_CURRENT:
        return (started, drive_voltage_v, error_before, measured_before, 0.0, 0.0, 0.0), 0.0, (0.0, 0.0, 0.0)
    if not (math.isfinite(target + measured) and 0.0 < dt_s < math.inf):
        return state, 1.0, (0.0, 0.0, 0.0)
    setting = constants[0]
    error = target - measured
    if started == 0.0:
        error_before, measured_before, rates_known = error, measured, 1.0
    measured_rate = 0.0
    error_rate = 0.0
    if rates_known != 0.0:
        # Backward Euler of a first-order lag: stable whatever the tick length, and no lag at all for a zero
        # constant.
        weight = dt_s / (setting["derivative_filter_s"] + dt_s)
        measured_rate = measured_rate_before + weight * ((measured - measured_before) / dt_s - measured_rate_before)
        error_rate = error_rate_before + weight * ((error - error_before) / dt_s - error_rate_before)
    failed = 0.0 if math.isfinite(measured_rate + error_rate) else 1.0
    unit = setting["error_unit"]
    error_ratio, change_ratio = rule_inputs(constants, error, error_rate)
    kp_ratio, ki_ratio, kd_ratio = infer(constants, error_ratio, change_ratio)
    kp = gain_from_ratio(kp_ratio, setting["kp_minimum"], setting["kp_maximum"])
    ki = gain_from_ratio(ki_ratio, setting["ki_minimum"], setting["ki_maximum"])
    kd = gain_from_ratio(kd_ratio, setting["kd_minimum"], setting["kd_maximum"])
    proportional = kp * (error - error_before)
    integral = ki * dt_s * error
    derivative = kd * (measured_rate - measured_rate_before)
    change_v = setting["input_scale"] * (proportional + integral - derivative) / unit
    drive = drive_voltage_v + change_v
    # In this order a drive that lost its meaning falls to the sense voltage, never to the maximum.
    drive = drive if drive > setting["sense_voltage_v"] else setting["sense_voltage_v"]
    drive = drive if drive < setting["maximum_voltage_v"] else setting["maximum_voltage_v"]
    return (1.0, drive, error, measured, measured_rate, error_rate, 1.0), failed, (kp, ki, kd)


@compiled
def fuzzy_tick(constants: FloatArray, state: FloatArray, given: FloatArray, answer: FloatArray) -> None:
    """Run ``fuzzy_pid_step`` on the arrays of a ``signals.CompiledTick``."""
    before = (state[0], state[1], state[2], state[3], state[4], state[5], state[6])
    after, failed, gains = fuzzy_pid_step(before, given[0], given[1], given[4], given[5], constants.view(FUZZY_PID))
    for place in range(len(before)):
        state[place] = after[place]
    answer[0], answer[1], answer[2], answer[3], answer[4] = after[1], failed, gains[0], gains[1], gains[2]
