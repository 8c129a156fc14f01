from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loops import Loop, LoopMaker, noisy, picked

from musclewire.errors import CallerError, RecordingError
from musclewire.sensing import LoopSegments, find_loops, find_segments

MAKER = LoopMaker()


def found(loop: Loop, cycle: str | int = "last") -> LoopSegments:
    return find_segments(loop.resistance_ohm, loop.strain, cycle=cycle)


def strains(loop: Loop, segments: LoopSegments) -> list[float]:
    """Strain at A, B, C on heating and C, B, A on cooling, in percent of full."""
    s = segments
    places = [s.heating_a, s.heating_b, s.heating_c, s.cooling_c, s.cooling_b, s.cooling_a]
    return list(100 * loop.strain[places] / MAKER.strain_max)


@pytest.mark.parametrize("samples", [100, 400, 1800, 100_000])
def test_a_clean_loop_is_cut_where_it_was_made_to_turn(samples: int) -> None:
    loop = MAKER.record(samples)
    segments = found(loop)
    # A is placed to within one sample; near the cold end the sine hardly moves.
    assert strains(loop, segments) == pytest.approx([0, 15, 100, 100, 15, 0], abs=4.0 if samples < 400 else 1.0)
    assert segments.resistance_max_ohm == pytest.approx(MAKER.resistance_max_ohm, abs=0.02)
    assert segments.resistance_min_ohm == pytest.approx(MAKER.resistance_min_ohm, abs=0.02)
    assert segments.transformation_fraction == pytest.approx(0.85, abs=0.04 if samples < 400 else 0.01)
    assert segments.complete
    assert segments.returns_cold


@pytest.mark.parametrize("samples", [400, 2000, 20_000])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_noise_moves_the_points_by_little(samples: int, seed: int) -> None:
    loop = noisy(MAKER.record(samples), 2e-3, 5e-3, seed)
    segments = found(loop)
    clean = strains(MAKER.record(samples), segments)
    assert clean == pytest.approx([0, 15, 100, 100, 15, 0], abs=5.0)
    assert segments.resistance_max_ohm == pytest.approx(MAKER.resistance_max_ohm, abs=0.06)
    assert segments.resistance_min_ohm == pytest.approx(MAKER.resistance_min_ohm, abs=0.06)


def test_the_branches_are_the_measured_samples_from_b_to_c() -> None:
    loop = MAKER.record()
    s = found(loop)
    assert np.array_equal(s.heating.resistance_ohm, loop.resistance_ohm[s.heating_b : s.heating_c + 1])
    assert np.array_equal(s.cooling.quantity, loop.strain[s.cooling_c : s.cooling_b + 1])


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_a_minor_loop_that_never_completes_has_c_where_it_turns(noise: float) -> None:
    loop = noisy(MAKER.record(1800, top=0.7), noise, 3 * noise)
    s = found(loop)
    assert s.heating_c == pytest.approx(900, abs=45)
    assert s.cooling_c == pytest.approx(900, abs=45)
    assert s.resistance_min_ohm == pytest.approx(float(MAKER.resistance(np.array([0.7]))[0]), abs=0.02)
    assert not s.complete


def test_a_minor_loop_that_stays_warm_has_b_where_it_turns() -> None:
    s = found(MAKER.record(3000, top=0.8, bottom=0.4, cycles=2))
    assert not s.returns_cold
    assert s.heating_a == s.heating_b
    assert s.heating_b == pytest.approx(1500, abs=2)
    assert s.cooling_b == 2999
    assert s.transformation_fraction == pytest.approx(1.0)


def test_of_several_cycles_the_last_complete_one_is_taken() -> None:
    s = found(noisy(MAKER.record(6000, cycles=3), 1e-3, 3e-3))
    assert (s.cycle, s.cycles_found) == (2, 3)
    assert 4000 <= s.heating_b < s.cooling_b < 6000


def test_a_cycle_can_be_asked_for_by_name_or_number() -> None:
    small, large = MAKER.record(1000, top=0.7), MAKER.record(1000, top=1.2)
    loop = Loop(
        np.concatenate([small.resistance_ohm, large.resistance_ohm, small.resistance_ohm]),
        np.concatenate([small.strain, large.strain, small.strain]),
        np.arange(3000.0),
    )
    assert [found(loop, name).cycle for name in ("first", "largest", "last", 1, -1)] == [0, 1, 2, 1, 2]
    assert len(find_loops(loop.resistance_ohm, loop.strain)) == 3
    with pytest.raises(CallerError, match="holds 3"):
        found(loop, 3)
    with pytest.raises(CallerError, match="'largest'"):
        found(loop, "biggest")


def test_a_recording_that_starts_hot_gives_its_one_loop() -> None:
    loop = MAKER.record(1800, start=0.5)
    s = found(loop)
    assert s.cooling_c < s.cooling_b <= s.cooling_a <= s.heating_a < s.heating_b < s.heating_c
    assert strains(loop, s) == pytest.approx([0, 15, 100, 100, 15, 0], abs=1.0)


@pytest.mark.parametrize("start", [0.1, 0.25, 0.4, 0.6, 0.75, 0.9])
def test_two_cycles_from_any_phase_hold_one_complete_loop(start: float) -> None:
    loop = noisy(MAKER.record(3600, cycles=2, start=start), 5e-4, 2e-3)
    s = found(loop)
    assert s.transformation_fraction == pytest.approx(0.85, abs=0.03)
    assert s.complete


def test_uneven_sampling_changes_nothing() -> None:
    keep = np.sort(np.random.default_rng(5).choice(40_000, 1500, replace=False))
    loop = picked(MAKER.record(40_000), keep)
    assert strains(loop, found(loop)) == pytest.approx([0, 15, 100, 100, 15, 0], abs=2.0)


@pytest.mark.parametrize("noise", [0.0, 1e-3])
@pytest.mark.parametrize("top", [1.2, 0.9])
def test_long_rests_at_both_ends_stay_out_of_the_branches(noise: float, top: float) -> None:
    ramp = np.linspace(0, top, 1000)
    progress = np.concatenate([np.zeros(2000), ramp, np.full(3000, top), ramp[::-1], np.zeros(2000)])
    loop = noisy(MAKER.along(progress), noise, 3 * noise)
    s = found(loop)
    assert 1950 <= s.heating_a <= 2050
    assert s.heating_b == pytest.approx(2000 + 1000 * 0.15 / top, abs=25)
    assert s.cooling_b == pytest.approx(7000 - 1000 * 0.15 / top, abs=25)
    assert s.strain_cold == pytest.approx(0.0, abs=0.001)


def test_samples_without_current_are_left_out_and_indices_stay_those_of_the_recording() -> None:
    loop = MAKER.record(2000)
    valid = np.ones(2000, dtype=bool)
    valid[:60] = valid[-60:] = False
    valid[::7] = False
    resistance = np.where(valid, loop.resistance_ohm, 0.0)
    s = find_segments(resistance, loop.strain, valid)
    reference = found(loop)
    assert s.heating_b == pytest.approx(reference.heating_b, abs=2)
    assert s.cooling_b == pytest.approx(reference.cooling_b, abs=2)
    assert valid[[s.heating_a, s.heating_b, s.heating_c, s.cooling_c, s.cooling_b, s.cooling_a]].all()


SLOW, RANDOM = MAKER.record(), np.random.default_rng(0)
WARMTH = (1 - np.cos(np.linspace(0, 4 * np.pi, 3600))) / 2
NAN_AT_77 = np.where(np.arange(1800) == 77, np.nan, SLOW.resistance_ohm)


@pytest.mark.parametrize(
    ("resistance", "strain", "message"),
    [
        (SLOW.resistance_ohm, -SLOW.strain, r"wrong sign.*negate"),
        (SLOW.resistance_ohm, 0.05 - SLOW.strain, r"wrong sign.*negate"),
        (16 + 0.01 * RANDOM.normal(size=500), 1e-5 * RANDOM.normal(size=500), r"^no transformation: the strain moves"),
        (17.0 + 0.5 * WARMTH, -2e-4 * WARMTH, r"^no transformation"),
        (np.full(1800, 16.0), SLOW.strain, r"^no transformation"),
        (SLOW.resistance_ohm[:900], SLOW.strain[:900], r"no complete cycle.*heating from 0 to"),
        (np.ones(15), np.ones(15), "15 usable samples of 15: a loop needs at least 20"),
        (np.array([]), np.array([]), "0 usable samples of 0"),
        (NAN_AT_77, SLOW.strain, "first at index 77"),
        (np.ones(30), np.ones(31), "equal length"),
    ],
    ids=[
        *("negative", "reversed", "within noise", "expansion alone", "flat", "half a cycle"),
        *("few", "none", "not a number", "unequal"),
    ],
)
def test_columns_that_hold_no_loop_are_refused(resistance: np.ndarray, strain: np.ndarray, message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        find_segments(resistance, strain)


@pytest.mark.parametrize("seed", range(6))
def test_a_resistance_that_is_only_noise_is_no_transformation(seed: int) -> None:
    flat = Loop(np.full(1800, 16.0), SLOW.strain, SLOW.time_s)
    with pytest.raises(RecordingError, match=r"^no transformation"):
        found(noisy(flat, 2e-3, 1e-3, seed))


@settings(deadline=None, max_examples=60)
@given(
    scale=st.floats(0.05, 50),
    stroke=st.floats(1e-4, 50),
    samples=st.integers(200, 3000),
    top=st.floats(0.5, 1.5),
)
def test_units_of_neither_axis_matter(scale: float, stroke: float, samples: int, top: float) -> None:
    loop = MAKER.record(samples, top=top)
    plain = found(loop)
    scaled = find_segments(scale * loop.resistance_ohm, stroke * loop.strain)
    assert scaled.heating_b == pytest.approx(plain.heating_b, abs=2)
    assert scaled.cooling_c == pytest.approx(plain.cooling_c, abs=2)
    assert scaled.transformation_fraction == pytest.approx(plain.transformation_fraction, abs=0.02)


@settings(deadline=None, max_examples=60)
@given(
    resistance=st.lists(st.floats(1, 100), min_size=25, max_size=60),
    seed=st.integers(0, 100),
)
def test_any_columns_give_segments_or_a_recording_error_in_one_line(resistance: list[float], seed: int) -> None:
    strain = np.random.default_rng(seed).random(len(resistance))
    try:
        s = find_segments(resistance, strain)
    except RecordingError as error:
        one_line = "\n" not in str(error)
    else:
        one_line = s.resistance_max_ohm > s.resistance_min_ohm
    assert one_line


def test_a_turn_found_too_early_by_a_sticking_strain_is_moved_to_the_least_resistance() -> None:
    """The guide holds the strain while the wire still pulls: strain noise alone would pick the turn."""
    up, down = np.linspace(0, 0.9, 900), np.linspace(0.9, 0, 120)
    loop = MAKER.along(np.concatenate([up, down]))
    strain = loop.strain.copy()
    strain[800:900] = strain[800]
    strain[850] += 1e-5
    s = find_segments(loop.resistance_ohm, strain)
    assert s.heating_c == pytest.approx(900, abs=2)
    assert not s.complete
