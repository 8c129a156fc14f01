from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.sensing import first_maximum, noise_level, parabola_maximum, smooth, smoothing_window
from musclewire.sensing._resistance_maximum import ResistanceMaximum, resistance_maximum
from musclewire.sensing._smoothing import smoothed_noise

FALL_OHM, TOP_OHM = 2.34, 17.5


def curve(samples: int, at: float, steepness: float = 60.0, skew: float = 0.5) -> np.ndarray:
    """Return a resistance that rises to its maximum at a fraction of the samples and falls from there.

    In closed form: round near its maximum, nearly straight far from it, flatter after it than before.
    """
    away = np.arange(samples) / (samples - 1) - at
    width = 1.0 / steepness
    stretched = away * (1.0 - skew * away)
    return TOP_OHM - FALL_OHM * (np.sqrt(stretched**2 + width**2) - width)


def maximum_of(measured: np.ndarray, max_window: int | None = None) -> ResistanceMaximum:
    noise = noise_level(measured)
    window = smoothing_window(noise, FALL_OHM, max_window or measured.size // 40)
    smoothed = smooth(measured, window)
    near = int(np.argmax(smoothed))
    return resistance_maximum(measured, smoothed, near, FALL_OHM, smoothed_noise(noise, window))


@settings(deadline=None, max_examples=50)
@given(samples=st.integers(60, 5000), at=st.floats(0.2, 0.8), steepness=st.floats(2.0, 60.0))
def test_without_noise_it_is_the_curves_own_maximum(samples: int, at: float, steepness: float) -> None:
    measured = curve(samples, at, steepness, skew=0.0)
    found = maximum_of(measured)
    assert found.place == pytest.approx(at * (samples - 1), abs=1.0)
    assert found.resistance_ohm == pytest.approx(TOP_OHM, abs=1e-3)
    plain = parabola_maximum(measured, int(np.argmax(measured)))
    assert found.place == pytest.approx(plain.place, abs=1.0)


@pytest.mark.parametrize("samples", [200, 2000])
def test_a_sharp_corner_without_noise_is_found_to_within_a_sample(samples: int) -> None:
    measured = TOP_OHM - FALL_OHM * np.abs(np.arange(samples) / (samples - 1) - 0.3)
    assert maximum_of(measured).place == pytest.approx(0.3 * (samples - 1), abs=1.0)
    assert maximum_of(measured).resistance_ohm == pytest.approx(TOP_OHM, abs=FALL_OHM / samples)


@settings(deadline=None, max_examples=20)
@given(noise_ohm=st.floats(1e-4, 0.06), at=st.floats(0.3, 0.7), seed=st.integers(0, 1000))
def test_noise_moves_the_maximum_by_a_part_of_itself(noise_ohm: float, at: float, seed: int) -> None:
    clean = curve(2000, at, steepness=5.0)
    draw = np.random.default_rng(seed)
    found = [maximum_of(clean + noise_ohm * draw.standard_normal(clean.size)) for _ in range(20)]
    resistances = np.array([one.resistance_ohm for one in found])
    # The mean of the largest of so many samples would lie three standard deviations above.
    assert abs(float(resistances.mean()) - TOP_OHM) < 0.25 * noise_ohm + 2e-4
    assert float(resistances.std()) < 0.3 * noise_ohm


def test_noise_moves_it_less_than_the_largest_smoothed_sample() -> None:
    clean, draw = curve(2000, 0.4, steepness=5.0), np.random.default_rng(7)
    fitted, largest = [], []
    for _ in range(50):
        measured = clean + 0.0066 * draw.standard_normal(clean.size)
        fitted.append(maximum_of(measured).place)
        largest.append(int(np.argmax(smooth(measured, 27))))
    assert np.std(fitted) < 0.5 * np.std(largest)
    assert abs(np.mean(fitted) - 0.4 * 1999) < np.std(fitted)


def test_a_broad_top_with_a_corner_is_read_near_the_corner() -> None:
    """As an early population of grains makes it: a long gentle rise, a corner, a steep fall."""
    place = np.arange(2000) / 1999
    clean = TOP_OHM + np.where(place < 0.5, 0.06 * (place - 0.5), -FALL_OHM * (place - 0.5))
    clean -= np.where(place < 0.2, 20.0 * (0.2 - place) ** 2, 0.0)
    draw = np.random.default_rng(11)
    found = [maximum_of(clean + 0.0066 * draw.standard_normal(clean.size)) for _ in range(30)]
    assert np.mean([one.place for one in found]) == pytest.approx(0.5 * 1999, abs=0.03 * 1999)
    assert np.std([one.place for one in found]) < 0.02 * 1999
    assert np.mean([one.resistance_ohm for one in found]) == pytest.approx(TOP_OHM, abs=0.004)


def test_a_maximum_at_an_end_is_the_end() -> None:
    falling = np.linspace(17.0, 15.0, 300)
    assert maximum_of(falling).place <= 1.0
    assert parabola_maximum(falling, 0) == ResistanceMaximum(0.0, 17.0)


def test_too_few_samples_for_a_fit_give_the_parabola_through_three() -> None:
    coarse = np.array([17.0, 17.3, 17.5, 17.4, 16.0, 15.0])
    assert resistance_maximum(coarse, coarse, 2, 2.5, 0.0) == parabola_maximum(coarse, 2)


@given(shift=st.floats(-0.5, 0.5), bend=st.floats(1e-3, 1.0))
def test_the_parabola_is_exact_on_a_parabola(shift: float, bend: float) -> None:
    values = 17.0 - bend * (np.arange(7) - 3 - shift) ** 2
    found = parabola_maximum(values, 3)
    assert found.place == pytest.approx(3 + shift, abs=1e-9)
    assert found.resistance_ohm == pytest.approx(17.0, abs=1e-9)


def test_a_first_heating_has_passed_b_once_it_has_fallen_from_it_and_not_before() -> None:
    fast = np.array([16.0, 16.4, 16.9, 17.0, 16.9, 16.7, 15.0, 17.5])
    found = first_maximum(fast, 2.5, 0.0)
    assert found == ResistanceMaximum(3.0, 17.0)  # neither C nor what comes after the fall
    assert first_maximum(fast[:5], 2.5, 0.0) is None
    assert first_maximum(fast[:6], 2.5, 0.1) is None  # as much noise makes
    assert first_maximum(np.empty(0), 2.5, 0.0) is None


def test_a_slow_first_heating_is_read_through_its_noise() -> None:
    place = np.arange(600) / 200.0
    clean = TOP_OHM - 0.2 * (place - 1.0) ** 2
    draw = np.random.default_rng(5)
    found = [first_maximum(clean + 0.01 * draw.standard_normal(600), FALL_OHM, 0.01) for _ in range(30)]
    heights = [one.resistance_ohm for one in found if one is not None]
    assert len(heights) == 30
    assert np.mean(heights) == pytest.approx(TOP_OHM, abs=0.004)
