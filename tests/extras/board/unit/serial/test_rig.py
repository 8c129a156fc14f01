"""The serial rig on a line that loses, delays and lies; the healthy line is the contract suite's."""

from __future__ import annotations

import struct
import threading
import zlib
from typing import Any

import pytest
from tests.extras.board.unit.serial.board_in_memory import BoardInMemory, configuration, driven, rig_on

from musclewire.controllers import Event
from musclewire.errors import CallerError, RigError
from musclewire.extras.board import Board, MessageKind, SerialDevice, SerialFrame, encode_frame
from musclewire.rigs import GuardedRig, ProtectionTripError
from musclewire.signals import Target


def trip_of(rig: GuardedRig, drive_v: float = 1.0) -> Event:
    with pytest.raises(ProtectionTripError) as caught:
        rig.exchange(drive_v)
    assert rig.drive_voltage_v == 0.0
    return caught.value.event


def test_an_exchange_is_one_command_and_the_mean_of_its_samples_and_leaving_switches_off() -> None:
    board = BoardInMemory()
    with rig_on(board) as rig:
        assert board.state == 0
        sample = rig.exchange(1.6)
        assert board.state == 1
    assert (board.state, board.drive_v) == (0, 0.0)
    assert sample.time_s == pytest.approx(0.05)
    assert sample.drive_voltage_v == pytest.approx(1.6)
    assert sample.shunt_voltage_v == pytest.approx(0.1, abs=1e-4)
    assert sample.wire_voltage_v == pytest.approx(1.5, abs=1e-4)


def test_time_is_the_boards_ticks_also_when_its_counter_comes_round() -> None:
    board = BoardInMemory(tick=2**32 - 120)
    with rig_on(board) as rig:
        times = [rig.exchange(1.0).time_s for _ in range(6)]
    assert times == pytest.approx([0.05 * count for count in range(1, 7)])


def test_a_lost_sample_is_counted_and_the_others_speak_for_the_period() -> None:
    board, rig = driven()
    board.drop = {MessageKind.SAMPLE}
    assert rig.exchange(1.6).shunt_voltage_v == pytest.approx(0.1, abs=1e-4)
    assert rig.metadata()["lost_frames"] == 1


def test_a_lost_acknowledgement_costs_nothing_because_samples_carry_the_commands_number() -> None:
    board, rig = driven()
    board.drop = {MessageKind.ACKNOWLEDGEMENT}
    rig.exchange(1.1)
    assert rig.metadata()["repeated_commands"] == 0


@pytest.mark.parametrize("how", ["deaf", "unplugged"])
def test_a_board_that_goes_silent_is_lost_nobody_says_that_it_is_off_and_the_rig_stays_off(how: str) -> None:
    board, rig = driven()
    began_s = board.now_s
    setattr(board, how, True)
    with pytest.raises(ProtectionTripError, match="a board's drive expires by itself") as caught:
        rig.exchange(1.0)
    assert (caught.value.event, rig.drive_voltage_v) == (Event.DEVICE_LOST, 0.0)
    assert board.now_s - began_s < 0.5
    with pytest.raises(RigError, match="stays off"):
        rig.exchange(1.0)


def test_ctrl_c_while_the_board_follows_a_target_asks_it_for_the_sense_voltage(monkeypatch: pytest.MonkeyPatch) -> None:
    board = BoardInMemory()

    def interrupted(_timeout_s: float) -> bytes:
        raise KeyboardInterrupt

    with rig_on(board) as rig:
        rig.exchange(Target(0.02))
        with monkeypatch.context() as patched:
            patched.setattr(board, "read", interrupted)
            with pytest.raises(KeyboardInterrupt):
                rig.exchange(Target(0.03))
        assert board.commands[-1][0] == MessageKind.DRIVE
        assert struct.unpack("<f", board.commands[-1][1])[0] == pytest.approx(rig.sense_voltage_v)


def test_a_board_that_is_gone_when_a_run_ends_is_an_error() -> None:
    board = BoardInMemory()

    def run() -> None:
        with rig_on(board) as rig:
            rig.exchange(1.0)
            board.unplugged = True

    with pytest.raises(RigError, match="did not answer at the end"):
        run()


@pytest.mark.parametrize("event", [Event.WIRE_OPEN, Event.OVER_CURRENT, Event.LINK_CORRUPTED, Event.COMMAND_MISSING])
def test_what_trips_on_the_board_is_raised_with_its_cause(event: Event) -> None:
    board, rig = driven()
    board.trip(event)
    assert trip_of(rig) is event


def test_a_lost_event_is_still_seen_in_the_samples() -> None:
    board, rig = driven()
    board.state, board.event = 4, Event.OVER_TEMPERATURE.value
    board.run(10)
    assert trip_of(rig) is Event.OVER_TEMPERATURE


@pytest.mark.parametrize(("at_reset", "event"), [(20, Event.WATCHDOG), (21, Event.POWER_LOST), (0, Event.POWER_LOST)])
def test_a_board_that_starts_anew_in_a_run_ends_it_with_the_reason(at_reset: int, event: Event) -> None:
    board, rig = driven()
    board.state, board.event_at_reset, board.tick = 0, at_reset, 0
    board.identify()
    assert trip_of(rig) is event


def test_a_restart_whose_message_was_lost_is_found_by_the_refused_command() -> None:
    board, rig = driven()
    board.state, board.event_at_reset, board.tick = 0, 20, 0
    assert trip_of(rig) is Event.WATCHDOG


def test_a_pause_lets_the_heater_expire_and_the_next_exchange_arms_again() -> None:
    board = BoardInMemory()
    with rig_on(board) as rig:
        rig.exchange(2.0)
        rig.make_safe()
        assert board.drive_v == pytest.approx(0.3)
        assert rig.drive_voltage_v == 0.3
        board.state, board.event = 4, Event.COMMAND_MISSING.value
        board.trip(Event.COMMAND_MISSING)
        assert rig.exchange(1.0).drive_voltage_v == pytest.approx(1.0)


def test_a_trip_of_an_earlier_session_does_not_keep_a_new_one_from_running() -> None:
    board = BoardInMemory(state=4, event=Event.LINK_CORRUPTED.value, stream_every=10)
    with rig_on(board) as rig:
        board.run(10)
        assert rig.exchange(1.0).drive_voltage_v == pytest.approx(1.0)


def test_what_the_board_sees_in_a_pause_ends_the_next_exchange() -> None:
    board, rig = driven()
    rig.make_safe()
    board.trip(Event.WIRE_SHORT)
    assert trip_of(rig) is Event.WIRE_SHORT


def test_a_trip_told_behind_the_end_of_a_period_is_the_cause_of_the_refused_command() -> None:
    board, rig = driven()
    board.state, board.event = 4, Event.OVER_POWER.value
    board.trip(Event.OVER_POWER)
    rig.device._unread.extend(rig.device._board.receive(0.0))
    assert trip_of(rig) is Event.OVER_POWER


def test_a_storm_of_broken_frames_trips_and_a_few_do_not() -> None:
    board, rig = driven()
    board.waiting += b"\x05ab\0" * 15
    rig.exchange(1.0)
    assert rig.metadata()["broken_frames"] == 15
    board, rig = driven()
    board.waiting += b"\x05ab\0" * 16
    assert trip_of(rig) is Event.LINK_CORRUPTED


def test_broken_frames_far_apart_are_no_storm() -> None:
    line = BoardInMemory()
    board = Board(line, line.clock_s)
    for _ in range(40):
        line.waiting += b"\x05ab\0"
        board.receive(0.0)
        line.now_s += 0.02
    line.now_s += 1.0
    for _ in range(15):
        line.waiting += b"\x05ab\0"
        board.receive(0.0)
        line.now_s += 0.005
    line.waiting += b"\x05ab\0"
    with pytest.raises(RigError, match="16 broken frames within"):
        board.receive(0.0)


ANOTHER_WIRE = (
    "built for wire flexinol-0.15-lt and the rig file says paper-100um: flash the firmware of the wire that is"
)


@pytest.mark.parametrize(
    ("board", "rig_file", "error", "said"),
    [
        ({"deaf": True}, {}, RigError, "check port, baud rate and that the board runs the firmware"),
        ({"answers": {MessageKind.OFF: 2}}, {}, RigError, "answered 2 to OFF: its firmware"),
        ({"expiry_ms": 40}, {}, CallerError, "without a command for longer than its heater lives, 40 ms"),
        ({"wire": "flexinol-0.15-lt"}, {}, CallerError, ANOTHER_WIRE),
        ({}, {"shunt": 2.0}, CallerError, "shunt is 2 ohm in the rig file and 1 ohm"),
        ({}, {"maximum_voltage": 6.0}, CallerError, "maximum_voltage is 6 V in the rig file"),
        ({}, {"sample_period": 0.0405}, CallerError, "whole number of the board's ticks"),
        # Every fault is to end off within half a second.
        ({}, {"sample_period": 0.1}, ValueError, r"must be 0\.05 s or less"),
    ],
)
def test_a_board_and_a_rig_file_that_do_not_go_together_are_not_opened(
    board: dict[str, Any], rig_file: dict[str, Any], error: type[Exception], said: str
) -> None:
    with pytest.raises(error, match=said):
        rig_on(BoardInMemory(**board), **rig_file)


@pytest.mark.parametrize(("version", "advice"), [(3, "update musclewire"), (1, "update the firmware")])
def test_another_protocol_version_says_which_side_to_update(version: int, advice: str) -> None:
    line = BoardInMemory(deaf=True)
    body = bytes([version, MessageKind.IDENTITY, *[1] * 61])
    body += struct.pack("<I", zlib.crc32(body))
    line.waiting += bytes([len(body) + 1]) + body + b"\0"  # a frame without a zero in it needs no more stuffing
    with pytest.raises(RigError, match=advice):
        rig_on(line)


def test_targets_go_to_the_board_and_its_drive_comes_back() -> None:
    board = BoardInMemory()
    with rig_on(board) as rig:
        sample = rig.exchange(Target(0.02))
        assert sample.drive_voltage_v == pytest.approx(1.0)
        assert board.target == pytest.approx(0.02)
        assert rig.device.board_estimate == pytest.approx(0.01)


def test_a_drive_out_of_range_never_reaches_the_board() -> None:
    board, rig = driven()
    sent = len([kind for kind, _ in board.commands if kind == MessageKind.DRIVE])
    assert trip_of(rig, 4.5) is Event.COMMAND_REFUSED
    assert len([kind for kind, _ in board.commands if kind == MessageKind.DRIVE]) == sent


def test_every_command_starts_with_a_zero_that_ends_what_a_disturbance_left() -> None:
    line = BoardInMemory()
    line.parser.feed(b"\x55\x55")
    Board(line, line.clock_s).send(MessageKind.HELLO)
    assert [kind for kind, _ in line.commands] == [MessageKind.HELLO]
    assert encode_frame(SerialFrame(MessageKind.HELLO, 1, b"")).endswith(b"\0")


def test_a_stop_is_sent_while_a_sample_is_awaited_and_its_answer_ends_the_wait() -> None:
    """By a line that gives nothing until OFF has been written, whatever the patience."""
    waits = threading.Event()

    class Blocking(BoardInMemory):
        """A board whose line waits for real, without any samples."""

        blocked = False

        def read(self, timeout_s: float) -> bytes:
            if self.blocked:
                waits.set()
                assert stopped.wait(60.0)
            return super().read(timeout_s)

        def obey(self, frame: SerialFrame) -> None:
            super().obey(frame)
            if frame.kind == MessageKind.OFF and self.blocked:
                stopped.set()

    stopped = threading.Event()
    board = Blocking()
    rig = rig_on(board)
    rig.exchange(1.0)
    board.blocked = True
    ended: list[RigError] = []

    def exchange() -> None:
        with pytest.raises(RigError) as caught:
            rig.exchange(2.0)
        ended.append(caught.value)

    thread = threading.Thread(target=exchange)
    thread.start()
    assert waits.wait(60.0)
    rig.close()
    thread.join(60.0)
    assert "was closed while a sample was awaited; the drive is off" in str(ended[0])
    assert board.drive_v == 0.0


def test_once_0_v_is_ordered_no_other_command_goes_out() -> None:
    line = BoardInMemory()
    board = Board(line, line.clock_s)
    board.order_off()
    for kind in (MessageKind.ARM, MessageKind.HELLO):
        with pytest.raises(RigError, match="the line is to be closed"):
            board.send(kind)
    with pytest.raises(RigError, match="the line is to be closed"):
        board.send_drive(1.0)
    board.send(MessageKind.OFF)
    assert {kind for kind, _ in line.commands} == {MessageKind.OFF}


def test_after_a_late_sample_the_next_is_due_on_the_grid_and_not_at_once() -> None:
    device = SerialDevice(configuration(), Board(board := BoardInMemory(), board.clock_s), board.clock_s)
    device._ticks, device._frames = 100, 1
    ticks = [100, 150, 200, 450, 470, 500, 560, 600]
    assert [tick for tick in ticks if device._is_over(tick)] == [100, 200, 450, 500, 600]
