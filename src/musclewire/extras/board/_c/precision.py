"""Check that a library's numbers and its polynomial are accurate enough in single precision."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, argument
from musclewire.extras.board._c.constants import CConstants, numbers_of
from musclewire.extras.board._c.numbers import check_single
from musclewire.sensing import SensingModel

# An estimate in single precision may differ from one in double by this fraction of the full scale.
MAX_ERROR = 2e-4
CHECKED_RESISTANCES = 4001
MIN_TICK_S = 1e-4
# Numbers that must stay apart, the lower first.
ORDERED = (
    ("SENSE_VOLTAGE_V", "MAXIMUM_VOLTAGE_V"),
    ("RESISTANCE_MIN_OHM", "RESISTANCE_MAX_OHM"),
    ("NORMALISED_MIN", "NORMALISED_MAX"),
    ("RESISTANCE_LOW_OHM", "RESISTANCE_HIGH_OHM"),
    ("QUANTITY_MIN", "QUANTITY_MAX"),
)


def check_precision(model: SensingModel, constants: CConstants) -> None:
    """Raise CallerError, naming the number, if single precision overflows, underflows or loses digits."""
    for name, value in numbers_of(constants.all()):
        if math.isfinite(value):
            check_single(name, value)
    for lower, upper in ORDERED:
        if not np.float32(constants.value(lower)) < np.float32(constants.value(upper)):
            raise CallerError(
                f"{lower.lower()} {constants.value(lower)!r} and {upper.lower()} {constants.value(upper)!r} are one "
                "number in single precision: export with " + argument("double", True)
            )
    _check_products(constants)
    _check_estimate(model, constants)


def _check_products(constants: CConstants) -> None:
    """Check the intermediate products and quotients of a tick: each must stay a normal number at full scale."""
    value = constants.value
    range_ = value("QUANTITY_MAX") - value("QUANTITY_MIN")
    rate = range_ / MIN_TICK_S
    of_controller = _fuzzy_products if any(one.name == "INPUT_SCALE" for one in constants.all()) else _inverse_products
    for name, result in {
        **of_controller(constants, range_, rate),
        "heat_loss / heat_capacity": value("HEAT_LOSS_W_PER_K") / value("HEAT_CAPACITY_J_PER_K"),
    }.items():
        check_single(name, result)


def _fuzzy_products(constants: CConstants, range_: float, rate: float) -> dict[str, float]:
    """Return products and quotients of the fuzzy PID at full scale, each with its name."""
    value = constants.value
    unit, scale = value("ERROR_UNIT"), value("INPUT_SCALE")
    return {
        "the quantity's range / error_unit / error_range": range_ / unit / value("ERROR_RANGE"),
        "the quantity's fastest rate / error_unit / change_range": rate / unit / value("CHANGE_RANGE"),
        "input_scale * kp * the quantity's range": scale * value("KP_MAXIMUM") * range_,
        "input_scale * kp * the quantity's range / error_unit": scale * value("KP_MAXIMUM") * range_ / unit,
        "ki * shortest tick * the quantity's range": value("KI_MAXIMUM") * MIN_TICK_S * range_,
        "kd * the quantity's fastest rate": value("KD_MAXIMUM") * rate,
    }


def _inverse_products(constants: CConstants, range_: float, rate: float) -> dict[str, float]:
    """Return products and quotients of the inverse of the wire's model at full scale, each with its name."""
    value = constants.value
    ceiling_w, tau_s = value("MAXIMUM_STEADY_POWER_W"), value("THERMAL_TIME_CONSTANT_S")
    return {
        "the square of the quantity's range": range_ * range_,
        "heat_per_unit * the quantity's fastest rate": value("HEAT_PER_UNIT") * rate,
        "maximum_steady_power * thermal_time_constant / shortest tick": ceiling_w * tau_s / MIN_TICK_S,
        "the square of maximum_steady_power": ceiling_w * ceiling_w,
    }


def _check_estimate(model: SensingModel, constants: CConstants) -> None:
    error = single_error_share(model, constants)
    if error <= MAX_ERROR:
        return
    low, high = constants.value("NORMALISED_MIN"), constants.value("NORMALISED_MAX")
    reach = max(abs(low), abs(high))
    branch, power, term = max(
        (
            (name, power, abs(coefficient) * reach**power)
            for name in ("heating", "cooling")
            for power, coefficient in enumerate(getattr(model, f"{name}_coefficients"))
        ),
        key=lambda found: found[2],
    )
    # If no term is larger than the result, the digits were lost earlier: in Eq. 3, whose two resistances are too alike.
    if term <= 10.0 * max(abs(model.quantity_min), abs(model.quantity_max)):
        culprit = (
            f"resistance_min_ohm {model.resistance_min_ohm!r} and resistance_max_ohm {model.resistance_max_ohm!r} "
            "are too alike"
        )
    else:
        value = getattr(model, f"{branch}_coefficients")[power]
        culprit = f"{branch}_coefficients[{power}], {value!r}, is cancelled by its neighbours"
    raise CallerError(
        f"in single precision the estimate is off by {error:.2g} of full scale, more than {MAX_ERROR:g}: "
        f"{culprit}; fit a lower order, or export with " + argument("double", True)
    )


def single_error_share(model: SensingModel, constants: CConstants) -> float:
    """Return the largest difference between the estimate in single and in double precision, over the full scale."""
    low, high = model.valid_resistance_ohm
    resistances = np.linspace(low, high, CHECKED_RESISTANCES)
    exact = model.estimate(resistances).value
    with np.errstate(all="ignore"):
        single = single_estimates(constants, resistances)
    error = np.abs(single.astype(np.float64) - exact).max()
    return float(error / (model.quantity_max - model.quantity_min)) if np.isfinite(error) else math.inf


def single_estimates(constants: CConstants, resistance_ohm: FloatArray) -> npt.NDArray[np.float32]:
    """Return the estimates as the library computes them in single precision, operation by operation."""

    def number(name: str) -> np.float32:
        return np.float32(constants.value(name))

    def branch(name: str, inside: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        total = np.zeros_like(inside)
        for coefficient in next(found.values for found in constants.all() if found.name == name):
            total = total * inside + np.float32(coefficient)
        return total

    normalised = (resistance_ohm.astype(np.float32) - number("RESISTANCE_MIN_OHM")) * number("SHARE_PER_OHM")
    inside = np.clip(normalised, number("NORMALISED_MIN"), number("NORMALISED_MAX"))
    return (branch("HEATING_FALLING", inside) + branch("COOLING_FALLING", inside)) / np.float32(2.0)
