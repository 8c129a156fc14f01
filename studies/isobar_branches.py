"""Measured isobars of Flexinol next to those of the simulated sample: their branches, their turns, and minor loops.

The measured curves are those of studies/data/flexinol_isobars, of which 150 and 172 MPa were used by no search.
Printed are, of each stress, measured and simulated:

- the distance of the branches in kelvin where equal parts of the stroke are left, as recorded, and less the strain that
  is linear in temperature, free of hysteresis and makes that distance most even,
- what strain does in the first 20 K after the turns at the cold and the hot end, the steepest part of each branch, and
  where tangents put the start of austenite;

then, of the simulated wires, over how many kelvin strain is at rest after a turn inside the loop, with one class of
barrier and with two; and the loops of the paper's Fig. 3(a) at its three amplitudes, without noise.
Prints tables, or one JSON document with --json.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from studies.measured_isobars import (
    LEFT,
    STRESSES_MPA,
    ZERO_CELSIUS_K,
    FloatArray,
    Levelled,
    austenite_start_k,
    distances_k,
    levelled,
    measured_isobar,
    rates_after_turns_per_k,
    steepest_rates_per_k,
)

from musclewire.experiment import PAPER_PERIOD_S, slow_sine
from musclewire.extras.paper import outside_band
from musclewire.identify import IsobaricLoop, simulated_isobar
from musclewire.parameters import load_alloy, load_bench, load_wire, read_published
from musclewire.sensing import Branch
from musclewire.wire import (
    ONE_CLASS,
    BarrierClass,
    WireConstants,
    constants_from,
    constants_of,
    drive_path,
    isobaric_path,
    with_pretension,
)

ISOBAR_WIRE, PAPER_WIRE, BENCH = "isobar-sample", "paper-100um", "paper"
# Two classes of as many grains, this far from the alloy's barrier: what an isobar shows of them, and what a turn shows.
CLASSES_APART_K = 3.0
TWO_CLASSES = (BarrierClass(0.5, -CLASSES_APART_K), BarrierClass(0.5, CLASSES_APART_K))
MINOR_LOOP_PA = 100e6
TURNS_LEFT = (0.75, 0.50, 0.25)
# Strain has left its place when it has moved by these parts of the stroke.
MOVED = (0.01, 0.10)
STEP_K = 0.05
# No density of a sum of independent quantities exceeds that of either; a normal one peaks at this over its deviation.
NORMAL_PEAK = 1.0 / np.sqrt(2.0 * np.pi)


class IsobarReading(NamedTuple):
    """What is read off one isobar."""

    stress_mpa: float
    source: str
    stroke: float
    distances_k: FloatArray
    levelled: Levelled
    rate_after_cold_turn_per_k: float
    rate_after_hot_turn_per_k: float
    steepest_heating_per_k: float
    steepest_cooling_per_k: float
    austenite_start_degc: float

    @property
    def most_spread_of_barriers_k(self) -> float:
        """Standard deviation that barriers may have if they are normal and independent of a grain's temperature."""
        return NORMAL_PEAK / max(self.steepest_heating_per_k, self.steepest_cooling_per_k)


class Rest(NamedTuple):
    """Kelvins after a turn over which strain moves by less than each part of the stroke in ``MOVED``."""

    classes: str
    branch: str
    left: float
    kelvin: tuple[float, ...]


class DrivenLoop(NamedTuple):
    """One cycle of the slow sine at an amplitude."""

    amplitude_v: float
    stroke: float
    outside: float
    rest_k: float
    whole_k: float


def reading_of(loop: IsobaricLoop, source: str) -> IsobarReading:
    """Return what is read off an isobar."""
    stroke = float(np.ptp(loop.strain))
    return IsobarReading(
        loop.stress_pa * 1e-6, source, stroke, distances_k(loop), levelled(loop), *rates_after_turns_per_k(loop),
        *steepest_rates_per_k(loop), austenite_start_k(loop) - ZERO_CELSIUS_K,
    )  # fmt: skip


def simulated_sample(stress_mpa: float) -> IsobaricLoop:
    """Return the isobar of the simulated sample."""
    wire = load_wire(ISOBAR_WIRE)
    return simulated_isobar(load_alloy(wire.alloy), wire, load_bench(BENCH), 1e6 * stress_mpa)


def isobar_readings() -> list[IsobarReading]:
    """Return what is read off each measured isobar, each followed by the simulated one."""
    return [
        reading_of(loop, source)
        for stress_mpa in STRESSES_MPA
        for loop, source in ((measured_isobar(stress_mpa), "measured"), (simulated_sample(stress_mpa), "simulated"))
    ]


def sample_with(classes: Sequence[BarrierClass]) -> WireConstants:
    """Return the simulated sample with grains of several classes of barrier."""
    wire = load_wire(ISOBAR_WIRE)
    alloy, bench = load_alloy(wire.alloy).values(), load_bench(BENCH).values()
    return constants_of(alloy, wire.values(), bench, classes=classes)


def isobar_with(classes: Sequence[BarrierClass], stress_pa: float = MINOR_LOOP_PA) -> IsobaricLoop:
    """Return a fine isobar of the simulated sample with several classes of barrier."""
    up = np.arange(303.15, 413.15 + 0.5 * STEP_K, STEP_K)
    kelvin = np.concatenate([up, up[-2::-1]])
    return IsobaricLoop(stress_pa, kelvin, isobaric_path(sample_with(classes), stress_pa, kelvin).strain)


def rest_after_turn_k(constants: WireConstants, way_k: FloatArray, back_k: FloatArray, stroke: float) -> FloatArray:
    """Return how far the way back from the end of ``way_k`` leads before strain has moved by each part of a stroke."""
    strain = isobaric_path(constants, MINOR_LOOP_PA, np.concatenate([way_k, back_k])).strain[len(way_k) - 1 :]
    moved = np.maximum.accumulate(np.abs(strain - strain[0])) / stroke
    gone_k = np.concatenate([[0.0], np.abs(back_k - way_k[-1])])
    return np.interp(MOVED, moved, gone_k)


def rests_after_turns() -> list[Rest]:
    """Return how long strain rests after turns on both branches of the isobar at 100 MPa, with one and two classes."""
    rests = []
    for words, classes in (("one", ONE_CLASS), ("two", TWO_CLASSES)):
        constants, loop = sample_with(classes), isobar_with(classes)
        stroke, hottest = float(np.ptp(loop.strain)), int(np.argmax(loop.temperature_k))
        left = (loop.strain - loop.strain.min()) / stroke
        for part in TURNS_LEFT:
            turns = {
                "heating": (int(np.argmax(left <= part)), loop.temperature_k[0]),
                "cooling": (hottest + int(np.argmax(left[hottest:] >= part)), loop.temperature_k[hottest]),
            }
            for branch, (turn, end_k) in turns.items():
                way_k = loop.temperature_k[: turn + 1]
                back_k = np.linspace(way_k[-1], end_k, round(abs(end_k - way_k[-1]) / STEP_K) + 1)[1:]
                found = rest_after_turn_k(constants, way_k, back_k, stroke)
                rests.append(Rest(words, branch, part, tuple(map(float, found))))
    return rests


def last_cycle(amplitude_v: float, pretension_n: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return drive [V], contraction and temperature [K] of the second of two slow sines of the paper's wire."""
    wire = load_wire(PAPER_WIRE)
    bench = load_bench(BENCH)
    constants = with_pretension(constants_from(load_alloy(wire.alloy), wire, bench), pretension_n)
    sample_s, sense_v = bench.sample_period_s.value, bench.sense_voltage_v.value
    wave = slow_sine(amplitude_v, sense_v)
    cycle = round(PAPER_PERIOD_S / sample_s)
    drive = np.array([wave(sample_s * sample) for sample in range(2 * cycle)])
    path, _ = drive_path(constants, drive, sample_s=sample_s)
    return drive[cycle:], path.displacement_m[cycle:] / constants.leg_length_m, path.temperature_k[cycle:]


def driven_loops() -> list[DrivenLoop]:
    """Return the loops of Fig. 3(a): stroke, excursion out of the major one, and rest after the turn at the hot end."""
    paper = read_published("lan_fan_2010")
    pretension_n = float(paper["loop_100um"]["pretension_n"])
    loops, major = [], None
    for amplitude_v in paper["setup"]["amplitude_v"]:
        drive, contraction, kelvin = last_cycle(float(amplitude_v), pretension_n)
        top = int(np.argmax(drive))
        up = Branch(drive[: top + 1], contraction[: top + 1])
        down = Branch(drive[top:][::-1], contraction[top:][::-1])
        major = major or (up, down)
        turn = int(np.argmax(kelvin))
        moved = np.maximum.accumulate(np.abs(contraction[turn:] - contraction[turn]))
        cooled = kelvin[turn] - kelvin[turn:]
        rest_k = float(np.interp(MOVED[0] * np.ptp(major[0].quantity), moved, cooled))
        outside = outside_band(drive, contraction, *major)
        loops.append(DrivenLoop(float(amplitude_v), float(np.ptp(contraction)), outside, rest_k, float(np.ptp(kelvin))))
    return loops


def numbers(values: Sequence[float] | FloatArray, width: int = 6) -> str:
    """Return numbers with a decimal."""
    return "".join(f"{value:{width}.1f}" for value in values)


def print_isobars(readings: Sequence[IsobarReading]) -> None:
    """Print both tables of the isobars."""
    print("distance of the branches [K] where parts of the stroke are left: "
          f"{', '.join(f'{100.0 * part:.0f}' for part in LEFT)} %")  # fmt: skip
    for each in readings:
        line = f"{each.stress_mpa:4.0f} MPa {each.source:9}"
        print(f"{line}  as recorded, stroke {100.0 * each.stroke:.2f} %          {numbers(each.distances_k)}"
              f"   deviation {each.distances_k.std():.1f}")  # fmt: skip
        rest = each.levelled
        print(f"{'':18}  less {1e6 * rest.per_k:5.1f}e-6 /K, stroke {100.0 * rest.stroke:.2f} %     "
              f"{numbers(rest.distances_k)}   half {rest.barrier_k:.1f} +- {rest.spread_k:.1f} K")  # fmt: skip
    print("\nstrain in the first 20 K after a turn at the ends [1e-6 /K], steepest part of the branches over 3 K "
          "[% of the stroke per K],\nlargest deviation that normal, independent barriers may have [K], start of "
          "austenite by tangents [C]")  # fmt: skip
    for each in readings:
        print(
            f"{each.stress_mpa:4.0f} MPa {each.source:9}  cold {1e6 * each.rate_after_cold_turn_per_k:5.0f}"
            f"  hot {1e6 * each.rate_after_hot_turn_per_k:5.0f}   heating {100.0 * each.steepest_heating_per_k:5.1f}"
            f"  cooling {100.0 * each.steepest_cooling_per_k:5.1f}   barriers {each.most_spread_of_barriers_k:4.1f}"
            f"   As {each.austenite_start_degc:5.1f}"
        )


def print_turns(rests: Sequence[Rest], loops: Sequence[DrivenLoop]) -> None:
    """Print what minor loops of the simulated wires do."""
    one, two = (distances_k(isobar_with(classes)) for classes in (ONE_CLASS, TWO_CLASSES))
    print(f"\nsimulated sample at {1e-6 * MINOR_LOOP_PA:.0f} MPa, barriers of one class, and of two that are "
          f"{CLASSES_APART_K:g} K below and above it")  # fmt: skip
    print(f"distance of the branches, one class  {numbers(one)}\n{'':26}two classes {numbers(two)}")
    print("kelvins after a turn inside the loop until strain has moved by 1 % and by 10 % of the stroke")
    for each in rests:
        print(f"  {each.classes} class{'es' if each.classes == 'two' else '  '}, turn on {each.branch} with "
              f"{100.0 * each.left:.0f} % left: {numbers(each.kelvin)}")  # fmt: skip
    print("\nFig. 3(a), simulated 100 um wire at 1.9 N, without noise")
    for loop in loops:
        print(f"  {loop.amplitude_v:.2f} V: stroke {100.0 * loop.stroke:.2f} %, outside the major loop by at most "
              f"{100.0 * loop.outside:.3f} % strain; after the hot turn strain moves by less than 1 % of the major "
              f"stroke over {loop.rest_k:.1f} K of {loop.whole_k:.0f} K")  # fmt: skip


def as_json(values: NamedTuple) -> dict[str, object]:
    """Return a reading as plain data."""
    found: dict[str, object] = {}
    for name, value in values._asdict().items():
        nested = as_json(value) if isinstance(value, Levelled) else value
        found[name] = value.tolist() if isinstance(value, np.ndarray) else nested
    return found


def main() -> None:
    """Print the tables, or everything as JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="one JSON document instead of tables")
    arguments = parser.parse_args()
    readings, rests, loops = isobar_readings(), rests_after_turns(), driven_loops()
    if arguments.json:
        tables = {"isobars": readings, "rests": rests, "fig3a": loops}
        print(json.dumps({name: [as_json(row) for row in rows] for name, rows in tables.items()}, indent=2))
        return
    print_isobars(readings)
    print_turns(rests, loops)


if __name__ == "__main__":
    main()
