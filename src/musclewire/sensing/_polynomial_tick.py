"""The tick of the polynomial estimator, compiled: the arithmetic of ``PolynomialEstimator.step`` to the bit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.physics import friction_force_n
from musclewire.signals import Reason

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
    """Estimate one sample; see ``signals._compiled_tick`` for the arrays."""
    constants_row, state_row = constants[:N_CONSTANTS].view(CONSTANTS)[0], state.view(STATE)[0]
    wire_voltage_v, shunt_voltage_v = given[2], given[3]
    resistance_ohm = 0.0
    if abs(shunt_voltage_v) >= constants_row["minimum_current_a"] * constants_row["shunt_resistance_ohm"]:
        resistance_ohm = wire_voltage_v / shunt_voltage_v * constants_row["shunt_resistance_ohm"]
    if not 0.0 < resistance_ohm < math.inf:
        state_row["dropouts"] += 1.0
        failed = 0.0 if state_row["dropouts"] < constants_row["allowed_samples"] else 1.0
        answer_with(answer, state_row["value"], constants_row["quantity_span"], NO_CURRENT, failed, 0.0)
        return
    value, std, in_range = estimate(constants_row, constants[N_CONSTANTS:], resistance_ohm)
    own = constants_row["own_low_ohm"] <= resistance_ohm <= constants_row["own_high_ohm"]
    if constants_row["loaded"] != 0.0:
        add_friction(constants_row, state_row, value)
    if in_range:
        track(constants_row, state_row, resistance_ohm, wire_voltage_v * wire_voltage_v / resistance_ohm)
        reason = OK if state_row["sensing"] != 0.0 else COLD
    else:
        reason = OUT_OF_RANGE if own else MISMATCH
    state_row["value"] = value + state_row["friction_n"]
    state_row["dropouts"] = 0.0
    state_row["mismatches"] = 0.0 if own else state_row["mismatches"] + 1.0
    failed = 1.0 if state_row["mismatches"] >= constants_row["allowed_samples"] else 0.0
    answer_with(answer, state_row["value"], std, reason, failed, resistance_ohm)


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
def estimate(constants: Row, coefficients: FloatArray, resistance_ohm: float) -> tuple[float, float, bool]:
    """Return value, standard deviation and validity of one resistance, as ``ResistanceCurve.estimate`` does."""
    fraction = (resistance_ohm - constants["resistance_min_ohm"]) * constants["per_ohm"]
    if not math.isfinite(fraction):
        return constants["quantity_max"], constants["quantity_span"], False
    low, high, margin = constants["normalised_min"], constants["normalised_max"], constants["normalised_margin"]
    valid = low - margin <= fraction <= high + margin
    inside = low if fraction < low else high if fraction > high else fraction
    heating = cooling = slope = 0.0 * inside
    for place in range(0, coefficients.shape[0], 2):
        slope = slope * inside + heating + cooling
        heating = heating * inside + coefficients[place]
        cooling = cooling * inside + coefficients[place + 1]
    half = (heating - cooling) / 2.0
    spread = slope / 2.0 * (abs(fraction - inside) + constants["noise_ohm"] * constants["per_ohm"])
    value = (heating + cooling) / 2.0
    variance = (
        half * half + constants["residual_variance"] + spread * spread + constants["scale_variance"] * value * value
    )
    return value, min(math.sqrt(variance), constants["quantity_span"]), valid


@compiled
def add_friction(constants: Row, state: Row, spring_force_n: float) -> None:
    """Follow the friction in addition to a known spring's force."""
    if state["spring_known"] != 0.0:
        moved_m = (spring_force_n - state["spring_force_n"]) / constants["stiffness_n_per_m"]
        state["friction_n"] = friction_force_n(
            state["friction_n"], moved_m, constants["load_friction_n"], constants["turning_m"]
        )
    state["spring_known"] = 1.0
    state["spring_force_n"] = spring_force_n


@compiled
def track(constants: Row, state: Row, resistance_ohm: float, power_w: float) -> None:
    """Follow the segment of the wire until it is between B and C, as ``SegmentTracker`` does."""
    if state["tracked"] == 0.0:
        state["tracked"] = 1.0
        state["sensing"] = 0.0 if resistance_ohm >= constants["ambiguous_above_ohm"] else 1.0
        state["heating"] = 1.0
        state["power_extreme_w"] = power_w
        state["resistance_anchor_ohm"] = state["smoothed_ohm"] = resistance_ohm
        return
    if state["sensing"] != 0.0:
        return
    heating, extreme, anchor = state["heating"] != 0.0, state["power_extreme_w"], state["resistance_anchor_ohm"]
    smoothed = state["smoothed_ohm"]
    smoothed += (resistance_ohm - smoothed) / constants["smoothing_samples"]
    if heating:
        extreme = max(extreme, power_w)
        turned = power_w < extreme * (1.0 - constants["min_power_change"])
    else:
        extreme = min(extreme, power_w)
        turned = power_w > extreme * (1.0 + constants["min_power_change"])
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
    if opposite_ohm > constants["min_change_ohm"]:
        sensing, anchor = True, smoothed
    state["sensing"] = 1.0 if sensing or smoothed < constants["ambiguous_above_ohm"] else 0.0
    state["heating"] = 1.0 if heating else 0.0
    state["power_extreme_w"] = extreme
    state["resistance_anchor_ohm"] = anchor
    state["smoothed_ohm"] = smoothed
