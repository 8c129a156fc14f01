"""Isobars: strain of a wire against temperature under a constant stress, simulated and summarised."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.parameters import Alloy, Bench, Wire
from musclewire.wire import constants_from, isobaric_path

# A loop begins at 30 C and ends at 140 C, up to which wires are driven by default.
COLDEST_K = 303.15
HOTTEST_K = 413.15
FRACTIONS = (0.1, 0.5, 0.9)


class IsobaricLoop(NamedTuple):
    """One loop, cold to hot to cold: temperatures and strains, each (n,), under one stress."""

    stress_pa: float
    temperature_k: FloatArray  # temperatures, (n,)
    strain: FloatArray  # strain at each, contraction positive, (n,)


class IsobarSummary(NamedTuple):
    """Stroke of a loop, and the temperatures at which 10, 50 and 90 % of either branch are complete."""

    stress_pa: float
    stroke: float
    heating_k: tuple[float, float, float]
    cooling_k: tuple[float, float, float]


def simulated_isobar(
    alloy: Alloy,
    wire: Wire,
    bench: Bench,
    stress_pa: float,
    *,
    coldest_k: float = COLDEST_K,
    hottest_k: float = HOTTEST_K,
    points: int = 441,
) -> IsobaricLoop:
    """Return the loop of a simulated wire under constant stress, from coldest to hottest and back.

    Parameters
    ----------
    alloy
        The alloy.
    wire
        The wire.
    bench
        The bench.
    stress_pa
        The constant stress [Pa].
    coldest_k
        Temperature at which the loop starts and ends [K].
    hottest_k
        Temperature at which it turns [K].
    points
        Number of temperatures each way.

    Returns
    -------
    The loop.
    """
    up = np.linspace(coldest_k, hottest_k, points)
    kelvin = np.concatenate([up, up[-2::-1]])
    path = isobaric_path(constants_from(alloy, wire, bench), stress_pa, kelvin)
    return IsobaricLoop(stress_pa, kelvin, path.strain)


def summarize_isobar(isobar: IsobaricLoop) -> IsobarSummary:
    """Return stroke and transformation temperatures of a loop, measured or simulated.

    A branch is complete by 10 % when it has covered a tenth of its own range of strain. Raises RecordingError if the
    loop has no stroke or temperature does not rise and fall.
    """
    hottest = int(np.argmax(isobar.temperature_k))
    stroke = float(np.ptp(isobar.strain))
    if not (0 < hottest < isobar.strain.size - 1 and stroke > 0.0):
        raise RecordingError(
            "an isobar must go from cold to hot and back, and its strain change on the way: it is hottest in row "
            f"{hottest + 1} of {isobar.strain.size}, and its strain changes by {100 * stroke:.2g} %"
        )
    heating = crossings(isobar.temperature_k[: hottest + 1], isobar.strain[: hottest + 1])
    cooling = crossings(isobar.temperature_k[hottest:][::-1], isobar.strain[hottest:][::-1])
    # Cooling runs the other way: at its first tenth nine tenths of the strain are still to come.
    return IsobarSummary(isobar.stress_pa, stroke, heating, (cooling[2], cooling[1], cooling[0]))


def crossings(temperature_k: FloatArray, strain: FloatArray) -> tuple[float, float, float]:
    """Return the temperatures [K] at which a branch, in order of temperature, has lost 10, 50, 90 % of its strain."""
    lost = (strain.max() - strain) / np.ptp(strain)
    # Noise may pass a level several times: the running maximum passes it once.
    rising = np.maximum.accumulate(lost)
    first, half, last = (interpolated(temperature_k, rising, fraction) for fraction in FRACTIONS)
    return first, half, last


def interpolated(temperature_k: FloatArray, rising: FloatArray, fraction: float) -> float:
    """Return the temperature at which ``rising`` first passes ``fraction``."""
    after = int(np.argmax(rising >= fraction))
    if after == 0:
        return float(temperature_k[0])
    before = after - 1
    part = (fraction - rising[before]) / (rising[after] - rising[before])
    return float(temperature_k[before] + part * (temperature_k[after] - temperature_k[before]))


def half_transformation_slope_pa_per_k(summaries: Sequence[IsobarSummary], branch: str) -> float:
    """Return the Clausius-Clapeyron slope [Pa/K] of a branch, fitted as temperature over stress: stress is exact."""
    stress = [summary.stress_pa for summary in summaries]
    half = [getattr(summary, f"{branch}_k")[1] for summary in summaries]
    return float(1.0 / np.polyfit(stress, half, 1)[0])
