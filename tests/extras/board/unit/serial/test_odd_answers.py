"""What a sound board never says: refusals without a reason, ticks that run backwards, samples without a reading."""

from __future__ import annotations

import pytest
from tests.extras.board.unit.serial.board_in_memory import BoardInMemory, configuration, driven, rig_on

from musclewire.controllers import Event
from musclewire.errors import CallerError, RigError
from musclewire.extras.board import Board, MessageKind, SerialDevice, SerialFrame
from musclewire.rigs import ProtectionTripError

NO_SUCH_COMMAND = 2


def test_a_heater_that_lives_shorter_than_a_sample_period_is_refused() -> None:
    with pytest.raises(CallerError, match="without a command for longer than its heater lives, 40 ms"):
        rig_on(BoardInMemory(expiry_ms=40))


def test_a_board_that_cannot_be_switched_off_at_the_start_is_not_opened() -> None:
    with pytest.raises(RigError, match=f"answered {NO_SUCH_COMMAND} to OFF: its firmware"):
        rig_on(BoardInMemory(answers={MessageKind.OFF: NO_SUCH_COMMAND}))


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
