from __future__ import annotations

import numpy as np
import pytest
from loops import Loop, LoopMaker, noisy

from musclewire.errors import CallerError, FitRejectedError, RecordingError
from musclewire.sensing import HotEnd, SensingModel, find_segments, fit_branches, fit_loop

MAKER = LoopMaker()


def fitted(loop: Loop, order: int | str = 6) -> SensingModel:
    return fit_loop(loop.resistance_ohm, loop.strain, order=order)


def test_sixth_order_follows_a_clean_loop_to_a_hundredth_percent_strain() -> None:
    model = fitted(MAKER.record())
    assert model.rmse_heating < 1e-4
    assert model.rmse_cooling < 1e-4
    assert model.strain_gap == pytest.approx(MAKER.exact_gap(), rel=0.005)
    assert model.warnings == ()
    # B lies between two samples.
    assert (model.normalised_min, model.normalised_max) == (0.0, pytest.approx(1.0, abs=1e-4))


def test_the_average_splits_the_gap() -> None:
    loop = MAKER.record()
    model = fitted(loop)
    s = find_segments(loop.resistance_ohm, loop.strain)
    middle = slice(s.heating_b + 60, s.heating_c - 60)
    above = loop.strain[middle] - model.strain(loop.resistance_ohm[middle])
    share = (loop.resistance_ohm[middle] - MAKER.resistance_min_ohm) / 2.3419
    assert above == pytest.approx(MAKER.gap_at(share) / 2, abs=1.5e-4)


@pytest.mark.parametrize("order", [3, 6, "auto"])
@pytest.mark.parametrize("seed", [0, 1])
def test_noise_hardly_moves_the_curve(order: int | str, seed: int) -> None:
    clean, rough = MAKER.record(), noisy(MAKER.record(), 1e-3, 5e-3, seed)
    resistance = np.linspace(15.4, 17.2, 50)
    apart = fitted(clean).strain(resistance) - fitted(rough, order).strain(resistance)
    assert np.abs(apart).max() < 5e-4


def test_a_rest_in_the_middle_does_not_pull_the_fit() -> None:
    up = np.linspace(0, 1.2, 600)
    steady = MAKER.along(np.concatenate([up, up[::-1]]))
    resting = MAKER.along(np.concatenate([up[:300], np.full(5000, up[300]), up[300:], up[::-1]]))
    resistance = np.linspace(15.2, 17.4, 40)
    assert fitted(resting, 3).strain(resistance) == pytest.approx(fitted(steady, 3).strain(resistance), abs=2e-5)


@pytest.mark.parametrize(
    ("loop", "warned"),
    [
        (MAKER.record(2000, top=0.7), "is not complete"),
        (MAKER.record(2000, top=0.9, bottom=0.3), "does not return to cold"),
        (LoopMaker(middle_gap=0.004).record(), "gap between heating and cooling is 7."),
        (LoopMaker(a_to_b=0.35).record(), "A-B takes 3"),
    ],
    ids=["not complete", "warm", "wide", "late"],
)
def test_a_loop_that_is_not_the_papers_is_fitted_with_a_warning(loop: Loop, warned: str) -> None:
    model = fitted(loop)
    assert any(warned in warning for warning in model.warnings)
    assert model.quantity_max == pytest.approx(loop.strain.max(), abs=2e-3)


def test_where_the_fall_has_levelled_off_the_transformation_counts_as_complete() -> None:
    loop = MAKER.record(2000, top=0.7)
    columns = loop.resistance_ohm, loop.strain
    assert any("; no room" in text for text in fit_loop(*columns, hot_end=HotEnd(more_drive="no room")).warnings)
    assert not any("not complete" in text for text in fit_loop(*columns, hot_end=HotEnd(levelled=True)).warnings)


def test_a_short_segment_a_to_b_costs_nothing_and_is_no_warning() -> None:
    for share in (0.01, 0.03):
        loop = LoopMaker(a_to_b=share).record()
        segments = find_segments(loop.resistance_ohm, loop.strain)
        assert segments.transformation_fraction > 0.95
        assert fit_loop(loop.resistance_ohm, loop.strain).warnings == ()


def test_an_offset_sensor_is_warned_of() -> None:
    loop = MAKER.record()
    model = fit_loop(loop.resistance_ohm, loop.strain + 0.005)
    assert any("zero the sensor" in warning for warning in model.warnings)


def test_displacement_and_force_are_fitted_alike() -> None:
    loop = MAKER.record()
    model = fit_loop(loop.resistance_ohm, 0.2 * loop.strain, quantity="displacement")
    assert model.quantity_max == pytest.approx(0.007, rel=0.01)
    assert model.strain_gap == pytest.approx(MAKER.exact_gap(), rel=0.005)
    assert model.report()["rmse_heating_pct"] < 0.3


def test_the_noise_of_the_recording_is_part_of_the_estimates_spread() -> None:
    model = fitted(noisy(MAKER.record(), 2e-3, 1e-3))
    assert model.resistance_noise_ohm == pytest.approx(2e-3 * 16.5, rel=0.15)
    assert model.estimate(16.3).std > model.estimate(16.3, 0.0).std


def test_strain_in_percent_is_recognised() -> None:
    loop = MAKER.record()
    with pytest.raises(RecordingError, match=r"strain reaches 3\.5: strain is a fraction"):
        fit_loop(loop.resistance_ohm, 100 * loop.strain)


def test_too_few_points_for_the_order_are_refused_and_few_are_warned_of() -> None:
    resistance = np.linspace(17, 15, 5)
    branch = (resistance, np.array([0.005, 0.012, 0.02, 0.027, 0.034]))
    with pytest.raises(RecordingError, match="largest order possible is 4"):
        fit_branches(branch, branch)
    assert any("passes through every point" in w for w in fit_branches(branch, branch, 4).warnings)


def test_an_average_that_cannot_be_inverted_is_rejected() -> None:
    resistance = np.linspace(17, 15, 80)
    hump = (resistance, 0.02 + 0.01 * np.sin(3 * np.pi * (resistance - 15) / 2))
    with pytest.raises(FitRejectedError, match="cannot be inverted"):
        fit_branches(hump, hump)
    rising = (resistance, 0.01 * (resistance - 14))
    with pytest.raises(FitRejectedError, match="falls over only 0 %"):
        fit_branches(rising, rising)


def test_an_average_that_turns_back_at_an_end_is_cut_there() -> None:
    resistance = np.linspace(17, 15, 80)
    branch = (resistance, 0.03 - 0.01 * (resistance - 15.4) ** 2)
    model = fit_branches(branch, branch, 2)
    assert model.normalised_min == pytest.approx(0.2, abs=1e-6)
    assert model.normalised_max == 1.0
    assert any("20.0 % of the resistance range is left out" in warning for warning in model.warnings)


def test_branches_of_different_reach_are_fitted_where_both_have_data() -> None:
    heating = (np.linspace(17, 15, 80), np.linspace(0.005, 0.035, 80))
    cooling = (np.linspace(15.2, 16.6, 60), np.linspace(0.032, 0.011, 60))
    model = fit_branches(heating, cooling, 2)
    assert (model.normalised_min, model.normalised_max) == pytest.approx((0.1, 0.8))
    with pytest.raises(RecordingError, match="share no resistance"):
        fit_branches(heating, (np.linspace(18, 19, 20), np.linspace(0.02, 0.01, 20)), 2)


def test_wrong_arguments_are_refused_before_any_work() -> None:
    with pytest.raises(CallerError, match="'auto'"):
        fit_loop([], [], order="best")
    with pytest.raises(CallerError, match="did you mean 'force'"):
        fit_loop([], [], quantity="forces")
