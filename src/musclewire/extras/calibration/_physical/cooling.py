"""A cooling curve: a wire that was heated by any means and then cools in air under its load."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError, argument
from musclewire.extras.calibration._physical.bench import bench_of
from musclewire.extras.calibration._physical.candidates import WireValues
from musclewire.extras.calibration._physical.observations import (
    CURVE_STRETCHES,
    ClockedObservation,
    RawChannel,
    binned,
    binned_channel,
    even_clock,
    instruments_of,
    require_rows,
)
from musclewire.parameters import load_bench
from musclewire.signals import Recording
from musclewire.wire import heated_state

# A curve that falls by less does not determine a rate.
MIN_FALL_K = 5.0
MIN_OVER_NOISE = 20.0  # range of another channel over its noise: with less it does not move
# A curve may end this far below the stated temperature of the air: the accuracy of two thermometers.
BELOW_AMBIENT_K = 3.0
# The start is that of a parabola fitted to the first part of the fall, in which a parabola is accurate.
EARLY_FRACTION = 0.1  # of the fall
MIN_EARLY = 6  # samples in it: with fewer the start is the first sample
UNCOUNTED_ZERO = ("strain", "force")


class CoolingObservation(ClockedObservation):
    """A wire that cools in air: its temperature, and strain or force if they were recorded.

    The initial state is that after slow heating to the first temperature. The zeros of strain and force are unknown, so
    the mean difference is subtracted from each.
    """

    def __init__(
        self,
        title: str,
        start_temperature_k: float,
        sample_period_s: float,
        samples: int,
        bench: Mapping[str, float],
        diameter_m: float | None,
        channels: Mapping[str, RawChannel],
    ) -> None:
        """Take channels, (samples,), on an even clock that begins at ``start_temperature_k``."""
        super().__init__(title, sample_period_s, samples, bench, diameter_m)
        self._start_k = start_temperature_k
        self._samples = samples
        time_s = np.asarray(sample_period_s * np.arange(samples))
        self.channels = [
            binned_channel(name, raw, time_s, self._bin, CURVE_STRETCHES)[0] for name, raw in channels.items()
        ]

    def columns(self, values: WireValues) -> Mapping[str, FloatArray]:
        """Return the simulated channels of this wire, sample by sample."""
        constants = self.constants(values, {})
        start = heated_state(constants, self._start_k)
        path = self.path(constants, np.zeros(self._samples - 1), start)
        force = start.stress_pa * constants.legs * constants.area_m2
        return {
            "strain": np.concatenate([[start.contraction], path.displacement_m / constants.leg_length_m]),
            "force": np.concatenate([[force], path.force_n]),
            "temperature": np.concatenate([[start.temperature_k], path.temperature_k]),
        }

    def simulate(self, values: WireValues) -> Mapping[str, FloatArray]:
        """Return the simulated channels of this wire, in bins."""
        columns = self.columns(values)
        found = {}
        for channel in self.channels:
            predicted = binned(columns[channel.name], self._bin)
            if channel.name in UNCOUNTED_ZERO:
                predicted = predicted + float(np.mean(channel.measured - predicted))
            found[channel.name] = predicted
        return found


def observe_cooling(recording: Recording, bench: Mapping[str, float], title: str) -> CoolingObservation:
    """Return a recording of a wire cooling without current as an observation.

    Without the wire's temperature ``bench`` must hold ``start_temperature_k``. Raises RecordingError if nothing cools,
    CallerError if bench or start is not known.
    """
    known = bench_of(recording, bench)
    complete = recording.with_metadata({**known, "leg_length_m": known["wire_length_m"] / known["legs"]})
    require_rows(complete)
    even, period_s = even_clock(complete["time_s"])
    channels = {name: raw.selected_rows(even) for name, raw in instruments_of(complete).items()}
    if not channels:
        raise RecordingError(
            "neither voltages nor temperature, strain or force were recorded: there is nothing to compare, record "
            "one of them"
        )
    ambient_k = known.get("ambient_temperature_k", load_bench("paper").ambient_temperature_k.value)
    start_k = start_of(channels, known)
    refuse_what_does_not_cool(channels, start_k, ambient_k)
    strain = channels.get("strain")
    # Contraction falls while the wire cools; elongation changes its sign.
    if strain is not None and strain.values[0] < strain.values[-1]:
        channels["strain"] = strain._replace(values=-strain.values)
    return CoolingObservation(title, start_k, period_s, even.size, known, bench.get("diameter_m"), channels)


def start_of(channels: Mapping[str, RawChannel], known: Mapping[str, float]) -> float:
    """Return the temperature at which a curve begins: as stated, or fitted to the beginning of the curve."""
    if "start_temperature_k" in known:
        return known["start_temperature_k"]
    if "temperature" not in channels:
        raise CallerError(
            "no voltages, so it is a cooling curve, and nothing says how hot it begins: record wire_temperature_k, or "
            "give " + argument("bench", {"start_temperature_k": "120 degC"})
        )
    values = channels["temperature"].values
    early = int(np.argmax(values < values[0] - EARLY_FRACTION * np.ptp(values)))
    if early < MIN_EARLY:
        return float(values[0])
    return float(np.polyfit(np.arange(early), values[:early], 2)[2])


def refuse_what_does_not_cool(channels: Mapping[str, RawChannel], start_k: float, ambient_k: float) -> None:
    """Raise RecordingError if a curve does not fall, or falls below the temperature of the air."""
    if "temperature" in channels:
        values = channels["temperature"].values
        fall, rise = start_k - float(values.min()), float(values.max()) - start_k
        if fall < MIN_FALL_K or rise > fall:
            raise RecordingError(
                f"without voltages a recording with a clock must be a cooling curve, and its temperature falls by "
                f"{max(fall, 0.0):.2g} K only: nothing can be identified from it; record a hot wire until it is cold"
            )
        if float(values.min()) < ambient_k - BELOW_AMBIENT_K:
            raise RecordingError(
                f"the wire cools to {values.min() - 273.15:.1f} C, below the air at {ambient_k - 273.15:.1f} C: "
                "give " + argument("bench", {"ambient_temperature_k": "20 degC"}) + ", or record it"
            )
        return
    moved = {name: float(np.ptp(raw.values)) for name, raw in channels.items()}
    if not any(change > MIN_OVER_NOISE * channels[name].noise[0] + 1e-12 for name, change in moved.items()):
        raise RecordingError(
            "nothing moves by more than its noise "
            f"({', '.join(f'{name} by {change:.2g}' for name, change in moved.items())}): the wire did not transform, "
            "begin hotter"
        )
    if start_k < ambient_k + MIN_FALL_K:
        raise RecordingError(
            f"it begins at {start_k - 273.15:.1f} C, no warmer than the air: a wire at rest identifies nothing, begin "
            "hotter"
        )
