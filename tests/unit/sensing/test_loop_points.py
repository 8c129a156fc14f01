from __future__ import annotations

import numpy as np
import pytest
from loops import LoopMaker

from musclewire.sensing import find_resistance_extremes, find_segments
from musclewire.sensing._loop_points import fall_from_b_to_c

MAKER = LoopMaker()


def with_a_high_cold_end(samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Return resistance and strain of a loop that reads 17.9 ohm where it is coldest, more than at B."""
    loop = MAKER.record(samples)
    colder = np.maximum(0.3 - loop.strain / (MAKER.strain_max * MAKER.a_to_b), 0.0) / 0.3
    return loop.resistance_ohm + 0.85 * colder**2, loop.strain


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_b_is_found_on_both_branches_where_the_cold_end_reads_more(noise: float) -> None:
    resistance, strain = with_a_high_cold_end(3600)
    assert resistance.max() > MAKER.resistance_max_ohm + 0.2
    draw = np.random.default_rng(3)
    found = find_segments(resistance * (1.0 + noise * draw.standard_normal(strain.size)), strain)
    for b in (found.heating_b, found.cooling_b):
        assert strain[b] == pytest.approx(MAKER.a_to_b * MAKER.strain_max, rel=0.15)
    assert found.resistance_max_ohm == pytest.approx(MAKER.resistance_max_ohm, abs=0.02)


def test_a_sweep_that_starts_above_b_re_anchors_to_b() -> None:
    resistance, _ = with_a_high_cold_end(3600)
    found = find_resistance_extremes(resistance[:1800])
    assert found.resistance_max_ohm == pytest.approx(MAKER.resistance_max_ohm, abs=0.01)


def test_two_samples_in_a_row_at_the_maximum_give_the_later_one() -> None:
    assert fall_from_b_to_c(np.array([1.0, 3.0, 3.0, 2.0, 0.5, 1.0]), 0.1) == (2, 4)


def test_a_ripple_half_way_down_is_not_b() -> None:
    down = np.concatenate([np.linspace(1.0, 3.0, 10), np.linspace(2.9, 2.0, 10), [2.1, 2.2], np.linspace(2.1, 0.0, 20)])
    assert fall_from_b_to_c(down, 0.05)[0] == 9
