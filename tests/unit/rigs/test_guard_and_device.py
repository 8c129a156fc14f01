"""What the guard does with each answer a device may give, and with one that is closed while it waits."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from musclewire.controllers import Event, State
from musclewire.errors import CallerError, NumericsError, RigError
from musclewire.rigs import (
    SWITCHED_OFF,
    Answer,
    DeviceFacts,
    DeviceFault,
    GuardedRig,
    HasOnBoardLoop,
    HasStage,
    HasTendonStage,
    HasTrueState,
    Metadata,
    Missing,
    ProtectionTripError,
    ability,
    open_rig,
    required_true_state,
)
from musclewire.signals import Command, Drive, RawSample, Target

LIMITS = open_rig("simulated").protection_limits
SENSE_V = LIMITS.sense_voltage_v


class Scripted:
    """A device that gives prepared answers; what it is told is noted."""

    drive_voltage_v = 0.0

    def __init__(self, *answers: Answer | Exception, senses: bool = True, maximum_v: float = 3.6) -> None:
        limits = LIMITS._replace(maximum_voltage_v=maximum_v)
        self.facts = DeviceFacts(
            0.05, paced=False, leg_length_m=0.07, drive_amplitude_v=3.2, limits=limits, wire_temperature_k=295.15
        )
        self.answers: Iterator[Answer | Exception] = iter(answers)
        self.told: list[Command | str] = []
        self.senses = senses

    def metadata(self) -> Metadata:
        return {}

    def exchange(self, command: Command) -> Answer:
        self.told.append(command)
        answer = next(self.answers)
        if isinstance(answer, Exception):
            raise answer
        return answer

    def sense(self) -> bool:
        self.told.append("sense")
        return self.senses

    def off(self) -> bool:
        self.told.append("off")
        return True


def sample(number: int, drive_v: float = 1.0) -> RawSample:
    current_a = drive_v / 18.0
    return RawSample(0.05 * number, drive_v, 17.0 * current_a + 1e-5 * (number % 7), current_a)


def late(missing_s: float, after_all: RawSample | None = None) -> Missing:
    return Missing(Event.SAMPLE_LATE, missing_s, after_all)


def test_while_a_sample_is_missing_the_drive_is_held_then_goes_to_the_sense_voltage(
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level("INFO", "musclewire.rigs")
    device = Scripted(sample(1), late(0.05), late(0.15), sample(2, SENSE_V), sample(3))
    rig = GuardedRig(device)
    rig.exchange(1.0)
    assert rig.exchange(1.0).drive_voltage_v == SENSE_V
    assert device.told == [Drive(1.0), Drive(1.0), Drive(1.0, by_protection=True), Drive(SENSE_V, by_protection=True)]
    assert rig.protection.state is State.RUN  # the sample came
    assert caplog.messages == [f"sample late for 0.15 s: the drive went to the sense voltage, {SENSE_V:g} V"]
    rig.exchange(1.0)
    assert device.told[-1] == Drive(1.0)


def test_a_sample_that_is_missing_for_too_long_ends_off() -> None:
    device = Scripted(sample(1), late(0.1), late(0.2), late(0.3))
    rig = GuardedRig(device)
    rig.exchange(1.0)
    with pytest.raises(ProtectionTripError, match=r"missing for 0.300 s") as caught:
        rig.exchange(1.0)
    assert caught.value.event is Event.SAMPLE_LATE
    assert device.told[-1] == "off"


def test_a_device_whose_wait_does_not_grow_is_lost_and_not_waited_for_for_ever() -> None:
    device = Scripted(sample(1), late(0.05), late(0.05))
    rig = GuardedRig(device)
    rig.exchange(1.0)
    with pytest.raises(ProtectionTripError, match="its clock stays") as caught:
        rig.exchange(1.0)
    assert caught.value.event is Event.DEVICE_LOST
    assert device.told[-1] == "off"


def test_a_sample_that_came_late_is_judged_as_any_other() -> None:
    device = Scripted(sample(1), late(0.15, sample(2)), late(0.3, sample(3)))
    rig = GuardedRig(device)
    rig.exchange(1.0)
    assert rig.exchange(1.0) == sample(2)
    assert rig.protection.state is State.RUN
    with pytest.raises(ProtectionTripError) as caught:
        rig.exchange(1.0)
    assert caught.value.event is Event.SAMPLE_LATE


@pytest.mark.parametrize(
    "trouble", [DeviceFault(Event.WIRE_OPEN, "seen by the device"), RigError("gone"), NumericsError("no numbers")]
)
def test_a_fault_and_every_trouble_that_a_device_reports_end_off_for_good(trouble: DeviceFault | Exception) -> None:
    device = Scripted(sample(1), trouble)
    rig = GuardedRig(device)
    rig.exchange(1.0)
    with pytest.raises((RigError, NumericsError)):
        rig.exchange(1.0)
    assert device.told[-1] == "off"
    with pytest.raises(RigError, match="stays off"):
        rig.exchange(1.0)


def test_a_mistake_in_a_device_ends_at_the_sense_voltage() -> None:
    device = Scripted(sample(1), ZeroDivisionError())
    rig = GuardedRig(device)
    rig.exchange(1.0)
    with pytest.raises(ZeroDivisionError):
        rig.exchange(1.0)
    assert device.told[-1] == "sense"


def test_what_cannot_be_put_to_the_sense_voltage_goes_off() -> None:
    device = Scripted(sample(1), senses=False)
    rig = GuardedRig(device)
    rig.exchange(1.0)
    rig.make_safe()
    assert device.told[-2:] == ["sense", "off"]
    assert rig.protection.state is State.OFF


def test_a_device_with_impossible_limits_is_let_go_of() -> None:
    device = Scripted(maximum_v=-1.0)
    with pytest.raises(CallerError):
        GuardedRig(device)
    assert device.told == ["off"]


def test_a_target_never_reaches_a_device_without_a_loop_of_its_own() -> None:
    device = Scripted(sample(1))
    rig = GuardedRig(device)
    with pytest.raises(CallerError, match="closes the loop itself"):
        rig.exchange(Target(0.02))
    assert device.told == ["sense"]


class Waiting(Scripted):
    """A device whose sample comes only when it is switched off."""

    def __init__(self) -> None:
        super().__init__(sample(1))
        self.released = threading.Event()

    def exchange(self, command: Command) -> Answer:
        assert self.released.wait(60.0)
        self.told.append(command)
        return SWITCHED_OFF

    def off(self) -> bool:
        self.released.set()
        return super().off()


def closed_while_waiting(rig: GuardedRig) -> RigError:
    """Return what an exchange ends with whose rig another thread closes once its command is out."""
    ended: list[RigError] = []
    before_ns = rig.drive_at_ns

    def exchange() -> None:
        with pytest.raises(RigError) as caught:
            rig.exchange(1.0)
        ended.append(caught.value)

    thread = threading.Thread(target=exchange)
    thread.start()
    while rig.drive_at_ns == before_ns and thread.is_alive():
        thread.join(1e-3)
    rig.close()
    thread.join(60.0)
    assert not thread.is_alive()
    return ended[0]


def test_an_exchange_whose_rig_is_closed_meanwhile_says_so_and_is_no_trip() -> None:
    device = Waiting()
    rig = GuardedRig(device)
    error = closed_while_waiting(rig)
    assert "was closed while a sample was awaited; the drive is off" in str(error)
    assert not isinstance(error, ProtectionTripError)
    assert rig.protection.state is State.OFF
    assert rig.protection.event is Event.NONE


def test_a_simulated_rig_that_waits_for_its_clock_may_be_closed_meanwhile() -> None:
    # So long a period that no busy machine lets the sample come first.
    rig = open_rig("simulated", real_time=True, sample_period_s=120.0)
    rig.exchange(1.0)  # the first sample waits for nothing: it begins the clock
    assert "closed while a sample was awaited" in str(closed_while_waiting(rig))
    assert rig.drive_voltage_v == 0.0


def test_what_a_rig_can_do_besides_is_asked_for_and_not_guessed() -> None:
    simulated, plain = open_rig("finger"), GuardedRig(Scripted())
    assert ability(simulated, HasStage) is not None
    assert ability(simulated, HasTendonStage) is not None
    assert ability(simulated, HasTrueState) is not None
    assert ability(simulated, HasOnBoardLoop) is None
    assert (
        ability(plain, HasStage)
        is ability(plain, HasTendonStage)
        is ability(plain, HasTrueState)
        is ability(plain, HasOnBoardLoop)
        is None
    )
    with pytest.raises(CallerError, match="only a simulated rig knows"):
        required_true_state(plain)
