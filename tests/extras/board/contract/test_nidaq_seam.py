"""What a card's driver may say and do, through NI's unmodified client: each fault ends off, in one clear line."""

from __future__ import annotations

import statistics
import sys
import threading
import time
from collections.abc import Callable
from itertools import pairwise

import pytest
from emulation.daq_bench import card_of
from emulation.daq_card import CardTask
from emulation.daq_server import DaqServer
from tests.extras.board.contract.nidaq_rigs import at_seam, wiring_of
from tests.extras.board.contract.serial_rigs import unwatched

from musclewire.controllers import Event
from musclewire.errors import MissingExtraError, RigError
from musclewire.extras.board._nidaq import device as device_module
from musclewire.rigs import GuardedRig, ProtectionTripError, open_rig

NAMES = ("ni-pci-6229", "ni-usb-6001")
ATTEMPTS = 5


def output_v(rig: GuardedRig) -> float:
    return rig.device.server.card.outputs_v["ao0"]


def wait_until(reached: Callable[[], bool]) -> None:
    """Wait until the card is as wanted; the limit is there only so that a fault does not hang a test."""
    until_s = time.monotonic() + 60.0
    while not reached():
        assert time.monotonic() < until_s
        time.sleep(0.001)


def input_task(rig: GuardedRig) -> CardTask:
    """Return the card's task that reads, with the readings that wait in it."""
    return next(task for task in rig.device.server.card._tasks.values() if task.inputs)


@pytest.mark.emulated
@pytest.mark.parametrize("name", NAMES)
def test_a_sample_is_the_mean_of_the_readings_of_its_period(name: str) -> None:
    """Of the noise and the steps of one reading, 40 readings leave a sixth."""
    with at_seam(name) as rig:
        found = [rig.exchange(rig.sense_voltage_v).shunt_voltage_v for _ in range(100)]
        model = rig.device.server.card.model
    step_v = 2.0 * model.range_v / 2**model.bits
    one_reading_v = (model.noise_v**2 + step_v**2 / 12.0) ** 0.5
    assert statistics.stdev(found[10:]) == pytest.approx(one_reading_v / 40**0.5, rel=0.3)


@pytest.mark.emulated
@pytest.mark.parametrize("name", NAMES)
def test_no_reading_of_a_sample_was_taken_under_another_drive(name: str) -> None:
    """Wire and shunt add up to the drive in the first sample after a step, to a millivolt.

    The card keeps real time: on a machine that is busy with other programs samples may come so late that the protection
    switches off, as it must, which says nothing about the samples. Then the steps are taken again.
    """
    for _ in range(ATTEMPTS):
        try:
            with at_seam(name, paced=True) as rig:
                for drive_v in (0.3, 2.0, 0.5, 3.0, 0.3):
                    sample = rig.exchange(drive_v)
                    assert sample.wire_voltage_v + sample.shunt_voltage_v == pytest.approx(drive_v, abs=1e-3)
        except ProtectionTripError as trip:
            if trip.event not in (Event.SAMPLE_LATE, Event.COMMAND_MISSING):
                raise
        else:
            return
    pytest.fail(f"the samples came too late in each of {ATTEMPTS} attempts")


@pytest.mark.parametrize("name", NAMES)
def test_gain_and_offset_of_the_output_reach_the_card(name: str) -> None:
    output = {"channel": "ao0", "gain": 2.0, "offset": 0.1}
    with at_seam(name, output=output) as rig:
        sample = rig.exchange(2.1)
        assert output_v(rig) == pytest.approx(1.0)
        assert sample.wire_voltage_v + sample.shunt_voltage_v == pytest.approx(2.1, abs=1e-3)


@pytest.mark.emulated
@pytest.mark.parametrize("name", NAMES)
def test_a_host_that_is_late_skips_whole_periods_and_the_times_say_so(name: str) -> None:
    with at_seam(name, paced=True) as rig:
        times = []
        for index in range(6):
            if index == 3:
                wait_until(lambda: len(input_task(rig).rows) > 120)  # of 1 ms; at the sense voltage that harms nothing
            times.append(rig.exchange(rig.sense_voltage_v).time_s)
        late = rig.metadata()["late_samples"]
    steps = [(after - before) / rig.sample_period_s for before, after in pairwise(times)]
    assert steps == pytest.approx([round(step) for step in steps], abs=1e-9)
    assert max(steps) >= 3.0 - 1e-9
    assert late >= 1


@pytest.mark.emulated
def test_a_driven_wire_goes_off_when_the_samples_come_too_late() -> None:
    with at_seam("ni-usb-6001", paced=True) as rig:
        unwatched(rig)  # the whole host hangs
        rig.exchange(2.0)
        wait_until(lambda: output_v(rig) == 0.0)
        with pytest.raises(ProtectionTripError) as caught:
            rig.exchange(2.0)
    assert caught.value.event in (Event.COMMAND_MISSING, Event.SAMPLE_LATE)


@pytest.mark.emulated
def test_a_driven_wire_whose_host_thinks_rests_and_goes_on() -> None:
    with at_seam("ni-usb-6001", paced=True) as rig:
        rig.exchange(2.0)
        wait_until(lambda: rig.drive_voltage_v <= rig.sense_voltage_v)
        assert output_v(rig) > 0.0
        time.sleep(1.0)
        assert [rig.exchange(2.0).drive_voltage_v for _ in range(3)][-1] == pytest.approx(2.0, abs=0.05)


@pytest.mark.emulated
def test_readings_that_were_overwritten_are_a_stalled_host(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(device_module, "BUFFER_S", 0.2)
    with at_seam("ni-usb-6001", paced=True) as rig:
        rig.exchange(rig.sense_voltage_v)
        wait_until(lambda: input_task(rig).overwritten)
        with pytest.raises(ProtectionTripError, match="overwritten before they were fetched") as caught:
            rig.exchange(rig.sense_voltage_v)
        assert output_v(rig) == 0.0
    assert caught.value.event is Event.COMMAND_MISSING


@pytest.mark.emulated
@pytest.mark.parametrize("name", NAMES)
def test_a_card_that_is_pulled_out_is_lost_and_says_so(name: str) -> None:
    with at_seam(name, paced=True) as rig:
        rig.exchange(1.0)
        rig.device.server.card.remove()
        with pytest.raises(ProtectionTripError, match="no longer in the system") as caught:
            rig.exchange(1.0)
        assert output_v(rig) == 0.0
    assert caught.value.event is Event.DEVICE_LOST


@pytest.mark.parametrize("name", NAMES)
def test_a_reset_by_another_program_ends_the_run_off(name: str) -> None:
    with at_seam(name) as rig:
        rig.exchange(1.0)
        rig.device.server.card.reset("Dev1")
        with pytest.raises(ProtectionTripError, match="reset by another program"):
            rig.exchange(1.0)
        assert output_v(rig) == 0.0


@pytest.mark.emulated
@pytest.mark.parametrize("name", NAMES)
def test_another_thread_may_switch_off_while_readings_are_awaited(name: str) -> None:
    """The card's clock is the real one: of the 50 ms of a sample nearly all is waiting.

    At the sense voltage, where a busy machine that is late ends nothing.
    """
    rig = at_seam(name, paced=True)
    ended, sampled = [], threading.Event()

    def exchange_until_it_fails() -> None:
        try:
            while True:
                rig.exchange(rig.sense_voltage_v)
                sampled.set()
        except RigError as error:
            ended.append(str(error))

    thread = threading.Thread(target=exchange_until_it_fails)
    thread.start()
    assert sampled.wait(60.0)
    card = rig.device.server.card
    rig.close()
    assert card.outputs_v["ao0"] == 0.0
    thread.join(60.0)
    assert "the drive is off" in ended[0] or "stays off" in ended[0]


def test_a_server_that_ends_is_a_lost_device() -> None:
    rig = at_seam("ni-usb-6001")
    rig.exchange(1.0)
    rig.device.server.close()
    with pytest.raises(ProtectionTripError, match="does not answer"):
        rig.exchange(1.0)


def test_a_card_that_another_rig_uses_is_reserved() -> None:
    with at_seam("ni-usb-6001") as rig:
        rig.exchange(rig.sense_voltage_v)
        with pytest.raises(RigError, match="reserved by another program"):
            open_rig(wiring_of("ni-usb-6001").model_copy(update={"grpc": rig.device.server.address}))
        assert rig.exchange(rig.sense_voltage_v).drive_voltage_v == rig.sense_voltage_v


@pytest.mark.parametrize(("number", "identity"), [(0x1A2B3C4, "NI 01A2B3C4 ao0"), (0, "NI Dev1 {address} ao0")])
def test_a_card_is_known_by_its_serial_number_or_else_by_name_and_machine(number: int, identity: str) -> None:
    wiring = wiring_of("ni-usb-6001")
    with DaqServer(card_of(wiring, paced=False)) as server:
        server.card.serial_number = number
        at_server = wiring.model_copy(update={"grpc": server.address})
        for _ in range(2):
            with open_rig(at_server) as rig:
                assert rig.device.facts.identity == identity.format(address=server.address)


def test_a_wrong_device_channel_or_setting_is_named() -> None:
    wiring = wiring_of("ni-usb-6001")
    inputs = wiring.inputs.model_dump()
    with DaqServer(card_of(wiring, paced=False)) as server:
        for changed, expected in (
            ({"device": "Dev7"}, "Dev7 is not known to the driver"),
            ({"output": {"channel": "ao3"}}, "has no such channel"),
            ({"output_timing": "hardware"}, "does not support a setting"),
            ({"inputs": {**inputs, "wire_voltage": {"channel": "ai30"}}}, "has no such channel"),
            ({"inputs": {**inputs, "wire_voltage": {"channel": "ai0", "terminal": "NRSE"}}}, "not support a setting"),
        ):
            data = {**wiring.model_dump(), **changed, "grpc": server.address}
            with pytest.raises(RigError, match=expected) as caught:
                open_rig(type(wiring).model_validate(data))
            assert caught.value.exit_code == 3


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"grpc": "127.0.0.1:9"}, "gRPC device server does not answer"),
        # Where NI's driver is installed, the card is asked for instead, and is not there.
        ({"device": "NoSuchCard"}, r"is not installed on this machine|is not known to the driver"),
    ],
)
def test_no_server_and_no_driver_are_said(changed: dict[str, str], said: str) -> None:
    with pytest.raises(RigError, match=said):
        open_rig(wiring_of("ni-usb-6001").model_copy(update=changed))


def test_without_the_package_it_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "nidaqmx", None)
    with pytest.raises(MissingExtraError, match=r'pip install "\.\[nidaq\]" in the checkout'):
        open_rig(wiring_of("ni-usb-6001"))
