"""The correction of a run: from today's zero a first heating that turns elsewhere, and a strain that is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.judge import KnownB, RunCorrection
from musclewire.judge._known_strain import COMPARED_S, KnownStrain
from musclewire.judge._run_correction import FirstHeating
from musclewire.sensing import Correction, SensingModel
from musclewire.signals import QuantityEstimate, Reason, WireSample

SHUNT_OHM, CURRENT_A, PERIOD_S, AT_S = 1.0, 0.15, 0.05, 2.0
# B repeats within 1.6 % of the span of 3 ohm, over which the strain falls from 3 % to nothing.
KNOWN = KnownB(b_ohm=20.0, c_ohm=17.0, rise_ohm=0.2, std_ohm=0.012, highest_ohm=20.0, sense_voltage_v=0.3)
STRAIGHT = SensingModel(17.0, 20.0, (0.03, -0.03), (0.03, -0.03), 0.0, 1.0)
STROKE = STRAIGHT.stroke
ESTIMATE = QuantityEstimate(0.02, 2e-4, True)


def read(time_s: float, ohm: float, drive_v: float = 3.0) -> WireSample:
    return WireSample(time_s, drive_v, CURRENT_A * ohm, CURRENT_A * SHUNT_OHM)


def heated(factor: float, from_ohm: float = 19.8) -> list[WireSample]:
    """Samples of a wire that rests for 0.2 s, then heats past B at 20 ohm down to 17.5 ohm, all times a factor."""
    warmth = np.clip(0.2 * (np.arange(60) - 4), 0.0, None)
    rising, falling = 20.0 - (20.0 - from_ohm) * (1.0 - warmth) ** 2, 20.0 - 0.5 * (warmth - 1.0) ** 2
    ohm = factor * np.maximum(np.where(warmth < 1.0, rising, falling), 17.5)
    return [read(PERIOD_S * row, one, 3.0 if row > 4 else 0.3) for row, one in enumerate(ohm.tolist())]


def after(factor: float, known: KnownB | None = KNOWN, from_ohm: float = 19.8) -> RunCorrection:
    """What corrects, once a whole heating has been watched."""
    run = RunCorrection(STRAIGHT, SHUNT_OHM, known)
    for sample in heated(factor, from_ohm):
        run.watch(sample, ESTIMATE, sample.time_s)
    return run


def held(true_ohm: float, factor: float, known: float, run: RunCorrection | None = None) -> RunCorrection:
    """What corrects, after a hold at a resistance that reads so many times too high, with the strain known."""
    run = run or RunCorrection(STRAIGHT, SHUNT_OHM, None, KnownStrain(known, AT_S))
    for row in range(60):
        sample = read(PERIOD_S * row, factor * true_ohm)
        run.watch(sample, own(run, factor * true_ohm), sample.time_s)
    return run


def own(run: RunCorrection, ohm: float) -> QuantityEstimate:
    """An estimate by the model of today."""
    return QuantityEstimate(run.model.strain(ohm), 1e-4, True)


@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_a_changed_resistance_is_brought_back_once_b_has_been_passed_and_not_before(factor: float) -> None:
    run = RunCorrection(STRAIGHT, SHUNT_OHM, KNOWN)
    corrects = [run.watch(sample, ESTIMATE, sample.time_s) for sample in heated(factor)]
    read_ohm = np.array([one.wire_voltage_v / one.shunt_voltage_v for one in heated(factor)])
    begins = corrects.index(True)
    assert sum(corrects) == 1
    assert read_ohm[begins] < read_ohm[: begins + 1].max() - 0.08 * 3.0
    assert run.correction.scale * factor == pytest.approx(1.0, abs=2e-4)
    assert run.model.strain(17.5 * factor) == pytest.approx(STRAIGHT.strain(17.5), abs=5e-5)


def test_by_b_an_estimate_is_as_uncertain_as_a_load_of_the_same_height_would_leave_it() -> None:
    # A hundredth of 20 ohm is 6.7 % of the span, of which 0.4 are left, and B repeats within 0.4 % of it.
    std = after(1.01).shown(ESTIMATE).std
    assert std == pytest.approx(STROKE * np.hypot(0.4 * 0.2 / 3.0, 0.012 / 3.0), rel=0.06)


@pytest.mark.parametrize("factor", [0.985, 1.015])
def test_where_b_is_away_by_more_than_9_percent_of_the_span_nothing_is_valid_and_nothing_scaled(factor: float) -> None:
    run = after(factor)
    refused = run.shown(ESTIMATE)
    assert (run.correction, refused.valid, refused.reason) == (Correction(), False, Reason.UNEXPLAINED)
    cold = ESTIMATE._replace(valid=False, reason=Reason.COLD)
    assert run.shown(cold) == cold


def test_a_wire_that_is_held_cold_for_long_is_neither_kept_whole_nor_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    searched = []
    monkeypatch.setattr(KnownB, "passed_in", lambda *_: searched.append(1))
    heating, noise = FirstHeating(KNOWN), np.random.default_rng(1)
    for _ in range(5000):  # noise of a tenth of the span, as at little current
        heating.has_passed(19.8 + 0.3 * noise.standard_normal(), 0.3)
    assert (len(heating._resistance_ohm) < 100, searched) == (True, [])


def test_a_long_rest_before_it_changes_nothing() -> None:
    run, noise = RunCorrection(STRAIGHT, SHUNT_OHM, KNOWN), np.random.default_rng(2)
    for row in range(2000):
        run.watch(read(PERIOD_S * row, 1.01 * 19.8 + 0.01 * noise.standard_normal(), 0.3), ESTIMATE, PERIOD_S * row)
    for sample in heated(1.01):
        run.watch(sample, ESTIMATE, sample.time_s)
    assert run.correction.scale == pytest.approx(1.0 / 1.01, abs=2e-4)


@pytest.mark.parametrize(
    "run",
    [after(1.002), after(1.01, known=None), after(1.01, from_ohm=19.98)],
    ids=["as it repeats", "a model without B", "from warm"],
)
def test_what_is_not_known_to_have_changed_is_neither_corrected_nor_widened(run: RunCorrection) -> None:
    assert run.correction == Correction()
    assert run.shown(ESTIMATE) == ESTIMATE


@given(st.floats(17.5, 19.5), st.floats(0.98, 1.02).filter(lambda factor: abs(factor - 1.0) > 2e-3))
def test_a_scale_of_the_resistance_is_taken_away_by_one_known_strain(true_ohm: float, factor: float) -> None:
    known = float(STRAIGHT.strain(true_ohm))
    run = held(true_ohm, factor, known)
    assert run.shown(own(run, factor * true_ohm)).value == pytest.approx(known, abs=3e-5)
    assert run.correction.scale * factor == pytest.approx(1.0, abs=1e-4)


def test_a_known_strain_that_agrees_changes_nothing_and_one_that_does_not_widens() -> None:
    known = float(STRAIGHT.strain(18.5))
    assert held(18.5, 1.0001, known).shown(ESTIMATE) == ESTIMATE
    assert held(18.5, 1.01, known).shown(ESTIMATE).std > 3.0 * ESTIMATE.std


def test_after_b_a_known_strain_moves_the_zero_and_makes_the_interval_narrower() -> None:
    """A load has moved B: what its scale leaves at one strain is what it leaves of the zero, and no other scale."""
    known = float(STRAIGHT.strain(18.5)) - 2e-4
    run = RunCorrection(STRAIGHT, SHUNT_OHM, KNOWN, KnownStrain(known, AT_S + 3.0))
    for sample in heated(1.01):
        run.watch(sample, ESTIMATE._replace(valid=False), sample.time_s)
    by_b, wide = run.correction, run.variance
    for row in range(60, 120):
        run.watch(read(PERIOD_S * row, 1.01 * 18.5), own(run, 1.01 * 18.5), PERIOD_S * row)
    assert run.shown(own(run, 1.01 * 18.5)).value == pytest.approx(known, abs=5e-5)
    assert run.correction.scale == pytest.approx(by_b.scale, abs=1e-4)
    assert run.correction.zero == pytest.approx(2e-4, rel=0.2)
    assert run.variance < 0.1 * wide


def test_in_another_room_a_known_strain_that_agrees_moves_the_zero_and_no_scale() -> None:
    room = Correction(zero=1e-3, zero_variance=3e-4**2)
    known = float(STRAIGHT.strain(18.5)) - 1.2e-3
    run = held(18.5, 1.0, known, RunCorrection(STRAIGHT, SHUNT_OHM, None, KnownStrain(known, AT_S), room))
    assert run.correction.scale == 1.0
    assert 1e-3 < run.correction.zero < 1.2e-3
    assert run.correction.zero_variance < 0.2 * room.zero_variance


def test_only_what_was_valid_at_the_moment_is_compared() -> None:
    run = RunCorrection(STRAIGHT, SHUNT_OHM, None, KnownStrain(0.02, AT_S))
    for row in range(60):
        reason = Reason.COLD if PERIOD_S * row >= AT_S - COMPARED_S else Reason.OK
        estimate = QuantityEstimate(0.025, 1e-4, reason is Reason.OK, reason)
        run.watch(read(PERIOD_S * row, 18.0), estimate, PERIOD_S * row)
    assert run.correction == Correction()


@pytest.mark.parametrize("value", [0.05, -0.01, float("nan")])
def test_a_strain_that_the_model_does_not_reach_is_refused(value: float) -> None:
    with pytest.raises(CallerError, match=r"this model senses 0 to 3 %"):
        RunCorrection(STRAIGHT, SHUNT_OHM, None, KnownStrain(value, AT_S))
