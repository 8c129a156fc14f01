# ruff: noqa: E402 - a package that may be missing is asked for first
"""Wires of the population that have cooled without power: the filter knows nothing of their strain."""

from __future__ import annotations

import numpy as np
import pytest
from tests.tools import require_package

require_package("musclewire_robustness", "pip install ./studies/robustness")

from musclewire_robustness.characterizing import slow_loop
from musclewire_robustness.plant import open_plant
from musclewire_robustness.population import drawn_wire

from musclewire.identify import fit
from musclewire.sensing import EstimatorSetup, estimates, filter_estimator
from musclewire.signals import WireSample

HEATED_S, COOLED_S, RESTED_S = 6.0, 45.0, 30.0


def heated_and_rested(seed: int) -> tuple[list[WireSample], EstimatorSetup]:
    """Heat a wire to the largest drive of its slow loop, cool it, and let it rest at the sense voltage."""
    wire = drawn_wire(seed)
    loop = slow_loop(wire)
    model = fit(loop)
    with open_plant(wire, run=7).rig as rig:
        hot_v, low_v, period_s = float(loop["drive_voltage_v"].max()), rig.sense_voltage_v, rig.sample_period_s
        heated, cooled, rested = (round(time_s / period_s) for time_s in (HEATED_S, COOLED_S, RESTED_S))
        drive_v = [low_v, *[hot_v] * heated, *np.linspace(hot_v, low_v, cooled), *[low_v] * rested]
        samples = [WireSample(*rig.exchange(float(one))[:4]) for one in drive_v]
        return samples, EstimatorSetup(model, rig.shunt_resistance_ohm, period_s)


def valid_at_rest(setup: EstimatorSetup, samples: list[WireSample]) -> float:
    """Return the share of valid samples in the last two thirds of the rest."""
    last = round(RESTED_S * 2.0 / 3.0 / setup.sample_period_s)
    return float(np.mean([one.valid for one, _ in estimates(filter_estimator(setup), samples)][-last:]))


def judged(seeds: range) -> list[float]:
    """Return the share of valid samples at rest, a wire each, and print it."""
    shares = []
    for seed in seeds:
        samples, setup = heated_and_rested(seed)
        shares.append(valid_at_rest(setup, samples))
        print(f"wire {seed}: {100 * shares[-1]:.1f} % valid at rest")
    return shares


@pytest.mark.slow
def test_a_wire_that_rests_cold_is_not_valid() -> None:
    assert max(judged(range(621, 624))) <= 0.01


@pytest.mark.full
def test_none_of_forty_wires_that_rest_cold_is_valid() -> None:
    shares = judged(range(621, 661))
    print(f"{sum(share > 0.01 for share in shares)} of {len(shares)} with more than 1 %, the largest {max(shares):.3f}")
    assert max(shares) <= 0.01
