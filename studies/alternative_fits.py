"""What the search for the paper's alloy finds when it may not see some data, or must stay within a published range.

Held out: an isobar, the 125 um wire or the finger; the fit predicts what it did not see. Published: a parameter of the
shipped alloy that lies outside what is published is held inside; the table says which targets that costs. A fit starts
from the shipped set with every unknown moved at random by up to 5 % of its range, so that nothing found with all data
is simply kept. The vectors found are in studies/vectors; the numbers are computed from them.

    python studies/alternative_fits.py                            the tables, from the vectors
    python studies/alternative_fits.py --fit "without 100 MPa"    search again, write its vector
    python studies/alternative_fits.py --quick                    the tables, and a few generations of one search
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from paper_wires.predictions import predictions
from paper_wires.search import Search, search
from paper_wires.targets import cost, targets
from paper_wires.unknowns import BOUNDS, NAMES, PUBLISHED_R_PHASE_K, FloatArray, limits, shipped_vector

VECTORS = Path(__file__).parent / "vectors"
MOVED, SPREAD, QUICK_GENERATIONS = 0.05, 0.02, 2


@dataclass(frozen=True)
class Fit:
    """What a fit may not see, or which bounds it keeps."""

    held_out: str | None = None
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)


FITS = {
    "without 50 MPa": Fit("50 MPa"),
    "without 100 MPa": Fit("100 MPa"),
    "without 200 MPa": Fit("200 MPa"),
    "without 125um": Fit("125um"),
    "without finger": Fit("finger"),
    "R-phase between 20 and 40 C": Fit(bounds={"r_phase_temperature_k": PUBLISHED_R_PHASE_K}),
    "barrier of 9.6 K or more at every stress": Fit(bounds={"martensite_barrier_per_pa": (0.0, 2e-8)}),
    "martensite's resistivity rising by 3e-4 /K": Fit(bounds={"martensite_resistivity_per_k": (2.9e-4, 3.1e-4)}),
}


def file_of(name: str) -> Path:
    """Return the file of a fit's vector."""
    return VECTORS / f"{name.replace(' ', '_').replace('/', 'per').replace(chr(39), '')}.json"


def moved_start(bounds: Mapping[str, tuple[float, float]], seed: int) -> FloatArray:
    """Return the shipped vector with every number moved at random, within its bounds."""
    low, high = limits(bounds)
    noise = np.random.default_rng(seed).uniform(-MOVED, MOVED, low.size)
    return np.clip(shipped_vector() + noise * (high - low), low, high)


def fitted(fit: Fit, seed: int, minutes: float, generations: int | None) -> FloatArray:
    """Return the best vector of a fit."""
    bounds = {**BOUNDS, **fit.bounds}
    asked = Search(seed=seed, spread=SPREAD, minutes=minutes, generations=generations, bounds=bounds)
    return search(moved_start(bounds, seed), asked, partial(cost, held_out=fit.held_out))


def read(name: str) -> FloatArray | None:
    """Return the vector of a fit; None before it was ever made."""
    if not file_of(name).exists():
        return None
    numbers = json.loads(file_of(name).read_text("utf-8"))
    return np.array([numbers[key] for key in NAMES])


def show_fit(name: str, fit: Fit, vector: FloatArray) -> None:
    """Print what a fit predicts of what it did not see, and which of its own targets it misses."""
    seen = targets(vector, fit.held_out)
    missed = {key: value for key, value in seen.items() if abs(value) > 1.0}
    print(f"\n{name}: cost {cost(vector, fit.held_out):.1f}; {len(seen) - len(missed)} of {len(seen)} targets met")
    for key, value in missed.items():
        print(f"  misses {key:28} {value:+.2f} tolerances")
    if fit.held_out is not None:
        for row in predictions(vector, fit.held_out):
            print(f"  predicts {row.what:34} {row.ours:8.3f}   measured {row.measured:8.3f}   {row.verdict}")


def arguments() -> argparse.Namespace:
    """Return what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fit", choices=tuple(FITS))
    parser.add_argument("--minutes", type=float, default=6.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--quick", action="store_true")
    return parser.parse_args()


def main() -> int:
    """Fit, or print the tables."""
    given = arguments()
    if given.fit is not None:
        best = fitted(FITS[given.fit], given.seed, given.minutes, None)
        numbers = dict(zip(NAMES, best.tolist(), strict=True))
        file_of(given.fit).write_text(json.dumps(numbers, indent=1) + "\n", "utf-8")
        show_fit(given.fit, FITS[given.fit], best)
        return 0
    missing = [name for name in FITS if read(name) is None]
    show_fit("shipped, all data", Fit(), shipped_vector())
    for name, fit in FITS.items():
        vector = read(name)
        if vector is not None:
            show_fit(name, fit, vector)
    if given.quick:
        fitted(FITS["without 100 MPa"], given.seed, given.minutes, QUICK_GENERATIONS)
    for name in missing:
        print(f"no vector yet of: {name}", file=sys.stderr)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
