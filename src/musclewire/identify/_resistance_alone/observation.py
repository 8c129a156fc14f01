"""The resistance of a driven wire, and two marks, as one observation of a search."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.identify._physical.candidates import WireValues
from musclewire.identify._physical.driven import DrivenObservation, observe_drive
from musclewire.identify._physical.observations import ObservedChannel
from musclewire.identify._resistance_alone.marks import Marks
from musclewire.signals import Recording
from musclewire.wire import ConnectorLoad

MARK = "displacement between the marks"
# What a recording may show of the wire apart from its circuit and its air. It is left out: an instrument that someone
# has in addition judges the result, and does not enter it.
OTHER_INSTRUMENTS = ("reference_strain", "displacement_m", "force_n", "endpoint_displacement_m", "wire_temperature_k")
# A stop that yields by a micrometre for each newton is rigid to what a ruler shows.
STOP_STIFFNESS_N_PER_M = 1e6


class ResistanceAndMarks:
    """Resistance over time, and the displacement between a cold and a hot mark if there are any."""

    title = "resistance, and marks"

    def __init__(self, driven: DrivenObservation, marks: Marks | None = None) -> None:
        """Take a driven wire of which the resistance alone is observed, and marks if they count."""
        self.driven = driven
        self._channels = list(driven.channels)
        if marks is not None and marks.stroke_m is not None:
            one = np.ones(1)
            self._channels.append(
                ObservedChannel(MARK, "m", "none", 0.0 * one, marks.stroke_m * one, marks.stroke_std_m * one)
            )

    @property
    def channels(self) -> Sequence[ObservedChannel]:
        """The resistance, and the displacement between the marks."""
        return self._channels

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
    """Return the resistance of a driven wire as an observation, with the numbers of its bench that are uncertain.

    Raises as ``observe_drive``.
    """
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
