"""The minor loop of a characterization: where it turns, how it is driven, and that nothing of the slow loop changes."""

from __future__ import annotations

import numpy as np
import pytest
from fake_rig import FakeRig, stop_after

from musclewire.errors import RigError
from musclewire.experiment import characterize
from musclewire.experiment._minor_loop import TURN_BACK, TURN_UP, MinorLoopPolicy, MinorLoopTurns, turns_after
from musclewire.experiment._open_loop import MIN_FALL_FRACTION, raised_cosine
from musclewire.identify import fit, loop_gaps
from musclewire.judge import resistance_reading
from musclewire.rigs import open_rig
from musclewire.sensing import SensingModel
from musclewire.signals import MINOR_LOOP_FROM, NO_CYCLE, Drive, Recording

PERIOD_S, SAMPLES = 90.0, 1800
SINE = raised_cosine(3.2, 0.3, PERIOD_S)
TURNS = MinorLoopTurns(back_s=36.0, up_s=27.0)


# The drive.


def test_the_drive_goes_the_slow_sines_way_up_back_up_and_down() -> None:
    corners_s, drive = TURNS.corners_s, TURNS.drive_on(SINE)
    assert corners_s == (0.0, 36.0, 45.0, 54.0, 90.0)
    assert [drive(time_s) for time_s in corners_s] == [SINE(time_s) for time_s in (0.0, 36.0, 27.0, 36.0, 0.0)]
    assert drive(20.0) == SINE(20.0)
    assert drive(40.0) == drive(50.0) == SINE(32.0)
    assert drive(80.0) == pytest.approx(SINE(10.0))
    assert drive(91.0) == SINE(0.0)


def test_it_is_nowhere_faster_or_higher_than_the_slow_sine() -> None:
    time_s = np.arange(0.0, 90.0, 0.05)
    sine_v, drive_v = (np.array([one(each) for each in time_s]) for one in (SINE, TURNS.drive_on(SINE)))
    assert drive_v.max() <= sine_v.max()
    assert drive_v.min() >= sine_v.min()
    assert np.abs(np.diff(drive_v)).max() <= np.abs(np.diff(sine_v)).max() * (1.0 + 1e-9)


def test_its_rows_are_of_no_cycle_and_its_time_is_the_runs() -> None:
    policy = MinorLoopPolicy(TURNS.drive_on(SINE), 180.0)
    assert policy.first_command() == Drive(SINE(0.0))
    sample = FakeRig().exchange(1.0)
    assert policy.after(sample, 200.0) == (Drive(SINE(20.0)), (NO_CYCLE,))
    known = policy.known_drive((180.05, 200.0, 200.05))
    assert known.drives_v.tolist() == [SINE(0.0), TURNS.drive_on(SINE)(180.05 - 180.0), SINE(20.0)]
    assert known.values.tolist() == [[NO_CYCLE]] * 3


# Where it turns.


def cycles(way: np.ndarray, noise_ohm: float = 0.0, fall_ohm: float = 2.0) -> Recording:
    """Return two cycles in which the resistance falls by a part of so much from 17 ohm, with noise."""
    time_s = (1.0 + np.arange(2 * SAMPLES)) * PERIOD_S / SAMPLES
    random = np.random.default_rng(1)
    ohm = 17.0 - fall_ohm * np.tile(way, 2) + noise_ohm * random.standard_normal(2 * SAMPLES)
    return Recording({"time_s": time_s, "wire_resistance_ohm": ohm})


def there_and_back(up_s: float, down_s: float) -> np.ndarray:
    """Return a way up by a straight line until ``up_s`` of a cycle and down from ``down_s`` on until its end."""
    since_s = (1.0 + np.arange(SAMPLES)) * PERIOD_S / SAMPLES
    return np.clip(np.minimum(since_s / up_s, (PERIOD_S - since_s) / (PERIOD_S - down_s)), 0.0, 1.0)


@pytest.mark.parametrize("noise_ohm", [0.0, 0.02])
def test_it_turns_where_the_last_cycle_had_fallen_by_half_and_was_back_to_a_third(noise_ohm: float) -> None:
    turns = turns_after(cycles(there_and_back(40.0, 60.0), noise_ohm), PERIOD_S, MIN_FALL_FRACTION)
    assert turns is not None
    assert turns.back_s == pytest.approx(TURN_BACK * 40.0, abs=1.0)
    assert turns.up_s == pytest.approx(TURN_UP * 30.0, abs=1.0)


def test_a_wire_that_lags_behind_the_drive_turns_with_its_peak_at_the_latest() -> None:
    since_s = (1.0 + np.arange(SAMPLES)) * PERIOD_S / SAMPLES
    late = np.where(since_s < 60.0, np.clip((since_s - 40.0) / 20.0, 0.0, 1.0), np.clip((85.0 - since_s) / 25.0, 0, 1))
    turns = turns_after(cycles(late), PERIOD_S, MIN_FALL_FRACTION)
    assert turns is not None
    assert turns.back_s == 0.5 * PERIOD_S


@pytest.mark.parametrize(
    "recording",
    [
        cycles(there_and_back(40.0, 60.0), fall_ohm=0.9 * 17.0 * MIN_FALL_FRACTION),
        cycles(np.minimum(1.0, 2.0 * np.arange(SAMPLES) / SAMPLES)),  # it does not come back
        Recording({"time_s": np.arange(3.0), "wire_resistance_ohm": np.zeros(3)}),  # no current
    ],
    ids=["hardly falls", "stays", "no current"],
)
def test_without_a_transformation_there_and_back_there_is_none(recording: Recording) -> None:
    assert turns_after(recording, PERIOD_S, MIN_FALL_FRACTION) is None


# A characterization with it.


@pytest.fixture(scope="module")
def without() -> Recording:
    with open_rig("simulated") as rig:
        return characterize(rig, minor_loop=False)


def test_the_cycles_are_those_of_a_run_without_it_to_the_bit(loop: Recording, without: Recording) -> None:
    assert without.minor_loop is None
    assert MINOR_LOOP_FROM not in without.metadata
    assert loop.names == without.names
    for name in loop.names:
        np.testing.assert_array_equal(loop[name], without[name], strict=True)
    differ = {key for key in loop.metadata if loop.metadata[key] != without.metadata.get(key)}
    assert differ - {"start_time", "step_error_k"} == {MINOR_LOOP_FROM}  # the largest error of all steps of the run


def test_no_reader_of_the_cycles_sees_it(loop: Recording, without: Recording) -> None:
    assert repr(loop_gaps(loop)) == repr(loop_gaps(without))
    for cycle in ("last", "first", "largest", 1):
        one, other = fit(loop, cycle=cycle).report(), fit(without, cycle=cycle).report()
        laws = [found["wire_model"].pop("minor_loops") for found in (one, other)]
        assert one == other
        assert laws[0]["origin"] == "minor loops of this recording"
        assert laws[1]["origin"] == "any law is as likely: no minor loop shows it"


def test_it_turns_well_inside_the_hysteresis_within_the_drive_of_the_cycles(loop: Recording) -> None:
    minor = loop.minor_loop
    assert minor is not None
    assert minor["time_s"][0] == pytest.approx(loop["time_s"][-1] + 0.05)
    assert minor["drive_voltage_v"].max() < loop["drive_voltage_v"].max()
    assert minor.duration_s < 1.1 * PERIOD_S
    stroke_m, moved_m = np.ptp(loop["displacement_m"]), minor["displacement_m"] - loop["displacement_m"].min()
    half = len(minor) // 2
    assert 0.6 < moved_m.max() / stroke_m < 0.8
    assert 0.2 < moved_m[half - 100 : half + 100].min() / stroke_m < 0.4
    assert moved_m[-1] < 0.02 * stroke_m
    assert set(minor["cycle"]) == {NO_CYCLE}


def test_the_law_is_known_no_better_than_its_turns_agree(loop: Recording) -> None:
    wire = fit(loop).wire_model
    assert wire is not None
    assert 0.0 <= wire.minor_loops.value <= 1.0
    assert 0.0 < wire.minor_loops.std < 12.0**-0.5


@pytest.mark.parametrize("rows", [900, 1000, 1100])
def test_a_minor_loop_of_one_turn_and_a_part_knows_little(rows: int, loop: Recording) -> None:
    whole = loop.minor_loop
    assert whole is not None
    cut = loop.with_minor_loop.between(0, len(loop) + rows)
    found = fit(Recording(cut.columns, loop.metadata)).wire_model
    assert found is not None
    assert found.minor_loops.std > 0.12
    before = fit(loop).wire_model
    assert before is not None
    assert before.minor_loops.value == pytest.approx(found.minor_loops.value, abs=3.0 * found.minor_loops.std)
    assert 0.0 <= found.minor_loops.value <= 1.0


@pytest.mark.parametrize("rows", [1, 400])
def test_a_run_that_is_cut_off_in_it_has_a_whole_slow_loop(rows: int, without: Recording) -> None:
    with open_rig("simulated") as rig:
        with pytest.raises(KeyboardInterrupt) as caught:
            characterize(rig, on_sample=stop_after(len(without) + rows, KeyboardInterrupt()))
        assert rig.drive_voltage_v == rig.sense_voltage_v
    cut: Recording = caught.value.recording  # type: ignore[attr-defined]
    assert cut.metadata["ended"] == "interrupted"
    assert len(cut) == len(without)
    assert cut.minor_loop is not None
    assert len(cut.minor_loop) == rows
    found, whole = fit(cut), fit(without)
    assert found.heating_coefficients == whole.heating_coefficients
    assert found.warnings == whole.warnings


def test_a_run_that_is_cut_off_before_has_none() -> None:
    with pytest.raises(KeyboardInterrupt) as caught:
        characterize(FakeRig(), period_s=10.0, on_sample=stop_after(57, KeyboardInterrupt()))
    assert caught.value.recording.minor_loop is None  # type: ignore[attr-defined]
    asked = iter(range(100))
    ended = characterize(FakeRig(), period_s=10.0, until=lambda: next(asked) == 56)
    assert (len(ended), ended.minor_loop) == (57, None)


def test_a_run_that_is_ended_at_the_last_row_of_its_cycles_has_none() -> None:
    asked = iter(range(1000))
    ended = characterize(FakeRig(), period_s=10.0, until=lambda: next(asked) == 399)
    assert (len(ended), ended.minor_loop) == (400, None)


def test_a_rig_that_fails_in_it_is_made_safe_and_keeps_the_cycles() -> None:
    rig = FakeRig(fails_at=410)
    with pytest.raises(OSError, match="cable") as caught:
        characterize(rig, period_s=10.0)
    assert rig.drive_voltage_v == rig.sense_voltage_v
    cut = caught.value.recording  # type: ignore[attr-defined]
    assert len(cut) == 400
    assert len(cut.minor_loop) == 10


def test_a_replay_of_it_goes_all_the_way_again(tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("replay")
    with open_rig("simulated") as rig:
        loop = characterize(rig, period_s=30.0, cycles=1, path=folder / "loop.h5")
    (folder / "again.toml").write_text('kind = "replay"\nrecording = "loop.h5"\n')
    with open_rig(folder / "again.toml") as rig:
        again = characterize(rig, period_s=30.0, cycles=1)
        with pytest.raises(RigError, match="ends after"):
            rig.exchange(0.3)
    assert again.minor_loop is not None
    for name in ("wire_voltage_v", "displacement_m", "cycle"):
        np.testing.assert_array_equal(again.whole_columns[name], loop.whole_columns[name])


def test_a_model_of_force_takes_it_too(loop: Recording) -> None:
    found: SensingModel = fit(loop, quantity="force")
    assert found.wire_model is not None
    assert found.wire_model.minor_loops.origin == "minor loops of this recording"
    assert resistance_reading(loop).resistance_ohm.size == len(loop)
