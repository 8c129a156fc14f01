"""What is known of a wire in addition to its resistance curve: tables of both branches, and numbers with deviations."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError

Table = tuple[float, ...]
# Places in the tables of a wire, evenly spaced: about as many as a slow loop has rows on a branch.
PLACES = 128


@dataclass(frozen=True)
class WireNumber:
    """One number of a wire: its value, its standard deviation in the same unit, and in words what it is known from."""

    value: float
    std: float
    origin: str

    def __post_init__(self) -> None:
        """Check that value and deviation are finite, and the deviation not negative."""
        if not (math.isfinite(self.value) and 0.0 <= self.std < math.inf):
            raise CallerError(f"a number of a wire model is {self.value} +- {self.std}: it must be finite")

    def times(self, factor: float) -> WireNumber:
        """Return the number in another unit."""
        return WireNumber(factor * self.value, factor * self.std, self.origin)


@dataclass(frozen=True)
class WireModel:
    """What a slow loop shows of a wire besides its resistance curve.

    Parameters
    ----------
    first_place, place_spacing
        The place v of the first row of the tables, and the distance of two rows: v is the quantity over its largest
        value from B on, and less than at B before it.
    heating_power_w, cooling_power_w
        Power [W] that holds each place on both branches, (n_places,); both rise.
    heating_resistance, cooling_resistance
        Normalised resistance of each place on both branches, (n_places,).
    time_constant_s
        Heat capacity over heat loss [s].
    heat_j_per_unit
        Heat [J] of the transformation for one unit of the quantity.
    resistance_noise_ohm
        Noise [ohm] of a reading.
    sensed_from
        The place of B, from which on resistance shows the quantity.
    phase_resistance
        By how much the cooling branch's resistance at one place and temperature is above the heating branch's: the
        difference of both, and what the cold wire's resistance rises by with the power between them.
    minor_loops
        The law of minor loops: 0 where the wire rests until its power meets the other branch (a play), 1 where it goes
        along a copy of that branch scaled to where it turned, between them a part of the way.
    lowest_power_w, highest_power_w
        The range of power [W] that the loop covers, on heating.
    """

    first_place: float
    place_spacing: float
    heating_power_w: Table
    cooling_power_w: Table
    heating_resistance: Table
    cooling_resistance: Table
    time_constant_s: WireNumber
    heat_j_per_unit: WireNumber
    resistance_noise_ohm: WireNumber
    sensed_from: WireNumber
    phase_resistance: WireNumber
    minor_loops: WireNumber
    lowest_power_w: WireNumber
    highest_power_w: WireNumber

    def __post_init__(self) -> None:
        """Check that the tables have the rows that an estimator reads, finite, and rise."""
        tables = (self.heating_power_w, self.cooling_power_w, self.heating_resistance, self.cooling_resistance)
        if any(len(table) != PLACES for table in tables):
            raise CallerError(f"the tables of a wire model have {PLACES} rows each: fit again")
        numbers = np.array([self.first_place, self.place_spacing, *np.ravel(tables)])
        if not (np.isfinite(numbers).all() and self.place_spacing > 0.0 and self.time_constant_s.value > 0.0):
            raise CallerError("a wire model has numbers that are not finite, or no time constant above 0: fit again")

    @property
    def places(self) -> FloatArray:
        """The places of the tables, (n_places,)."""
        last = self.first_place + self.place_spacing * (len(self.heating_power_w) - 1)
        return np.linspace(self.first_place, last, len(self.heating_power_w))

    @property
    def tables(self) -> FloatArray:
        """Powers and resistances of both branches, heating first, (n_places, 4)."""
        return np.column_stack(
            [self.heating_power_w, self.cooling_power_w, self.heating_resistance, self.cooling_resistance]
        )

    @property
    def middle_power_w(self) -> float:
        """Median power [W] of the heating branch where resistance shows the quantity: what noise is a part of."""
        return float(np.median(np.array(self.heating_power_w)[self.places >= self.sensed_from.value]))

    @property
    def numbers(self) -> dict[str, WireNumber]:
        """The numbers by name, without the tables."""
        found = {one.name: getattr(self, one.name) for one in fields(self)}
        return {name: value for name, value in found.items() if isinstance(value, WireNumber)}

    def per(self, factor: float) -> WireModel:
        """Return the model of a wire whose quantity is so many times as large, in another unit or on a spring."""
        return replace(self, heat_j_per_unit=self.heat_j_per_unit.times(1.0 / factor))
