"""Moving air: repeatable, of the stated strength, and absent unless a rig file has it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.parameters import load_wire
from musclewire.rigs import HasTrueState, RigConfiguration, Surroundings, ability, open_rig
from musclewire.rigs._air import AirModel, AirState
from musclewire.signals import RawSample

DT_S = 0.05
DRIVE_V = [0.3, 1.0, 3.0, 3.2, 2.0, 0.3]


def airs(surroundings: Surroundings, seed: int, samples: int, dt_s: float = DT_S) -> list[AirState]:
    weather = AirModel(surroundings, seed)
    return [weather.after(index * dt_s, dt_s) for index in range(samples)]


def samples(air: Surroundings, drive_v: list[float] = DRIVE_V, seed: int = 3) -> list[RawSample]:
    with open_rig(RigConfiguration(surroundings=air), seed=seed) as rig:
        return [rig.exchange(voltage) for voltage in drive_v]


def test_one_seed_gives_one_weather() -> None:
    air = Surroundings(ambient_swing=2.0, draught=0.1)
    assert airs(air, 5, 200) == airs(air, 5, 200)
    assert airs(air, 5, 200) != airs(air, 6, 200)


def test_draughts_have_the_spread_and_the_memory_they_are_given() -> None:
    """A first-order process: spread 0.08; after one draught time 1/e of a draught is left. Told to 4 % by 40 000 s."""
    air = Surroundings(draught=0.08, draught_time=2.0)
    ratio = np.array([moment.convection_ratio for moment in airs(air, 1, 80_000, dt_s=0.5)])
    assert ratio.mean() == pytest.approx(1.0, abs=0.003)
    # Cut off at three of its standard deviations, which takes 1 % of the spread.
    assert ratio.std() == pytest.approx(0.08, rel=0.04)
    gone = ratio - ratio.mean()
    assert float(gone[4:] @ gone[:-4] / (gone @ gone)) == pytest.approx(np.exp(-1.0), abs=0.03)


def test_the_first_draught_is_as_strong_as_any_other() -> None:
    """Over 2000 seeds, the air that a rig opens into."""
    first = np.array([airs(Surroundings(draught=0.1), seed, 1)[0].convection_ratio for seed in range(2000)])
    assert first.std() == pytest.approx(0.1, rel=0.06)


@settings(derandomize=True, deadline=None, max_examples=40)
@given(
    draught=st.floats(0.0, 0.25),
    swing_k=st.floats(0.0, 20.0),
    period_s=st.floats(1.0, 1e4),
    dt_s=st.floats(1e-3, 100.0),
    seed=st.integers(0, 1000),
)
def test_air_stays_within_its_bounds(draught: float, swing_k: float, period_s: float, dt_s: float, seed: int) -> None:
    air = Surroundings(draught=draught, ambient_swing=swing_k, ambient_period=period_s)
    for moment in airs(air, seed, 200, dt_s):
        assert abs(moment.warmer_k) <= swing_k
        assert max(1.0 - 3.0 * draught, 0.2) <= moment.convection_ratio <= 1.0 + 3.0 * draught


def test_the_airs_temperature_is_a_sine_of_its_period_from_any_phase() -> None:
    air = Surroundings(ambient_swing=2.0, ambient_period=40.0)
    found = np.array([moment.warmer_k for moment in airs(air, 4, 1600)])
    assert np.abs(found).max() == pytest.approx(2.0, rel=1e-3)
    assert found[800:] == pytest.approx(found[:800], abs=1e-9)
    assert sum(before < 0.0 <= after for before, after in pairwise(found)) == 2
    starts = [airs(air, seed, 1)[0].warmer_k for seed in range(200)]
    assert min(starts) < -1.8
    assert max(starts) > 1.8


def test_still_air_changes_no_bit_of_what_a_rig_shows() -> None:
    with open_rig("simulated", seed=3) as rig:
        plain = [rig.exchange(voltage) for voltage in DRIVE_V]
    assert samples(Surroundings()) == plain
    assert samples(Surroundings(ambient_period=5.0, draught_time=1.0)) == plain


def test_weather_leaves_the_noise_of_the_instruments_as_it_was() -> None:
    """A cold wire without drive shows nothing but noise, whatever the draught."""
    assert samples(Surroundings(draught=0.2), [0.0] * 20) == samples(Surroundings(), [0.0] * 20)


def test_a_draught_moves_a_warm_wire_and_one_seed_moves_it_the_same_way() -> None:
    """By more than the micron of the LVDT, on the way through whatever temperatures the wire transforms at."""
    air = Surroundings(draught=0.15, draught_time=1.0)
    warming_v = np.linspace(0.3, load_wire("paper-100um").drive_amplitude_v.value, 400).tolist()
    moved = [sample.displacement_m for sample in samples(air, warming_v)]
    still = [sample.displacement_m for sample in samples(Surroundings(), warming_v)]
    assert moved == [sample.displacement_m for sample in samples(air, warming_v)]
    assert np.abs(np.subtract(moved, still)).max() > 1e-5


def test_a_wire_without_drive_follows_the_airs_temperature() -> None:
    """The wire's time constant is under a second: over a swing of 60 s it lags by a few per cent."""
    swing = Surroundings(ambient_swing=3.0, ambient_period=60.0)
    found = []
    with open_rig(RigConfiguration(surroundings=swing), seed=3) as rig:
        for _ in range(1200):
            rig.exchange(0.0)
            found.append(ability(rig, HasTrueState).wire_state.temperature_k - 295.15)
    assert max(found) == pytest.approx(3.0, rel=0.03)
    assert min(found) == pytest.approx(-3.0, rel=0.03)
