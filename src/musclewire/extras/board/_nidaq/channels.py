"""Scales from volts at a terminal to quantities, and the division of a sample period; arithmetic without a card."""

from __future__ import annotations

from typing import NamedTuple

from musclewire.errors import CallerError

# The first reading after the output's clock edge is taken while the output still settles.
SETTLING_READINGS = 1


class LinearScale(NamedTuple):
    """``quantity = per_volt * voltage + offset``; both as a calibration found them."""

    per_volt: float
    offset: float

    def quantity(self, voltage_v: float) -> float:
        """Return the quantity [SI] for a voltage at the terminal."""
        return self.per_volt * voltage_v + self.offset

    def voltage_v(self, quantity: float) -> float:
        """Return the voltage at the terminal for a quantity [SI]."""
        return (quantity - self.offset) / self.per_volt

    def largest(self, range_v: float) -> float:
        """Return the largest quantity that fits into a terminal's range to both sides."""
        return min(abs(self.quantity(range_v)), abs(self.quantity(-range_v)))


class ReadingSpan(NamedTuple):
    """The readings of a sample: how many to fetch, and how many of the last ones to average."""

    fetch: int
    average: int
    periods: int


class SamplePeriodLayout(NamedTuple):
    """The division of a sample period: its readings, the averaged ones, and whether the card's clock sets the drive.

    On demand, a period begins with the host's time to decide, in which the drive changes, followed by the averaged
    readings. By the card's clock it begins with one reading to settle, then the averaged ones, then the host's time to
    decide.
    """

    period: int
    readings: int
    clocked: bool

    @property
    def decision(self) -> int:
        """Readings that pass while the host may decide."""
        return self.period - self.readings - (SETTLING_READINGS if self.clocked else 0)

    def first(self) -> ReadingSpan:
        """Return the span of the first sample, whose drive is out before the readings begin."""
        fetch = SETTLING_READINGS + self.readings if self.clocked else self.period
        return ReadingSpan(fetch, self.readings, 1)

    def following(self, waiting: int) -> ReadingSpan:
        """Return the span of a sample whose drive was written when ``waiting`` readings had come since the last one.

        All its averaged readings are taken under that drive. A host that was late skips whole periods, so that times
        stay multiples of the period.
        """
        late = max(0, waiting - self.decision)
        if self.clocked:
            periods = 1 + -(-late // self.period)
            return ReadingSpan(periods * self.period, self.readings, periods)
        # A late write leaves fewer readings of its period; under half of them is too few.
        periods = 1 + late // self.period
        left = periods * self.period - waiting
        if 2 * left < self.readings:
            periods, left = periods + 1, left + self.period
        return ReadingSpan(periods * self.period, min(self.readings, left), periods)


def layout_of(sample_period_s: float, reading_rate_hz: float, readings: int, *, clocked: bool) -> SamplePeriodLayout:
    """Return how a sample period is divided. Raises CallerError if the numbers do not fit together."""
    exact = sample_period_s * reading_rate_hz
    period = round(exact)
    if period < 1 or abs(exact - period) > 1e-6 * exact:
        raise CallerError(
            f"a sample_period of {sample_period_s:g} s has {exact:g} readings at a reading_rate of "
            f"{reading_rate_hz:g} Hz: it must be a whole number"
        )
    layout = SamplePeriodLayout(period, readings, clocked)
    if layout.decision < 1:
        raise CallerError(
            f"readings {readings} of the {period} in a sample period leave the host no time to decide: "
            f"average at most {readings - 1 + layout.decision}"
        )
    return layout
