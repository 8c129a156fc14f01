"""The resistance of a driven wire, and two marks, as one observation of a search."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite, sqrt

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.extras.calibration._physical.candidates import WireValues
from musclewire.extras.calibration._physical.driven import DrivenObservation, observe_drive
from musclewire.extras.calibration._physical.observations import ObservedChannel
from musclewire.signals import Recording
from musclewire.wire import ConnectorLoad

# Two readings may lie in the wrong order by chance, by at most this many standard deviations of their difference.
PLAUSIBLE = 3.0


@dataclass(frozen=True)
class Marks:
    """Positions of the connector read off a ruler, cold and at the hottest, or an end stop that it runs against.

    All are along the direction of the contraction. Both marks are of the recording that is fitted: cold before it, hot
    at the largest contraction in it.

    Parameters
    ----------
    cold_m, hot_m
        Positions of the cold and of the hottest wire [m], contraction positive; None if they were not read. Only their
        difference counts.
    end_stop_m
        Displacement from the cold position at which the connector meets a rigid stop [m]; None without one.
    reading_std_m
        Standard deviation of one reading, or of the stop's position [m]. The default of 0.5 mm is half a division of a
        ruler.
    leg_length_std_m
        Standard deviation of the stated length of one leg [m]; the default is the same half a division.

    Raises
    ------
    CallerError
        If only one mark is given, the hot one is below the cold one by more than their errors, the stop is not beyond
        the cold position, or an error is not above 0.
    """

    cold_m: float | None = None
    hot_m: float | None = None
    end_stop_m: float | None = None
    reading_std_m: float = 0.5e-3
    leg_length_std_m: float = 0.5e-3

    def __post_init__(self) -> None:
        """Check the marks."""
        if (self.cold_m is None) != (self.hot_m is None):
            raise CallerError("one mark shows nothing: give both, the cold wire's and the hot one's")
        if self.end_stop_m is not None and not 0.0 < self.end_stop_m < inf:
            raise CallerError(
                f"the end stop is at {1e3 * self.end_stop_m:.4g} mm from the cold wire: it must be beyond"
            )
        for name, value in (("reading_std_m", self.reading_std_m), ("leg_length_std_m", self.leg_length_std_m)):
            if not (isfinite(value) and value > 0.0):
                raise CallerError(f"{name} is {value}: no ruler is exact, give a standard deviation above 0")
        if self.stroke_m is not None and not -PLAUSIBLE * self.stroke_std_m < self.stroke_m < inf:
            raise CallerError(
                f"the hot mark is {1e3 * self.stroke_m:.4g} mm from the cold one: a wire contracts as it is heated, so "
                "that it must be further along the contraction"
            )

    @property
    def stroke_m(self) -> float | None:
        """Displacement between both marks [m]; None without them."""
        return None if self.cold_m is None or self.hot_m is None else self.hot_m - self.cold_m

    @property
    def stroke_std_m(self) -> float:
        """Standard deviation of the displacement between two marks [m]."""
        return sqrt(2.0) * self.reading_std_m


MARK = "displacement between the marks"
# What a recording may show of the wire apart from its circuit and its air. It is left out: an instrument that someone
# has in addition judges the result, and does not enter it.
OTHER_INSTRUMENTS = ("reference_strain", "displacement_m", "force_n", "endpoint_displacement_m", "wire_temperature_k")
# A stop that yields by a micrometre for each newton is rigid to what a ruler shows.
STOP_STIFFNESS_N_PER_M = 1e6


class ResistanceAndMarks:
    """Resistance over time, and the displacement between a cold and a hot mark if there are any."""

    def __init__(self, driven: DrivenObservation, marks: Marks | None = None) -> None:
        """Take a driven wire of which the resistance alone is observed, and marks if they count."""
        self.title = "resistance, and marks"
        self.driven = driven
        self.channels: Sequence[ObservedChannel] = driven.channels
        if marks is not None and marks.stroke_m is not None:
            one = np.ones(1)
            mark = ObservedChannel(MARK, "m", 0.0 * one, marks.stroke_m * one, marks.stroke_std_m * one)
            self.channels = [*driven.channels, mark]

    def refined(self) -> ResistanceAndMarks:
        """Return the observation itself: finer steps change the resistance by less than the model's error."""
        return self

    def simulate(self, values: WireValues) -> Mapping[str, FloatArray]:
        """Return resistance and displacement of this wire."""
        resistance, moved_m = self.loop(values)
        return {
            "resistance": self.driven.in_bins("resistance", resistance),
            MARK: np.array([moved_m.max() - moved_m[0]]),
        }

    def loop(self, values: WireValues) -> tuple[FloatArray, FloatArray]:
        """Return resistance [ohm] and displacement [m] of this wire at the driven wire's ticks, both (n,)."""
        columns = self.driven.columns(values)
        return columns["resistance"], columns["strain"] * leg_length_m(values)


def leg_length_m(values: WireValues) -> float:
    """Return the length of one leg of a wire."""
    return values.bench["wire_length_m"] / values.bench["legs"]


def electrical_part(recording: Recording) -> Recording:
    """Return a recording without its instruments of motion, force and temperature."""
    kept = {name: values for name, values in recording.columns.items() if name not in OTHER_INSTRUMENTS}
    return Recording(kept, recording.metadata)


def observe_resistance(
    recording: Recording, bench: Mapping[str, float], end_stop_m: float | None, uncertain: Collection[str]
) -> ResistanceAndMarks:
    """Return a driven wire's resistance as an observation, and the uncertain numbers of its bench."""
    driven = observe_drive(electrical_part(recording), bench, "resistance")
    stiffness = driven.bench["spring_stiffness_n_per_m"]
    load = None if end_stop_m is None else spring_and_stop(stiffness, end_stop_m)
    return ResistanceAndMarks(driven.loaded(load, uncertain))


def spring_and_stop(stiffness_n_per_m: float, end_stop_m: float) -> ConnectorLoad:
    """Return a spring, and beyond a displacement a stop that is much stiffer."""
    return ConnectorLoad(
        stiffness_n_per_m,
        end_stop_m,
        np.array([0.0, 0.0, STOP_STIFFNESS_N_PER_M * end_stop_m]),
        np.zeros(3),
    )
