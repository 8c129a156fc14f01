"""The numbers in docs/explanation/physics.md, from the simulated wire as shipped."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from parameter_page import paragraphs, table
from physics_runs import LoopTruth, at_strain, parts_of_the_difference, without_r_phase

ZERO_DEGC_K = 273.15


def blocks(loops: tuple[LoopTruth, ...]) -> dict[str, str]:
    """Return the text between the page's markers, by their names."""
    return {"pretension": pretension_table(loops), "reading": paragraphs(reading(loops[0], loops[-1]))}


def pretension_table(loops: tuple[LoopTruth, ...]) -> str:
    """Return the difference of the branches of each loop at half the stroke, and its parts."""
    rows: list[tuple[str, Callable[[LoopTruth], str]]] = [
        ("stress of the cold legs", lambda loop: f"{cold_stress_mpa(loop):.0f} MPa"),
        ("strain gap (Eq. 2)", lambda loop: f"{100.0 * loop.strain_gap:.1f} %"),
        ("the same with its sign, heating less cooling", lambda loop: f"{100.0 * loop.signed_gap:+.1f} %"),
        (
            "the same of this wire without an R-phase",
            lambda loop: f"{100.0 * without_r_phase(loop).signed_gap:+.1f} %",
        ),
        ("most R-phase on heating", lambda loop: f"{100.0 * loop.heating.r_phase.max():.0f} %"),
        ("most R-phase on cooling", lambda loop: f"{100.0 * loop.cooling.r_phase.max():.0f} %"),
        ("half way: temperature on heating", lambda loop: f"{half_way_degc(loop, 'heating'):.0f} °C"),
        ("half way: temperature on cooling", lambda loop: f"{half_way_degc(loop, 'cooling'):.0f} °C"),
        ("half way: more resistance on heating, as it is hotter", lambda loop: half_way_mohm(loop, "hotter")),
        ("half way: more (or less), as one branch has more R-phase", lambda loop: half_way_mohm(loop, "r_phase")),
        ("half way: shape and martensite fraction", lambda loop: half_way_mohm(loop, "rest")),
        ("half way: all together", lambda loop: half_way_mohm(loop, "whole")),
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


def half_way_mohm(loop: LoopTruth, part: str) -> str:
    """Return one part of the branches' difference in resistance at half the largest strain."""
    parts = parts_of_the_difference(loop)
    ohm = np.interp(0.5 * loop.shared_contraction[1], parts.contraction, getattr(parts, part))
    return f"{1e3 * ohm:+.0f} mohm"


def reading(lowest: LoopTruth, highest: LoopTruth) -> str:
    """Return whether the shipped wire does at the lowest and the highest pretension what the page's argument says."""
    low, high = mean_mohm(lowest), mean_mohm(highest)
    says = (
        f"In the shipped wire, over the whole loop, temperature makes {low[0]:+.0f} mohm at "
        f"{lowest.pretension_n:.2f} N and {high[0]:+.0f} mohm at {highest.pretension_n:.2f} N, and R-phase "
        f"{low[1]:+.0f} and {high[1]:+.0f} mohm."
    )
    if low[1] * low[0] >= 0.0:
        return (
            f"{says} So here R-phase stands on the hotter branch and **adds** to the effect of temperature at low "
            "pretension: these parameters meet the paper's gaps in another way than the one shown above."
        )
    if abs(high[1]) > 0.5 * abs(low[1]):
        return f"{says} The two oppose each other as shown above, but load takes **less than half** of the second away."
    return (
        f"{says} The two oppose each other at low pretension, and load takes most of the second away, as shown above."
    )


def mean_mohm(loop: LoopTruth) -> tuple[float, float]:
    """Return what temperature and R-phase make of the branches' difference in resistance, mean over the strain."""
    parts = parts_of_the_difference(loop)
    return 1e3 * float(parts.hotter.mean()), 1e3 * float(parts.r_phase.mean())
