"""Whatever a rig, a callback or the user does, the rig ends at its sense voltage and nothing recorded is lost."""

from __future__ import annotations

import os
from dataclasses import replace
from errno import ENOSPC
from pathlib import Path

import pytest
from fake_rig import FakeRig, stop_after, straight_model

from musclewire.controllers import sampled_reference, staircase
from musclewire.errors import CallerError, RigError
from musclewire.experiment import WaveformPolicy, characterize, control, run_on_rig, run_warnings, slow_sine
from musclewire.sensing import SensingModel


@pytest.mark.parametrize(
    ("problem", "ended"),
    [
        (KeyboardInterrupt(), "interrupted"),
        (SystemExit(143), "interrupted"),
        (ZeroDivisionError("a callback of the user"), "ZeroDivisionError: a callback of the user"),
    ],
)
def test_a_callback_that_raises_leaves_the_rig_safe_and_the_recording_on_the_exception(
    problem: BaseException, ended: str
) -> None:
    rig = FakeRig()
    with pytest.raises(type(problem)) as caught:
        characterize(rig, period_s=10.0, on_sample=stop_after(57, problem))
    assert rig.drive_voltage_v == rig.sense_voltage_v
    recording = caught.value.recording  # type: ignore[attr-defined]
    assert len(recording) == 57
    assert recording.metadata["ended"] == ended
    assert any("57 samples" in note for note in caught.value.__notes__)


@pytest.mark.parametrize("failing_sample", [0, 1, 30])
def test_a_rig_that_fails_is_made_safe_too(failing_sample: int) -> None:
    rig = FakeRig(fails_at=failing_sample)
    with pytest.raises(OSError, match="cable"):
        characterize(rig, period_s=10.0)
    assert rig.safe_calls >= 1
    assert rig.drive_voltage_v == rig.sense_voltage_v


def test_a_recording_that_cannot_be_put_anywhere_is_refused_before_anything_is_heated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig, closed = FakeRig(), tmp_path / "closed"
    (tmp_path / "old.h5").write_bytes(b"precious")
    (tmp_path / "cut.h5.journal").write_bytes(b"precious")
    closed.mkdir()
    monkeypatch.setattr("os.access", lambda folder, _: Path(folder) != closed)
    for path, message in (
        (tmp_path / "old.h5", "exists"),
        (tmp_path / "nowhere" / "new.h5", "no folder"),
        (closed / "new.h5", "cannot be written to"),
        (tmp_path / "cut.h5", "musclewire recover"),
    ):
        with pytest.raises(CallerError, match=message):
            characterize(rig, period_s=5.0, path=path)
    assert rig.samples == 0


@pytest.fixture
def _disk_full(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the disk take the beginning of a journal and no row."""

    def full(descriptor: int, data: bytes) -> None:
        if os.lseek(descriptor, 0, os.SEEK_CUR):
            raise OSError(ENOSPC, "No space left on device")
        os.write(descriptor, data)

    monkeypatch.setattr("musclewire.signals._open_journal.write_all", full)


@pytest.mark.usefixtures("_disk_full")
def test_without_any_other_place_the_journal_is_named_with_the_rows_it_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "gone"))
    with pytest.raises(RigError) as caught:
        characterize(FakeRig(), period_s=5.0, path=tmp_path / "run.h5")
    assert caught.value.__notes__[0].endswith(r"run.h5.journal (the first 0)")


@pytest.mark.usefixtures("_disk_full")
def test_a_disk_that_takes_no_more_ends_the_run_safe_with_the_samples_on_the_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    rig = FakeRig()
    with pytest.raises(RigError, match=r"cannot write .*run\.h5: No space left on device") as caught:
        characterize(rig, period_s=5.0, path=tmp_path / "run.h5")
    assert rig.drive_voltage_v == rig.sense_voltage_v
    assert len(caught.value.recording) >= 1  # type: ignore[attr-defined]
    (rescued,) = tmp_path.glob("run-rescued-*.csv")
    assert any(str(rescued) in note for note in caught.value.__notes__)


def test_a_reference_shorter_than_a_sample_is_refused_before_anything_is_heated() -> None:
    rig = FakeRig()
    with pytest.raises(CallerError, match="less than one sample"):
        control(rig, straight_model(), sampled_reference([0.0], [0.02]))
    assert rig.samples == 0


def test_a_step_too_short_to_settle_has_no_error_rather_than_a_wrong_one() -> None:
    from musclewire.controllers import staircase

    metrics = control(FakeRig(), straight_model(), staircase(hold_s=1.0)).metrics
    assert {step.mae_pct for step in metrics.steps} == {None}
    assert metrics.mae_max_pct is None


def test_a_finished_run_ends_at_the_sense_voltage_and_leaving_the_block_switches_off() -> None:
    with FakeRig() as rig:
        recording = characterize(rig, period_s=5.0, cycles=2)
        assert rig.drive_voltage_v == rig.sense_voltage_v
        assert recording.metadata["ended"] == "done"
    assert rig.drive_voltage_v == 0.0


def test_a_wire_that_stays_without_current_ends_the_loop_as_a_rig_fault() -> None:
    rig = FakeRig(dropouts=range(400, 10_000))
    with pytest.raises(RigError, match="no current through the wire for 10 samples") as caught:
        control(rig, straight_model())
    assert rig.drive_voltage_v == rig.sense_voltage_v
    assert len(caught.value.recording) == 408  # type: ignore[attr-defined]


def test_a_moment_without_current_is_bridged_by_holding_the_drive() -> None:
    rig = FakeRig(dropouts=range(500, 508))
    run = control(rig, straight_model())
    part = slice(499, 507)
    assert (run["valid"][part] == 0.0).all()
    assert (run["wire_resistance_ohm"][part] == 0.0).all()
    assert len(set(run["drive_voltage_v"][part])) == 1
    assert run.metrics.valid_share < 1.0


def test_a_model_of_another_wire_is_stopped_before_it_can_overheat_this_one() -> None:
    """Found by trying: a resistance above the model's range reads as cold, and the drive went to its maximum."""
    rig = FakeRig()
    thick_wire = SensingModel(3.9, 4.4, (0.04, -0.04), (0.04, -0.04), 0.0, 1.0)
    with pytest.raises(RigError, match="is not this model's wire"):
        control(rig, thick_wire)
    assert rig.samples == 10
    assert rig.drive_voltage_v == rig.sense_voltage_v


@pytest.mark.parametrize(
    ("fitted_to", "said"),
    [
        ({"wire": "paper-200um"}, "fitted to wire paper-200um, the rig has paper-100um"),
        ({"finger": "another"}, "finger another, the rig has lan-fan-2010"),
    ],
)
def test_a_model_of_another_wire_length_or_finger_is_refused_before_anything_moves(
    fitted_to: dict[str, str | float], said: str
) -> None:
    class Named(FakeRig):
        def metadata(self):
            return {**super().metadata(), "wire": "paper-100um", "wire_length_m": 0.08, "finger": "lan-fan-2010"}

    rig = Named()
    with pytest.raises(CallerError, match=said):
        control(rig, replace(straight_model(), quantity="displacement", wire=fitted_to))
    assert rig.samples == 0


def test_the_drive_never_falls_below_the_sense_voltage_while_sensing() -> None:
    run = control(FakeRig(), straight_model())
    assert run["drive_voltage_v"].min() >= 0.3
    assert run["drive_voltage_v"].max() <= 3.6


def test_the_loop_reads_no_reference_instrument() -> None:
    class Liar(FakeRig):
        def exchange(self, command):
            return super().exchange(command)._replace(displacement_m=-1.0)

    honest, lied = control(FakeRig(), straight_model()), control(Liar(), straight_model())
    assert (honest["drive_voltage_v"] == lied["drive_voltage_v"]).all()


def test_a_slow_sine_starts_and_ends_at_the_sense_voltage_and_peaks_at_the_amplitude() -> None:
    drive = slow_sine(3.2, 0.3, 90.0)
    assert drive(0.0) == pytest.approx(0.3)
    assert drive(45.0) == pytest.approx(3.2)
    assert drive(90.0) == pytest.approx(0.3)
    assert min(drive(0.1 * step) for step in range(900)) >= 0.3


def test_cycles_are_numbered_from_one_and_the_last_sample_of_a_cycle_belongs_to_it() -> None:
    recording = run_on_rig(FakeRig(), WaveformPolicy(slow_sine(3.0, 0.3, 1.0), 1.0), 3.0)
    assert recording["cycle"].tolist() == [1.0] * 20 + [2.0] * 20 + [3.0] * 20


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"amplitude_v": 9.0}, "above the rig's maximum of 3.6 V"),
        ({"amplitude_v": 0.2}, "above the sense voltage"),
    ],
)
def test_a_slow_sine_that_cannot_be_is_the_callers_error(arguments: dict[str, float], message: str) -> None:
    rig = FakeRig()
    with pytest.raises(CallerError, match=message):
        characterize(rig, **arguments)  # type: ignore[arg-type]
    assert rig.samples == 0


def test_targets_outside_what_the_model_senses_are_refused_before_anything_moves() -> None:
    from musclewire.controllers import staircase

    rig = FakeRig()
    with pytest.raises(CallerError, match=r"from 3 to 6 %, but this model senses strain only from 0 to 4 %"):
        control(rig, straight_model(), staircase(0.03, 0.06))
    assert rig.samples == 0


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ({"pretension_n": 0.95}, "the rig states a pretension of 0.95 N, and the model was made at 1.9 N"),
        (
            {"pretension_n": 1.9, "spring_stiffness_n_per_m": 300.0},
            "a spring of 300 N/m, and the model was made at",
        ),
        ({"pretension_n": 1.91, "spring_stiffness_n_per_m": 590.0}, None),
        ({}, None),
    ],
)
def test_a_loop_on_another_load_than_the_models_says_so_and_does_not_hold(
    stated: dict[str, float], said: str | None
) -> None:
    class Loaded(FakeRig):
        def metadata(self):
            return {**super().metadata(), **stated}

    made_at = {"pretension_n": 1.9, "spring_stiffness_n_per_m": 588.6}
    run = control(Loaded(), replace(straight_model(), wire=made_at), staircase(0.015, 0.018, 0.003, 1.0))
    assert (said or "") in str(run.metadata.get("other_load", ""))
    assert ("other_load" in run.metadata) == (said is not None)
    assert any(said in one for one in run_warnings(run)) if said else True
