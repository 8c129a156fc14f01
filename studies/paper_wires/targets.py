"""Loops of a candidate and how far each number is from what is printed or measured, in units of its tolerance."""

from __future__ import annotations

import math

import numpy as np

from musclewire.identify.isobaric_loops import half_transformation_slope_pa_per_k, simulated_isobar, summarize_isobar
from musclewire.parameters.library import read_published
from musclewire.simulate.paths import drive_path
from musclewire.simulate.stepping import fixed_steps
from musclewire.wire.building import constants_from
from paper_wires.loops import Loop, analysed
from paper_wires.unknowns import NAMES, PULL, FloatArray, PaperWires, changed, paper_wires

STEP_S, STEPS = 0.025, 2
PRETENSIONS_125UM_N = (1.70, 2.20, 2.71, 3.22, 3.95, 4.30, 4.67)
ORDER_PRETENSION_200UM_N = 7.53  # the force ratio of 1.9 N on the 100 um wire
# A recording's least resistance is the least of many noisy readings at C: by about this much below the wire's own.
MIN_OF_NOISY_OHM = 0.011
PAPER, ISOBARS = read_published("lan_fan_2010"), read_published("flexinol_isobars")


def slow_loop(
    wires: PaperWires,
    diameter_um: int,
    pretension_n: float,
    *,
    amplitude_v: float | None = None,
    stiffness: float = 1.0,
) -> Loop:
    """Return one slow sine of a spool on the bench, noise-free."""
    own = wires.bench.values()
    bench = changed(
        wires.bench,
        pretension_n=pretension_n,
        spring_stiffness_n_per_m=stiffness * own["spring_stiffness_n_per_m"],
    )
    constants = constants_from(wires.alloy, wires.wires[diameter_um], bench)
    time_s = STEP_S * STEPS * np.arange(round(90.0 / (STEP_S * STEPS)))
    amplitude = wires.amplitude_v(diameter_um) if amplitude_v is None else amplitude_v
    sense = own["sense_voltage_v"]
    drive = sense + (amplitude - sense) * 0.5 * (1.0 - np.cos(2.0 * math.pi * time_s / 90.0))
    path, _ = drive_path(constants, drive, sample_s=STEPS * STEP_S, stepping=fixed_steps(STEP_S))
    return analysed(path, pretension_n, constants.leg_length_m, constants.shunt_resistance_ohm)


def above(value: float) -> float:
    """Return a value where it is above 0."""
    return max(float(value), 0.0)


def main_loop_targets(wires: PaperWires) -> dict[str, float]:
    """Return Table 2, Fig. 9 and Fig. 3 for the 100 um wire at 1.9 N."""
    loop = slow_loop(wires, 100, 1.9)
    table, printed = PAPER["table2"], PAPER["loop_100um"]
    found = {}
    differences = []
    for branch in ("heating", "cooling"):
        strain_pct = 100.0 * np.interp(table["required_resistance_ohm"], *getattr(loop, branch))
        off = strain_pct - np.array(table[f"strain_{branch}_pct"])
        differences.append(off)
        found |= {f"table2 {branch} {i}": value / 0.05 for i, value in enumerate(off)}
        found[f"polynomial {branch}"] = loop.polynomial_misfit_pct(branch) / 0.04
    found["table2 rms"] = float(np.sqrt(np.mean(np.square(differences)))) / 0.02
    found["R_min"] = (loop.min_ohm - MIN_OF_NOISY_OHM - printed["resistance_min_ohm"]) / 0.02
    found["R_max"] = (loop.largest_ohm - printed["resistance_max_ohm"]) / 0.02
    found["gap 100um"] = (loop.strain_gap_pct - printed["strain_gap_pct"]) / 0.25
    # Counts a tenth: resistance turns where the measured isobars let it, long before 15 % of the strain are done.
    found["segment A-B"] = (loop.segment_ab_pct - 15.0) / 40.0
    found["hot end"] = above(loop.min_martensite - 0.03) / 0.03
    stroke = loop.stroke
    for amplitude, max_fraction in ((2.9, 0.94), (2.75, 0.92)):
        smaller = slow_loop(wires, 100, 1.9, amplitude_v=amplitude).stroke
        fraction = smaller / stroke
        found[f"minor loop {amplitude} V"] = 1.0 + (fraction - max_fraction) / 0.03 if fraction > max_fraction else 0.0
        stroke = smaller
    found["smallest minor loop"] = above(0.2 - stroke / loop.stroke) / 0.05
    return found


def pretension_targets(wires: PaperWires) -> dict[str, float]:
    """Return Figs. 4 to 6: gaps of the 125 um wire over pretension, and the order of the three diameters."""
    loops = [slow_loop(wires, 125, pretension) for pretension in PRETENSIONS_125UM_N]
    strain = [loop.strain_gap_pct for loop in loops]
    force = [loop.force_gap_pct for loop in loops]
    low, high = PAPER["strain_gap_125um"]["strain_gap_pct"]
    found = {
        "gap 125um 1.70 N": (strain[0] - low) / 0.5,
        "gap 125um 4.67 N": (strain[-1] - high) / 0.5,
        "force gap 3.22 N": (force[3] - PAPER["force_gap_125um"]["force_gap_pct"]) / 0.5,
        "hot end 125um": above(max(loop.min_martensite for loop in loops) - 0.05) / 0.03,
    }
    for index in range(6):
        found[f"gap falls {index}"] = above(strain[index + 1] - strain[index] + 0.1) / 0.1
    for index in (0, 1, 2, 4, 5, 6):
        found[f"force gap least at 3.22 N {index}"] = above(force[3] - force[index] + 0.1) / 0.1
    thick = slow_loop(wires, 200, ORDER_PRETENSION_200UM_N)
    same_ratio = float(np.interp(2.98, PRETENSIONS_125UM_N, strain))
    found["hot end 200um"] = above(thick.min_martensite - 0.05) / 0.03
    found["order 100, 125 um"] = above(slow_loop(wires, 100, 1.9).strain_gap_pct - same_ratio + 0.3) / 0.3
    found["order 125, 200 um"] = above(same_ratio - thick.strain_gap_pct + 0.3) / 0.3
    return found


def stiffness_target(wires: PaperWires) -> dict[str, float]:
    """Return Fig. 7: the largest distance of strain curves at half, one and two times the stiffness."""
    loops = [slow_loop(wires, 100, 1.7, stiffness=factor) for factor in (0.5, 1.0, 2.0)]
    worst = max(
        one.distance_pct(other, branch)
        for index, one in enumerate(loops)
        for other in loops[:index]
        for branch in ("heating", "cooling")
    )
    return {"stiffness": worst / 5.0}


def isobar_targets(wires: PaperWires) -> dict[str, float]:
    """Return strokes, temperatures and slopes of the isobars; tenths and nine tenths count little."""
    # Between austenite and R-phase hysteresis is 1 to 5 K wide (published): h_R / r to either side.
    width_k = 2.0 * wires.numbers["r_phase_barrier_k"] / wires.numbers["r_phase_entropy_ratio"]
    # Load turns more martensite along the wire, never less.
    backwards = wires.numbers["strain_at_no_stress"] - wires.numbers["strain_saturated"]
    found = {"R-phase hysteresis": above(width_k - 5.0) / 3.0, "strain grows with stress": above(backwards) / 0.001}
    summaries = []
    for index, mpa in enumerate(ISOBARS["stress_mpa"]):
        loop = simulated_isobar(wires.alloy, wires.isobar_sample, wires.bench, mpa * 1e6, points=111)
        summary = summarize_isobar(loop)
        summaries.append(summary)
        found[f"stroke {mpa:g} MPa"] = (100.0 * summary.stroke - ISOBARS["stroke_pct"][index]) / 0.3
        for branch in ("heating", "cooling"):
            ours = np.array(getattr(summary, f"{branch}_k")) - 273.15
            off = ours - np.array(ISOBARS[f"{branch}_degc"][index])
            found[f"{branch} half {mpa:g} MPa"] = off[1] / 4.0
            found |= {f"{branch} tail {tail} {mpa:g} MPa": off[tail] / 16.0 for tail in (0, 2)}
    for branch in ("heating", "cooling"):
        slope = half_transformation_slope_pa_per_k(summaries, branch) / 1e6
        found[f"slope {branch}"] = slope - ISOBARS[f"{branch}_slope_mpa_per_k"]
    return found


def targets(vector: FloatArray) -> dict[str, float]:
    """Return every target of a vector by name, in units of its tolerance: within -1 to 1 it holds."""
    wires = paper_wires(vector)
    return {
        **main_loop_targets(wires),
        **pretension_targets(wires),
        **stiffness_target(wires),
        **isobar_targets(wires),
    }


def cost(vector: FloatArray) -> float:
    """Return what the search makes small: squares, a steep price beyond 0.9 of a tolerance, and the weak pulls."""
    found = np.array(list(targets(vector).values()))
    if not np.all(np.isfinite(found)):
        return 1e9
    numbers = dict(zip(NAMES, vector, strict=True))
    pull = sum(((numbers[name] - centre) / deviation) ** 2 for name, (centre, deviation) in PULL.items())
    beyond = np.maximum(np.abs(found) - 0.9, 0.0)
    return float(0.5 * np.sum(found**2) + 60.0 * np.sum(beyond**1.5) + 0.3 * pull)
