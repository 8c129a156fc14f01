"""How far noise moves point B of a slow loop: A-B as a share of the strain, and R_max, over 50 seeds.

First the definition that musclewire uses (sensing/resistance_maximum.py), on wires of three diameters, pretensions, a
minor loop, other sample periods and a wire with an early population of grains, each with one, three and ten times the
noise of the paper's bench: A-B without noise; its mean over the seeds less that (bias) and its standard deviation, in
points; R_max likewise [mohm]. Then other definitions on the same loops with the bench's noise. A definition that reads
the maximum of resistance has the same A-B without noise as the first one; the others mean another place.
Exits with 1 if the bench's own noise alone (bias and two standard deviations) takes up what the paper's rows allow:
4 points of A-B, 20 mohm of R_max. --quick: the paper's wire alone; --json: one document.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_smoothing_spline

from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.sensing import LoopSegments, find_segments, noise_level, smooth, smoothing_window
from musclewire.wire import constants_of, drive_path

Array = NDArray[np.float64]

SEEDS, NOISES = 50, (1.0, 3.0, 10.0)
PERIOD_S, CYCLES = 90.0, 2
# An early population of grains: with one, resistance over strain has a broad top.
EARLY = {"early_fraction": 1.0 / 6.0, "early_width": 3.5}
# What the rows of `reproduce` allow these two to be off.
ALLOWED = {"ab_points": 4.0, "resistance_max_mohm": 20.0}


class Case(NamedTuple):
    """A wire, what pulls it, and how it is driven and sampled; the wire's own amplitude if None."""

    name: str
    wire: str = "paper-100um"
    pretension_n: float = 1.9
    amplitude_v: float | None = None
    sample_s: float = 0.05
    early: bool = False


CASES = (
    Case("100 um, 1.9 N"),
    Case("100 um, 1.1 N", pretension_n=1.1),
    Case("100 um, 3.0 N", pretension_n=3.0),
    Case("125 um, 1.70 N", "paper-125um", 1.70),
    Case("125 um, 4.67 N", "paper-125um", 4.67),
    Case("200 um, 7.53 N", "paper-200um", 7.53),
    Case("100 um, 1.9 N, 2.75 V", amplitude_v=2.75),
    Case("100 um, 1.9 N, 10 ms", sample_s=0.01),
    Case("100 um, 1.9 N, 500 ms", sample_s=0.5),
    Case("100 um, early population", early=True),
)
COMPARED = (CASES[0], CASES[-1])


class Course(NamedTuple):
    """A loop without noise as the bench reads it, (n_samples,) each, and the noise of its readings."""

    wire_voltage_v: Array
    shunt_voltage_v: Array
    strain: Array
    shunt_ohm: float
    voltage_noise_v: float
    strain_noise: float

    def read(self, noises: float, seed: int) -> tuple[Array, Array]:
        """Return resistance [ohm] and strain with a multiple of the bench's noise."""
        draw = np.random.default_rng(seed)
        wire_v, shunt_v = (
            volts + noises * self.voltage_noise_v * draw.standard_normal(volts.size)
            for volts in (self.wire_voltage_v, self.shunt_voltage_v)
        )
        strain = self.strain + noises * self.strain_noise * draw.standard_normal(self.strain.size)
        return wire_v / shunt_v * self.shunt_ohm, strain


@lru_cache
def course_of(case: Case) -> Course:
    """Return the slow sine of a case."""
    spool, bench = load_wire(case.wire), dict(load_bench("paper").values())
    bench["pretension_n"] = case.pretension_n
    material, numbers = load_alloy(spool.alloy).values(), spool.values()
    constants = constants_of({**material, **(EARLY if case.early else {})}, numbers, bench)
    time_s = case.sample_s * np.arange(round(CYCLES * PERIOD_S / case.sample_s))
    sense_v, top_v = bench["sense_voltage_v"], case.amplitude_v or numbers["drive_amplitude_v"]
    drive_v = sense_v + (top_v - sense_v) * 0.5 * (1.0 - np.cos(2.0 * math.pi * time_s / PERIOD_S))
    path, _ = drive_path(constants, drive_v, sample_s=case.sample_s)
    # The converter's steps add to the noise of a reading; a sample of another length is a mean of other many readings.
    step_v = 2.0 * bench["acquisition_range_v"] / 2.0 ** bench["acquisition_bits"]
    readings = bench["acquisition_readings"] * case.sample_s / bench["sample_period_s"]
    noise_v = math.sqrt((bench["acquisition_noise_v"] ** 2 + step_v**2 / 12.0) / readings)
    strain = path.displacement_m / constants.leg_length_m
    strain_noise = bench["displacement_noise_m"] / constants.leg_length_m
    return Course(
        path.wire_voltage_v, path.shunt_voltage_v, strain, constants.shunt_resistance_ohm, noise_v, strain_noise
    )


class Half(NamedTuple):
    """The samples of a loop from A to C on heating: measured, smoothed, and the loop they are of."""

    resistance: Array
    strain: Array
    smoothed: Array
    loop: LoopSegments

    @classmethod
    def of(cls, resistance: Array, strain: Array) -> Half:
        """Cut a loop."""
        loop = find_segments(resistance, strain)
        window = smoothing_window(
            noise_level(resistance), float(np.ptp(resistance)), int(0.03 * resistance.size / (2 * CYCLES))
        )
        part = slice(loop.heating_a, loop.heating_c + 1)
        return cls(resistance[part], strain[part], smooth(resistance, window)[part], loop)

    def share_pct(self, strain_at_b: float) -> float:
        """Return A-B as a share of the strain from A to C [%]."""
        at_c = float(np.median(self.strain[-9:]))
        return 100.0 * (strain_at_b - self.loop.strain_cold) / (at_c - self.loop.strain_cold)

    def near_the_top(self, fraction: float) -> NDArray[np.int64]:
        """Return the samples around B within a fraction of the fall to C below it."""
        b = self.loop.heating_b - self.loop.heating_a
        low = self.smoothed[b] - fraction * (self.smoothed[b] - self.smoothed[-1])
        below = np.flatnonzero(self.smoothed < low)
        first, last = below[below < b], below[below > b]
        return np.arange(first[-1] + 1 if first.size else 0, last[0] if last.size else self.smoothed.size)


def by_musclewire(half: Half) -> float:
    """Return A-B by the definition in use [%]."""
    return 100.0 * (1.0 - half.loop.transformation_fraction)


def by_largest_sample(half: Half) -> float:
    """Return A-B where the smoothed resistance is largest [%]."""
    return half.share_pct(half.strain[int(np.argmax(half.smoothed))])


def by_polynomial(half: Half, order: int, fraction: float) -> float:
    """Return A-B where a polynomial through the samples near the top is largest [%]."""
    rows = half.near_the_top(fraction)
    place = np.linspace(-1.0, 1.0, rows.size)
    fine = np.linspace(-1.0, 1.0, 2001)
    top = fine[np.argmax(np.polyval(np.polyfit(place, half.resistance[rows], order), fine))]
    return half.share_pct(float(np.polyval(np.polyfit(place, half.strain[rows], 4), top)))


def by_spline(half: Half) -> float:
    """Return A-B where a smoothing spline (generalised cross-validation) is largest [%]."""
    rows = half.near_the_top(0.15)
    fine = np.linspace(rows[0], rows[-1], 4001)
    top = fine[np.argmax(make_smoothing_spline(rows.astype(np.float64), half.resistance[rows])(fine))]
    return half.share_pct(float(np.interp(top, rows, half.strain[rows])))


def by_chord(half: Half, fraction: float) -> float:
    """Return A-B at the middle of the chord of the top, in strain [%]."""
    rows = half.near_the_top(fraction)
    return half.share_pct(0.5 * float(half.strain[rows[0]] + half.strain[rows[-1]]))


def by_continuation(half: Half, low: float, high: float) -> float:
    """Return A-B where the straight line through a part of B-C reaches R_max [%]."""
    span = half.loop.resistance_max_ohm - half.loop.resistance_min_ohm
    normalised = (half.smoothed - half.loop.resistance_min_ohm) / span
    after_b = np.arange(normalised.size) > half.loop.heating_b - half.loop.heating_a
    rows = after_b & (normalised > low) & (normalised < high)
    slope, level = np.polyfit(half.strain[rows], half.resistance[rows], 1)
    return half.share_pct((half.loop.resistance_max_ohm - level) / slope)


DEFINITIONS: dict[str, Callable[[Half], float]] = {
    "polynomial that suffices (in use)": by_musclewire,
    "largest smoothed sample (before)": by_largest_sample,
    "parabola within 3 % of the fall": lambda half: by_polynomial(half, 2, 0.03),
    "cubic within 1 % of the fall": lambda half: by_polynomial(half, 3, 0.01),
    "cubic within 3 % of the fall": lambda half: by_polynomial(half, 3, 0.03),
    "cubic within 5 % of the fall": lambda half: by_polynomial(half, 3, 0.05),
    "smoothing spline": by_spline,
    "middle of the chord 2 % below": lambda half: by_chord(half, 0.02),
    "middle of the chord 5 % below": lambda half: by_chord(half, 0.05),
    "line from 50 to 80 % of R to R_max": lambda half: by_continuation(half, 0.5, 0.8),
    "line from 80 to 95 % of R to R_max": lambda half: by_continuation(half, 0.8, 0.95),
}


def noise_row(case: Case, noises: float) -> dict[str, Any]:
    """Return bias and spread of A-B and R_max of a case with a multiple of the bench's noise."""
    course = course_of(case)
    clean = find_segments(*course.read(0.0, 0))
    loops = [find_segments(*course.read(noises, seed)) for seed in range(1, SEEDS + 1)]
    shares = np.array([100.0 * (1.0 - loop.transformation_fraction) for loop in loops])
    tops_mohm = np.array([1e3 * loop.resistance_max_ohm for loop in loops])
    clean_pct = 100.0 * (1.0 - clean.transformation_fraction)
    return {
        "wire": case.name,
        "noises": noises,
        "ab_pct": clean_pct,
        "bias_ab_points": float(shares.mean()) - clean_pct,
        "spread_ab_points": float(shares.std(ddof=1)),
        "resistance_max_ohm": clean.resistance_max_ohm,
        "bias_resistance_max_mohm": float(tops_mohm.mean()) - 1e3 * clean.resistance_max_ohm,
        "spread_resistance_max_mohm": float(tops_mohm.std(ddof=1)),
    }


def definition_rows(case: Case) -> list[dict[str, Any]]:
    """Return bias and spread of A-B of a case by every definition, with the bench's noise."""
    course = course_of(case)
    clean = Half.of(*course.read(0.0, 0))
    halves = [Half.of(*course.read(1.0, seed)) for seed in range(1, SEEDS + 1)]
    rows = []
    for name, share_pct in DEFINITIONS.items():
        shares, clean_pct = np.array([share_pct(half) for half in halves]), share_pct(clean)
        found = {"bias_ab_points": float(shares.mean()) - clean_pct, "spread_ab_points": float(shares.std(ddof=1))}
        rows.append({"wire": case.name, "definition": name, "ab_pct": clean_pct, **found})
    return rows


def beyond(row: dict[str, Any]) -> list[str]:
    """Return which quantities of a row the noise alone moves by more than is allowed."""
    moved = {name: abs(row[f"bias_{name}"]) + 2.0 * row[f"spread_{name}"] for name in ALLOWED}
    return [f"{row['wire']}: {name} {moved[name]:.2f}" for name, most in ALLOWED.items() if moved[name] >= most]


def print_tables(rows: list[dict[str, Any]], compared: list[dict[str, Any]]) -> None:
    print(f"{SEEDS} seeds; A-B in percent of the strain, bias and spread in points; R_max, bias and spread in mohm")
    print(f"{'':26}{'noise':>6}{'A-B':>8}{'bias':>8}{'spread':>8}{'R_max ohm':>12}{'bias':>8}{'spread':>8}")
    for row in rows:
        print(
            f"{row['wire']:26}{row['noises']:6.0f}{row['ab_pct']:8.2f}{row['bias_ab_points']:+8.2f}"
            f"{row['spread_ab_points']:8.2f}{row['resistance_max_ohm']:12.4f}"
            f"{row['bias_resistance_max_mohm']:+8.1f}{row['spread_resistance_max_mohm']:8.1f}"
        )
    print("\nother definitions, the bench's noise; A-B in percent of the strain, bias and spread in points")
    for row in compared:
        print(
            f"{row['wire']:26}{row['definition']:40}{row['ab_pct']:8.2f}{row['bias_ab_points']:+8.2f}"
            f"{row['spread_ab_points']:8.2f}"
        )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="the paper's wire alone")
    parser.add_argument("--json", action="store_true", help="one JSON document instead of tables")
    arguments = parser.parse_args()
    cases = CASES[:1] if arguments.quick else CASES
    rows = [noise_row(case, noises) for case in cases for noises in NOISES]
    compared = [row for case in (COMPARED[:1] if arguments.quick else COMPARED) for row in definition_rows(case)]
    missed = [text for row in rows if row["noises"] == 1.0 for text in beyond(row)]
    if arguments.json:
        print(json.dumps({"noise": rows, "definitions": compared, "missed": missed}, indent=2))
    else:
        print_tables(rows, compared)
        print("\nnoise of the bench alone is beyond a tolerance: " + ("; ".join(missed) or "nowhere"))
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
