"""The numbers in docs/explanation/physics.md, from the simulated wire as shipped."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from parameter_page import table
from physics_runs import LoopTruth, at_strain, without_r_phase

ZERO_DEGC_K = 273.15


def blocks(loops: tuple[LoopTruth, ...]) -> dict[str, str]:
    """Return the text between the page's markers, by their names."""
    return {"pretension": pretension_table(loops)}


def pretension_table(loops: tuple[LoopTruth, ...]) -> str:
    """Return the gap of each loop, with and without an R-phase, and what parts its branches."""
    rows: list[tuple[str, Callable[[LoopTruth], str]]] = [
        ("stress of the cold legs", lambda loop: f"{cold_stress_mpa(loop):.0f} MPa"),
        ("strain gap (Eq. 2)", lambda loop: f"{100.0 * loop.strain_gap:.1f} %"),
        ("with its sign, heating less cooling", lambda loop: f"{100.0 * loop.signed_gap:+.1f} %"),
        (
            "with its sign, without an R-phase",
            lambda loop: f"{100.0 * without_r_phase(loop).signed_gap:+.1f} %",
        ),
        ("most R-phase on cooling", lambda loop: f"{100.0 * loop.cooling.r_phase.max():.0f} %"),
        ("half way: temperature on heating", lambda loop: f"{half_way_degc(loop, 'heating'):.0f} °C"),
        ("half way: temperature on cooling", lambda loop: f"{half_way_degc(loop, 'cooling'):.0f} °C"),
    ]
    header = ["pretension", *(f"{loop.pretension_n:.2f} N" for loop in loops)]
    return table(header, [[words, *(of(loop) for loop in loops)] for words, of in rows])


def cold_stress_mpa(loop: LoopTruth) -> float:
    """Return the stress of one leg under the pretension alone."""
    return 1e-6 * loop.pretension_n / (loop.constants.legs * loop.constants.area_m2)


def half_way_degc(loop: LoopTruth, branch: str) -> float:
    """Return the temperature of a branch at half the largest strain."""
    half = np.array([0.5 * loop.shared_contraction[1]])
    return float(at_strain(getattr(loop, branch), half).temperature_k[0]) - ZERO_DEGC_K
