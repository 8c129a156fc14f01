"""CMA-ES from a vector, within bounds."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from musclewire.errors import MusclewireError
from paper_wires.unknowns import BOUNDS, FloatArray, limits

POPULATION = 32
# What a candidate costs whose numbers describe no wire.
NO_WIRE = 1e6


@dataclass(frozen=True)
class Search:
    """How long a search goes on, and how wide it begins, as a fraction of each unknown's bounds."""

    seed: int = 1
    spread: float = 0.012
    minutes: float = 30.0
    generations: int | None = None
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=lambda: BOUNDS)


def search(start: FloatArray, asked: Search, cost: Callable[[FloatArray], float]) -> FloatArray:
    """Return the best vector of an evolution from ``start``, clipped to the bounds."""
    import cma

    low, high = limits(asked.bounds)
    best = np.clip(start, low, high)
    least, began = price(best, cost), time.monotonic()
    options = {"bounds": [0, 1], "seed": asked.seed, "popsize": POPULATION, "verbose": -9}
    evolution = cma.CMAEvolutionStrategy((best - low) / (high - low), asked.spread, options)
    while not evolution.stop() and time.monotonic() - began < 60.0 * asked.minutes:
        places = evolution.ask()
        vectors = [low + (high - low) * np.asarray(place) for place in places]
        costs = [price(vector, cost) for vector in vectors]
        evolution.tell(places, costs)
        if min(costs) < least:
            least, best = min(costs), vectors[int(np.argmin(costs))]
        if evolution.countiter % 50 == 0:
            print(f"generation {evolution.countiter}, cost {least:.2f}, spread {evolution.sigma:.4f}", flush=True)
        if asked.generations is not None and evolution.countiter >= asked.generations:
            break
    return best


def price(vector: FloatArray, cost: Callable[[FloatArray], float]) -> float:
    """Return the cost of a vector; a fixed high one if its numbers describe no wire, or no loop."""
    try:
        return cost(vector)
    except MusclewireError:
        return NO_WIRE
