"""How far each number of a candidate is from what is printed or measured, in units of its tolerance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from musclewire.extras.paper import FORCE_RATIOS, lowest_place
from musclewire.identify import half_transformation_slope_pa_per_k, simulated_isobar, summarize_isobar
from musclewire.parameters import read_published
from paper_wires.loops import Loop
from paper_wires.slow_loops import finger_loop, slow_loop
from paper_wires.unknowns import NAMES, PULL, FloatArray, PaperWires, paper_wires

Targets = dict[str, float]

PRETENSIONS_125UM_N = (1.70, 2.20, 2.71, 3.22, 3.70, 4.20, 4.67)
PRETENSIONS_FINGER_N = (0.15, 0.37, 0.59, 0.71, 0.83, 1.15, 1.7)
CHOSEN_FINGER = PRETENSIONS_FINGER_N.index(0.71)
# Levels of Table 3 [mm], and how far heating and cooling branch may lie from their average there, in percent of the
# level: what the staircase can hardly correct. Larger where the branches are steep.
FINGER_LEVELS = ((2.5, 5.5, 7.0), (3.0, 2.6, 4.5), (3.5, 2.2, 2.6), (4.0, 1.8, 1.8), (4.5, 1.8, 1.8), (5.0, 1.8, 2.0))
MAXIMUM_FORCE_N = {"100um": 4.601, "125um": 7.220, "200um": 18.247}
# Gaps read from a recording lie higher than a curve without noise has them, by about this much.
GAP_OF_NOISE_PCT = 0.05
# And A-B from a recording is that much shorter, by the definition of B that noise moves least.
AB_OF_NOISE_PCT = 1.0
# A recording's least resistance is the least of many noisy readings at C: by about this much below the wire's own.
MIN_OF_NOISY_OHM = 0.012
# What a gap must fall by from one pretension to the next, so that the noise of a recording does not turn the order.
CLEARLY_PCT = 0.06
PAPER, ISOBARS = read_published("lan_fan_2010"), read_published("flexinol_isobars")
# Beyond this fraction of a tolerance a target costs; the rest of it is room for noise. Most of the price is paid for
# missing it at all, so that what cannot all be met is missed in few places rather than a little everywhere.
FREE_FRACTION, MISSED, BEYOND, SQUARES, PULLING = 0.78, 30.0, 15.0, 0.2, 0.3
LARGEST_COUNTED = 20.0
# Targets that count more than one row or bar, and less.
WEIGHTS = {"table2 rms": 2.5, "segment A-B": 4.0, "gap 100um": 2.0, "stiffness": 2.0}
# Given up: what lets the 100 um wire's gap fall to the largest pretension narrows its hysteresis there to half of what
# the isobars measure, and breaks their rows (studies/alternative_fits.py).
GIVEN_UP = ("gap falls 100um", "smallest gap 100um")
LIGHT = ("hot end", "polynomial", "slope")


def above(value: float) -> float:
    """Return a value where it is above 0."""
    return max(float(value), 0.0)


def main_loop_targets(wires: PaperWires) -> Targets:
    """Return Table 2, Fig. 9 and Fig. 3 for the 100 um wire at 1.9 N."""
    loop = slow_loop(wires, "100um", 1.9)
    printed = PAPER["loop_100um"]
    found = table2_targets(loop)
    found["R_min"] = (loop.min_ohm - MIN_OF_NOISY_OHM - printed["resistance_min_ohm"]) / 0.02
    found["R_max"] = (loop.largest_ohm - printed["resistance_max_ohm"]) / 0.02
    found["gap 100um"] = (loop.strain_gap_pct + GAP_OF_NOISE_PCT - printed["strain_gap_pct"]) / 0.25
    found["segment A-B"] = (loop.segment_ab_pct - AB_OF_NOISE_PCT - 15.0) / 4.0
    found["hot end"] = above(loop.min_martensite - 0.15) / 0.05
    stroke = loop.stroke
    for amplitude, max_fraction in ((2.9, 0.94), (2.75, 0.92)):
        smaller = slow_loop(wires, "100um", 1.9, amplitude_v=amplitude).stroke
        fraction = smaller / stroke
        found[f"minor loop {amplitude} V"] = 1.0 + (fraction - max_fraction) / 0.03 if fraction > max_fraction else 0.0
        stroke = smaller
    found["smallest minor loop"] = above(0.29 - stroke / loop.stroke) / 0.02
    return found


def table2_targets(loop: Loop) -> Targets:
    """Return the strains of Table 2 and how well a polynomial follows each branch."""
    table = PAPER["table2"]
    found, differences = {}, []
    for branch in ("heating", "cooling"):
        strain_pct = 100.0 * np.interp(table["required_resistance_ohm"], *getattr(loop, branch))
        off = strain_pct - np.array(table[f"strain_{branch}_pct"])
        differences.append(off)
        found |= {f"table2 {branch} {i}": value / 0.05 for i, value in enumerate(off)}
        found[f"polynomial {branch}"] = loop.polynomial_misfit_pct(branch) / 0.03
    found["table2 rms"] = float(np.sqrt(np.mean(np.square(differences)))) / 0.02
    return found


def gaps_at_ratios(wires: PaperWires, spool: str) -> list[Loop]:
    """Return a spool's loops at the force ratios of Fig. 6."""
    return [slow_loop(wires, spool, ratio * MAXIMUM_FORCE_N[spool]) for ratio in FORCE_RATIOS]


def falling_targets(spool: str, loops: Sequence[Loop]) -> Targets:
    """Return that the gap falls from one force ratio to the next."""
    gaps = [loop.strain_gap_pct for loop in loops]
    return {
        f"gap falls {spool} {index}": above(after - before + CLEARLY_PCT) / 0.12
        for index, (before, after) in enumerate(pairwise(gaps))
    }


def loops_125um(wires: PaperWires) -> list[Loop]:
    """Return the 125 um wire's loops over pretension."""
    return [slow_loop(wires, "125um", pretension) for pretension in PRETENSIONS_125UM_N]


def pretension_targets(wires: PaperWires) -> Targets:
    """Return Figs. 4 and 5: gaps of the 125 um wire over pretension."""
    loops = loops_125um(wires)
    strain = [loop.strain_gap_pct for loop in loops]
    force = [loop.force_gap_pct for loop in loops]
    low, high = PAPER["strain_gap_125um"]["strain_gap_pct"]
    found = {
        "gap 125um 1.70 N": (strain[0] - low) / 0.5,
        "gap 125um 4.67 N": (strain[-1] - high) / 0.5,
        "force gap 3.22 N": (force[3] - PAPER["force_gap_125um"]["force_gap_pct"]) / 0.5,
        "largest distance 125um": loops[-1].largest_distance_pct / 5.0,
        "hot end 125um": above(max(loop.min_martensite for loop in loops) - 0.18) / 0.05,
    }
    for index in range(6):
        found[f"gap falls 125um {index}"] = above(strain[index + 1] - strain[index] + 0.1) / 0.1
    for index in (0, 1, 2, 4, 5, 6):
        found[f"force gap least at 3.22 N {index}"] = above(force[3] - force[index] + 0.1) / 0.1
    return found


def thin_targets(wires: PaperWires) -> Targets:
    """Return Fig. 6 for the 100 um wire: the gap falls and is smallest beyond a force ratio of 0.45."""
    loops = gaps_at_ratios(wires, "100um")
    gaps = [loop.strain_gap_pct for loop in loops]
    found = falling_targets("100um", loops)
    found["smallest gap 100um"] = above(min(gaps[2:]) - min(gaps[:2]) + 0.1) / 0.2
    found["force gap larger 100um"] = above(min(gaps) - min(loop.force_gap_pct for loop in loops) + 0.1) / 0.3
    return found


def thick_targets(wires: PaperWires) -> Targets:
    """Return Fig. 6 for the 200 um wire: the gap falls, below the force gap."""
    loops = gaps_at_ratios(wires, "200um")
    found = falling_targets("200um", loops)
    found["hot end 200um"] = above(max(loop.min_martensite for loop in loops) - 0.18) / 0.05
    smallest = min(loop.strain_gap_pct for loop in loops)
    found["force gap larger 200um"] = above(smallest - min(loop.force_gap_pct for loop in loops) + 0.1) / 0.3
    return found


def order_targets(wires: PaperWires) -> Targets:
    """Return Fig. 6: at equal force ratio the thinner of the three wires has the smaller gap."""
    gaps = [[loop.strain_gap_pct for loop in gaps_at_ratios(wires, spool)] for spool in ("100um", "125um", "200um")]
    found = {}
    for index in range(len(FORCE_RATIOS)):
        found[f"order 100, 125 um {index}"] = above(gaps[0][index] - gaps[1][index] + 0.15) / 0.3
        found[f"order 125, 200 um {index}"] = above(gaps[1][index] - gaps[2][index] + 0.15) / 0.3
    return found


def stiffness_target(wires: PaperWires) -> Targets:
    """Return Fig. 7: the largest distance of strain curves at half, one and two times the stiffness."""
    loops = [slow_loop(wires, "100um", 1.7, stiffness=factor) for factor in (0.5, 1.0, 2.0)]
    worst = max(
        one.distance_pct(other, branch)
        for index, one in enumerate(loops)
        for other in loops[:index]
        for branch in ("heating", "cooling")
    )
    return {"stiffness": worst / 5.0}


def isobar_targets(wires: PaperWires, without_mpa: float | None = None) -> Targets:
    """Return strokes, the points of 10, 50 and 90 % and slopes of the isobars, all but one if asked."""
    # Load turns more martensite along the wire, never less.
    backwards = wires.numbers["strain_at_no_stress"] - wires.numbers["strain_saturated"]
    found, summaries = {"strain grows with stress": above(backwards) / 0.001}, []
    for index, mpa in enumerate(ISOBARS["stress_mpa"]):
        if mpa == without_mpa:
            continue
        summary = summarize_isobar(
            simulated_isobar(wires.alloy, wires.isobar_sample, wires.bench, mpa * 1e6, points=111)
        )
        summaries.append(summary)
        found[f"stroke {mpa:g} MPa"] = (100.0 * summary.stroke - ISOBARS["stroke_pct"][index]) / 0.3
        for branch in ("heating", "cooling"):
            off = np.array(getattr(summary, f"{branch}_k")) - 273.15 - np.array(ISOBARS[f"{branch}_degc"][index])
            found[f"{branch} half {mpa:g} MPa"] = off[1] / 4.0
            found |= {f"{branch} tail {tail} {mpa:g} MPa": off[tail] / 7.0 for tail in (0, 2)}
    if without_mpa is None:
        for branch in ("heating", "cooling"):
            slope = half_transformation_slope_pa_per_k(summaries, branch) / 1e6
            found[f"slope {branch}"] = slope - ISOBARS[f"{branch}_slope_mpa_per_k"]
    return found


def finger_targets(wires: PaperWires) -> Targets:
    """Return Figs. 16 and 17: the finger's gap falls to 0.71 N, has the printed size there, and grows again."""
    loops = [finger_loop(wires, pretension) for pretension in PRETENSIONS_FINGER_N]
    gaps = [loop.strain_gap_pct for loop in loops]
    printed, chosen = PAPER["displacement_gap"], loops[CHOSEN_FINGER]
    found = {
        "finger gap": (chosen.strain_gap_pct - printed["displacement_gap_pct"]) / 0.7,
        "finger place": (lowest_place(PRETENSIONS_FINGER_N, gaps) - printed["pretension_n"]) / 0.15,
        "finger grows": above(gaps[CHOSEN_FINGER] - gaps[-1] + 0.3) / 0.2,
        "finger reach": above(6.05e-3 - float(chosen.heating[1].max())) / 1e-4,
        "hot end finger": above(chosen.min_martensite - 0.15) / 0.05,
    }
    for index in range(CHOSEN_FINGER):
        found[f"finger falls {index}"] = above(gaps[index + 1] - gaps[index] + 0.08) / 0.1
    return found | level_targets(chosen)


def level_targets(loop: Loop) -> Targets:
    """Return how far the branches lie from the averaged polynomial at the levels of Table 3."""
    off = loop.off_average([1e-3 * level for level, _, _ in FINGER_LEVELS])
    found = {}
    for (level, heating, cooling), (up, down) in zip(FINGER_LEVELS, off, strict=True):
        found[f"finger level heating {level:g} mm"] = 100.0 * up / heating
        found[f"finger level cooling {level:g} mm"] = 100.0 * down / cooling
    return found


# Groups of targets by name, and what a search that does not see them leaves out with them.
GROUPS: dict[str, Callable[[PaperWires], Targets]] = {
    "main loop": main_loop_targets,
    "100um": thin_targets,
    "125um": pretension_targets,
    "200um": thick_targets,
    "order": order_targets,
    "stiffness": stiffness_target,
    "isobars": isobar_targets,
    "finger": finger_targets,
}
HELD_OUT_WITH = {"125um": ("125um", "order"), "finger": ("finger",)}


def targets(vector: FloatArray, held_out: str | None = None) -> Targets:
    """Return every target of a vector by name, in units of its tolerance: within -1 to 1 it holds.

    ``held_out`` leaves some out: "finger", "125um" or an isobar as "100 MPa".
    """
    wires = paper_wires(vector)
    left_out = HELD_OUT_WITH.get(held_out or "", ())
    found: Targets = {}
    for name, measure in GROUPS.items():
        if name in left_out:
            continue
        if name == "isobars" and held_out is not None and held_out.endswith(" MPa"):
            found |= isobar_targets(wires, float(held_out.removesuffix(" MPa")))
        else:
            found |= measure(wires)
    return found


def weight(name: str) -> float:
    """Return how much a target counts."""
    if name.startswith(GIVEN_UP):
        return 0.12
    return WEIGHTS.get(name, 0.6 if name.startswith(LIGHT) else 1.0)


def cost(vector: FloatArray, held_out: str | None = None) -> float:
    """Return what the search makes small: the price of what is missed, small squares of all, and the weak pulls."""
    found = targets(vector, held_out)
    values, weights = np.array(list(found.values())), np.array([weight(name) for name in found])
    if not np.all(np.isfinite(values)):
        return 1e9
    numbers = dict(zip(NAMES, vector, strict=True))
    pull = sum(((numbers[name] - centre) / deviation) ** 2 for name, (centre, deviation) in PULL.items())
    beyond = np.minimum(np.maximum(np.abs(values) - FREE_FRACTION, 0.0), LARGEST_COUNTED)
    price = MISSED * (1.0 - np.exp(-3.0 * beyond)) + BEYOND * beyond
    squares = np.minimum(values**2, LARGEST_COUNTED**2)
    return float(np.sum(weights * price) + SQUARES * np.sum(squares) + PULLING * pull)
