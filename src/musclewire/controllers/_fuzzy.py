"""Fuzzy inference: from the error and its change to the three gain ratios of the paper's Eq. 6.

Inputs are ratios in [-1, 1] (clipped), outputs ratios in [0, 1]. The compiled arithmetic is loaded on first use,
because Numba takes a moment to import.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from musclewire.arrays import FloatArray
from musclewire.controllers._rules import (
    SET_NAMES,
    ConstantRules,
    MamdaniRules,
    MembershipSet,
    RuleBase,
    ZhaoRules,
)
from musclewire.errors import CallerError, NumericsError

# The range of Zhao's alpha; a smaller alpha integrates more.
ALPHA_WEAKEST = 5.0
ALPHA_STRONGEST = 2.0


class FuzzyRatios(NamedTuple):
    """K_p', K_I' and K_D' of Eq. 6: the place of each gain in its range."""

    kp: float  # of the proportional gain, 0 (minimum) to 1 (maximum)
    ki: float  # of the integral gain, 0 to 1
    kd: float  # of the derivative gain, 0 to 1


class RatioSurface(NamedTuple):
    """K_p', K_I' and K_D' over arrays of inputs, each 0 to 1 and of the inputs' common shape."""

    kp: FloatArray
    ki: FloatArray
    kd: FloatArray


def infer_ratios(rule_base: RuleBase, error_ratio: float, change_ratio: float) -> FuzzyRatios:
    """Return the three gain ratios for one error and one change of error.

    Parameters
    ----------
    rule_base
        The rules.
    error_ratio
        Error over its range, clipped to [-1, 1].
    change_ratio
        Rate of the error over its range, clipped to [-1, 1].

    Returns
    -------
    The ratios, each 0 to 1.

    Raises
    ------
    NumericsError
        If an input is NaN.
    """
    from musclewire.controllers import _kernels as kernels

    if math.isnan(error_ratio) or math.isnan(change_ratio):
        raise NumericsError(
            f"fuzzy inputs are {error_ratio} and {change_ratio}; NaN is in no rule table, find what produced it"
        )
    return FuzzyRatios(*kernels.infer(packed_rules(rule_base), float(error_ratio), float(change_ratio)))


def infer_surface(rule_base: RuleBase, error_ratio: ArrayLike, change_ratio: ArrayLike) -> RatioSurface:
    """Return the three gain ratios over arrays of inputs, clipped to [-1, 1] and broadcast against each other."""
    from musclewire.controllers import _kernels as kernels

    try:
        errors, changes = np.broadcast_arrays(
            np.asarray(error_ratio, dtype=np.float64), np.asarray(change_ratio, dtype=np.float64)
        )
    except ValueError:
        shapes = f"{np.shape(error_ratio)} and {np.shape(change_ratio)}"
        raise CallerError(
            f"error_ratio and change_ratio have shapes {shapes}, which do not broadcast: give both one shape"
        ) from None
    if np.isnan(errors).any() or np.isnan(changes).any():
        raise NumericsError("fuzzy inputs hold NaN, which is in no rule table: find the measurement that produced it")
    ratios = np.empty((3, errors.size))
    kernels.infer_many(
        packed_rules(rule_base),
        np.ascontiguousarray(errors.ravel()),
        np.ascontiguousarray(changes.ravel()),
        ratios,
    )
    return RatioSurface(*(ratio.reshape(errors.shape) for ratio in ratios))


def rule_weights(rule_base: RuleBase, error_ratio: float, change_ratio: float) -> FloatArray:
    """Return how strongly each rule fires for two inputs, (7, 7): the error's sets down, those of its change across."""
    from musclewire.controllers import _kernels as kernels

    weights = np.zeros((len(SET_NAMES), len(SET_NAMES)))
    if not isinstance(rule_base.rules, ConstantRules):
        kernels.weigh_rules(packed_rules(rule_base), float(error_ratio), float(change_ratio), weights)
    return weights


def packed_rules(rule_base: RuleBase) -> NDArray[np.void]:
    """Return a rule base as the structured array of length 1 that the compiled kernels read (``kernels.FUZZY_PID``)."""
    from musclewire.controllers import _kernels as kernels

    packed = np.zeros(1, kernels.FUZZY_PID)
    row, rules = packed[0], rule_base.rules
    row["inference"] = {
        "constant": kernels.CONSTANT,
        "product-weighted-sum": kernels.PRODUCT_WEIGHTED_SUM,
        "min-max-centroid": kernels.MIN_MAX_CENTROID,
    }[rules.inference]
    row["mirrored"] = {"no": 0.0, "positive-error": 1.0, "negative-error": -1.0}[rule_base.mirrored]
    row["kp_table"], row["ki_table"], row["kd_table"] = _tables(rules)
    if not isinstance(rules, ConstantRules):
        sets = [_set_values(rule_base.input_sets[name]) for name in SET_NAMES]
        row["set_shapes"] = [shape for shape, *_ in sets]
        row["set_points"] = [points for _, *points in sets]
    if isinstance(rules, MamdaniRules):
        row["output_sets"] = _sampled_output_sets(rules)
    return packed


def _tables(rules: ZhaoRules | MamdaniRules | ConstantRules) -> list[FloatArray]:
    if isinstance(rules, ConstantRules):
        return [np.full((7, 7), ratio) for ratio in (rules.kp, rules.ki, rules.kd)]
    if isinstance(rules, MamdaniRules):
        tables = (rules.kp, rules.ki, rules.kd)
        return [np.array([[float(SET_NAMES.index(cell)) for cell in row] for row in table]) for table in tables]
    alpha = np.array(rules.alpha)
    integral = (1.0 / alpha - 1.0 / ALPHA_WEAKEST) / (1.0 / ALPHA_STRONGEST - 1.0 / ALPHA_WEAKEST)
    kp, kd = (np.array([[float(cell == "B") for cell in row] for row in table]) for table in (rules.kp, rules.kd))
    return [kp, np.clip(integral, 0.0, 1.0), kd]


def _set_values(fuzzy_set: MembershipSet) -> tuple[int, float, float, float]:
    from musclewire.controllers import _kernels as kernels

    shape = {"triangle": kernels.TRIANGLE, "z": kernels.FALLING, "s": kernels.RISING}[fuzzy_set.shape]
    first, second, third = (*fuzzy_set.points, 0.0)[:3]
    return shape, first, second, third


def _sampled_output_sets(rules: MamdaniRules) -> FloatArray:
    from musclewire.controllers import _kernels as kernels

    universe = np.linspace(-kernels.UNIVERSE_END, kernels.UNIVERSE_END, kernels.UNIVERSE_POINTS)
    sets = [_set_values(rules.output_sets[name]) for name in SET_NAMES]
    return np.array([[kernels.membership(*values, float(x)) for x in universe] for values in sets], dtype=np.float64)
