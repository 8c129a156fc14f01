"""What the grains remember, as the Preisach literature asks: wiping-out and congruency at constant stress.

Wiping-out: of a history of turning points only the alternating dominant ones are left; the rest, wiped out by a larger
excursion, must not matter. Congruency: minor loops between the same two temperatures are congruent whatever happened
before. Both together make a classical Preisach operator (Mayergoyz 1986, doi 10.1103/PhysRevLett.56.1518). Random
histories for alloys of round numbers (tests/unit/wire/wire_makers.py), one of them without R-phase; shown is the
largest departure found, in the fractions of martensite and R-phase and in strain.
Prints a table, or one JSON document with --json.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from musclewire.wire import WireConstants, isobaric_path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/unit/wire"))

from wire_makers import ALLOYS, constants

Array = NDArray[np.float64]

HOT_K, COLD_K = 430.0, 295.0
LOOP_POINTS = 24
OUTPUTS = ("martensite", "r_phase", "strain")
WIRES = {
    # Never any R-phase: each grain is austenite or martensite, a relay.
    "two phases": constants(r_phase_temperature_k=100.0),
    **{kind: constants(kind) for kind in ALLOYS},
    # R-phase holds on over a range in which R-phase and martensite can turn to and fro.
    "lasting": constants(r_phase_barrier_k=4.0, r_to_m_barrier_k=3.0, r_phase_entropy_ratio=0.1),
}


def remembered(turns: Sequence[float]) -> list[float]:
    """Return the turning points that are not wiped out, beginning with the first one and ending with the last.

    The first is taken for a state that no later turn leads beyond.
    """
    kept: list[float] = []
    for turn in turns:
        while len(kept) > 1:
            onwards = (kept[-1] - kept[-2]) * (turn - kept[-1]) >= 0.0
            beyond = abs(turn - kept[-1]) >= abs(kept[-1] - kept[-2])
            if onwards:
                del kept[-1]
            elif beyond and len(kept) > 2:
                del kept[-2:]
            else:
                break
        kept.append(turn)
    return kept


def along(wire: WireConstants, stress_pa: float, temperature_k: Sequence[float] | Array) -> Array:
    """Return martensite, R-phase and strain of a wire cooled to the first temperature, (3, n_points)."""
    path = isobaric_path(wire, stress_pa, np.asarray(temperature_k, dtype=np.float64))
    return np.array([path.martensite_fraction, path.r_phase_fraction, path.strain])


def minor_loop(wire: WireConstants, stress_pa: float, history_k: Sequence[float], low_k: float, high_k: float) -> Array:
    """Return the outputs along a closed minor loop after a history, less those at its upper end, (3, n_points).

    After the history the wire goes to the lower end and the upper one; there the loop, down and up, begins.
    """
    down = np.linspace(high_k, low_k, LOOP_POINTS + 1)
    path = np.concatenate(([HOT_K], history_k, [low_k], down, down[-2::-1]))
    loop = along(wire, stress_pa, path)[:, len(history_k) + 2 :]
    return loop - loop[:, :1]


def wiping_out_departure(wire: WireConstants, random: np.random.Generator) -> Array:
    """Return by how much one random history misses its remembered turning points alone, (3,)."""
    stress_pa = random.uniform(20e6, 250e6)
    turns = [HOT_K, *random.uniform(COLD_K, 410.0, random.integers(2, 12))]
    whole = along(wire, stress_pa, turns)[:, -1]
    return np.asarray(np.abs(whole - along(wire, stress_pa, remembered(turns))[:, -1]))


def congruency_departure(wire: WireConstants, random: np.random.Generator) -> Array:
    """Return by how much the minor loops between two temperatures differ after two random histories, (3,)."""
    stress_pa = random.uniform(20e6, 250e6)
    low_k, high_k = np.sort(random.uniform(COLD_K, 410.0, 2))
    one, other = (
        minor_loop(wire, stress_pa, random.uniform(COLD_K, 410.0, random.integers(1, 6)), low_k, high_k)
        for _ in range(2)
    )
    return np.asarray(np.abs(one - other).max(axis=1))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--histories", type=int, default=2000, help="random histories for each alloy (default 2000)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true", help="one JSON document instead of a table")
    arguments = parser.parse_args()
    rows = []
    for name, wire in WIRES.items():
        random = np.random.default_rng(arguments.seed)
        worst = {
            law: np.max([departure(wire, random) for _ in range(arguments.histories)], axis=0).tolist()
            for law, departure in (("wiping_out", wiping_out_departure), ("congruency", congruency_departure))
        }
        rows.append({"alloy": name, **{law: dict(zip(OUTPUTS, found, strict=True)) for law, found in worst.items()}})
    if arguments.json:
        print(json.dumps(rows, indent=2))
        return
    print(f"largest departure in {arguments.histories} random histories")
    print(f"{'':12}{'wiping-out':^36}{'congruency':^36}")
    print(f"{'alloy':12}" + 2 * "".join(f"{name:>12}" for name in OUTPUTS))
    for row in rows:
        numbers = [row[law][name] for law in ("wiping_out", "congruency") for name in OUTPUTS]
        print(f"{row['alloy']:12}" + "".join(f"{number:12.1e}" for number in numbers))


if __name__ == "__main__":
    main()
