"""From today's zero, a first heating that turns at another resistance than the model's scales what is read after it."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.judge._first_heating import KnownB
from musclewire.judge._scale_by_b import ScaleByB
from musclewire.signals import QuantityEstimate, Reason, WireSample

SHUNT_OHM, CURRENT_A, PERIOD_S, STROKE = 1.0, 0.15, 0.05, 0.03
# B repeats within 1.6 % of the span of 3 ohm.
KNOWN = KnownB(b_ohm=20.0, c_ohm=17.0, rise_ohm=0.2, std_ohm=0.012, highest_ohm=20.0, sense_voltage_v=0.3)
ESTIMATE = QuantityEstimate(0.02, 2e-4, True)


def heated(factor: float, from_ohm: float = 19.8) -> list[WireSample]:
    """Samples of a wire that rests for 0.2 s, then heats past B at 20 ohm down to 17.5 ohm, all times a factor."""
    warmth = np.clip(0.2 * (np.arange(60) - 4), 0.0, None)
    rising, falling = 20.0 - (20.0 - from_ohm) * (1.0 - warmth) ** 2, 20.0 - 0.5 * (warmth - 1.0) ** 2
    ohm = factor * np.maximum(np.where(warmth < 1.0, rising, falling), 17.5)
    return [
        WireSample(PERIOD_S * row, 3.0 if row > 4 else 0.3, CURRENT_A * one, CURRENT_A * SHUNT_OHM)
        for row, one in enumerate(ohm.tolist())
    ]


def after(factor: float, known: KnownB | None = KNOWN, from_ohm: float = 19.8) -> ScaleByB:
    """What scales, once a whole heating has been watched."""
    scale = ScaleByB(known, STROKE, SHUNT_OHM)
    for sample in heated(factor, from_ohm):
        scale.watch(sample)
    return scale


@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_a_scaled_resistance_is_brought_back_once_b_has_been_passed_and_not_before(factor: float) -> None:
    scale = ScaleByB(KNOWN, STROKE, SHUNT_OHM)
    factors = []
    for sample in heated(factor):
        scale.watch(sample)
        factors.append(scale.factor)
    read_ohm = np.array([one.wire_voltage_v / one.shunt_voltage_v for one in heated(factor)])
    begins = int(np.argmax(np.array(factors) != 1.0))
    assert read_ohm[begins] < read_ohm[: begins + 1].max() - 0.08 * 3.0
    assert factors[-1] * factor == pytest.approx(1.0, abs=2e-4)
    sample = heated(factor)[-1]
    assert scale.scaled(sample).wire_voltage_v == pytest.approx(CURRENT_A * 17.5, rel=2e-4)
    assert scale.scaled(sample).shunt_voltage_v == sample.shunt_voltage_v


def test_a_scaled_estimate_states_the_interval_that_scaling_leaves_and_keeps_a_wider_one() -> None:
    # A hundredth of 20 ohm is 6.7 % of the span, so that 3 % and 0.8 times 6.7 % of the stroke are left.
    half_width = 1.96 * after(1.01).judged(ESTIMATE).std
    assert half_width == pytest.approx(0.01 * (3.0 + 0.8 * 100.0 * 0.2 / 3.0) * STROKE, rel=0.02)
    wide = ESTIMATE._replace(std=0.5 * STROKE)
    assert after(1.01).judged(wide) == wide


@pytest.mark.parametrize("factor", [0.985, 1.015])
def test_where_b_is_away_by_more_than_9_percent_of_the_span_nothing_is_valid_and_nothing_scaled(factor: float) -> None:
    scale = after(factor)
    refused = scale.judged(ESTIMATE)
    assert (scale.factor, refused.valid, refused.reason) == (1.0, False, Reason.UNEXPLAINED)
    cold = ESTIMATE._replace(valid=False, reason=Reason.COLD)
    assert scale.judged(cold) == cold


def test_a_wire_that_is_held_cold_for_long_is_neither_kept_whole_nor_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    searched = []
    monkeypatch.setattr(KnownB, "passed_in", lambda *_: searched.append(1))
    scale, noise = ScaleByB(KNOWN, STROKE, SHUNT_OHM), np.random.default_rng(1)
    for row in range(5000):  # noise of a tenth of the span, as at little current
        ohm = 19.8 + 0.3 * noise.standard_normal()
        scale.watch(WireSample(PERIOD_S * row, 0.3, 0.01 * ohm, 0.01 * SHUNT_OHM))
    assert (len(scale._resistance_ohm) < 100, searched) == (True, [])


def test_a_long_rest_before_it_changes_nothing() -> None:
    scale, noise = ScaleByB(KNOWN, STROKE, SHUNT_OHM), np.random.default_rng(2)
    for row in range(2000):
        ohm = 1.01 * 19.8 + 0.01 * noise.standard_normal()
        scale.watch(WireSample(PERIOD_S * row, 0.3, 0.01 * ohm, 0.01 * SHUNT_OHM))
    for sample in heated(1.01):
        scale.watch(sample)
    assert scale.factor == pytest.approx(1.0 / 1.01, abs=2e-4)


@pytest.mark.parametrize(
    "scale",
    [after(1.002), after(1.01, known=None), after(1.01, from_ohm=19.98)],
    ids=["as it repeats", "a model without B", "from warm"],
)
def test_what_is_not_known_to_have_changed_is_neither_scaled_nor_widened(scale: ScaleByB) -> None:
    assert scale.factor == 1.0
    assert scale.judged(ESTIMATE) == ESTIMATE
