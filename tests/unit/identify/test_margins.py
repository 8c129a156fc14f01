"""Gains and margins by the rule and the numbers of its literature."""

from __future__ import annotations

import math

import pytest
from known_plant import plant_settings

from musclewire.identify._tuning import feedback_gains, margins_of, worst_margins


@pytest.mark.parametrize(
    ("lag_s", "gain", "phase_deg", "delay_over_theta"), [(1e4, 2.96, 46.9, 1.59), (0.8, 3.14, 61.4, 2.14)]
)
def test_simc_has_the_margins_of_its_literature(
    lag_s: float, gain: float, phase_deg: float, delay_over_theta: float
) -> None:
    """Skogestad 2003, Table 1, with tau_c = theta: an integrating process, and one of first order with T_i = tau."""
    settings = plant_settings(thermal_time_constant_s=lag_s)
    margins = margins_of(lag_s * 5.0 / 0.2, 5.0, settings)
    assert margins.gain == pytest.approx(gain, abs=0.03)
    assert math.degrees(margins.phase_rad) == pytest.approx(phase_deg, abs=0.5)
    assert margins.delay_s == pytest.approx(delay_over_theta * settings.dead_time_s, rel=0.03)


def test_gains_follow_the_rule() -> None:
    heating, cooling = feedback_gains(plant_settings(heat_per_unit=2.5))
    assert heating == pytest.approx([(0.8 * 5.0 + 2.5) / 0.2] * 33)
    assert cooling == pytest.approx(heating)


def test_a_longer_closed_loop_time_has_larger_margins() -> None:
    quick, slow = worst_margins(plant_settings()), worst_margins(plant_settings(closed_loop_time_s=0.4))
    assert slow.gain > quick.gain
    assert slow.delay_s > quick.delay_s
