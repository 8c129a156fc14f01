"""Runs, corrections and odd answers of a board in memory."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from firmware.build import MODELS
from tests.extras.board.unit.serial.board_in_memory import BoardInMemory, configuration, driven, rig_on

from musclewire.controllers import Event, staircase
from musclewire.errors import CallerError, RigError
from musclewire.experiment import Decision, control_on_board, run_on_rig
from musclewire.extras.board import Board, MessageKind, SerialDevice, SerialFrame
from musclewire.rigs import GuardedRig, HasOnBoardLoop, ProtectionTripError, ability, open_rig
from musclewire.sensing import Correction, load_model
from musclewire.signals import Command, RawSample, Target, journal_of

# A run whose targets go to a board: what is ready before the board is armed, and what the recording says.


class OneTarget:
    """A policy that asks for the same strain all the time."""

    columns = ()

    def first_command(self) -> Command:
        return Target(0.01)

    def after(self, _sample: RawSample, _elapsed_s: float) -> Decision:
        return Decision(Target(0.01))


def test_the_file_is_made_before_the_board_is_armed_so_that_its_heater_does_not_expire_meanwhile(
    tmp_path: Path,
) -> None:
    path = tmp_path / "run.h5"
    there_when_armed = []

    class Watched(BoardInMemory):
        def obey(self, frame: SerialFrame) -> None:
            if frame.kind == MessageKind.ARM:
                there_when_armed.append(journal_of(path).exists())
            super().obey(frame)

    board = Watched()
    with rig_on(board) as rig:
        recording = run_on_rig(rig, OneTarget(), 0.25, path=path)
        assert recording.metadata["limit_maximum_voltage_v"] == rig.maximum_voltage_v
    assert there_when_armed == [True]
    assert len(recording) == 5
    targets = [struct.unpack("<f", payload)[0] for kind, payload in board.commands if kind == MessageKind.TARGET]
    assert targets == pytest.approx([0.01] * 5)


def test_a_target_is_refused_by_a_rig_without_a_loop_of_its_own_before_anything_is_heated() -> None:
    with open_rig("simulated") as rig:
        with pytest.raises(CallerError, match=r"a target of 0.01 \(strain\) needs a board"):
            run_on_rig(rig, OneTarget(), 0.25)
        assert rig.drive_voltage_v <= rig.sense_voltage_v
        assert rig.exchange(1.0).time_s == pytest.approx(rig.sample_period_s)


# A correction on its way to a board: told back, told again once the board is armed, refused by firmware without it.

UNKNOWN, OUT_OF_RANGE = 2, 3


def loop_on(rig: GuardedRig) -> HasOnBoardLoop:
    loop = ability(rig, HasOnBoardLoop)
    assert loop is not None
    return loop


def kinds(board: BoardInMemory) -> list[int]:
    return [kind for kind, _ in board.commands if kind in (MessageKind.ARM, MessageKind.CORRECT, MessageKind.DRIVE)]


def test_it_goes_out_at_once_and_again_after_each_arming_until_it_is_taken_back() -> None:
    board = BoardInMemory()
    arm, correct, drive = MessageKind.ARM, MessageKind.CORRECT, MessageKind.DRIVE
    with rig_on(board) as rig:
        loop_on(rig).correct(Correction(1.01, -0.002))
        assert kinds(board) == [correct]
        assert struct.unpack("<ff", board.commands[-1][1]) == pytest.approx((1.01, -0.002))
        rig.exchange(1.0)
        loop_on(rig).correct(Correction(1.02, 0.0))
        assert kinds(board) == [correct, arm, correct, drive, correct]
        rig.make_safe()  # which orders the sense voltage
        rig.exchange(1.0)
        assert kinds(board)[-3:] == [arm, correct, drive]
        loop_on(rig).correct(None)
        rig.make_safe()
        rig.exchange(1.0)
        assert kinds(board)[-2:] == [arm, drive]


@pytest.mark.parametrize("lost", [MessageKind.CORRECTION, MessageKind.ACKNOWLEDGEMENT])
def test_what_gets_lost_on_the_line_is_asked_for_again(lost: MessageKind) -> None:
    board = BoardInMemory()
    with rig_on(board) as rig:
        board.drop = {lost}
        loop_on(rig).correct(Correction(1.01))
        assert kinds(board) == [MessageKind.CORRECT] * 2


def test_a_board_that_tells_another_correction_back_is_not_believed() -> None:
    class Forgetful(BoardInMemory):
        """Takes every correction for none."""

        def tell(self, kind: int, payload: bytes) -> None:
            super().tell(kind, struct.pack("<ff", 1.0, 0.0) if kind == MessageKind.CORRECTION else payload)

    with rig_on(Forgetful()) as rig, pytest.raises(RigError, match="confirms another correction"):
        loop_on(rig).correct(Correction(1.01))


def test_one_that_the_board_finds_out_of_range_is_an_error() -> None:
    board, said = BoardInMemory(answers={MessageKind.CORRECT: OUT_OF_RANGE}), "3 to CORRECT: a number in it is out of"
    with rig_on(board) as rig, pytest.raises(RigError, match=said):
        loop_on(rig).correct(Correction(1.2))


def test_a_rig_that_is_closed_meanwhile_sends_none() -> None:
    board = BoardInMemory()
    with rig_on(board) as rig:
        device = rig.device
        assert isinstance(device, SerialDevice)
        device._board.order_off()
        loop_on(rig).correct(Correction(1.01))
        assert kinds(board) == []


@pytest.mark.parametrize("asked", [{"zero_from": "today"}, {"known_strain": (0.015, 2.0)}])
def test_firmware_that_knows_no_corrections_is_refused_before_it_is_armed(
    asked: dict[str, object], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    board = BoardInMemory(answers={MessageKind.CORRECT: UNKNOWN})
    monkeypatch.setattr(SerialDevice, "checksum_of", lambda *_: 7)
    model, reference = load_model(MODELS / "paper-100um.json"), staircase(0.015, 0.02, 0.005, 3.0)
    with rig_on(board) as rig:
        with pytest.raises(RigError, match=r"to CORRECT: its firmware does not know that yet, update it"):
            control_on_board(rig, model, reference, path=tmp_path / "run.h5", **asked)  # type: ignore[arg-type]
        assert kinds(board) == [MessageKind.CORRECT]
    assert list(tmp_path.iterdir()) == []


# What a sound board never says: refusals without a reason, ticks that run backwards, samples without a reading.

NO_SUCH_COMMAND = 2


def test_a_board_that_acknowledges_nothing_is_not_opened() -> None:
    class Speechless(BoardInMemory):
        """Greets, and never acknowledges."""

        def tell(self, kind: int, payload: bytes) -> None:
            if kind != MessageKind.ACKNOWLEDGEMENT:
                super().tell(kind, payload)

    with pytest.raises(RigError, match="did not answer to OFF"):
        rig_on(Speechless())


def test_a_board_that_does_not_know_the_command_ends_the_run_with_its_answer() -> None:
    board, rig = driven()
    board.answers = {MessageKind.DRIVE: NO_SUCH_COMMAND}
    with pytest.raises(ProtectionTripError, match=f"answered {NO_SUCH_COMMAND} to command") as caught:
        rig.exchange(1.0)
    assert caught.value.event is Event.COMMAND_REFUSED


@pytest.mark.parametrize(("says", "event"), [(True, Event.WATCHDOG), (False, Event.POWER_LOST)])
def test_a_refusal_is_explained_by_what_the_board_says_after_it(says: bool, event: Event) -> None:
    class Restarted(BoardInMemory):
        """Refuses a drive after its restart, and then greets or says nothing more."""

        def obey(self, frame: SerialFrame) -> None:
            super().obey(frame)
            if frame.kind == MessageKind.DRIVE and self.state == 0:
                self.identify() if says else setattr(self, "deaf", True)

    board = Restarted()
    rig = rig_on(board)
    rig.exchange(1.0)
    board.state, board.event_at_reset = 0, Event.WATCHDOG.value
    with pytest.raises(ProtectionTripError, match="started by" if says else "it gives no reason") as caught:
        rig.exchange(1.0)
    assert caught.value.event is event


def test_samples_without_a_reading_are_left_out_of_the_mean() -> None:
    board = BoardInMemory()
    with rig_on(board) as rig:
        rig.exchange(1.6)
        board.unreadable = 2
        sample = rig.exchange(1.6)
    assert sample.wire_voltage_v == pytest.approx(1.5, abs=1e-4)
    assert sample.shunt_voltage_v == pytest.approx(0.1, abs=1e-4)


def test_a_host_that_was_late_finds_its_lateness_in_the_time_of_the_sample() -> None:
    board = BoardInMemory()
    with rig_on(board) as rig:
        assert rig.exchange(1.0).time_s == pytest.approx(0.05)
        board.run(100)
        assert 0.15 < rig.exchange(1.0).time_s <= 0.2


def test_before_the_first_exchange_the_sense_voltage_is_not_ordered_and_nothing_is_known_of_the_wire() -> None:
    board = BoardInMemory()
    device = SerialDevice(configuration(), Board(board, board.clock_s), board.clock_s)
    assert (device.board_estimate, device.board_resistance_ohm, device.model_checksum) == (None, None, 7)
    assert device.sense()
    assert MessageKind.DRIVE not in [kind for kind, _ in board.commands]
    assert device.off()
    assert device.off()
