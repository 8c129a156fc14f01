"""What an isobar is summarised by: loops of straight branches, whose temperatures are known without any arithmetic."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import RecordingError
from musclewire.identify import IsobaricLoop, half_transformation_slope_pa_per_k, summarize_isobar

STROKE = 0.04


def straight_loop(
    heated_k: tuple[float, float] = (360.0, 380.0),
    cooled_k: tuple[float, float] = (350.0, 330.0),
    stress_pa: float = 1e8,
) -> IsobaricLoop:
    """A loop that loses its stroke evenly between two temperatures, and regains it between two others, in time."""
    up = np.linspace(300.0, 400.0, 201)
    strain_up = np.interp(up, heated_k, (STROKE, 0.0))
    strain_down = np.interp(up, cooled_k[::-1], (STROKE, 0.0))
    return IsobaricLoop(stress_pa, np.concatenate([up, up[-2::-1]]), np.concatenate([strain_up, strain_down[-2::-1]]))


def test_the_fractions_of_each_branch_are_counted_in_its_own_direction() -> None:
    """After a tenth of the cooling branch a tenth of the stroke is back: at the hottest of its three temperatures."""
    found = summarize_isobar(straight_loop())
    assert found.stroke == pytest.approx(STROKE)
    assert found.heating_k == pytest.approx((362.0, 370.0, 378.0))
    assert found.cooling_k == pytest.approx((348.0, 340.0, 332.0))


starts = st.floats(310.0, 350.0)
widths = st.floats(2.0, 40.0)


@given(starts, widths, starts, widths)
def test_a_tenth_a_half_and_nine_tenths_follow_each_other_in_time_on_both_branches(
    heated_k: float, heating_width_k: float, cooled_k: float, cooling_width_k: float
) -> None:
    ends = (heated_k, heated_k + heating_width_k), (cooled_k + cooling_width_k, cooled_k)
    found = summarize_isobar(straight_loop(*ends))
    for (first, last), branch in zip(ends, (found.heating_k, found.cooling_k), strict=True):
        # The loop's corners lie between two of its temperatures, 0.5 K apart.
        assert branch == pytest.approx([first + part * (last - first) for part in (0.1, 0.5, 0.9)], abs=0.3)


def test_the_slope_of_an_isobars_half_over_stress_is_that_of_each_branch() -> None:
    loops = [
        straight_loop((350.0 + warmer, 370.0 + warmer), (350.0 + 0.5 * warmer, 330.0 + 0.5 * warmer), stress_pa)
        for stress_pa, warmer in ((0.5e8, 0.0), (1e8, 5.0), (2e8, 15.0))
    ]
    summaries = [summarize_isobar(loop) for loop in loops]
    assert half_transformation_slope_pa_per_k(summaries, "heating") == pytest.approx(10e6)
    assert half_transformation_slope_pa_per_k(summaries, "cooling") == pytest.approx(20e6)


def test_what_goes_one_way_only_or_never_strains_is_no_isobar() -> None:
    loop = straight_loop()
    half = IsobaricLoop(1e8, loop.temperature_k[:201], loop.strain[:201])
    for wrong in (half, IsobaricLoop(1e8, loop.temperature_k, np.zeros(loop.strain.size))):
        with pytest.raises(RecordingError, match="from cold to hot and back"):
            summarize_isobar(wrong)
