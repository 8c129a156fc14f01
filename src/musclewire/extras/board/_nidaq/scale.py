"""The linear rule between a voltage at a terminal and the quantity behind it.

A module of its own, because the guardian needs it too: with the schema of rig files it would import all rigs and Numba,
and take three times as long to start.
"""

from __future__ import annotations

from typing import NamedTuple


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
