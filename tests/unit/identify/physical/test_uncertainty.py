"""Intervals against closed forms: the posterior of a linear problem with normal noise and a normal prior is known."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from made_wires import candidates

from musclewire.identify._physical.posterior import covariance, estimates, excess_variance


def test_the_covariance_is_that_of_bayes_rule_for_a_linear_problem() -> None:
    matrix = np.random.default_rng(1).normal(size=(40, 3))
    noise = np.linspace(0.5, 2.0, 40)
    # Another way to the same: condition the joint normal distribution of parameters and data.
    gain = matrix.T @ np.linalg.inv(matrix @ matrix.T + np.diag(noise**2))
    assert covariance(matrix / noise[:, None]) == pytest.approx(np.eye(3) - gain @ matrix)


def test_intervals_hold_as_often_as_they_say() -> None:
    """500 worlds drawn from the prior, each measured with noise: about 95 % of the intervals hold the truth."""
    random = np.random.default_rng(3)
    matrix = random.normal(size=(12, 4))
    spread = covariance(matrix)
    deviation = np.sqrt(np.diag(spread))
    held = 0
    for _ in range(500):
        truth = random.standard_normal(4)
        found = spread @ matrix.T @ (matrix @ truth + random.standard_normal(12))
        held += int(np.sum(np.abs(found - truth) < 1.96 * deviation))
    assert held / 2000 == pytest.approx(0.95, abs=0.02)


def test_without_data_the_prior_stays() -> None:
    assert covariance(np.zeros((5, 3))) == pytest.approx(np.eye(3))


def test_residuals_larger_than_stated_widen_and_smaller_ones_do_not_narrow() -> None:
    random = np.random.default_rng(4)
    residuals = random.standard_normal(5000)
    assert excess_variance(3.0 * residuals, 10) == pytest.approx(9.0, rel=0.05)
    assert excess_variance(0.3 * residuals, 10) == 1.0
    matrix = random.normal(size=(20, 2))
    assert np.all(np.diag(covariance(matrix, 9.0)) > np.diag(covariance(matrix)))


def test_a_parameter_is_identifiable_at_half_the_priors_width_and_at_a_bound_near_it() -> None:
    space = candidates()
    coordinates = np.zeros(len(space))
    coordinates[0] = space.low[0] + 0.01
    deviation = np.linspace(0.1, 0.9, len(space))
    items = estimates(space, coordinates, deviation)
    assert [item.identifiable for item in items] == [
        bool(one <= 0.5) and (item.prior_mean == 0.0 or abs(item.value) > item.std)
        for one, item in zip(deviation, items, strict=True)
    ]
    small = dataclasses.replace(items[0], prior_mean=2e-4, prior_std=1e-4, value=1.2e-5, std=2.7e-5)
    assert not small.identifiable
    assert dataclasses.replace(small, prior_mean=0.0).identifiable
    assert [item.at_bound for item in items] == [True] + [False] * (len(space) - 1)
    first = items[0]
    assert first.std == pytest.approx(deviation[0] * first.prior_std)
    assert first.interval == pytest.approx((first.value - 1.96 * first.std, first.value + 1.96 * first.std))
