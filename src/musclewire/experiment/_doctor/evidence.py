"""Straight lines through the readings: how each channel follows the drive, with standard errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.experiment._doctor.probing import VoltageLevel

# A smaller slope [V/V] counts as none, however significant statistically.
MIN_SLOPE = 1e-5
SIGMAS = 6.0


class LinearFit(NamedTuple):
    """A channel over the commanded voltage: volts at no drive, volts per volt, and the standard error of that."""

    offset_v: float
    slope: float
    slope_error: float

    @property
    def moves(self) -> bool:
        """Whether the channel follows the drive, upward or downward, beyond chance."""
        return abs(self.slope) > max(SIGMAS * self.slope_error, MIN_SLOPE)


class Evidence(NamedTuple):
    """The levels and their fits: ``wire``, ``shunt`` and both together (``circuit``) over the drive, in volts."""

    levels: tuple[VoltageLevel, ...]
    wire: LinearFit
    shunt: LinearFit
    circuit: LinearFit
    sense_voltage_v: float
    shunt_resistance_ohm: float

    @property
    def zero(self) -> VoltageLevel:
        """The level at 0 V."""
        return self.levels[0]

    @property
    def carries(self) -> bool:
        """Whether a current flows that grows with the drive, and the wire has a voltage with it."""
        return self.wire.moves and self.shunt.moves

    @property
    def resistance_ohm(self) -> float:
        """Resistance of the wire by the slopes, which no offset affects; 0.0 without current."""
        return self.shunt_resistance_ohm * self.wire.slope / self.shunt.slope if self.carries else 0.0

    @property
    def wire_at_sense_v(self) -> float:
        """Reading of the wire's channel that is expected at the sense voltage, without its offset."""
        return abs(self.wire.slope) * self.sense_voltage_v

    @property
    def shunt_at_sense_v(self) -> float:
        """Reading of the shunt's channel that is expected at the sense voltage, without its offset."""
        return abs(self.shunt.slope) * self.sense_voltage_v

    @property
    def sense_current_a(self) -> float:
        """Current at the sense voltage; negative if the shunt's channel is reversed."""
        return self.shunt.slope * self.sense_voltage_v / self.shunt_resistance_ohm


def evidence_of(levels: Sequence[VoltageLevel], sense_voltage_v: float, shunt_resistance_ohm: float) -> Evidence:
    """Return the lines through levels of which the first is at 0 V. Needs two levels or more, all finite."""
    drive_v = np.concatenate([np.full(len(level.time_s), level.commanded_v) for level in levels])
    wire_v = np.concatenate([level.wire_voltage_v for level in levels])
    shunt_v = np.concatenate([level.shunt_voltage_v for level in levels])
    return Evidence(
        tuple(levels),
        line(drive_v, wire_v),
        line(drive_v, shunt_v),
        line(drive_v, wire_v + shunt_v),
        sense_voltage_v,
        shunt_resistance_ohm,
    )


def line(drive_v: FloatArray, reading_v: FloatArray) -> LinearFit:
    """Return the least-squares line through readings."""
    away = drive_v - drive_v.mean()
    spread = float(away @ away)
    slope = float(away @ reading_v) / spread
    offset = float(reading_v.mean()) - slope * float(drive_v.mean())
    rest = reading_v - offset - slope * drive_v
    return LinearFit(offset, slope, math.sqrt(float(rest @ rest) / (len(rest) - 2) / spread))


def noise_v(readings_v: FloatArray) -> float:
    """Return the rms noise of readings after removing a linear drift."""
    count = np.arange(len(readings_v), dtype=np.float64)
    slope, offset = np.polyfit(count, readings_v, 1)
    return float(np.std(readings_v - offset - slope * count))
