"""How far the default 3.2 V loop moves with the time step and with the number of grains.

The loop is that of the paper's bench without instrument noise: a cycle of 90 s to settle, one to measure, a sample
every 40 ms as the mean over that time, so that every step divides it. Shown are the strain gap (Eq. 2), the smallest
and the largest resistance from B to C, and their distance from the finest run.
Prints a table, or one JSON document with --json; --quick leaves the finest runs out.
"""

from __future__ import annotations

import argparse
import json
import math

import numpy as np

from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.sensing import find_segments
from musclewire.sensing.gaps import hysteresis_gap
from musclewire.simulate.kernel import advance
from musclewire.simulate.wire import constants_from, resting_state

PERIOD_S, SAMPLE_S = 90.0, 0.04
SENSE_V, AMPLITUDE_V = 0.3, 3.2
DEFAULT_STEP_S, DEFAULT_GRAINS = 1e-3, 160
STEPS_S = (8e-3, 4e-3, 2e-3, 1e-3, 5e-4)
GRAINS = (40, 80, 160, 320, 640)


def loop_numbers(dt_s: float, grains: int) -> dict[str, float]:
    """Return strain gap and resistances of the second cycle."""
    bench = load_bench("paper")
    bench = bench.model_copy(update={"grains": bench.grains.model_copy(update={"value": float(grains)})})
    wire = constants_from(load_alloy("flexinol"), load_wire("paper-100um"), bench)
    state, samples = resting_state(wire), round(PERIOD_S / SAMPLE_S)
    resistance, strain = [], []
    for i in range(2 * samples):
        swing = 0.5 * (1.0 - math.cos(2.0 * math.pi * (i + 0.5) * SAMPLE_S / PERIOD_S))
        state, means = advance(state, wire, SENSE_V + (AMPLITUDE_V - SENSE_V) * swing, dt_s, round(SAMPLE_S / dt_s))
        resistance.append(means.wire_voltage_v / means.shunt_voltage_v * wire.shunt_resistance_ohm)
        strain.append(means.displacement_m / wire.leg_length_m)
    segments = find_segments(np.array(resistance[samples:]), np.array(strain[samples:]))
    both = np.concatenate((segments.heating[0], segments.cooling[0]))
    return {
        "strain_gap_pct": 100.0 * hysteresis_gap(segments.heating, segments.cooling),
        "resistance_min_ohm": float(both.min()),
        "resistance_max_ohm": float(both.max()),
    }


def study(cases: list[tuple[float, int]]) -> list[dict[str, object]]:
    """Return one row a case, each with its distance from the last."""
    found = [loop_numbers(*case) for case in cases]
    return [
        {
            "dt_s": dt,
            "grains": grains,
            **numbers,
            "from_finest": {key: value - found[-1][key] for key, value in numbers.items()},
        }
        for (dt, grains), numbers in zip(cases, found, strict=True)
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="leave the finest runs out")
    parser.add_argument("--json", action="store_true", help="one JSON document instead of a table")
    arguments = parser.parse_args()
    last = -1 if arguments.quick else None
    studies = {
        "time step": study([(dt, DEFAULT_GRAINS) for dt in STEPS_S[:last]]),
        "grains": study([(DEFAULT_STEP_S, grains) for grains in GRAINS[:last]]),
    }
    if arguments.json:
        print(json.dumps(studies, indent=2))
        return
    for title, rows in studies.items():
        print(
            f"{title:>10}{'dt ms':>8}{'grains':>8}{'gap %':>10}{'R_min':>11}{'R_max':>11}"
            "   from the finest: gap, R_min, R_max"
        )
        for row in rows:
            off = row["from_finest"]
            print(
                f"{'':10}{1e3 * row['dt_s']:8.2f}{row['grains']:8d}{row['strain_gap_pct']:10.4f}"
                f"{row['resistance_min_ohm']:11.5f}{row['resistance_max_ohm']:11.5f}"
                f"   {off['strain_gap_pct']:+.4f} {off['resistance_min_ohm']:+.5f} {off['resistance_max_ohm']:+.5f}"
            )


if __name__ == "__main__":
    main()
