"""Measured isobars of Flexinol (studies/data/flexinol_isobars/SOURCE.md) and what can be read off their branches."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.identify import IsobaricLoop

FloatArray = NDArray[np.float64]

DATA = Path(__file__).parent / "data" / "flexinol_isobars"
STRESSES_MPA = (50.0, 100.0, 150.0, 172.0, 200.0)
ZERO_CELSIUS_K = 273.15
# Parts of the stroke that are left, from the cold end to the hot one, at which the branches are compared.
LEFT = (0.97, 0.95, 0.90, 0.80, 0.70, 0.50, 0.30, 0.20, 0.10, 0.05, 0.03)
# Strains linear in temperature that are tried, in steps of 0.5e-6 per kelvin.
TRIED_PER_K = np.linspace(-30e-6, 90e-6, 241)
# The extensometer's steps make rates over less than this meaningless.
RATE_OVER_K = 3.0


class Levelled(NamedTuple):
    """A loop less the strain linear in temperature that makes the distance of its branches most even."""

    per_k: float
    stroke: float
    distances_k: FloatArray

    @property
    def barrier_k(self) -> float:
        """Half of the mean distance."""
        return 0.5 * float(self.distances_k.mean())

    @property
    def spread_k(self) -> float:
        """Standard deviation of half of the distance over the parts of the stroke."""
        return 0.5 * float(self.distances_k.std())


def measured_isobar(stress_mpa: float) -> IsobaricLoop:
    """Return the measured loop at one of the five stresses, cold to hot to cold."""
    with (DATA / f"flexinol_{stress_mpa:.0f}MPa.csv").open(encoding="utf-8") as file:
        rows = [(float(row["temperature_degc"]), float(row["strain"])) for row in csv.DictReader(file)]
    degc, strain = np.array(rows).T
    return IsobaricLoop(1e6 * stress_mpa, degc + ZERO_CELSIUS_K, strain)


def branches(loop: IsobaricLoop) -> tuple[FloatArray, FloatArray]:
    """Return heating and cooling as temperature and strain in order of temperature, each (2, n)."""
    hottest = int(np.argmax(loop.temperature_k))
    both = np.array([loop.temperature_k, loop.strain])
    heating, cooling = both[:, : hottest + 1], both[:, hottest:]
    return heating[:, np.argsort(heating[0], kind="stable")], cooling[:, np.argsort(cooling[0], kind="stable")]


def temperatures_k(branch: FloatArray, strains: FloatArray) -> FloatArray:
    """Return where a branch passes strains, falling with temperature; rises on the way, of noise, are levelled."""
    kelvin, strain = branch
    falling = np.maximum.accumulate(strain[::-1])
    return np.interp(strains, falling, kelvin[::-1])


def distances_k(loop: IsobaricLoop, left: tuple[float, ...] = LEFT) -> FloatArray:
    """Return by how much heating is hotter than cooling where equal parts of the whole loop's stroke are left."""
    heating, cooling = branches(loop)
    strains = loop.strain.min() + np.array(left) * np.ptp(loop.strain)
    return temperatures_k(heating, strains) - temperatures_k(cooling, strains)


def less_linear_strain(loop: IsobaricLoop, per_k: float) -> IsobaricLoop:
    """Return a loop without a strain that falls by ``per_k`` per kelvin on both branches alike."""
    return loop._replace(strain=loop.strain - per_k * (loop.temperature_k.max() - loop.temperature_k))


def levelled(loop: IsobaricLoop) -> Levelled:
    """Return the loop with the strain linear in temperature taken off that leaves the most even distance."""
    rests = [(per_k, less_linear_strain(loop, per_k)) for per_k in TRIED_PER_K]
    found = [Levelled(float(per_k), float(np.ptp(rest.strain)), distances_k(rest)) for per_k, rest in rests]
    return min(found, key=lambda each: each.spread_k)


def rates_after_turns_per_k(loop: IsobaricLoop, over_k: float = 20.0) -> tuple[float, float]:
    """Return the change of strain per kelvin over the first kelvins after the cold turn and after the hot one.

    The first kelvin at each turn is left out: stress and temperature settle there.
    """
    heating, cooling = branches(loop)
    coldest, hottest = heating[0, 0], cooling[0, -1]
    rates = []
    for branch, low, high in (
        (heating, coldest + 1.0, coldest + 1.0 + over_k),
        (cooling, hottest - 1.0 - over_k, hottest - 1.0),
    ):
        cold_end, hot_end = np.interp([low, high], *branch)
        rates.append(float(hot_end - cold_end) / over_k)
    return rates[0], rates[1]


def steepest_rates_per_k(loop: IsobaricLoop, over_k: float = RATE_OVER_K) -> tuple[float, float]:
    """Return the largest part of the stroke that either branch does in a kelvin, mean over ``over_k``."""
    found = []
    for kelvin, strain in branches(loop):
        low = np.linspace(kelvin[0], kelvin[-1] - over_k, 2000)
        fall = np.interp(low, kelvin, strain) - np.interp(low + over_k, kelvin, strain)
        found.append(float(fall.max()) / over_k / float(np.ptp(loop.strain)))
    return found[0], found[1]


def austenite_start_k(loop: IsobaricLoop, over_k: float = RATE_OVER_K) -> float:
    """Return where the tangent to the steepest part of heating meets the line through its first 20 K."""
    kelvin, strain = branches(loop)[0]
    low = np.linspace(kelvin[0], kelvin[-1] - over_k, 2000)
    fall = (np.interp(low, kelvin, strain) - np.interp(low + over_k, kelvin, strain)) / over_k
    middle_k = float(low[np.argmax(fall)] + 0.5 * over_k)
    rate, offset = np.polyfit(*branches(loop)[0][:, kelvin < kelvin[0] + 20.0], 1)
    steepest = float(fall.max())
    return float((np.interp(middle_k, kelvin, strain) + steepest * middle_k - offset) / (steepest + rate))
