"""The wire in segments: how far it is from the simulated wire, from a fin, and from itself with finer steps and grid.

The drive is half a slow loop of 20 s, then jumps between 0.3 and 3.2 V. Printed are largest differences over the run:
of one segment without clamps from the kernel of one wire with a tenth of its tolerances; of enthalpy from the heat
that came and went; of 5 and 2.5 ms steps from an eighth of 2.5 ms; of 10, 12, 20 and 40 segments from 200; of the
temperatures of a wire held warm from the closed form of a fin between cold ends; and the processor's time per
simulated millisecond.

    python benchmarks/wire_in_segments.py

Ends with 1 if a difference is above its bar. Times are printed and not judged.
"""

from __future__ import annotations

import math
import sys
from time import thread_time

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.extras.studies import NormalMixture, SegmentedWire, WireStructure, fin_length_m, mixture_distribution
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.wire import BarrierClass, OneWire, StepControl, constants_from

SAMPLE_S, SAMPLES, STROKE, LENGTH_M = 0.05, 600, 0.038, 0.14
CLASSES = (BarrierClass(0.3, -2.0), BarrierClass(0.4, 0.0), BarrierClass(0.3, 2.5))
GRAINS = mixture_distribution((NormalMixture(0.8, 0.0, 1.0), NormalMixture(0.2, -1.5, 2.0)))
PARTS = load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper")
CONVECTION_W_PER_M2_K, CONDUCTIVITY_W_PER_M_K = 100.0, 18.0
TIMED_SAMPLES = 4000


def of_parts(structure: WireStructure, step_s: float = 2.5e-3) -> SegmentedWire:
    """Return the paper's wire of 0.1 mm in segments."""
    return SegmentedWire(*PARTS, structure, step_s)


def rich(segments: int) -> WireStructure:
    """Return a structure with several classes of barrier and other grains."""
    return WireStructure(segments, classes=CLASSES, grains=GRAINS)


def drive_v(number: int) -> float:
    """Return the drive of a sample [V]."""
    time_s = number * SAMPLE_S
    if time_s < 20.0:
        return 0.3 + 2.9 * math.sin(math.pi * time_s / 20.0) ** 2
    return 3.2 if int(time_s) % 4 < 2 else 0.3


def strains_of(wire: SegmentedWire) -> FloatArray:
    """Return the mean strain of each sample of the run."""
    return np.array([wire.advance(drive_v(number), SAMPLE_S).strain for number in range(SAMPLES)])


def from_one_wire() -> tuple[float, float]:
    """Return the largest difference of strain [% of stroke] and resistance [%] from the kernel of one wire."""
    known, ours = OneWire(constants_from(*PARTS)), of_parts(WireStructure(1, clamped=False))
    strain = resistance = 0.0
    for number in range(SAMPLES):
        expected = known.advance(drive_v(number), SAMPLE_S, StepControl(0.0, 5e-4, 3e-6, 1e-6))
        found = ours.advance(drive_v(number), SAMPLE_S)
        ratios = [one.wire_voltage_v / one.shunt_voltage_v for one in (found, expected)]
        resistance = max(resistance, abs(ratios[0] / ratios[1] - 1.0))
        strain = max(strain, abs(found.displacement_m - expected.displacement_m) / ours.leg_length_m)
    return 100.0 * strain / STROKE, 100.0 * resistance


def energy_left_j() -> float:
    """Return the difference of enthalpy gained from heat in less heat out, over the run [J]."""
    wire = of_parts(rich(12))
    before_j = wire.enthalpy_j
    strains_of(wire)
    sums = wire.sums
    gained_j = sums["heat_in_j"] - sums["heat_to_air_j"] - sums["heat_to_clamps_j"]
    return abs(wire.enthalpy_j - before_j - gained_j)


def steps_pct() -> dict[str, float]:
    """Return the largest difference of strain from an eighth of the step [% of stroke]."""
    finest = strains_of(of_parts(rich(12), 3.125e-4))
    steps = {f"{1e3 * step_s:g} ms": step_s for step_s in (5e-3, 2.5e-3)}
    return {
        name: 100.0 * float(np.abs(strains_of(of_parts(rich(12), step_s)) - finest).max()) / STROKE
        for name, step_s in steps.items()
    }


def segments_pct() -> dict[str, float]:
    """Return the largest difference of strain from 200 segments [% of stroke]."""
    finest = strains_of(of_parts(WireStructure(200)))
    return {
        str(number): 100.0 * float(np.abs(strains_of(of_parts(WireStructure(number))) - finest).max()) / STROKE
        for number in (10, 12, 20, 40)
    }


def from_a_fin_pct(structure: WireStructure) -> tuple[float, float]:
    """Return the largest difference of an excess temperature, and that of the mean, from a fin [% of the middle]."""
    wire = of_parts(structure)
    wire._derived["convection_w_per_m2_k"] = CONVECTION_W_PER_M2_K
    for _ in range(200):
        wire.advance(0.7, SAMPLE_S)
    factor = PARTS[1].convection_factor.value
    fin_m = fin_length_m(CONDUCTIVITY_W_PER_M_K, 100e-6, CONVECTION_W_PER_M2_K * factor)
    ends_m = np.concatenate(([0.0], np.cumsum(wire.weights))) * LENGTH_M - 0.5 * LENGTH_M
    drop = fin_m / math.cosh(0.5 * LENGTH_M / fin_m) * np.diff(np.sinh(ends_m / fin_m)) / np.diff(ends_m)
    excess = wire.state.segment_temperatures_k - PARTS[2].ambient_temperature_k.value
    excess /= excess.max()
    mean = float(wire.weights @ excess) - (1.0 - 2.0 * fin_m / LENGTH_M)
    return 100.0 * float(np.abs(excess - (1.0 - drop)).max()), 100.0 * abs(mean)


def microseconds_per_ms(segments: int) -> float:
    """Return the processor's time per simulated millisecond [us], the call from Python included."""
    wire = of_parts(rich(segments))
    strains_of(wire)
    began_s = thread_time()
    for number in range(TIMED_SAMPLES):
        wire.advance(drive_v(number), SAMPLE_S)
    return 1e6 * (thread_time() - began_s) / (1e3 * SAMPLE_S * TIMED_SAMPLES)


def rows() -> list[tuple[str, float, str, float]]:
    """Return name, value, unit and bar of each number."""
    strain, resistance = from_one_wire()
    fine, _ = from_a_fin_pct(WireStructure(400, length_fractions=(1.0 / 400,) * 400))
    coarse, mean = from_a_fin_pct(WireStructure(12))
    found = [
        ("one segment: strain", strain, "% of stroke", 0.01),
        ("one segment: resistance", resistance, "%", 0.002),
        ("energy", energy_left_j(), "J", 1e-11),
        *((f"steps of {name}", value, "% of stroke", 0.05) for name, value in steps_pct().items()),
        *((f"{name} segments", value, "% of stroke", 0.4) for name, value in segments_pct().items()),
        ("fin, 400 segments", fine, "% of excess", 0.6),
        ("fin, 12 segments", coarse, "% of excess", 3.0),
        ("fin, 12 segments, mean", mean, "% of excess", 0.3),
    ]
    return [*found, *((f"{n} segments", microseconds_per_ms(n), "us per ms", math.inf) for n in (1, 10, 20))]


def main() -> int:
    """Print the numbers; return 1 if one is above its bar."""
    missed = 0
    for name, value, unit, bar in rows():
        late = value > bar
        missed += late
        limit = "" if math.isinf(bar) else f"at most {bar:g}"
        print(f"{name:<26} {value:10.3g} {unit:<12} {limit}{'  MISSED' if late else ''}")
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
