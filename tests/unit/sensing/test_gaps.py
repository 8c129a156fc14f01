from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loops import LoopMaker, noisy

from musclewire.errors import CallerError, RecordingError
from musclewire.sensing import find_segments, hysteresis_gap, signed_hysteresis_gap

Column = np.ndarray[tuple[int], np.dtype[np.float64]]


def straight(offset: float, samples: int = 50) -> tuple[Column, Column]:
    """Strain falling from 3 % to 1 % between 15 and 17 ohm, shifted by an offset."""
    resistance = np.linspace(17, 15, samples)
    return resistance, 0.03 - 0.01 * (resistance - 15) + offset


def test_parallel_branches_have_their_distance_over_the_largest_strain() -> None:
    assert hysteresis_gap(straight(0.0), straight(-0.0003)) == pytest.approx(0.01)
    assert signed_hysteresis_gap(straight(0.0), straight(-0.0003)) == pytest.approx(0.01)
    assert signed_hysteresis_gap(straight(-0.0003), straight(0.0)) == pytest.approx(-0.01)


def test_branches_that_cross_keep_their_distance_but_lose_their_sign() -> None:
    maker = LoopMaker(crossing=True, middle_gap=0.001)
    loop = maker.record(20_000)
    s = find_segments(loop.resistance_ohm, loop.strain)
    assert hysteresis_gap(s.heating, s.cooling) == pytest.approx(maker.exact_gap(), abs=1e-4)
    assert signed_hysteresis_gap(s.heating, s.cooling) == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize("middle_gap", [0.0003, 0.001, 0.004])
@pytest.mark.parametrize("samples", [400, 1800, 20_000])
def test_the_gap_of_a_clean_loop_is_the_exact_one(middle_gap: float, samples: int) -> None:
    maker = LoopMaker(middle_gap=middle_gap)
    loop = maker.record(samples)
    s = find_segments(loop.resistance_ohm, loop.strain)
    assert hysteresis_gap(s.heating, s.cooling) == pytest.approx(maker.exact_gap(), rel=0.005)


@pytest.mark.parametrize("crossing", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_noise_of_a_fiftieth_percent_moves_the_gap_by_less_than_a_tenth_of_a_point(crossing: bool, seed: int) -> None:
    for middle_gap in (0.0002, 0.001, 0.003):
        maker = LoopMaker(middle_gap=middle_gap, crossing=crossing)
        loop = noisy(maker.record(1800), 2e-4, 1e-3, seed)
        s = find_segments(loop.resistance_ohm, loop.strain)
        assert hysteresis_gap(s.heating, s.cooling) == pytest.approx(maker.exact_gap(), abs=1e-3)


@given(st.integers(1, 12), st.floats(1e-4, 5e-3))
def test_a_gap_that_opens_evenly_is_its_mean_however_few_resistances_are_compared(points: int, widest: float) -> None:
    resistance, strain = straight(0.0)
    opening = widest * (resistance - 15.0) / 2.0
    gap = hysteresis_gap((resistance, strain), (resistance, strain - opening), points)
    assert gap == pytest.approx(0.5 * widest / 0.03, rel=1e-9)


FALLING = np.linspace(0.02, 0.01, 9)


@pytest.mark.parametrize(
    ("heating", "cooling", "error", "says"),
    [
        (straight(0.0), (np.linspace(17.5, 19, 9), FALLING), RecordingError, "share no resistance"),
        ((straight(0.0)[0], -straight(0.0)[1]), straight(-0.06), RecordingError, "contraction must be positive"),
        (([16.0], [0.02]), straight(0.0), RecordingError, "heating branch has 1 points"),
    ],
)
def test_branches_without_a_gap_are_named(
    heating: tuple[Column, Column], cooling: tuple[Column, Column], error: type[Exception], says: str
) -> None:
    with pytest.raises(error, match=says):
        hysteresis_gap(heating, cooling)
    with pytest.raises(CallerError, match="at least 1 point"):
        hysteresis_gap(straight(0.0), straight(0.0), points=0)


def test_only_shared_resistances_are_compared_and_another_maximum_may_be_given() -> None:
    low = (np.linspace(15, 16, 40), np.linspace(0.03, 0.02, 40))
    high = (np.linspace(15.5, 17, 40), np.linspace(0.025, 0.01, 40))
    assert hysteresis_gap(low, high) == pytest.approx(0.0, abs=1e-12)
    assert hysteresis_gap(straight(0.0), straight(-0.0003), maximum=0.06) == pytest.approx(0.005)


branches = st.integers(10, 400).flatmap(lambda n: st.tuples(st.just(n), st.floats(0.3, 3.0), st.floats(-0.002, 0.002)))


def curve(shape: tuple[int, float, float]) -> tuple[Column, Column]:
    samples, bend, bow = shape
    share = np.linspace(0, 1, samples)
    return 17 - 2 * share, 0.01 + 0.02 * share**bend + bow * np.sin(np.pi * share)


@settings(deadline=None)
@given(branches, branches, st.floats(0.01, 100), st.floats(1e-3, 1e3))
def test_scaling_either_axis_changes_nothing(
    h: tuple[int, float, float], c: tuple[int, float, float], ohms: float, units: float
) -> None:
    (rh, sh), (rc, sc) = curve(h), curve(c)
    plain = hysteresis_gap((rh, sh), (rc, sc))
    scaled = hysteresis_gap((ohms * rh, units * sh), (ohms * rc, units * sc))
    assert scaled == pytest.approx(plain, rel=1e-3, abs=1e-6)


@settings(deadline=None)
@given(branches, branches)
def test_direction_doubled_samples_and_resampling_change_nothing(
    h: tuple[int, float, float], c: tuple[int, float, float]
) -> None:
    heating, cooling = curve(h), curve(c)
    plain = hysteresis_gap(heating, cooling)
    backwards = tuple(column[::-1] for column in heating)
    assert hysteresis_gap((backwards[0], backwards[1]), cooling) == pytest.approx(plain, rel=1e-3, abs=1e-6)
    doubled = tuple(np.repeat(column, 2) for column in heating)
    assert hysteresis_gap((doubled[0], doubled[1]), cooling) == pytest.approx(plain, rel=1e-9, abs=1e-12)
    finer = np.linspace(17, 15, 2 * h[0] - 1)
    resampled = (finer, np.interp(finer, heating[0][::-1], heating[1][::-1]))
    assert hysteresis_gap(resampled, cooling) == pytest.approx(plain, rel=1e-3, abs=2e-5)


@settings(deadline=None)
@given(branches, branches)
def test_the_gap_is_symmetric_and_not_smaller_than_its_sign_tells(
    h: tuple[int, float, float], c: tuple[int, float, float]
) -> None:
    gap, signed = hysteresis_gap(curve(h), curve(c)), signed_hysteresis_gap(curve(h), curve(c))
    assert hysteresis_gap(curve(c), curve(h)) == pytest.approx(gap, abs=1e-12)
    assert abs(signed) <= gap + 1e-12
