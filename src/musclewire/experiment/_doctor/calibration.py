"""Offsets and gains of the two input channels, to be written into a rig file."""

from __future__ import annotations

from typing import NamedTuple

from musclewire.errors import CallerError
from musclewire.experiment._doctor.evidence import Evidence
from musclewire.experiment._doctor.probing import VoltageLevel

# A meter and a channel that differ by more do not measure the same voltage.
MAX_GAIN_ERROR = 0.2


class ChannelCalibration(NamedTuple):
    """Error of one channel: true = (reading - offset_v) * gain. ``gain`` is None without a meter's reading."""

    channel: str
    offset_v: float
    gain: float | None


def calibrations(
    evidence: Evidence, at_sense: VoltageLevel | None, meter_wire_v: float | None, meter_shunt_v: float | None
) -> tuple[ChannelCalibration, ...]:
    """Return the calibration of both channels: offsets at 0 V, gains by a meter that was read at the sense voltage.

    Raises CallerError if a meter's reading cannot belong to the channel.
    """
    found = []
    for channel, meter_v in (("wire", meter_wire_v), ("shunt", meter_shunt_v)):
        offset = float(getattr(evidence.zero, f"{channel}_voltage_v").mean())
        found.append(ChannelCalibration(channel, offset, gain_of(channel, offset, at_sense, meter_v)))
    return tuple(found)


def gain_of(channel: str, offset_v: float, at_sense: VoltageLevel | None, meter_v: float | None) -> float | None:
    """Return the factor by which a channel's reading agrees with a meter's."""
    if meter_v is None:
        return None
    if at_sense is None:
        raise CallerError(
            f"the sense voltage was not put out, so --meter-{channel} cannot be used: correct the failed checks first"
        )
    reading = float(getattr(at_sense, f"{channel}_voltage_v").mean()) - offset_v
    gain = meter_v / reading if reading else 0.0
    if not abs(gain - 1.0) <= MAX_GAIN_ERROR:
        raise CallerError(
            f"--meter-{channel} {meter_v:g} V and a reading of {reading:g} V: over {MAX_GAIN_ERROR:.0%} apart, so "
            "they do not measure the same voltage: check where the meter was"
        )
    return gain
