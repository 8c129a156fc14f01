"""The schema of rig files of boards on a serial line."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from musclewire.rigs import DeviceConfiguration, LivePeriod, MountedWire
from musclewire.signals import measured_in

Volts = Annotated[float, measured_in("V"), Field(gt=0.0, allow_inf_nan=False)]
Seconds = Annotated[float, measured_in("s"), Field(gt=0.0, le=60.0)]


class SerialConfiguration(MountedWire, DeviceConfiguration):
    """A rig file with ``kind = "serial"``: the wire that is mounted, and the board that drives it.

    Attributes:
        sample_period: time between samples, at most 50 ms, so that every fault ends with 0 V within half a second.
        port: ``/dev/ttyACM0``, ``COM3``, or a URL of pyserial's such as ``socket://127.0.0.1:4000``.
        baud: speed of the line in bits per second; a board on USB takes any.
        patience: time for which a sample may be overdue before the board counts as lost.
        wire_range: end of the range of the channel that reads the wire.
        shunt_range: end of the range of the channel that reads the shunt.
        readings_noisy: whether noise changes every reading, so that a constant reading is a fault by itself.
    """

    kind: Literal["serial"]
    sample_period: LivePeriod = 0.05
    port: str = Field(min_length=1)
    baud: int = Field(default=115200, ge=1200, le=12_000_000)
    patience: Seconds = 0.25
    wire_range: Volts
    shunt_range: Volts
    readings_noisy: bool = True
