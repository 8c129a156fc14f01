"""Isobaric strain-temperature loops as an observation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.extras.calibration._physical.candidates import WireValues, candidate_constants
from musclewire.extras.calibration._physical.observations import CURVE_STRETCHES, ObservedChannel, with_model_error
from musclewire.identify import IsobaricLoop
from musclewire.sensing import noise_level
from musclewire.signals import Recording
from musclewire.wire import isobaric_path

# Error expected of a model of this kind in the strain of an isobar.
ISOBAR_ERROR = 2e-4
# Stress belongs to one isobar if its means differ by less than both of these together:
SAME_STRESS = 0.03  # of the stress
SAME_STRESS_PA = 1e5  # [Pa]
MIN_POINTS = 20  # rows of an isobar over heating and cooling
MIN_STROKE = 1e-3  # strain over an isobar: with less no wire has transformed
MEAN_ROWS = MIN_POINTS // 2  # rows over which stress is averaged, as a load cell scatters
# Standard deviations by which two means may differ and be equal: the largest of some hundred differences exceeds 4
# about once in two hundred.
SAME_BY_SCATTER = 5.0
# Within an isobar, means over this fraction of its rows show whether stress drifts or follows the wire.
STRETCH_FRACTION = 0.1
MIN_RANGE_K = 5.0  # [K]: a smaller range of temperature shows no loop
MAX_STRESS_PA = 3e9  # [Pa]: a wire breaks far below


class IsobaricObservation:
    """One wire under several constant stresses, one after the other, with one extensometer.

    The extensometer's zero is not the model's; it is fitted once for all isobars, so that differences in strain between
    stresses count.
    """

    def __init__(self, title: str, isobars: Sequence[IsobaricLoop], model_error: float = ISOBAR_ERROR) -> None:
        """Take loops whose strains are positive in elongation."""
        self.title = title
        self._isobars = list(isobars)
        self.channels: Sequence[ObservedChannel] = [
            ObservedChannel(
                f"strain at {isobar.stress_pa / 1e6:.4g} MPa",
                "1",
                isobar.temperature_k,
                isobar.strain,
                with_model_error(noise_level(isobar.strain), model_error, isobar.strain.size, CURVE_STRETCHES),
            )
            for isobar in isobars
        ]

    def refined(self) -> IsobaricObservation:
        """Return the observation itself: an isobar has no time step."""
        return self

    def simulate(self, values: WireValues) -> Mapping[str, FloatArray]:
        """Return the strain of this wire along each isobar's temperatures, on the extensometer's zero."""
        constants = candidate_constants(values, values.wire, values.bench)
        strains = [isobaric_path(constants, item.stress_pa, item.temperature_k).strain for item in self._isobars]
        zero = float(np.mean(np.concatenate([item.strain for item in self._isobars]) - np.concatenate(strains)))
        return {channel.name: strain + zero for channel, strain in zip(self.channels, strains, strict=True)}


def counts_contraction(isobars: Sequence[IsobaricLoop]) -> bool:
    """Return whether strain rises with temperature over all loops: almost without load it only expands."""
    return sum(float(np.cov(item.temperature_k, item.strain)[0, 1]) for item in isobars) > 0.0


def in_elongation(isobars: Sequence[IsobaricLoop]) -> list[IsobaricLoop]:
    """Return isobars, which all have the same sign of strain, with strain positive in elongation."""
    sign = -1.0 if counts_contraction(isobars) else 1.0
    return [item._replace(strain=sign * item.strain) for item in isobars]


def isobars_in(recording: Recording) -> list[IsobaricLoop]:
    """Return the isobars of a recording with temperature, strain and stress, with the recording's sign of strain.

    The stress may scatter about its mean, as a load cell's does; it may not move slowly with time or with the wire.
    Raises RecordingError if temperature is constant, or stress is not constant over a loop.
    """
    temperature_k, stress_pa = recording["wire_temperature_k"], recording["stress_pa"]
    if np.ptp(temperature_k) < MIN_RANGE_K:
        raise RecordingError(
            f"the temperature changes by {np.ptp(temperature_k):.2g} K: record an isobar from cold to hot and back"
        )
    scatter_pa = noise_level(stress_pa)
    if not (stress_pa.min() >= -SAME_BY_SCATTER * scatter_pa and stress_pa.max() < MAX_STRESS_PA):
        raise RecordingError(
            f"stress goes from {stress_pa.min() / 1e6:.4g} to {stress_pa.max() / 1e6:.4g} MPa: it must be tension, "
            "positive, and below what breaks a wire; check its unit and sign"
        )
    strain = recording["reference_strain"]
    found = []
    starts = [0, *changes_of_level(stress_pa, scatter_pa)]
    for start, stop in zip(starts, [*starts[1:], len(recording)], strict=True):
        if stop - start < MIN_POINTS:
            raise RecordingError(
                f"stress changes at row {stop + 1} after {stop - start} rows: an isobar needs at "
                f"least {MIN_POINTS} points at one stress, over heating and cooling"
            )
        part = slice(start, stop)
        refuse_moving(stress_pa[part], scatter_pa, start)
        found.append(IsobaricLoop(float(np.median(stress_pa[part])), temperature_k[part], strain[part]))
    return found


def changes_of_level(stress_pa: FloatArray, scatter_pa: float) -> list[int]:
    """Return the rows at which a stress, (n,), steps: where means over the rows before and after differ most."""
    rows = np.arange(1, stress_pa.size)
    total = np.concatenate([[0.0], np.cumsum(stress_pa)])
    first, last = np.maximum(rows - MEAN_ROWS, 0), np.minimum(rows + MEAN_ROWS, stress_pa.size)
    before, after = (total[rows] - total[first]) / (rows - first), (total[last] - total[rows]) / (last - rows)
    scatter = scatter_pa * np.sqrt(1.0 / (rows - first) + 1.0 / (last - rows))
    excess = np.abs(after - before) - same_stress(after, scatter)
    stretches = np.flatnonzero(np.diff(np.concatenate([[False], excess > 0.0, [False]]).astype(np.int8)))
    return [int(rows[begin + np.argmax(excess[begin:end])]) for begin, end in stretches.reshape(-1, 2)]


def same_stress(stress_pa: FloatArray, scatter_pa: FloatArray | float) -> FloatArray:
    """Return by how much [Pa] two means near ``stress_pa`` may differ if the difference scatters so."""
    return np.asarray(SAME_STRESS * np.abs(stress_pa) + SAME_STRESS_PA + SAME_BY_SCATTER * np.asarray(scatter_pa))


def refuse_moving(stress_pa: FloatArray, scatter_pa: float, first_row: int) -> None:
    """Raise RecordingError if the stress of an isobar, (n,), moves slowly instead of scattering about one value."""
    count = int(min(round(1.0 / STRETCH_FRACTION), stress_pa.size // 4))
    stretches = np.array_split(stress_pa, count)
    means = np.array([stretch.mean() for stretch in stretches])
    rows = min(stretch.size for stretch in stretches)
    if np.ptp(means) <= same_stress(means.mean(), scatter_pa * np.sqrt(2.0 / rows)):
        return
    raise RecordingError(
        f"stress is not constant: from row {first_row + 1} to {first_row + stress_pa.size} it moves slowly between "
        f"{means.min() / 1e6:.4g} and {means.max() / 1e6:.4g} MPa, while it scatters by {scatter_pa / 1e6:.2g} MPa "
        "about its trend: an isobar is taken under a weight; a wire on a spring is a recording of a drive"
    )


def observe_isobars(isobars: Sequence[IsobaricLoop]) -> IsobaricObservation:
    """Return isobars as one observation. Raises RecordingError if none of them shows a transformation."""
    strokes = [float(np.ptp(item.strain)) for item in isobars]
    if max(strokes) < MIN_STROKE:
        raise RecordingError(
            f"strain changes by {100.0 * max(strokes):.3g} % at most: nothing transforms between "
            f"{min(item.temperature_k.min() for item in isobars) - 273.15:.0f} C and "
            f"{max(item.temperature_k.max() for item in isobars) - 273.15:.0f} C, so nothing can be identified"
        )
    return IsobaricObservation("isobars", sorted(isobars, key=lambda item: item.stress_pa))
