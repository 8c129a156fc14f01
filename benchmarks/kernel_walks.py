"""Fractions of the fronts beside those of grains, along random walks in temperature and stress.

The grains of tests/grain_wire are intervals of equal weight: a piecewise linear distribution. The fronts are taken
through the same walk; their fractions follow from that distribution by plain interpolation, or from the kernel's own
table of it, which is exact where the edges of the grains lie on its cells.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from kernel_courses import Array, Numbers, shipped

from musclewire.wire import OffsetDistribution, WireConstants, constants_of

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests/unit/wire"))

from wire_makers import fronts_along

from grain_wire import grain_wire

POINTS = 300
GRAINS = (160, 2560)
# Cells on which the edges of these few grains are rounded, so that the kernel's equal cells hold them exactly.
CELL = 1.0 / 256.0
ROUNDED_GRAINS = 24
ALLOYS: dict[str, dict[str, float]] = {
    "as shipped": {},
    "R-phase at once": {"r_phase_spread_k": 0.5},
    "R-phase that lasts": {"r_phase_barrier_k": 4.0, "r_to_m_barrier_k": 3.0},
    "late martensite": {"r_to_m_barrier_k": 25.0},
    "a barrier that closes": {"martensite_barrier_per_pa": -4e-8},
}


def random_walk(random: np.random.Generator) -> tuple[Array, Array]:
    """Return temperatures and stresses, (POINTS,): jumps and small steps, both at once."""
    size = random.choice([0.02, 0.2, 1.0], POINTS)
    kelvin, pascal = np.empty(POINTS), np.empty(POINTS)
    t, s = random.uniform(300.0, 400.0), random.uniform(0.0, 300e6)
    for point in range(POINTS):
        t = float(np.clip(t + size[point] * random.normal(0.0, 40.0), 280.0, 430.0))
        s = float(np.clip(s + size[point] * random.normal(0.0, 120e6), 0.0, 600e6))
        kelvin[point], pascal[point] = t, s
    return kelvin, pascal


def numbers_of(alloy: str) -> Numbers:
    """Return the shipped wire with an alloy of this file."""
    material, spool, bench = shipped()
    return {**material, **ALLOYS[alloy]}, spool, bench


def uniform_table(edges: Array) -> OffsetDistribution:
    """Return the kernel's table of grains of equal weight whose edges are multiples of CELL."""
    ends = np.arange(round(edges[0] / CELL), round(edges[-1] / CELL) + 1) * CELL
    value = np.interp(ends, edges, np.linspace(0.0, 1.0, edges.size))
    nothing = np.zeros(ends.size - 1)
    return OffsetDistribution(float(ends[0]), CELL, np.stack((value[:-1], np.diff(value), nothing, nothing), axis=1))


def with_distribution(constants: WireConstants, table: OffsetDistribution) -> WireConstants:
    """Return constants whose grains have another distribution."""
    changed = constants.replace(
        distribution_start=table.start,
        distribution_step=table.step,
        distribution_core_start=table.core_start,
        distribution_core_end=table.core_end,
        distribution_core_step=table.core_step,
    )
    changed.distribution_cells = np.ascontiguousarray(table.cells[None])
    return changed


def walk_departures(walks: int, seed: int = 12) -> dict[str, float]:
    """Return the largest difference of a fraction over random walks and alloys, for each table."""
    random = np.random.default_rng(seed)
    worst = dict.fromkeys([*(f"{grains} grains" for grains in GRAINS), "the kernel's table"], 0.0)
    for _ in range(walks):
        for alloy in ALLOYS:
            kelvin, pascal = random_walk(random)
            for grains in GRAINS:
                found = departure(numbers_of(alloy), grains, kelvin, pascal)
                worst[f"{grains} grains"] = max(worst[f"{grains} grains"], found)
            found = table_departure(numbers_of(alloy), kelvin, pascal)
            worst["the kernel's table"] = max(worst["the kernel's table"], found)
    return worst


def departure(numbers: Numbers, grains: int, kelvin: Array, pascal: Array) -> float:
    """Return the largest difference of a fraction, by plain interpolation between the grains' edges."""
    wire = grain_wire(*numbers, grains=grains)
    wire.cool(kelvin[0], pascal[0])
    wanted = wire.walk(kelvin, pascal)
    constants = constants_of(*numbers)
    fronts = fronts_along(constants, kelvin, pascal)[:2]
    below_f, below_m = np.interp(fronts, wire.grains.edges, np.linspace(0.0, 1.0, grains + 1))
    return max(
        float(np.abs(1.0 - below_m - wanted.martensite_fraction).max()),
        float(np.abs(below_m - below_f - wanted.r_phase_fraction).max()),
    )


def table_departure(numbers: Numbers, kelvin: Array, pascal: Array) -> float:
    """Return the largest difference of a fraction, by the kernel's own table of the grains' distribution."""
    wire = grain_wire(*numbers, grains=ROUNDED_GRAINS)
    edges = np.round(wire.grains.edges / CELL) * CELL
    wire = wire.with_edges(edges)
    wire.cool(kelvin[0], pascal[0])
    wanted = wire.walk(kelvin, pascal)
    constants = with_distribution(constants_of(*numbers), uniform_table(edges))
    found = fronts_along(constants, kelvin, pascal)[2:]
    return max(
        float(np.abs(found[0] - wanted.martensite_fraction).max()),
        float(np.abs(found[1] - wanted.r_phase_fraction).max()),
    )
