"""A recording played back as a rig: the same bits, the same decisions, the same protection."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import musclewire as mw
from musclewire.controllers import Event, staircase
from musclewire.errors import CallerError, RecordingError, RigError
from musclewire.experiment import WaveformPolicy, run_on_rig
from musclewire.rigs import GuardedRig, ProtectionTripError
from musclewire.signals import RawSample, Recording

Replay = Callable[..., GuardedRig]
TARGETS = (0.010, 0.020, 0.005)


@pytest.fixture(scope="module")
def driven() -> Recording:
    """Three seconds of the paper's wire, warmed and let go."""
    with mw.open_rig("simulated", seed=3) as rig:
        return run_on_rig(rig, WaveformPolicy(lambda time_s: 2.0 if time_s < 2.0 else 0.3, 3.0), 3.0)


@pytest.fixture(scope="module")
def closed_loop() -> tuple[mw.SensingModel, Recording]:
    """A closed loop on the paper's wire, with its model."""
    with mw.open_rig("simulated", seed=3) as rig:
        model = mw.fit(mw.characterize(rig, period_s=30.0))
    with mw.open_rig("simulated", seed=4) as rig:
        return model, mw.control(rig, model, staircase(*TARGETS), approach_s=4.0)


@pytest.fixture
def replay(tmp_path: Path) -> Replay:
    """Return what opens the replay of a recording by a rig file, with more lines in it."""

    def opened(recording: Recording, more: str = "", suffix: str = ".h5") -> GuardedRig:
        recording.save(tmp_path / f"recorded{suffix}")
        (tmp_path / "replay.toml").write_text(f'kind = "replay"\nrecording = "recorded{suffix}"\n{more}', "utf-8")
        return mw.open_rig(tmp_path / "replay.toml")

    return opened


def changed(recording: Recording, name: str, first_row: int, last_row: int | None, value: float) -> Recording:
    """Return a recording with some cells of a column overwritten."""
    values = np.array(recording[name])
    values[first_row:last_row] = value
    return recording.with_columns({name: values})


def play(rig: GuardedRig, recording: Recording) -> list[RawSample]:
    """Ask a rig for the drives of a recording, one after the other."""
    return [rig.exchange(float(drive_v)) for drive_v in recording["drive_voltage_v"]]


@pytest.mark.parametrize("suffix", [".h5", ".csv"])
def test_every_sample_comes_back_to_the_bit(driven: Recording, replay: Replay, suffix: str) -> None:
    with replay(driven, suffix=suffix) as rig:
        samples = play(rig, driven)
    for name in ("time_s", "drive_voltage_v", "wire_voltage_v", "shunt_voltage_v", "displacement_m", "force_n"):
        assert np.array([getattr(sample, name) for sample in samples]).tobytes() == driven[name].tobytes(), name


def test_the_same_model_makes_the_same_decisions_to_the_bit(
    closed_loop: tuple[mw.SensingModel, Recording], replay: Replay
) -> None:
    model, recorded = closed_loop
    with replay(recorded) as rig:
        again = mw.control(rig, model, staircase(*TARGETS), approach_s=4.0)
    assert again.names == recorded.names
    for name in recorded.names:
        assert again[name].tobytes() == recorded[name].tobytes(), name
    assert again.metadata["replay_differences"] == 0


def test_another_controller_is_found_out_where_it_first_differs(
    closed_loop: tuple[mw.SensingModel, Recording], replay: Replay
) -> None:
    model, recorded = closed_loop
    with replay(recorded) as rig, pytest.raises(RigError, match=r"asked at .* was recorded: replay with the same"):
        mw.control(rig, model, staircase(0.012, 0.022, 0.005), approach_s=4.0)


def test_differences_may_be_reported_instead(closed_loop: tuple[mw.SensingModel, Recording], replay: Replay) -> None:
    model, recorded = closed_loop
    with replay(recorded, 'on_difference = "report"') as rig:
        again = mw.control(rig, model, staircase(0.012, 0.022, 0.005), approach_s=4.0)
    assert again.metadata["replay_differences"] > 10
    assert again.metadata["replay_largest_difference_v"] > 0.1
    assert 0.0 < again.metadata["replay_first_difference_s"] < 10.0
    assert again["wire_voltage_v"].tobytes() == recorded["wire_voltage_v"].tobytes()


def test_the_end_of_the_recording_is_an_error_that_says_so(driven: Recording, replay: Replay) -> None:
    with replay(driven) as rig:
        assert len(play(rig, driven)) == 60
        with pytest.raises(RigError, match=r"ends after 60 samples \(it ended 'done'\)"):
            rig.exchange(0.3)
    with replay(driven) as rig, pytest.raises(RigError, match="ends after 60 samples") as caught:
        run_on_rig(rig, WaveformPolicy(lambda time_s: 2.0 if time_s < 2.0 else 0.3, 3.0), 4.0)
    assert len(caught.value.recording) == 60


@pytest.mark.parametrize(
    ("event", "column", "last_row", "value"),
    [
        pytest.param(Event.WIRE_OPEN, "shunt_voltage_v", None, 0.0, id="the wire breaks"),
        pytest.param(Event.READING_NOT_FINITE, "wire_voltage_v", None, np.nan, id="a channel gives no number"),
        pytest.param(Event.CLOCK_BACKWARDS, "time_s", 21, 0.1, id="the clock runs back"),
        pytest.param(Event.WIRE_SHORT, "shunt_voltage_v", None, 1.9, id="the wire is bridged"),
    ],
)
def test_the_protection_sees_what_went_wrong_in_a_recording_within_half_a_second(
    driven: Recording, replay: Replay, event: Event, column: str, last_row: int | None, value: float
) -> None:
    broken = changed(driven, column, 20, last_row, value)
    with replay(broken) as rig:
        with pytest.raises(ProtectionTripError) as caught:
            play(rig, broken)
        assert caught.value.event is event
        assert rig.drive_voltage_v == 0.0
        assert 20 < len(broken) - rig.device.samples_left <= 30  # type: ignore[attr-defined]


def test_the_metadata_are_those_of_the_recorded_rig(driven: Recording, replay: Replay) -> None:
    rig = replay(driven)
    facts = rig.metadata()
    assert facts["rig"] == "replay"
    assert facts["replayed_rig"] == "simulated"
    assert facts["replayed_recording"] == "recorded.h5"
    for key in ("wire", "wire_length_m", "pretension_n", "shunt_resistance_ohm", "seed"):
        assert facts[key] == driven.metadata[key]
    assert "ended" not in facts
    with mw.open_rig("simulated") as original:
        assert rig.protection_limits == original.protection_limits


def test_a_recording_from_elsewhere_needs_a_rig_file_that_says_the_rest(driven: Recording, replay: Replay) -> None:
    no_shunt = {name: values for name, values in driven.columns.items() if name != "shunt_voltage_v"}
    with pytest.raises(RecordingError, match="shunt_voltage_v"):
        replay(Recording(no_shunt, driven.metadata))
    foreign = Recording(driven.columns, {"wire": "paper-100um", "ended": "done"})
    with pytest.raises(RecordingError, match="does not say its shunt_resistance_ohm: give shunt in the rig file"):
        replay(foreign)
    more = """
        shunt = "1 ohm"
        wire_length = "160 mm"
        legs = 2
        sense_voltage = "0.3 V"
        maximum_voltage = "3.4 V"
        drive_amplitude = "3.2 V"
    """
    with replay(foreign, more) as rig:
        assert rig.sample_period_s == pytest.approx(0.05)
        assert rig.leg_length_m == pytest.approx(0.08)
        assert rig.maximum_voltage_v == pytest.approx(3.4)
        assert len(play(rig, foreign)) == len(foreign)


def test_a_limit_in_the_rig_file_counts_before_that_of_the_recorded_rig(driven: Recording, replay: Replay) -> None:
    rig = replay(driven, '[limits]\nmaximum_current = "50 mA"\n')
    with rig, pytest.raises(ProtectionTripError, match="more current") as caught:
        play(rig, driven)
    assert caught.value.event is Event.OVER_CURRENT


def test_a_typo_in_the_rig_file_and_a_paced_replay_are_refused(driven: Recording, replay: Replay) -> None:
    with pytest.raises(CallerError, match="on_difference"):
        replay(driven, 'on_diference = "report"')
    rig = replay(driven)
    with pytest.raises(CallerError, match="has no clock: leave out real_time"):
        mw.open_rig(rig.device._configuration, real_time=True)  # type: ignore[attr-defined]
