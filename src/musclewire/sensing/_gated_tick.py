"""The tick of the gated estimator, compiled: the arithmetic of ``GatedEstimator.step`` to the bit."""

from __future__ import annotations

import math

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.sensing import _polynomial_tick as polynomial_tick
from musclewire.sensing._polynomial_tick import Row, add_friction, answer_with
from musclewire.signals import Reason

__all__ = ["CONSTANTS", "STATE", "tick"]

# Constants and state begin with the polynomial estimator's, whose segment and friction are the same; names as in
# ``gated_branches``. The curve's coefficients follow the constants in the same array.
CONSTANTS = np.dtype(
    [
        (name, np.float64)
        for name in (
            "dt_s", "mean_power_gain", "lagging_gain", "approach_gain", "middle_gain", "return_gain",
            "turning_fraction", "supporting_fraction", "still_per_s", "driven_per_s", "surprise_per_s", "noise_s",
            "motion_deviations", "min_motion_variance", "gap_fraction", "beyond", "min_variance", "first_variance",
            "min_noise", "max_power_w", "max_ratio", "max_noise_v2", "ambiguous_above", "resistance_min_ohm", "per_ohm",
            "normalised_min", "normalised_max", "normalised_margin",
        )
    ]
)  # fmt: skip
STATE = np.dtype(
    [
        (name, np.float64)
        for name in (
            "followed", "value", "resistance", "lagging", "variance", "before", "before_last", "noise_v2", "learnt_s",
            "mean_power_w", "heating", "sensing",
        )
    ]
)  # fmt: skip
SHARED_CONSTANTS, SHARED_STATE = polynomial_tick.CONSTANTS, polynomial_tick.STATE
N_SHARED, N_STATE = len(polynomial_tick.CONSTANTS.names or ()), len(polynomial_tick.STATE.names or ())
N_CONSTANTS = N_SHARED + len(CONSTANTS.names or ())
NO_CURRENT, OK, COLD = float(Reason.NO_CURRENT), float(Reason.OK), float(Reason.COLD)
OUT_OF_RANGE, MISMATCH = float(Reason.OUT_OF_RANGE), float(Reason.MISMATCH)


@compiled
def tick(constants: FloatArray, state: FloatArray, given: FloatArray, answer: FloatArray) -> None:
    """Estimate one sample; see ``signals._compiled_tick`` for the arrays."""
    constants_row, state_row = constants[:N_SHARED].view(SHARED_CONSTANTS)[0], state[:N_STATE].view(SHARED_STATE)[0]
    gates, branch = constants[N_SHARED:N_CONSTANTS].view(CONSTANTS)[0], state[N_STATE:].view(STATE)[0]
    wire_voltage_v, shunt_voltage_v = given[2], given[3]
    resistance_ohm = 0.0
    if abs(shunt_voltage_v) >= constants_row["minimum_current_a"] * constants_row["shunt_resistance_ohm"]:
        resistance_ohm = wire_voltage_v / shunt_voltage_v * constants_row["shunt_resistance_ohm"]
    if not 0.0 < resistance_ohm < math.inf:
        state_row["dropouts"] += 1.0
        failed = 0.0 if state_row["dropouts"] < constants_row["allowed_samples"] else 1.0
        answer_with(answer, state_row["value"], constants_row["quantity_span"], NO_CURRENT, failed, 0.0)
        return
    state_row["dropouts"] = 0.0
    if not constants_row["own_low_ohm"] <= resistance_ohm <= constants_row["own_high_ohm"]:
        state_row["mismatches"] += 1.0
        failed = 0.0 if state_row["mismatches"] < constants_row["allowed_samples"] else 1.0
        answer_with(answer, state_row["value"], constants_row["quantity_span"], MISMATCH, failed, resistance_ohm)
        return
    state_row["mismatches"] = 0.0
    power_w = wire_voltage_v * wire_voltage_v / resistance_ohm
    variance, on_curve = follow(gates, branch, constants[N_CONSTANTS:], resistance_ohm, power_w, shunt_voltage_v)
    if constants_row["loaded"] != 0.0:
        add_friction(constants_row, state_row, branch["value"])
    reason = OUT_OF_RANGE
    if on_curve:
        reason = OK if branch["sensing"] != 0.0 else COLD
    state_row["value"] = branch["value"] + state_row["friction_n"]
    std = math.sqrt(variance + constants_row["scale_variance"] * branch["value"] * branch["value"])
    answer_with(answer, state_row["value"], min(std, constants_row["quantity_span"]), reason, 0.0, resistance_ohm)


@compiled
def follow(
    constants: Row, state: Row, both: FloatArray, resistance_ohm: float, power_w: float, shunt_voltage_v: float
) -> tuple[float, bool]:
    """Follow the branches by one sample; return variance, and whether the reading is on the curve."""
    read = (resistance_ohm - constants["resistance_min_ohm"]) * constants["per_ohm"]
    power_w = min(power_w, constants["max_power_w"])
    if state["followed"] == 0.0:
        state["followed"] = 1.0
        return begin(constants, state, both, read, power_w)
    per_volt = resistance_ohm * constants["per_ohm"] / shunt_voltage_v
    noise = state["noise_v2"] * per_volt * per_volt + constants["min_noise"]
    on_curve = is_on_curve(constants, read, noise)
    state["mean_power_w"] += (power_w - state["mean_power_w"]) * constants["mean_power_gain"]
    ratio = min(power_w / state["mean_power_w"] - 1.0, constants["max_ratio"])
    filtered(constants, state, read, noise, ratio)
    learn_noise(constants, state, read, per_volt)
    support = ratio if state["heating"] != 0.0 else -ratio
    if support < -constants["turning_fraction"]:
        support = -support
        state["heating"], state["lagging"] = 1.0 - state["heating"], state["resistance"]
    inside = min(max(state["resistance"], constants["normalised_min"]), constants["normalised_max"])
    hot, cold, slope = branches(both, inside)
    moved = state["resistance"] - state["lagging"]
    if not moved * moved > constants["motion_deviations"] * state["variance"] + constants["min_motion_variance"]:
        moved = 0.0
    locate(constants, state, moved)
    move(constants, state, hot, cold, moved, support)
    gap = constants["gap_fraction"] * (hot - cold)
    slope = slope / 2.0
    off = slope * (state["resistance"] - inside)
    return gap * gap + slope * slope * state["variance"] + off * off + constants["min_variance"], on_curve


@compiled
def begin(constants: Row, state: Row, both: FloatArray, read: float, power_w: float) -> tuple[float, bool]:
    """Follow the first sample."""
    inside = min(max(read, constants["normalised_min"]), constants["normalised_max"])
    hot, cold, slope = branches(both, inside)
    state["value"] = (hot + cold) / 2.0
    state["resistance"] = state["lagging"] = state["before"] = state["before_last"] = read
    state["variance"], state["noise_v2"], state["learnt_s"] = constants["first_variance"], 0.0, -1.0
    state["mean_power_w"], state["heating"] = power_w, 1.0
    state["sensing"] = 0.0 if read >= constants["ambiguous_above"] else 1.0
    half, away = (hot - cold) / 2.0, slope / 2.0 * (read - inside)
    margin = constants["normalised_margin"]
    on_curve = constants["normalised_min"] - margin <= read <= constants["normalised_max"] + margin
    return half * half + away * away + constants["min_variance"], on_curve


@compiled
def locate(constants: Row, state: Row, moved: float) -> None:
    """Follow whether the wire is between B and C."""
    if state["resistance"] > constants["normalised_max"]:
        state["sensing"] = 0.0
        return
    below = constants["ambiguous_above"] - state["resistance"]
    if (state["heating"] != 0.0 and moved < 0.0) or (below > 0.0 and below * below > 9.0 * state["variance"]):
        state["sensing"] = 1.0


@compiled
def is_on_curve(constants: Row, read: float, noise: float) -> bool:
    """Return whether a reading can be one of the valid range, within three deviations of its noise."""
    margin = constants["normalised_margin"]
    outside = max(constants["normalised_min"] - margin - read, read - constants["normalised_max"] - margin, 0.0)
    return bool(outside * outside <= 9.0 * noise)


@compiled
def filtered(constants: Row, state: Row, read: float, noise: float, ratio: float) -> None:
    """Filter the resistance."""
    away = read - state["resistance"]
    variance = state["variance"]
    surprise = max(away * away - noise - variance, 0.0)
    variance += constants["dt_s"] * (
        constants["still_per_s"] + constants["driven_per_s"] * ratio * ratio + constants["surprise_per_s"] * surprise
    )
    weight = variance / (variance + noise)
    state["resistance"] += weight * away
    variance -= weight * variance
    state["variance"] = variance
    state["lagging"] += (state["resistance"] - state["lagging"]) * constants["lagging_gain"]


@compiled
def learn_noise(constants: Row, state: Row, read: float, per_volt: float) -> None:
    """Learn the noise from the second difference of the readings."""
    bend = (read - state["before"]) - (state["before"] - state["before_last"])
    state["before_last"] = state["before"]
    state["before"] = read
    if state["learnt_s"] < 0.0 or constants["dt_s"] <= 0.0:
        state["learnt_s"] = 0.0
        return
    state["learnt_s"] = min(state["learnt_s"] + constants["dt_s"], constants["noise_s"])
    bend_v = bend / per_volt
    state["noise_v2"] += (min(bend_v * bend_v / 6.0, constants["max_noise_v2"]) - state["noise_v2"]) * (
        constants["dt_s"] / state["learnt_s"]
    )


@compiled
def move(constants: Row, state: Row, hot: float, cold: float, moved: float, support: float) -> None:
    """Move the quantity towards its branch and keep it within both."""
    value = state["value"]
    if state["heating"] != 0.0:
        branch, ahead, towards = hot, hot - value, -moved
    else:
        branch, ahead, towards = cold, value - cold, moved
    if ahead < 0.0:
        value += (branch - value) * constants["return_gain"]
    elif towards > 0.0:
        value = branch
    elif support > constants["supporting_fraction"]:
        value += (branch - value) * constants["approach_gain"]
    else:
        value += ((hot + cold) / 2.0 - value) * constants["middle_gain"]
    state["value"] = min(max(value, min(hot, cold) - constants["beyond"]), max(hot, cold) + constants["beyond"])


@compiled
def branches(both: FloatArray, inside: float) -> tuple[float, float, float]:
    """Return both branches and the slope of their sum at a normalised resistance, by Horner's rule."""
    hot = cold = slope = 0.0 * inside
    for place in range(0, both.shape[0], 2):
        slope = slope * inside + hot + cold
        hot = hot * inside + both[place]
        cold = cold * inside + both[place + 1]
    return hot, cold, slope
