"""The tick of the polynomial estimator, compiled: the arithmetic of ``PolynomialEstimator.step`` to the bit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.physics.material import friction_force_n
from musclewire.signals.exchange import Reason

__all__ = ["CONSTANTS", "STATE", "tick"]

# A row of a structured array; mypy knows no fields of it.
Row = Any

CONSTANTS = np.dtype(
    [
        (name, np.float64)
        for name in (
            # The circuit, and which resistances can be the wire's.
            "shunt_resistance_ohm", "minimum_current_a", "own_low_ohm", "own_high_ohm", "allowed_samples",
            # The curve; its coefficients, highest powers first and heating before cooling, follow in the same array.
            "resistance_min_ohm", "per_ohm", "normalised_min", "normalised_max", "normalised_margin", "noise_ohm",
            "residual_variance", "scale_variance", "quantity_max", "quantity_span",
            # The segment tracker.
            "ambiguous_above_ohm", "min_change_ohm", "smoothing_samples", "min_power_change",
            # The known spring; `loaded` is 0 without one.
            "loaded", "stiffness_n_per_m", "load_friction_n", "turning_m",
        )
    ]
)  # fmt: skip
STATE = np.dtype(
    [
        (name, np.float64)
        for name in (
            "value", "dropouts", "mismatches", "tracked", "sensing", "heating", "power_extreme_w",
            "resistance_anchor_ohm", "smoothed_ohm", "spring_known", "spring_force_n", "friction_n",
        )
    ]
)  # fmt: skip
N_CONSTANTS = len(CONSTANTS.names or ())
NO_CURRENT, OK, COLD = float(Reason.NO_CURRENT), float(Reason.OK), float(Reason.COLD)
OUT_OF_RANGE, MISMATCH = float(Reason.OUT_OF_RANGE), float(Reason.MISMATCH)


@compiled
def tick(constants: FloatArray, state: FloatArray, given: FloatArray, answer: FloatArray) -> None:
    """Estimate one sample; see ``signals.compiled_tick`` for the arrays."""
    of, now = constants[:N_CONSTANTS].view(CONSTANTS)[0], state.view(STATE)[0]
    wire_voltage_v, shunt_voltage_v = given[2], given[3]
    resistance_ohm = 0.0
    if abs(shunt_voltage_v) >= of["minimum_current_a"] * of["shunt_resistance_ohm"]:
        resistance_ohm = wire_voltage_v / shunt_voltage_v * of["shunt_resistance_ohm"]
    if not 0.0 < resistance_ohm < math.inf:
        now["dropouts"] += 1.0
        failed = 0.0 if now["dropouts"] < of["allowed_samples"] else 1.0
        answer_with(answer, now["value"], of["quantity_span"], NO_CURRENT, failed, 0.0)
        return
    value, std, in_range = estimate(of, constants[N_CONSTANTS:], resistance_ohm)
    own = of["own_low_ohm"] <= resistance_ohm <= of["own_high_ohm"]
    if of["loaded"] != 0.0:
        add_friction(of, now, value)
    if in_range:
        track(of, now, resistance_ohm, wire_voltage_v * wire_voltage_v / resistance_ohm)
        reason = OK if now["sensing"] != 0.0 else COLD
    else:
        reason = OUT_OF_RANGE if own else MISMATCH
    now["value"] = value + now["friction_n"]
    now["dropouts"] = 0.0
    now["mismatches"] = 0.0 if own else now["mismatches"] + 1.0
    failed = 1.0 if now["mismatches"] >= of["allowed_samples"] else 0.0
    answer_with(answer, now["value"], std, reason, failed, resistance_ohm)


@compiled
def answer_with(
    answer: FloatArray, value: float, std: float, reason: float, failed: float, resistance_ohm: float
) -> None:
    """Write the answer of a tick, and the resistance that is recorded with it."""
    answer[0] = value
    answer[1] = std
    answer[2] = 1.0 if reason == OK else 0.0
    answer[3] = reason
    answer[4] = failed
    answer[5] = resistance_ohm


@compiled
def estimate(of: Row, coefficients: FloatArray, resistance_ohm: float) -> tuple[float, float, bool]:
    """Return value, standard deviation and validity of one resistance, as ``ResistanceCurve.estimate`` does."""
    fraction = (resistance_ohm - of["resistance_min_ohm"]) * of["per_ohm"]
    if not math.isfinite(fraction):
        return of["quantity_max"], of["quantity_span"], False
    low, high, margin = of["normalised_min"], of["normalised_max"], of["normalised_margin"]
    valid = low - margin <= fraction <= high + margin
    inside = low if fraction < low else high if fraction > high else fraction
    heating = cooling = slope = 0.0 * inside
    for place in range(0, coefficients.shape[0], 2):
        slope = slope * inside + heating + cooling
        heating = heating * inside + coefficients[place]
        cooling = cooling * inside + coefficients[place + 1]
    half = (heating - cooling) / 2.0
    spread = slope / 2.0 * (abs(fraction - inside) + of["noise_ohm"] * of["per_ohm"])
    value = (heating + cooling) / 2.0
    variance = half * half + of["residual_variance"] + spread * spread + of["scale_variance"] * value * value
    return value, min(math.sqrt(variance), of["quantity_span"]), valid


@compiled
def add_friction(of: Row, now: Row, spring_force_n: float) -> None:
    """Follow the friction in addition to a known spring's force."""
    if now["spring_known"] != 0.0:
        moved_m = (spring_force_n - now["spring_force_n"]) / of["stiffness_n_per_m"]
        now["friction_n"] = friction_force_n(now["friction_n"], moved_m, of["load_friction_n"], of["turning_m"])
    now["spring_known"] = 1.0
    now["spring_force_n"] = spring_force_n


@compiled
def track(of: Row, now: Row, resistance_ohm: float, power_w: float) -> None:
    """Follow the segment of the wire until it is between B and C, as ``SegmentTracker`` does."""
    if now["tracked"] == 0.0:
        now["tracked"] = 1.0
        now["sensing"] = 0.0 if resistance_ohm >= of["ambiguous_above_ohm"] else 1.0
        now["heating"] = 1.0
        now["power_extreme_w"] = power_w
        now["resistance_anchor_ohm"] = now["smoothed_ohm"] = resistance_ohm
        return
    if now["sensing"] != 0.0:
        return
    heating, extreme, anchor = now["heating"] != 0.0, now["power_extreme_w"], now["resistance_anchor_ohm"]
    smoothed = now["smoothed_ohm"]
    smoothed += (resistance_ohm - smoothed) / of["smoothing_samples"]
    if heating:
        extreme = max(extreme, power_w)
        turned = power_w < extreme * (1.0 - of["min_power_change"])
    else:
        extreme = min(extreme, power_w)
        turned = power_w > extreme * (1.0 + of["min_power_change"])
    if turned:
        heating, extreme, anchor = not heating, power_w, smoothed
    # Here the wire is not sensed yet: a change in the direction of A-B moves the anchor, one in the opposite counts.
    if not heating:
        anchor = min(anchor, smoothed)
        opposite_ohm = smoothed - anchor
    else:
        anchor = max(anchor, smoothed)
        opposite_ohm = anchor - smoothed
    sensing = False
    if opposite_ohm > of["min_change_ohm"]:
        sensing, anchor = True, smoothed
    now["sensing"] = 1.0 if sensing or smoothed < of["ambiguous_above_ohm"] else 0.0
    now["heating"] = 1.0 if heating else 0.0
    now["power_extreme_w"] = extreme
    now["resistance_anchor_ohm"] = anchor
    now["smoothed_ohm"] = smoothed
