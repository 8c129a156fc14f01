"""Find one alloy for the paper's wires, its finger and the Flexinol isobars: the search behind the parameter files.

CMA-ES (Hansen 2016, arXiv 1604.00772) on whole simulated loops; every target counts in units of its tolerance, with a
steep price near and beyond it, and bounds from the literature (docs/explanation/parameters.md). Starts from the shipped
files, or from a vector written before; ends with the best vector in a file, which --write turns into parameter files.

    python studies/fit_paper_wires.py --quick                       judge the shipped set, search a few generations
    python studies/fit_paper_wires.py --minutes 30 --output best.json  the whole search
    python studies/fit_paper_wires.py --r-phase published           with the R-phase at no stress between 20 and 40 C
    python studies/fit_paper_wires.py --write best.json             write the parameter files
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from paper_wires.files import write_parameter_files
from paper_wires.search import Search, search
from paper_wires.targets import cost, targets
from paper_wires.unknowns import BOUNDS, NAMES, PUBLISHED_R_PHASE_K, FloatArray, shipped_vector

QUICK_GENERATIONS = 3


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


def arguments() -> argparse.Namespace:
    """Return what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--spread", type=float, default=Search.spread)
    parser.add_argument("--r-phase", choices=("free", "published"), default="free")
    parser.add_argument("--start", type=Path)
    parser.add_argument("--output", type=Path)
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
    bounds = BOUNDS if given.r_phase == "free" else {**BOUNDS, "r_phase_temperature_k": PUBLISHED_R_PHASE_K}
    generations = QUICK_GENERATIONS if given.quick else None
    asked = Search(seed=given.seed, spread=given.spread, minutes=given.minutes, generations=generations, bounds=bounds)
    best = search(start, asked, cost)
    show(best)
    if given.output is not None:
        given.output.write_text(json.dumps(dict(zip(NAMES, best.tolist(), strict=True)), indent=1) + "\n", "utf-8")
    return 0 if given.r_phase == "published" or cost(best) <= cost(start) else 1


if __name__ == "__main__":
    sys.exit(main())
