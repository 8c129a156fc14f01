"""Distributions of a parameter, against closed forms and printed tables."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from musclewire.errors import CallerError
from musclewire.extras.studies import ParameterTable
from musclewire.extras.studies._varied_parameters import GridAxis, SampledParameter, parameter_of, quantile_function

# Of the standard normal distribution, as every table prints it.
NORMAL_975 = 1.959964


def quantile(probability: float, **given: Any) -> float:
    return float(quantile_function("parameters.x", "linear", given)(np.array([probability]))[0])


def test_a_normal_distribution_has_the_tables_quantile() -> None:
    assert quantile(0.975, distribution="normal", mean=10.0, std=2.0) == pytest.approx(10 + 2 * NORMAL_975, abs=1e-5)


def test_a_truncated_normal_distribution_stays_between_its_ends_and_keeps_its_middle() -> None:
    given = {"distribution": "normal", "mean": 10.0, "std": 2.0, "low": 9.0, "high": 11.0}
    assert quantile(0.5, **given) == pytest.approx(10.0)
    assert 9.0 < quantile(1e-9, **given) < quantile(1.0 - 1e-9, **given) < 11.0


def test_low_and_high_alone_are_uniform_and_with_a_log_spacing_log_uniform() -> None:
    assert quantile(0.25, low=1.0, high=5.0) == pytest.approx(2.0)
    found = quantile_function("parameters.x", "log", {"low": 1.0, "high": 100.0})(np.array([0.5]))
    assert found[0] == pytest.approx(10.0)


def test_two_thirds_of_a_log_normal_distribution_lie_within_its_factor() -> None:
    one_sigma = 0.5 * (1.0 + math.erf(1.0 / math.sqrt(2.0)))
    assert quantile(one_sigma, distribution="log-normal", median=3.0, factor=1.5) == pytest.approx(4.5)
    assert quantile(0.5, distribution="log-normal", median=3.0, factor=1.5) == pytest.approx(3.0)


def test_a_triangular_distribution_has_its_mode_where_its_area_says() -> None:
    # The area left of the mode is its distance from the lower end over the width.
    assert quantile(0.25, distribution="triangular", low=0.0, mode=1.0, high=4.0) == pytest.approx(1.0)


def test_any_continuous_distribution_of_scipy_is_known_by_its_name() -> None:
    # Weibull: 1 - exp(-(x / scale)^c).
    found = quantile(1.0 - math.exp(-1.0), distribution="weibull_min", shape={"c": 2.5}, scale=3.0, loc=1.0)
    assert found == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"distribution": "normel", "mean": 1.0}, "did you mean 'normal'"),
        ({"low": 2.0, "high": 1.0}, "'low' must be below 'high'"),
        ({"distribution": "log-normal", "median": -1.0, "factor": 2.0}, "numbers above 0"),
    ],
)
def test_numbers_that_make_no_distribution_are_refused(given: dict[str, Any], words: str) -> None:
    with pytest.raises(CallerError, match=words.replace("(", r"\(").replace(".", r"\.")):
        quantile_function("parameters.x", "linear", given)


def test_units_are_taken_off_and_a_difference_of_temperatures_needs_one() -> None:
    table = ParameterTable(distribution="normal", mean="22 degC", std="2 K")
    found = parameter_of("ambient_temperature", "K", table)
    assert isinstance(found, SampledParameter)
    assert found.quantile(np.array([0.5]))[0] == pytest.approx(295.15)
    with pytest.raises(CallerError, match="difference of temperatures"):
        parameter_of("ambient_temperature", "K", ParameterTable(distribution="normal", mean="22 degC", std="2 degC"))


def test_points_are_an_axis_with_both_ends() -> None:
    linear = parameter_of("pretension", "N", ParameterTable(low="1 N", high="2 N", points=3))
    assert isinstance(linear, GridAxis)
    assert linear.values == pytest.approx((1.0, 1.5, 2.0))
    log = parameter_of("pretension", "N", ParameterTable(low=1.0, high=100.0, points=3, spacing="log"))
    assert isinstance(log, GridAxis)
    assert log.values == pytest.approx((1.0, 10.0, 100.0))


@pytest.mark.parametrize(
    ("unit", "table", "words"),
    [
        ("N", {"values": [1.0], "low": 1.0}, "'low' does not belong to 'values'"),
        ("N", {"values": ["1 mm"]}, "force is needed|needed, like"),
    ],
)
def test_keys_that_do_not_belong_together_are_refused(unit: str, table: dict[str, Any], words: str) -> None:
    with pytest.raises(CallerError, match=words):
        parameter_of("x", unit, ParameterTable(**table))


def test_a_prior_is_a_distribution_between_its_bounds() -> None:
    found = parameter_of("martensite_temperature_k", "K", ParameterTable(prior="niti-wire"))
    assert isinstance(found, SampledParameter)
    ends = found.quantile(np.array([1e-12, 1.0 - 1e-12]))
    from musclewire.parameters import load_priors

    prior = load_priors("niti-wire").parameters["martensite_temperature_k"]
    assert prior.low <= ends[0] < ends[1] <= prior.high
