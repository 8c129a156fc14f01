"""The tick of the gated estimator, compiled: the arithmetic of ``GatedEstimator.step`` to the bit."""

from __future__ import annotations

import math

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.sensing import polynomial_tick
from musclewire.sensing.polynomial_tick import Row, add_friction, answer_with
from musclewire.signals.exchange import Reason

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
    """Estimate one sample; see ``signals.compiled_tick`` for the arrays."""
    of, now = constants[:N_SHARED].view(SHARED_CONSTANTS)[0], state[:N_STATE].view(SHARED_STATE)[0]
    gates, branch = constants[N_SHARED:N_CONSTANTS].view(CONSTANTS)[0], state[N_STATE:].view(STATE)[0]
    wire_voltage_v, shunt_voltage_v = given[2], given[3]
    resistance_ohm = 0.0
    if abs(shunt_voltage_v) >= of["minimum_current_a"] * of["shunt_resistance_ohm"]:
        resistance_ohm = wire_voltage_v / shunt_voltage_v * of["shunt_resistance_ohm"]
    if not 0.0 < resistance_ohm < math.inf:
        now["dropouts"] += 1.0
        failed = 0.0 if now["dropouts"] < of["allowed_samples"] else 1.0
        answer_with(answer, now["value"], of["quantity_span"], NO_CURRENT, failed, 0.0)
        return
    now["dropouts"] = 0.0
    if not of["own_low_ohm"] <= resistance_ohm <= of["own_high_ohm"]:
        now["mismatches"] += 1.0
        failed = 0.0 if now["mismatches"] < of["allowed_samples"] else 1.0
        answer_with(answer, now["value"], of["quantity_span"], MISMATCH, failed, resistance_ohm)
        return
    now["mismatches"] = 0.0
    power_w = wire_voltage_v * wire_voltage_v / resistance_ohm
    variance, on_curve = follow(gates, branch, constants[N_CONSTANTS:], resistance_ohm, power_w, shunt_voltage_v)
    if of["loaded"] != 0.0:
        add_friction(of, now, branch["value"])
    reason = OUT_OF_RANGE
    if on_curve:
        reason = OK if branch["sensing"] != 0.0 else COLD
    now["value"] = branch["value"] + now["friction_n"]
    std = math.sqrt(variance + of["scale_variance"] * branch["value"] * branch["value"])
    answer_with(answer, now["value"], min(std, of["quantity_span"]), reason, 0.0, resistance_ohm)


@compiled
def follow(
    of: Row, now: Row, both: FloatArray, resistance_ohm: float, power_w: float, shunt_voltage_v: float
) -> tuple[float, bool]:
    """Follow the branches by one sample; return variance, and whether the reading is on the curve."""
    read = (resistance_ohm - of["resistance_min_ohm"]) * of["per_ohm"]
    power_w = min(power_w, of["max_power_w"])
    if now["followed"] == 0.0:
        now["followed"] = 1.0
        return begin(of, now, both, read, power_w)
    per_volt = resistance_ohm * of["per_ohm"] / shunt_voltage_v
    noise = now["noise_v2"] * per_volt * per_volt + of["min_noise"]
    on_curve = is_on_curve(of, read, noise)
    now["mean_power_w"] += (power_w - now["mean_power_w"]) * of["mean_power_gain"]
    ratio = min(power_w / now["mean_power_w"] - 1.0, of["max_ratio"])
    filtered(of, now, read, noise, ratio)
    learn_noise(of, now, read, per_volt)
    support = ratio if now["heating"] != 0.0 else -ratio
    if support < -of["turning_fraction"]:
        support = -support
        now["heating"], now["lagging"] = 1.0 - now["heating"], now["resistance"]
    inside = min(max(now["resistance"], of["normalised_min"]), of["normalised_max"])
    hot, cold, slope = branches(both, inside)
    moved = now["resistance"] - now["lagging"]
    if not moved * moved > of["motion_deviations"] * now["variance"] + of["min_motion_variance"]:
        moved = 0.0
    locate(of, now, moved)
    move(of, now, hot, cold, moved, support)
    gap = of["gap_fraction"] * (hot - cold)
    slope = slope / 2.0
    off = slope * (now["resistance"] - inside)
    return gap * gap + slope * slope * now["variance"] + off * off + of["min_variance"], on_curve


@compiled
def begin(of: Row, now: Row, both: FloatArray, read: float, power_w: float) -> tuple[float, bool]:
    """Follow the first sample."""
    inside = min(max(read, of["normalised_min"]), of["normalised_max"])
    hot, cold, slope = branches(both, inside)
    now["value"] = (hot + cold) / 2.0
    now["resistance"] = now["lagging"] = now["before"] = now["before_last"] = read
    now["variance"], now["noise_v2"], now["learnt_s"] = of["first_variance"], 0.0, -1.0
    now["mean_power_w"], now["heating"] = power_w, 1.0
    now["sensing"] = 0.0 if read >= of["ambiguous_above"] else 1.0
    half, away = (hot - cold) / 2.0, slope / 2.0 * (read - inside)
    margin = of["normalised_margin"]
    on_curve = of["normalised_min"] - margin <= read <= of["normalised_max"] + margin
    return half * half + away * away + of["min_variance"], on_curve


@compiled
def locate(of: Row, now: Row, moved: float) -> None:
    """Follow whether the wire is between B and C."""
    if now["resistance"] > of["normalised_max"]:
        now["sensing"] = 0.0
        return
    below = of["ambiguous_above"] - now["resistance"]
    if (now["heating"] != 0.0 and moved < 0.0) or (below > 0.0 and below * below > 9.0 * now["variance"]):
        now["sensing"] = 1.0


@compiled
def is_on_curve(of: Row, read: float, noise: float) -> bool:
    """Return whether a reading can be one of the valid range, within three deviations of its noise."""
    margin = of["normalised_margin"]
    outside = max(of["normalised_min"] - margin - read, read - of["normalised_max"] - margin, 0.0)
    return bool(outside * outside <= 9.0 * noise)


@compiled
def filtered(of: Row, now: Row, read: float, noise: float, ratio: float) -> None:
    """Filter the resistance."""
    away = read - now["resistance"]
    variance = now["variance"]
    surprise = max(away * away - noise - variance, 0.0)
    variance += of["dt_s"] * (of["still_per_s"] + of["driven_per_s"] * ratio * ratio + of["surprise_per_s"] * surprise)
    weight = variance / (variance + noise)
    now["resistance"] += weight * away
    variance -= weight * variance
    now["variance"] = variance
    now["lagging"] += (now["resistance"] - now["lagging"]) * of["lagging_gain"]


@compiled
def learn_noise(of: Row, now: Row, read: float, per_volt: float) -> None:
    """Learn the noise from the second difference of the readings."""
    bend = (read - now["before"]) - (now["before"] - now["before_last"])
    now["before_last"] = now["before"]
    now["before"] = read
    if now["learnt_s"] < 0.0 or of["dt_s"] <= 0.0:
        now["learnt_s"] = 0.0
        return
    now["learnt_s"] = min(now["learnt_s"] + of["dt_s"], of["noise_s"])
    bend_v = bend / per_volt
    now["noise_v2"] += (min(bend_v * bend_v / 6.0, of["max_noise_v2"]) - now["noise_v2"]) * (
        of["dt_s"] / now["learnt_s"]
    )


@compiled
def move(of: Row, now: Row, hot: float, cold: float, moved: float, support: float) -> None:
    """Move the quantity towards its branch and keep it within both."""
    value = now["value"]
    if now["heating"] != 0.0:
        branch, ahead, towards = hot, hot - value, -moved
    else:
        branch, ahead, towards = cold, value - cold, moved
    if ahead < 0.0:
        value += (branch - value) * of["return_gain"]
    elif towards > 0.0:
        value = branch
    elif support > of["supporting_fraction"]:
        value += (branch - value) * of["approach_gain"]
    else:
        value += ((hot + cold) / 2.0 - value) * of["middle_gain"]
    now["value"] = min(max(value, min(hot, cold) - of["beyond"]), max(hot, cold) + of["beyond"])


@compiled
def branches(both: FloatArray, inside: float) -> tuple[float, float, float]:
    """Return both branches and the slope of their sum at a normalised resistance, by Horner's rule."""
    hot = cold = slope = 0.0 * inside
    for place in range(0, both.shape[0], 2):
        slope = slope * inside + hot + cold
        hot = hot * inside + both[place]
        cold = cold * inside + both[place + 1]
    return hot, cold, slope
