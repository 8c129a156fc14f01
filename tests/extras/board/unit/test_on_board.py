"""A run whose targets go to a board: what is ready before the board is armed, and what the recording says."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from tests.extras.board.unit.serial.board_in_memory import BoardInMemory, rig_on

from musclewire.errors import CallerError
from musclewire.experiment import Decision, run_on_rig
from musclewire.extras.board import MessageKind, SerialFrame
from musclewire.rigs import open_rig
from musclewire.signals import Command, RawSample, Target, journal_of


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
