"""A correction on its way to a board: told back, told again once the board is armed, refused by firmware without it."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from firmware.build import MODELS
from tests.extras.board.unit.serial.board_in_memory import BoardInMemory, rig_on

from musclewire.controllers import staircase
from musclewire.errors import RigError
from musclewire.experiment import control_on_board
from musclewire.extras.board import MessageKind, SerialDevice
from musclewire.rigs import GuardedRig, HasOnBoardLoop, ability
from musclewire.sensing import Correction, load_model

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
