"""The device's time when its host is late or pauses, on a card in memory and by a clock of the test's own."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from musclewire.controllers import Event
from musclewire.extras.board._nidaq import device as module
from musclewire.extras.board._nidaq.device import NiDaqDevice
from musclewire.extras.board._nidaq.output import HostStalledError
from musclewire.rigs import Answer, DeviceFault, Missing, rig_configuration
from musclewire.signals import Drive, RawSample

PAUSE_S = 10.0


class Card:
    """Card, inputs and output in one; ``waiting_readings`` have come since the last sample."""

    clock_hz = None

    def __init__(self, rate_hz: float) -> None:
        self.rate_hz, self.waiting_readings = rate_hz, 0

    def fetch(self, count: int) -> np.ndarray:
        return np.full((2, count), 0.1)

    def waiting(self) -> int:
        return self.waiting_readings

    def __getattr__(self, name: str) -> Any:
        """Take every order that needs no answer."""
        return lambda *_: name


@pytest.fixture
def at_card(monkeypatch: pytest.MonkeyPatch) -> tuple[NiDaqDevice, Card, SimpleNamespace]:
    """A device, its card and its clock."""
    configuration: Any = rig_configuration("ni-usb-6001")[0]
    card, clock = Card(configuration.reading_rate), SimpleNamespace(now_s=100.0)
    for name in ("AcquisitionCard", "InputStream", "GuardedOutput"):
        monkeypatch.setattr(module, name, lambda *_: card)
    monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: clock.now_s))
    wired = {"inputs": configuration.inputs.model_copy(update={"displacement": None, "force": None})}
    return NiDaqDevice(configuration.model_copy(update=wired)), card, clock


def time_of(answer: Answer) -> float:
    sample = answer.sample if isinstance(answer, Missing) else answer
    assert isinstance(sample, RawSample)
    return sample.time_s


@pytest.mark.parametrize("periods_late", [1, 3])
def test_a_driven_wire_whose_host_is_late_has_missed_as_many_periods_as_it_came_late(
    at_card: tuple[NiDaqDevice, Card, SimpleNamespace], periods_late: int
) -> None:
    device, card, _ = at_card
    period_s = device.facts.sample_period_s
    before_s = time_of(device.exchange(Drive(2.0)))
    card.waiting_readings = periods_late * round(period_s * card.rate_hz)
    answer = device.exchange(Drive(2.0))
    assert isinstance(answer, Missing)
    assert (answer.event, answer.missing_s) == (Event.SAMPLE_LATE, pytest.approx(periods_late * period_s))
    assert time_of(answer) - before_s == pytest.approx((1 + periods_late) * period_s)


def test_a_pause_passes_on_the_devices_clock_although_the_card_has_stopped(
    at_card: tuple[NiDaqDevice, Card, SimpleNamespace],
) -> None:
    device, _, clock = at_card
    before_s = time_of(device.exchange(Drive(2.0)))
    assert device.sense()
    clock.now_s += PAUSE_S
    assert time_of(device.exchange(Drive(2.0))) - before_s == pytest.approx(PAUSE_S + device.facts.sample_period_s)


def test_readings_under_a_guardian_that_has_switched_off_meanwhile_are_no_fault_of_the_supply(
    at_card: tuple[NiDaqDevice, Card, SimpleNamespace], monkeypatch: pytest.MonkeyPatch
) -> None:
    def switched_off() -> None:
        raise HostStalledError(0.31)

    device, card, _ = at_card
    device.exchange(Drive(2.0))
    monkeypatch.setattr(card, "keep", switched_off, raising=False)
    answer = device.exchange(Drive(2.0))
    assert answer == DeviceFault(Event.COMMAND_MISSING, "no command for 0.310 s: the guardian has switched off")
