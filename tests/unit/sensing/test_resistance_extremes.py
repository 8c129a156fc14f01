from __future__ import annotations

import numpy as np
import pytest
from loops import LoopMaker, noisy

from musclewire.errors import RecordingError
from musclewire.sensing import find_resistance_extremes

MAKER = LoopMaker()


@pytest.mark.parametrize("noise", [0.0, 2e-4, 2e-3])
@pytest.mark.parametrize("samples", [200, 5000])
def test_one_heating_sweep_gives_b_and_c_without_a_sensor(noise: float, samples: int) -> None:
    sweep = noisy(MAKER.record(samples, cycles=0.5), noise, 0.0)
    extremes = find_resistance_extremes(sweep.resistance_ohm)
    assert extremes.resistance_max_ohm == pytest.approx(MAKER.resistance_max_ohm, abs=0.005 + 35 * noise)
    assert extremes.resistance_min_ohm == pytest.approx(MAKER.resistance_min_ohm, abs=0.005 + 35 * noise)
    assert extremes.index_b < extremes.index_c
    if noise < 1e-3:
        assert extremes.saw_b
        assert extremes.saw_c


def test_a_sweep_that_stops_early_says_that_c_was_not_seen() -> None:
    sweep = MAKER.record(1000, top=0.8, cycles=0.5)
    extremes = find_resistance_extremes(sweep.resistance_ohm)
    assert not extremes.saw_c
    assert extremes.index_c == 999


def test_a_sweep_that_starts_warm_says_that_b_was_not_seen() -> None:
    sweep = MAKER.record(1000, bottom=0.4, cycles=0.5)
    assert not find_resistance_extremes(sweep.resistance_ohm).saw_b


def test_the_way_back_is_left_out_where_the_drive_is_known() -> None:
    loop = MAKER.record(2000)
    lower_on_return = loop.resistance_ohm - 0.05 * (np.arange(2000) >= 1000)
    drive = np.concatenate([np.linspace(0, 3.2, 1000), np.linspace(3.2, 0, 1000)])
    extremes = find_resistance_extremes(lower_on_return, drive)
    assert extremes.index_c < 1000
    assert extremes.resistance_min_ohm == pytest.approx(MAKER.resistance_min_ohm, abs=0.001)


def test_samples_without_current_keep_their_places() -> None:
    sweep = MAKER.record(2000, cycles=0.5)
    valid = np.arange(2000) % 3 > 0
    plain = find_resistance_extremes(sweep.resistance_ohm)
    extremes = find_resistance_extremes(np.where(valid, sweep.resistance_ohm, 0.0), valid=valid)
    assert extremes.index_b == pytest.approx(plain.index_b, abs=2)
    assert extremes.index_c == pytest.approx(plain.index_c, abs=2)


def test_a_sweep_without_transformation_is_refused() -> None:
    with pytest.raises(RecordingError, match=r"^no transformation"):
        find_resistance_extremes(MAKER.record(500, top=0.14, cycles=0.5).resistance_ohm)
    noise = np.random.default_rng(0).normal(size=5000)
    with pytest.raises(RecordingError, match=r"^no transformation"):
        find_resistance_extremes(16 * (1 + 2e-3 * noise))


def test_unusable_columns_are_named() -> None:
    with pytest.raises(RecordingError, match="at least 20"):
        find_resistance_extremes(np.ones(19))
    with pytest.raises(RecordingError, match="equal length"):
        find_resistance_extremes(np.ones(30), np.ones(29))
    with pytest.raises(RecordingError, match="first at index 4"):
        find_resistance_extremes([16.0] * 4 + [np.nan] + [16.0] * 30)
