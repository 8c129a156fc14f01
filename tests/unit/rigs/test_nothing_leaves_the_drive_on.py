"""No blind spot in the over-temperature protection, and no way out of an exchange that leaves the drive on."""

from __future__ import annotations

import linecache
import logging
import math
import sys
import threading
from types import FrameType
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.unit.rigs.ideal_wire import LIMITS, PERIOD_S, IdealWire

from musclewire.controllers import Event, State, largest_power_w_per_v2, protection_table
from musclewire.errors import CallerError, RigError
from musclewire.rigs import Answer, GuardedRig, Missing, ProtectionTripError
from musclewire.signals import Command, RawSample, Target

SENSE_V = LIMITS.sense_voltage_v
NONE_V = (math.nan, math.nan)


def unread(sample: RawSample) -> RawSample:
    return sample._replace(wire_voltage_v=math.nan, shunt_voltage_v=math.nan)


def hold(rig: GuardedRig, drive_v: float, time_s: float) -> Event:
    """Hold a drive for a time, or until the rig trips; return why."""
    try:
        for _ in range(round(time_s / PERIOD_S)):
            rig.exchange(drive_v)
    except ProtectionTripError as error:
        return error.event
    return Event.NONE


def most_allowed_k(drive_v: float) -> float:
    """The limit, what the largest drive adds in one sample and ``sense_after_s``, and 5 K."""
    rise_k_per_s = largest_power_w_per_v2(LIMITS) * drive_v**2 / LIMITS.heat_capacity_j_per_k
    return LIMITS.maximum_temperature_k + (PERIOD_S + protection_table().sense_after_s) * rise_k_per_s + 5.0


@given(
    st.lists(st.booleans(), min_size=1, max_size=12),
    st.floats(2.0, 6.0),
    st.floats(1.05 * LIMITS.resistance_low_ohm, 0.95 * LIMITS.resistance_high_ohm),
)
def test_the_wire_is_never_hotter_than_its_limit_whatever_readings_are_missing(
    missing: list[bool], drive_v: float, resistance_ohm: float
) -> None:
    device = IdealWire(
        lambda number, sample: unread(sample) if missing[number % len(missing)] else sample,
        resistance_ohm=resistance_ohm,
    )
    rig = GuardedRig(device)
    hold(rig, drive_v, 20.0)
    assert device.hottest_k <= most_allowed_k(drive_v)
    if rig.protection.state is not State.TRIPPED:
        assert rig.protection.temperature_k >= device.temperature_k - 1.0


@pytest.mark.parametrize("of_how_many", [2, 3, 4])
def test_readings_that_keep_missing_end_at_the_sense_voltage(of_how_many: int) -> None:
    device = IdealWire(lambda number, sample: unread(sample) if number % of_how_many == 0 else sample)
    rig = GuardedRig(device)
    assert hold(rig, 3.0, 4.0) is Event.NONE
    assert rig.exchange(3.0).drive_voltage_v == SENSE_V
    assert rig.protection.state is State.DEGRADED


def test_a_gap_that_ends_lets_the_drive_back_at_the_first_reading() -> None:
    device = IdealWire(lambda number, sample: unread(sample) if 40 <= number < 43 else sample)
    rig = GuardedRig(device)
    drives = [rig.exchange(3.0).drive_voltage_v for _ in range(50)]
    assert drives[42:44] == [SENSE_V, SENSE_V]
    assert drives[44:] == [3.0] * 6


def test_a_device_that_says_0_v_while_it_drives_is_not_believed() -> None:
    device = IdealWire(lambda _, sample: RawSample(sample.time_s, 0.0, 0.0, 0.0))
    assert hold(GuardedRig(device), 4.6, 60.0) is Event.SUPPLY_MISSING
    assert device.drive_voltage_v == 0.0
    assert device.hottest_k <= LIMITS.maximum_temperature_k


def test_a_device_that_says_more_than_was_ordered_is_stuck() -> None:
    device = IdealWire()
    device.put, honest = lambda drive_v: honest(max(drive_v, 4.0)), device.put  # type: ignore[method-assign]
    assert hold(GuardedRig(device), 1.0, 2.0) is Event.OUTPUT_STUCK


def test_a_drive_that_is_no_number_does_not_switch_the_judgement_off() -> None:
    device = IdealWire(lambda _, sample: RawSample(sample.time_s, math.nan, 1.0, 0.0))
    assert hold(GuardedRig(device), 3.0, 2.0) in (Event.WIRE_OPEN, Event.SUPPLY_MISSING)


# A host that is late by as much as the table permits has missed this and one sample more.
LONGEST_S = PERIOD_S + protection_table().trip_after_s


@pytest.mark.parametrize(
    ("clock", "event"),
    [
        (lambda number: 60.0 * number, Event.CLOCK_LEAPT),
        (lambda number: PERIOD_S * number + (1e6 if number > 40 else 0.0), Event.CLOCK_LEAPT),
        (lambda number: PERIOD_S * (number + 1) + (LONGEST_S + 0.01 if number > 40 else 0.0), Event.CLOCK_LEAPT),
        (lambda number: PERIOD_S * (number + 1) + (LONGEST_S - 0.01 if number > 40 else 0.0), Event.NONE),
        (lambda number: PERIOD_S * min(number, 40), Event.CLOCK_BACKWARDS),
        (lambda number: math.nan if number > 40 else PERIOD_S * number, Event.CLOCK_BACKWARDS),
    ],
)
def test_a_clock_that_leaps_is_a_fault_at_the_first_sample_after_it(clock: Any, event: Event) -> None:
    device = IdealWire(lambda number, sample: sample._replace(time_s=clock(number)))
    assert hold(GuardedRig(device), 3.0, 10.0) is event
    assert device.samples <= 42 or event is Event.NONE


def test_a_clock_that_runs_slow_takes_no_heat_away_and_a_quick_one_adds_it() -> None:
    for rate in (0.01, 1.0, 3.0):
        device = IdealWire(lambda number, sample, rate=rate: sample._replace(time_s=rate * PERIOD_S * number))  # type: ignore[misc]
        rig = GuardedRig(device)
        hold(rig, 3.0, 1.0)
        assert rig.protection.temperature_k >= device.temperature_k - 2.0


@pytest.mark.parametrize("waited_s", [-1.0, math.nan])
def test_a_wait_that_is_no_time_ends(waited_s: float) -> None:
    device = IdealWire(lambda number, sample: sample if number < 3 else Missing(Event.SAMPLE_LATE, waited_s, sample))
    assert hold(GuardedRig(device), 3.0, 1.0) is Event.DEVICE_LOST


WRONG = ("3", None, (1, 2), [1.0], 1j, True, np.True_, np.array([1.0, 2.0]), object(), b"1", {})


@pytest.mark.parametrize("wrong", WRONG, ids=lambda wrong: type(wrong).__name__)
def test_what_is_no_voltage_leaves_the_sense_voltage(wrong: Any) -> None:
    device = IdealWire()
    rig = GuardedRig(device)
    rig.exchange(3.0)
    with pytest.raises(CallerError, match="is no voltage"):
        rig.exchange(wrong)
    assert device.drive_voltage_v == SENSE_V
    assert rig.exchange(np.float32(1.5)).drive_voltage_v == 1.5


@pytest.mark.parametrize("answer", [None, (1.0, 2.0), "sample", 3.0], ids=lambda answer: type(answer).__name__)
def test_a_device_that_answers_no_sample_is_switched_off(answer: object) -> None:
    device = IdealWire(lambda number, sample: sample if number < 3 else answer)
    rig = GuardedRig(device)
    for _ in range(3):
        rig.exchange(4.6)
    with pytest.raises(RigError, match="where a sample is due"):
        rig.exchange(4.6)
    assert device.drive_voltage_v == 0.0


@pytest.mark.parametrize("field", ["wire_voltage_v", "shunt_voltage_v", "drive_voltage_v", "time_s"])
def test_a_sample_without_a_number_leaves_no_drive_on(field: str) -> None:
    device = IdealWire(lambda number, sample: sample if number < 3 else sample._replace(**{field: None}))
    rig = GuardedRig(device)
    for _ in range(3):
        rig.exchange(3.0)
    with pytest.raises((TypeError, RigError)):
        rig.exchange(3.0)
    assert device.drive_voltage_v <= SENSE_V


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit, MemoryError, ZeroDivisionError])
def test_whatever_a_device_raises_leaves_the_sense_voltage(error: type[BaseException]) -> None:
    def raises(number: int, sample: RawSample) -> RawSample:
        if number == 3:
            raise error
        return sample

    device = IdealWire(raises)
    rig = GuardedRig(device)
    for _ in range(3):
        rig.exchange(3.0)
    with pytest.raises(error):
        rig.exchange(3.0)
    assert device.drive_voltage_v == SENSE_V
    assert rig.exchange(3.0).drive_voltage_v == 3.0


class InterruptAt:
    """Raises KeyboardInterrupt at the n-th line with a call that runs within an exchange, like Ctrl-C there.

    Python looks for signals at calls, at the entry of a function and at the end of a loop's round.
    """

    def __init__(self, nth: int) -> None:
        self.left, self.raised = nth, False

    def __call__(self, frame: FrameType, event: str, _argument: object) -> Any:
        if event == "call":
            inside = frame.f_code is GuardedRig.exchange.__code__
            return self if inside or (frame.f_back is not None and frame.f_back.f_trace) else None
        if event == "line" and not self.raised and "(" in linecache.getline(frame.f_code.co_filename, frame.f_lineno):
            self.left -= 1
            if self.left == 0:
                self.raised = True
                raise KeyboardInterrupt
        return self


@pytest.mark.parametrize("drive_v", [3.0, "3"])
def test_ctrl_c_at_every_line_of_an_exchange_leaves_no_drive_on(drive_v: Any) -> None:
    nth, raised = 1, True
    while raised:
        device = IdealWire()
        rig = GuardedRig(device)
        rig.exchange(3.0)
        interrupt = InterruptAt(nth)
        before = sys.gettrace()
        sys.settrace(interrupt)
        try:
            rig.exchange(drive_v)
        except (KeyboardInterrupt, CallerError):
            pass
        finally:
            sys.settrace(before)
        raised = interrupt.raised
        if raised:
            assert device.drive_voltage_v <= SENSE_V, nth
            assert rig.exchange(2.0).drive_voltage_v == 2.0
        nth += 1
    assert nth > 15


def test_a_rig_that_is_paced_rests_when_its_turn_is_over_and_says_so(caplog: pytest.LogCaptureFixture) -> None:
    device = IdealWire(paced=True)
    rig = GuardedRig(device)
    rig.exchange(3.0)
    rig._silence_s = math.inf  # the thread looks no more
    assert rig._rest_if_silent() > 0.0
    assert device.drive_voltage_v == 3.0
    rig._silence_s = 0.0
    rig._rest_if_silent()
    assert device.drive_voltage_v == SENSE_V
    assert rig.protection.state is State.ARMED
    with caplog.at_level(logging.WARNING, logger="musclewire.rigs"):
        assert rig.exchange(3.0).drive_voltage_v == 3.0
    assert "nobody talked to the rig" in caplog.text
    rig.close()


class OwnLoop(IdealWire):
    """An ideal wire whose own closed loop puts out what the test says."""

    model_checksum, board_estimate, board_resistance_ohm = 0, None, None
    puts_v = 0.0

    def checksum_of(self, *_: object) -> int:
        return 0

    def correct(self, _correction: object) -> None:
        return None

    def exchange(self, command: Command) -> Answer:
        return self.put(self.puts_v) if isinstance(command, Target) else super().exchange(command)


def test_what_a_devices_own_loop_puts_out_is_judged_by_its_readings_and_is_no_command_to_refuse() -> None:
    """Its converter rounds up: a little above the maximum is no fault of anybody, but the wire still gets too hot."""
    device = OwnLoop()
    device.puts_v = 1.001 * LIMITS.maximum_voltage_v
    rig = GuardedRig(device)
    assert rig.exchange(Target(0.02)).drive_voltage_v == device.puts_v
    assert rig.protection.state is State.RUN
    events = []
    for _ in range(1000):
        try:
            rig.exchange(Target(0.02))
        except RigError as error:
            events.append(getattr(error, "event", None))
            break
    assert events == [Event.OVER_TEMPERATURE]
    assert device.drive_voltage_v == 0.0


def test_a_second_thread_in_an_exchange_gets_an_error_and_the_first_goes_on() -> None:
    entered, leave = threading.Event(), threading.Event()

    def waits(number: int, sample: RawSample) -> RawSample:
        if number == 1:
            entered.set()
            leave.wait(5.0)
        return sample

    device = IdealWire(waits)
    rig = GuardedRig(device)
    rig.exchange(3.0)
    thread = threading.Thread(target=rig.exchange, args=(3.0,))
    thread.start()
    entered.wait(5.0)
    with pytest.raises(CallerError, match="another thread is in an exchange"):
        rig.exchange(3.0)
    assert device.drive_voltage_v == 3.0
    leave.set()
    thread.join()
    assert rig.exchange(3.0).drive_voltage_v == 3.0
