"""The inference against scikit-fuzzy and against numerical inversions, then its properties."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import skfuzzy
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from musclewire.controllers import (
    SET_NAMES,
    MamdaniRules,
    MembershipSet,
    RuleBase,
    ZhaoRules,
    infer_ratios,
    infer_surface,
    load_rule_base,
    rule_base_names,
    rule_weights,
)
from musclewire.errors import CallerError, NumericsError

UNIVERSE = np.linspace(-3.0, 3.0, 101)
GAINS = ("kp", "ki", "kd")
POINTS = [
    (0.0, 0.0),
    (0.3, -0.2),
    (-0.3, 0.2),
    (1.0, 1.0),
    (-1.0, 1.0),
    (0.999, -0.001),
    (0.05, 0.6),
    (-0.77, -0.41),
    (1 / 3, -2 / 3),
    (0.5, 0.5),
]

ratios = st.floats(-1.0, 1.0)
wide = st.floats(-1e6, 1e6)
names = st.sampled_from(rule_base_names())


def published_set(fuzzy_set: MembershipSet, x: Any) -> Any:
    """Evaluate a set with scikit-fuzzy's own functions."""
    x = np.atleast_1d(np.asarray(x, dtype=float))
    if fuzzy_set.shape == "triangle":
        return skfuzzy.trimf(x, fuzzy_set.points)
    return {"z": skfuzzy.zmf, "s": skfuzzy.smf}[fuzzy_set.shape](x, *fuzzy_set.points)


def mamdani(rule_base: RuleBase) -> MamdaniRules:
    assert isinstance(rule_base.rules, MamdaniRules)
    return rule_base.rules


def scikit_fuzzy_ratios(rule_base: RuleBase, error: float, change: float) -> list[float]:
    """Infer all 49 rules with scikit-fuzzy's membership functions and its centroid; no shortcut."""
    rules = mamdani(rule_base)
    error_grades = [published_set(rule_base.input_sets[name], 3.0 * error)[0] for name in SET_NAMES]
    change_grades = [published_set(rule_base.input_sets[name], 3.0 * change)[0] for name in SET_NAMES]
    found = []
    for gain in GAINS:
        joined = np.zeros_like(UNIVERSE)
        for row in range(7):
            for column in range(7):
                output = published_set(rules.output_sets[getattr(rules, gain)[row][column]], UNIVERSE)
                cut = np.fmin(np.fmin(error_grades[row], change_grades[column]), output)
                joined = np.fmax(joined, cut)
        found.append((1.0 + skfuzzy.defuzz(UNIVERSE, joined, "centroid") / 3.0) / 2.0)
    return found


@pytest.mark.parametrize(("error", "change"), POINTS)
def test_liu_agrees_with_scikit_fuzzy(error: float, change: float) -> None:
    rule_base = load_rule_base("liu-7x7")
    expected = scikit_fuzzy_ratios(rule_base, error, change)
    assert infer_ratios(rule_base, error, change) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(("error", "change"), POINTS)
def test_mirrored_liu_agrees_with_scikit_fuzzy_at_the_mirrored_point(error: float, change: float) -> None:
    expected = scikit_fuzzy_ratios(load_rule_base("liu-7x7"), -abs(error), -math.copysign(1.0, error) * change)
    assert infer_ratios(load_rule_base("liu-7x7-mirrored"), error, change) == pytest.approx(expected, abs=1e-12)


def zhao_by_numerical_inversion(error: float, change: float) -> list[float]:
    """Zhao's inference with scikit-fuzzy's antecedents and the log sets inverted by a root finder."""
    rules = load_rule_base("zhao-1993").rules
    assert isinstance(rules, ZhaoRules)
    universe = np.array([-1.0 + index / 3.0 for index in range(7)])
    error_grades, change_grades = (
        [skfuzzy.interp_membership(universe, peak, x) for peak in np.eye(7)] for x in (error, change)
    )

    def inverted(size: str, mu: float) -> float:
        tiny = 1e-15
        grade = (lambda x: -math.log(x) / 4.0) if size == "S" else (lambda x: -math.log(1.0 - x) / 4.0)
        return float(brentq(lambda x: grade(x) - mu, tiny, 1.0 - tiny, xtol=1e-15))

    kp = ki = kd = total = 0.0
    for row in range(7):
        for column in range(7):
            mu = float(error_grades[row] * change_grades[column])
            total += mu
            if mu > 1e-12:
                kp += mu * inverted(rules.kp[row][column], mu)
                kd += mu * inverted(rules.kd[row][column], mu)
                ki += mu * (1.0 / rules.alpha[row][column] - 0.2) / 0.3
    assert total == pytest.approx(1.0)
    return [kp, ki, kd]


@pytest.mark.parametrize(("error", "change"), POINTS)
def test_zhao_agrees_with_a_numerical_inversion_of_its_log_sets(error: float, change: float) -> None:
    expected = zhao_by_numerical_inversion(error, change)
    assert infer_ratios(load_rule_base("zhao-1993"), error, change) == pytest.approx(expected, abs=1e-9)


@given(ratios, ratios)
def test_zhao_tunes_both_directions_alike(error: float, change: float) -> None:
    rule_base = load_rule_base("zhao-1993")
    assert infer_ratios(rule_base, error, change) == pytest.approx(infer_ratios(rule_base, -error, -change), abs=1e-13)


@given(ratios, ratios)
def test_mirrored_liu_tunes_both_directions_alike_to_the_bit(error: float, change: float) -> None:
    rule_base = load_rule_base("liu-7x7-mirrored")
    assert infer_ratios(rule_base, error, change) == infer_ratios(rule_base, -error, -change)


def test_the_other_mirrored_half_reads_the_rows_of_positive_error() -> None:
    liu = load_rule_base("liu-7x7")
    other = liu.model_copy(update={"mirrored": "positive-error"})
    assert infer_ratios(other, 0.4, 0.7) == infer_ratios(liu, 0.4, 0.7)
    assert infer_ratios(other, -0.4, -0.7) == infer_ratios(liu, 0.4, 0.7)


@given(names, wide, wide)
def test_every_ratio_is_in_the_unit_interval_for_any_input(name: str, error: float, change: float) -> None:
    assert all(0.0 <= ratio <= 1.0 for ratio in infer_ratios(load_rule_base(name), error, change))


@given(names, wide, wide)
def test_inputs_beyond_the_range_count_as_its_end(name: str, error: float, change: float) -> None:
    rule_base = load_rule_base(name)
    clipped = infer_ratios(rule_base, max(-1.0, min(1.0, error)), max(-1.0, min(1.0, change)))
    assert infer_ratios(rule_base, error, change) == clipped


@given(ratios)
def test_the_sets_of_liu_equal_scikit_fuzzys_and_leave_no_gap(ratio: float) -> None:
    rule_base = load_rule_base("liu-7x7")
    # Two equal inputs have equal grades, and so has the rule of both: the smaller of the two.
    grades = np.diagonal(rule_weights(rule_base, ratio, ratio))
    expected = [published_set(rule_base.input_sets[name], 3.0 * ratio)[0] for name in SET_NAMES]
    assert grades == pytest.approx(expected, abs=1e-14)
    assert max(grades) >= 0.5


@pytest.mark.parametrize("name", rule_base_names())
def test_the_surface_equals_the_scalar_inference_to_the_bit(name: str) -> None:
    rule_base = load_rule_base(name)
    errors, changes = np.linspace(-1.2, 1.2, 7)[:, np.newaxis], np.linspace(-1.0, 1.0, 5)
    surface = infer_surface(rule_base, errors, changes)
    assert surface.kp.shape == (7, 5)
    for row in range(7):
        for column in range(5):
            expected = infer_ratios(rule_base, errors[row, 0], changes[column])
            assert tuple(ratio[row, column] for ratio in surface) == expected


def test_nan_and_shapes_that_do_not_fit_are_refused() -> None:
    with pytest.raises(NumericsError, match="NaN"):
        infer_ratios(load_rule_base(), math.nan, 0.0)
    with pytest.raises(NumericsError, match="NaN"):
        infer_surface(load_rule_base(), [0.0, math.nan], 0.0)
    with pytest.raises(CallerError, match=r"shapes \(2,\) and \(3,\)"):
        infer_surface(load_rule_base(), [0.0, 0.1], [0.0, 0.1, 0.2])
