"""The arithmetic of one controller tick, compiled: memberships, inference, Eq. 6 and the velocity-form PID.

Everything stands in this one file, in strict IEEE arithmetic and without allocation of unknown size, so that
a C translation can equal it to the bit. What a rule base or a set of settings says arrives as one flat array
of floats each, because every array handed over from Python costs about 60 ns of the tick.
``fuzzy.pack_rules`` and ``fuzzy_pid.pack_settings`` write these arrays; the offsets below are their layout.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from musclewire.compiled import compiled

Floats = NDArray[np.float64]

UNIVERSE_END = 3.0  # the published tables live on -3..3; integer corners keep both directions exactly alike
UNIVERSE_POINTS = 101
CONSTANT, PRODUCT_WEIGHTED_SUM, MIN_MAX_CENTROID = 0.0, 1.0, 2.0
TRIANGLE, FALLING, RISING = 0.0, 1.0, 2.0

# Layout of the rule array: kind, mirrored (+1 or -1: the half of the tables that is read; 0: all), then 7
# sets (shape and three points), 3 tables, 7 sampled output sets.
AT_KIND = 0
AT_MIRRORED = 1
AT_INPUT_SETS = 2
AT_TABLES = AT_INPUT_SETS + 7 * 4
AT_OUTPUT_SETS = AT_TABLES + 3 * 7 * 7
RULE_VALUES = AT_OUTPUT_SETS + 7 * UNIVERSE_POINTS

# Layout of the settings array.
AT_KP_MINIMUM, AT_KP_MAXIMUM, AT_KI_MINIMUM, AT_KI_MAXIMUM, AT_KD_MINIMUM, AT_KD_MAXIMUM = 0, 1, 2, 3, 4, 5
AT_INPUT_SCALE, AT_ERROR_UNIT, AT_ERROR_RANGE, AT_CHANGE_RANGE, AT_DERIVATIVE_FILTER = 6, 7, 8, 9, 10
AT_SENSE_VOLTAGE, AT_MAXIMUM_VOLTAGE = 11, 12
SETTING_VALUES = 13


@compiled
def membership(shape: float, first: float, second: float, third: float, x: float) -> float:
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
def grade_inputs(rules: Floats, ratio: float, grades: Floats) -> None:
    """Write the grades of an input in [-1, 1] (clipped) in the seven input sets into ``grades``."""
    clipped = min(max(ratio, -1.0), 1.0)
    x = clipped * UNIVERSE_END
    for index in range(7):
        at = AT_INPUT_SETS + 4 * index
        grades[index] = membership(rules[at], rules[at + 1], rules[at + 2], rules[at + 3], x)


@compiled
def product_weighted_sum(rules: Floats, error_grades: Floats, change_grades: Floats) -> tuple[float, float, float]:
    """Return (kp, ki, kd) ratios after Zhao, Tomizuka, Isaka 1993, doi 10.1109/21.260670.

    A rule fires with mu, the product of its two grades. Inverting mu_S = -ln(x)/4 and mu_B = -ln(1-x)/4
    gives what Small and Big mean at that mu; the integral table holds its ratio already.
    """
    kp = ki = kd = 0.0
    for row in range(7):
        if error_grades[row] == 0.0:
            continue
        for column in range(7):
            mu = error_grades[row] * change_grades[column]
            if mu == 0.0:
                continue
            at = AT_TABLES + 7 * row + column
            small = math.exp(-4.0 * mu)
            big = 1.0 - small
            kp += mu * (big if rules[at] == 1.0 else small)
            ki += mu * rules[at + 49]
            kd += mu * (big if rules[at + 98] == 1.0 else small)
    return min(max(kp, 0.0), 1.0), min(max(ki, 0.0), 1.0), min(max(kd, 0.0), 1.0)


@compiled
def fire_labels(rules: Floats, table: int, error_grades: Floats, change_grades: Floats, fired: Floats) -> None:
    """Write how strongly each output set of one table fires into ``fired``: min for and, max for or."""
    for label in range(7):
        fired[label] = 0.0
    for row in range(7):
        if error_grades[row] == 0.0:
            continue
        for column in range(7):
            strength = min(error_grades[row], change_grades[column])
            label = int(rules[AT_TABLES + 49 * table + 7 * row + column])
            fired[label] = max(fired[label], strength)


@compiled
def centroid_ratio(rules: Floats, fired: Floats, joined: Floats) -> float:
    """Return (1 + x)/2 for the centroid x (in units of the universe) of the output sets cut at ``fired``.

    The joined set is piecewise linear between the 101 points, and its area and moment are exact: the two end
    points carry half a cell, whose centre is a third of the spacing inwards.
    """
    for point in range(UNIVERSE_POINTS):
        joined[point] = 0.0
    for label in range(7):
        strength = fired[label]
        if strength == 0.0:
            continue
        at = AT_OUTPUT_SETS + UNIVERSE_POINTS * label
        for point in range(UNIVERSE_POINTS):
            grade = rules[at + point]
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
def infer(rules: Floats, error_ratio: float, change_ratio: float) -> tuple[float, float, float]:
    """Return the (kp, ki, kd) ratios in [0, 1] for two inputs, each clipped to [-1, 1]."""
    if rules[AT_KIND] == CONSTANT:
        return rules[AT_TABLES], rules[AT_TABLES + 49], rules[AT_TABLES + 98]
    half = rules[AT_MIRRORED]
    if half != 0.0:
        sign = half if error_ratio > 0.0 else (-half if error_ratio < 0.0 else 0.0)
        error_ratio, change_ratio = sign * error_ratio, sign * change_ratio
    error_grades = np.empty(7)
    change_grades = np.empty(7)
    grade_inputs(rules, error_ratio, error_grades)
    grade_inputs(rules, change_ratio, change_grades)
    if rules[AT_KIND] == PRODUCT_WEIGHTED_SUM:
        return product_weighted_sum(rules, error_grades, change_grades)
    fired = np.empty(7)
    joined = np.empty(UNIVERSE_POINTS)
    fire_labels(rules, 0, error_grades, change_grades, fired)
    kp = centroid_ratio(rules, fired, joined)
    fire_labels(rules, 1, error_grades, change_grades, fired)
    ki = centroid_ratio(rules, fired, joined)
    fire_labels(rules, 2, error_grades, change_grades, fired)
    kd = centroid_ratio(rules, fired, joined)
    return kp, ki, kd


@compiled
def infer_many(rules: Floats, error_ratios: Floats, change_ratios: Floats, ratios: Floats) -> None:
    """Write the three ratios for each pair of inputs into ``ratios``, shape (3, n)."""
    for index in range(error_ratios.shape[0]):
        kp, ki, kd = infer(rules, error_ratios[index], change_ratios[index])
        ratios[0, index] = kp
        ratios[1, index] = ki
        ratios[2, index] = kd


@compiled
def gain_from_ratio(ratio: float, minimum: float, maximum: float) -> float:
    """Return the gain for a fuzzy ratio: the paper's Eq. 6."""
    return (maximum - minimum) * ratio + minimum


@compiled
def tick(
    drive_voltage_v: float,
    error: float,
    measured: float,
    measured_rate: float,
    error_rate: float,
    rates_known: bool,
    new_target: float,
    new_measured: float,
    dt_s: float,
    settings: Floats,
    rules: Floats,
) -> tuple[float, float, float, float, float, bool, float, float, float]:
    """Advance the controller by one tick.

    The first six arguments are its state, and so are the first six results. The last three results are the
    gains used. Errors and measurements are in the caller's unit; the paper's percent strain enters by the
    error unit. See ``fuzzy_pid`` for the law and its reasons.
    """
    new_error = new_target - new_measured
    new_measured_rate = 0.0
    new_error_rate = 0.0
    if rates_known:
        # Backward Euler of a first-order lag: stable whatever the tick length, and no lag at all for a zero
        # constant.
        share = dt_s / (settings[AT_DERIVATIVE_FILTER] + dt_s)
        new_measured_rate = measured_rate + share * ((new_measured - measured) / dt_s - measured_rate)
        new_error_rate = error_rate + share * ((new_error - error) / dt_s - error_rate)
    unit = settings[AT_ERROR_UNIT]
    kp_ratio, ki_ratio, kd_ratio = infer(
        rules, new_error / unit / settings[AT_ERROR_RANGE], new_error_rate / unit / settings[AT_CHANGE_RANGE]
    )
    kp = gain_from_ratio(kp_ratio, settings[AT_KP_MINIMUM], settings[AT_KP_MAXIMUM])
    ki = gain_from_ratio(ki_ratio, settings[AT_KI_MINIMUM], settings[AT_KI_MAXIMUM])
    kd = gain_from_ratio(kd_ratio, settings[AT_KD_MINIMUM], settings[AT_KD_MAXIMUM])
    proportional = kp * (new_error - error)
    integral = ki * dt_s * new_error
    derivative = kd * (new_measured_rate - measured_rate)
    change_v = settings[AT_INPUT_SCALE] * (proportional + integral - derivative) / unit
    drive = drive_voltage_v + change_v
    # In this order a drive that lost its meaning falls to the sense voltage, never to the maximum.
    drive = drive if drive > settings[AT_SENSE_VOLTAGE] else settings[AT_SENSE_VOLTAGE]
    drive = drive if drive < settings[AT_MAXIMUM_VOLTAGE] else settings[AT_MAXIMUM_VOLTAGE]
    return drive, new_error, new_measured, new_measured_rate, new_error_rate, True, kp, ki, kd
