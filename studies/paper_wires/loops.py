"""One noise-free slow loop: its points A, B, C, branches and gaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from musclewire.sensing import parabola_maximum
from musclewire.wire import DrivenPath, WireConstants
from paper_wires.unknowns import FloatArray

Curve = tuple[FloatArray, FloatArray]
POINTS = 200


@dataclass(frozen=True, eq=False)
class Loop:
    """Branches from B to C as (resistance [ohm] rising, strain), force likewise, and what the whole loop reached."""

    heating: Curve
    cooling: Curve
    force_heating: Curve
    force_cooling: Curve
    stroke: float
    segment_ab_pct: float
    min_martensite: float

    @property
    def min_ohm(self) -> float:
        """R_min: the heating branch's end C."""
        return float(self.heating[0][0])

    @property
    def largest_ohm(self) -> float:
        """R_max: the heating branch's start B."""
        return float(self.heating[0][-1])

    @property
    def strain_gap_pct(self) -> float:
        """Eq. 2."""
        return gap_pct(self.heating, self.cooling)

    @property
    def force_gap_pct(self) -> float:
        """Eq. 2, of the contraction force."""
        return gap_pct(self.force_heating, self.force_cooling)

    @property
    def largest_distance_pct(self) -> float:
        """Largest distance of heating and cooling branch at equal resistance, in percent of the stroke."""
        low, high = max(self.heating[0][0], self.cooling[0][0]), min(self.heating[0][-1], self.cooling[0][-1])
        ohm = np.linspace(low, high, POINTS)
        apart = np.abs(np.interp(ohm, *self.heating) - np.interp(ohm, *self.cooling)).max()
        return 100.0 * float(apart) / self.stroke

    def polynomial_misfit_pct(self, branch: str) -> float:
        """Return what a sixth-order polynomial leaves of a branch, rms in percent strain (Eq. 4)."""
        ohm, strain = getattr(self, branch)
        rows = np.linspace(0, ohm.size - 1, 150).astype(int)
        normalised = ((ohm - ohm[0]) / (ohm[-1] - ohm[0]))[rows]
        return 100.0 * float(np.std(strain[rows] - np.polyval(np.polyfit(normalised, strain[rows], 6), normalised)))

    def off_average(self, values: Sequence[float]) -> list[tuple[float, float]]:
        """Return how far both branches are from the averaged polynomial where that has these values, relative to them.

        The model of Eqs. 3 to 5 is inverted for each value; the branches are read at the resistance found.
        """
        low, high = float(self.heating[0][0]), float(self.heating[0][-1])
        normalised = np.linspace(0.0, 1.0, 2 * POINTS)
        average = np.zeros_like(normalised)
        for ohm, value in (self.heating, self.cooling):
            rows = np.linspace(0, ohm.size - 1, 120).astype(int)
            average += 0.5 * np.polyval(np.polyfit((ohm[rows] - low) / (high - low), value[rows], 6), normalised)
        found = []
        for value in values:
            ohm_there = low + (high - low) * normalised[int(np.argmin(np.abs(average - value)))]
            up, down = (float(np.interp(ohm_there, *branch)) for branch in (self.heating, self.cooling))
            found.append((up / value - 1.0, down / value - 1.0))
        return found

    def distance_pct(self, other: Loop, branch: str) -> float:
        """Return the largest distance of two loops' branches where they overlap, in percent of the larger stroke."""
        ours, theirs = getattr(self, branch), getattr(other, branch)
        ohm = np.linspace(max(ours[0][0], theirs[0][0]), min(ours[0][-1], theirs[0][-1]), 150)
        apart = np.abs(np.interp(ohm, *ours) - np.interp(ohm, *theirs)).max()
        return 100.0 * float(apart) / max(self.stroke, other.stroke)


def analysed(path: DrivenPath, quantity: FloatArray, pretension_n: float, constants: WireConstants) -> Loop:
    """Return the loop of a path that went once from cold to hot and back, for strain or a displacement, (n_samples,).

    Resistance is from the voltages, means over a sample as displacement and force are: that at a sample's end would be
    ahead of them by half a sample, which the gap of two close branches shows.
    """
    ohm = path.wire_voltage_v / path.shunt_voltage_v * constants.shunt_resistance_ohm
    force = path.force_n - pretension_n
    hottest = int(np.argmax(path.temperature_k))
    b = int(np.argmax(ohm[: hottest + 1]))
    c = b + int(np.argmin(ohm[b : hottest + 1]))
    c_cooling = hottest + int(np.argmin(ohm[hottest:]))
    b_cooling = c_cooling + int(np.argmax(ohm[c_cooling:]))
    up, down = slice(b, c + 1), slice(c_cooling, b_cooling + 1)
    return Loop(
        heating=rising(ohm[up][::-1], quantity[up][::-1]),
        cooling=rising(ohm[down], quantity[down]),
        force_heating=rising(ohm[up][::-1], force[up][::-1]),
        force_cooling=rising(ohm[down], force[down]),
        stroke=float(quantity.max()),
        segment_ab_pct=segment_ab_pct(ohm, quantity, b, c),
        min_martensite=float(path.martensite_fraction.min()),
    )


def segment_ab_pct(ohm: FloatArray, strain: FloatArray, b: int, c: int) -> float:
    """Return the share of A-B in the strain of a heating branch, as a recording's second cycle shows it [%].

    B is the maximum of resistance as on recordings; A, where the next heating begins, is the path's end: friction and
    grains that stay austenite leave some strain there which the very first heating does not start from.
    """
    at_b = float(np.interp(parabola_maximum(ohm, b).place, np.arange(strain.size), strain))
    cold = float(strain[-1])
    return 100.0 * (at_b - cold) / (float(strain[c]) - cold)


def rising(ohm: FloatArray, values: FloatArray) -> Curve:
    """Return a curve whose resistance never falls."""
    return np.maximum.accumulate(ohm + 1e-12 * np.arange(ohm.size)), values


def gap_pct(heating: Curve, cooling: Curve) -> float:
    """Return the mean distance of two branches at equal resistance, in percent of the largest value (Eq. 2)."""
    low, high = max(heating[0][0], cooling[0][0]), min(heating[0][-1], cooling[0][-1])
    ohm = low + (high - low) * (np.arange(POINTS) + 0.5) / POINTS
    apart = np.abs(np.interp(ohm, *heating) - np.interp(ohm, *cooling))
    return 100.0 * float(np.mean(apart)) / max(float(heating[1].max()), float(cooling[1].max()))
