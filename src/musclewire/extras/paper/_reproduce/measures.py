"""Measures of loops and runs: distances between curves, excursions, a gap by plain means."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.extras.paper._reproduce.loops import SlowSineLoop
from musclewire.sensing import Branch, hysteresis_gap, signed_hysteresis_gap

POINTS = 400


def last_cycle(loop: SlowSineLoop) -> NDArray[np.bool_]:
    """Return which samples belong to the last cycle, (n_times,)."""
    cycle = loop.recording["cycle"]
    return np.asarray(cycle == cycle.max())


def drive_branches(loop: SlowSineLoop) -> tuple[Branch, Branch]:
    """Return the last cycle's strain over rising drive voltage [V], heating and cooling."""
    part = last_cycle(loop)
    drive, strain = loop.recording["drive_voltage_v"][part], loop.quantity("strain")[part]
    top = int(np.argmax(drive))
    return Branch(drive[: top + 1], strain[: top + 1]), Branch(drive[top:][::-1], strain[top:][::-1])


def off_temperature_pct(loop: SlowSineLoop) -> float:
    """Return the mean distance of strain over voltage from strain over temperature [% of the largest strain].

    A temperature has the place of the voltage at which heating and cooling have it on average.
    """
    part = last_cycle(loop)
    drive, strain, temperature = loop.recording["drive_voltage_v"], loop.quantity("strain"), loop.true_temperature_k
    return off_place_pct(drive[part], strain[part], temperature[part])


def off_place_pct(drive: FloatArray, strain: FloatArray, temperature: FloatArray) -> float:
    """Return the same of one cycle whose drive rises and falls, each (n,)."""
    top = int(np.argmax(drive))
    paths = (slice(None, top + 1), slice(None, top - 1 if top else None, -1))
    volts = np.linspace(max(drive[0], drive[-1]), drive[top], POINTS)
    degrees = np.mean([np.interp(volts, drive[path], temperature[path]) for path in paths], axis=0)
    distances = []
    for path in paths:
        order = np.argsort(temperature[path], kind="stable")
        by_temperature = np.interp(degrees, temperature[path][order], strain[path][order])
        distances.append(np.abs(np.interp(volts, drive[path], strain[path]) - by_temperature))
    return float(100.0 * np.mean(distances) / strain.max())


def off_line_pct(branch: Branch) -> float:
    """Return the largest distance of a curve from the straight line fitted to it [% of its largest value]."""
    ohm, values = branch
    places = np.linspace(ohm[0], ohm[-1], POINTS)
    curve = np.interp(places, ohm, values)
    line = np.polyval(np.polyfit(places, curve, 1), places)
    return float(100.0 * np.abs(curve - line).max() / np.max(values))


def drive_gap_pct(loop: SlowSineLoop) -> float:
    """Return Eq. 2 over equal drive voltage in place of equal resistance, over the whole cycle [%]."""
    heating, cooling = drive_branches(loop)
    low, high = max(heating[0][0], cooling[0][0]), min(heating[0][-1], cooling[0][-1])
    volts = np.linspace(low, high, POINTS)
    distance = np.abs(np.interp(volts, *heating) - np.interp(volts, *cooling))
    return float(100.0 * distance.mean() / max(heating.quantity.max(), cooling.quantity.max()))


def outside_band(place: FloatArray, value: FloatArray, lower: Branch, upper: Branch) -> float:
    """Return the largest distance of points, (n,), outside the band of two curves, which keep their last values."""
    first, second = np.interp(place, *lower), np.interp(place, *upper)
    bottom, top = np.minimum(first, second), np.maximum(first, second)
    return float(np.maximum(np.maximum(bottom - value, value - top), 0.0).max())


def outside_loop_pct(minor: SlowSineLoop, major: SlowSineLoop) -> float:
    """Return the largest excursion of a minor loop out of a major one, strain over drive voltage [% strain]."""
    heating, cooling = drive_branches(major)
    part = last_cycle(minor)
    return 100.0 * outside_band(
        minor.recording["drive_voltage_v"][part], minor.quantity("strain")[part], heating, cooling
    )


def plain_gap_pct(loop: SlowSineLoop) -> float:
    """Return Eq. 2 between B and C with NumPy alone [%]: samples sorted by resistance, no smoothing, no pooling."""
    found = loop.gaps.segments
    curves = []
    for branch in (found.heating, found.cooling):
        order = np.argsort(branch.resistance_ohm, kind="stable")
        curves.append((branch.resistance_ohm[order], branch.quantity[order]))
    (up_ohm, up), (down_ohm, down) = curves
    places = np.linspace(max(up_ohm[0], down_ohm[0]), min(up_ohm[-1], down_ohm[-1]), POINTS)
    differences = np.abs(np.interp(places, up_ohm, up) - np.interp(places, down_ohm, down))
    return float(100.0 * differences.mean() / max(up.max(), down.max()))


def largest_distance(one: Branch, other: Branch) -> float:
    """Return the largest distance of curves at equal resistance. Raises RecordingError if they share none."""
    places = shared_places(one, other)
    return float(np.abs(np.interp(places, *one) - np.interp(places, *other)).max())


def shared_places(one: Branch, other: Branch) -> FloatArray:
    """Return evenly spaced resistances that both curves have, (400,)."""
    low = max(float(one.resistance_ohm[0]), float(other.resistance_ohm[0]))
    high = min(float(one.resistance_ohm[-1]), float(other.resistance_ohm[-1]))
    if not high > low:
        raise RecordingError(
            f"two curves share no resistance, one begins at {low:.4g} ohm, one ends at {high:.4g} ohm: take curves of "
            "one wire"
        )
    return np.linspace(low, high, POINTS)


def force_ratio_of(soft: SlowSineLoop, stiff: SlowSineLoop) -> float:
    """Return the mean contraction force of ``stiff`` over that of ``soft`` at equal resistance, both branches."""
    sums = np.zeros(2)
    for one, other in zip(soft.sensing_branches("force"), stiff.sensing_branches("force"), strict=True):
        places = shared_places(one, other)
        sums += (np.interp(places, *one).mean(), np.interp(places, *other).mean())
    return float(sums[1] / sums[0])


def one_sided_fraction(heating: Branch, cooling: Branch) -> float:
    """Return the size of the signed gap over the gap: 1 for branches that do not intersect, less for those that do."""
    return abs(signed_hysteresis_gap(heating, cooling)) / hysteresis_gap(heating, cooling)


def rank_correlation(places: Sequence[float], values: Sequence[float]) -> float:
    """Return Spearman's rank correlation, -1 for falling to 1 for rising values; equal ones rank in their order."""
    ranks = [np.argsort(np.argsort(row, kind="stable"), kind="stable") for row in (places, values)]
    return float(np.corrcoef(ranks[0], ranks[1])[0, 1])


def falling_steps(values: Sequence[float]) -> int:
    """Return how many values are below the one before."""
    return int((np.diff(values) < 0.0).sum())


def lowest_place(places: Sequence[float], values: Sequence[float]) -> float:
    """Return the place of the smallest value: an end, or the vertex of the parabola through three."""
    at, height = np.asarray(places, dtype=np.float64), np.asarray(values, dtype=np.float64)
    lowest = int(np.argmin(height))
    if lowest in {0, at.size - 1}:
        return float(at[lowest])
    near = slice(lowest - 1, lowest + 2)
    bend, slope, _ = np.polyfit(at[near] - at[lowest], height[near], 2)
    return float(at[lowest] - slope / (2.0 * bend)) if bend > 0.0 else float(at[lowest])
