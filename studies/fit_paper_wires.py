"""Find one alloy for the paper's three wires and the Flexinol isobars: the search behind the shipped parameter files.

CMA-ES (Hansen 2016, arXiv 1604.00772) on whole simulated loops; every target counts in units of its tolerance, with a
steep price beyond it, and bounds from the literature (docs/explanation/parameters.md). Starts from the shipped files,
or from a vector written before; ends with the best vector in a file, which --write turns into the parameter files.

    python studies/fit_paper_wires.py --quick                       judge the shipped set, search a few generations
    python studies/fit_paper_wires.py --minutes 30 --out best.json  the whole search
    python studies/fit_paper_wires.py --write best.json             write the parameter files
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from paper_wires.files import write_parameter_files
from paper_wires.targets import cost, targets
from paper_wires.unknowns import HIGH, LOW, NAMES, FloatArray, shipped_vector

POPULATION, FIRST_SPREAD, QUICK_GENERATIONS = 20, 0.012, 3


def read_vector(path: Path) -> FloatArray:
    """Return a vector from a file of numbers by name."""
    numbers = json.loads(path.read_text("utf-8"))
    return np.array([numbers[name] for name in NAMES])


def show(vector: FloatArray) -> None:
    """Print the targets that are not met, and how many are."""
    found = targets(vector)
    missed = {name: value for name, value in found.items() if abs(value) > 1.0}
    print(f"cost {cost(vector):.2f}; {len(found) - len(missed)} of {len(found)} targets within their tolerance")
    for name, value in missed.items():
        print(f"  {name:32} {value:+.2f} tolerances")


def search(start: FloatArray, seed: int, spread: float, minutes: float, generations: int | None) -> FloatArray:
    """Return the best vector of an evolution from ``start``."""
    import cma

    def vector(place: FloatArray) -> FloatArray:
        return LOW + (HIGH - LOW) * np.asarray(place)

    first = np.clip((start - LOW) / (HIGH - LOW), 0.0, 1.0)
    options = {"bounds": [0, 1], "seed": seed, "popsize": POPULATION, "verbose": -9}
    evolution = cma.CMAEvolutionStrategy(first, spread, options)
    best, least, began = start, cost(start), time.monotonic()
    while not evolution.stop() and time.monotonic() - began < 60.0 * minutes:
        places = evolution.ask()
        costs = [cost(vector(place)) for place in places]
        evolution.tell(places, costs)
        if min(costs) < least:
            least, best = min(costs), vector(places[int(np.argmin(costs))])
        if evolution.countiter % 50 == 0:
            print(f"generation {evolution.countiter}, cost {least:.2f}, spread {evolution.sigma:.4f}", flush=True)
        if generations is not None and evolution.countiter >= generations:
            break
    return best


def arguments() -> argparse.Namespace:
    """Return what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--spread", type=float, default=FIRST_SPREAD)
    parser.add_argument("--start", type=Path)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--write", type=Path)
    return parser.parse_args()


def main() -> int:
    """Judge, search, write."""
    given = arguments()
    if given.write is not None:
        write_parameter_files(read_vector(given.write))
        return 0
    start = shipped_vector() if given.start is None else read_vector(given.start)
    show(start)
    best = search(start, given.seed, given.spread, given.minutes, QUICK_GENERATIONS if given.quick else None)
    show(best)
    if given.out is not None:
        given.out.write_text(json.dumps(dict(zip(NAMES, best.tolist(), strict=True)), indent=1) + "\n", "utf-8")
    return 0 if cost(best) <= cost(start) else 1


if __name__ == "__main__":
    sys.exit(main())
