"""Section II: minor loops and segments, pretension, diameter, stiffness (Figs. 3 to 8)."""

from __future__ import annotations

from typing import Literal

import numpy as np

from musclewire.extras.paper._reproduce.loops import SlowSineLoop
from musclewire.extras.paper._reproduce.measures import (
    drive_gap_pct,
    falling_steps,
    force_ratio_of,
    largest_distance,
    lowest_place,
    off_line_pct,
    off_temperature_pct,
    outside_loop_pct,
    rank_correlation,
)
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.extras.paper._reproduce.table1 import WIRES, wire_name
from musclewire.parameters import load_wire, read_published

FORCE_RATIOS = (0.25, 0.35, 0.45, 0.55, 0.65)
# The force ratio that the smallest gap must lie beyond.
MIDDLE_RATIO = 0.45


def loops_at_ratio(runs: RunCache, wire: str) -> list[SlowSineLoop]:
    """Return the loops of a wire at every force ratio of Fig. 6."""
    largest = load_wire(wire).maximum_force_n.value
    return [runs.loop(wire, round(ratio * largest, 3)) for ratio in FORCE_RATIOS]


def strain_gaps_pct(runs: RunCache, wire: str) -> list[float]:
    """Return a wire's strain gap at every force ratio [%]."""
    return [loop.strain_gap_pct for loop in loops_at_ratio(runs, wire)]


def ratios_in_order(runs: RunCache) -> float:
    """Return the number of force ratios at which the smaller of all three wires has the smaller strain gap."""
    gaps = np.array([strain_gaps_pct(runs, wire) for wire in WIRES])
    return float((np.diff(gaps, axis=0) > 0.0).all(axis=0).sum())


def gap_rank_correlation(runs: RunCache, *, diameter_um: int) -> float:
    """Return the rank correlation of a wire's strain gap with the force ratio."""
    return rank_correlation(FORCE_RATIOS, strain_gaps_pct(runs, wire_name(diameter_um)))


def smallest_gap_at_ratio(runs: RunCache, *, diameter_um: int) -> float:
    """Return the force ratio of a wire's smallest strain gap."""
    return lowest_place(FORCE_RATIOS, strain_gaps_pct(runs, wire_name(diameter_um)))


def force_less_strain_pct(runs: RunCache, *, diameter_um: int) -> float:
    """Return the smallest force gap less the smallest strain gap of a wire [%]."""
    wire = wire_name(diameter_um)
    smallest_force_gap_pct = min(loop.force_gap_pct for loop in loops_at_ratio(runs, wire))
    return smallest_force_gap_pct - min(strain_gaps_pct(runs, wire))


MAIN_WIRE, SWEEP_WIRE = "paper-100um", "paper-125um"
SWEEP_POINTS = 13
STIFFNESS_FACTORS = (0.5, 1.0, 2.0)


def loop_of_amplitude(runs: RunCache, volts: float) -> SlowSineLoop:
    """Return the 100 um loop of Fig. 3 with one amplitude, at the pretension of Fig. 9 (Fig. 3 prints none)."""
    pretension = read_published("lan_fan_2010")["loop_100um"]["pretension_n"]
    return runs.loop(MAIN_WIRE, pretension, amplitude_v=float(volts))


def amplitude_of(runs: RunCache, *, volts: float) -> float:
    """Return the amplitude that a loop's recording states."""
    return loop_of_amplitude(runs, volts).recording.facts.amplitude_v


def stroke_ratio(runs: RunCache, *, small: float, large: float) -> float:
    """Return the stroke at one amplitude over that at a larger one."""
    return loop_of_amplitude(runs, small).stroke_pct / loop_of_amplitude(runs, large).stroke_pct


def outside_pct(runs: RunCache, *, small: float, large: float) -> float:
    """Return the largest excursion of the loop of one amplitude out of that of a larger one [% strain]."""
    return outside_loop_pct(loop_of_amplitude(runs, small), loop_of_amplitude(runs, large))


def temperature_distance_pct(runs: RunCache) -> float:
    """Return how far strain over voltage is from strain over temperature [% of S_max]."""
    return off_temperature_pct(runs.main_loop())


def unreturned_pct(runs: RunCache) -> float:
    """Return the strain of the last second less that of the first, before any heating, as a size [% strain]."""
    loop = runs.main_loop()
    time_s, strain = loop.recording["time_s"], loop.quantity("strain")
    return float(100.0 * abs(strain[time_s > time_s[-1] - 1.0].mean() - strain[time_s < time_s[0] + 1.0].mean()))


def segment_correlation(runs: RunCache, *, segment: Literal["A-B", "B-C"]) -> float:
    """Return the correlation of strain and resistance in a segment, of heating or cooling: the nearer to 0."""
    loop = runs.main_loop()
    found, strain = loop.gaps.segments, loop.quantity("strain")
    ends = {
        "A-B": ((found.heating_a, found.heating_b), (found.cooling_b, found.cooling_a)),
        "B-C": ((found.heating_b, found.heating_c), (found.cooling_c, found.cooling_b)),
    }[segment]
    parts = [slice(first, last + 1) for first, last in ends]
    return float(min((np.corrcoef(loop.resistance_ohm[part], strain[part])[0, 1] for part in parts), key=abs))


def bent_pct(runs: RunCache) -> float:
    """Return how far segment B-C is from a straight line, heating or cooling [% of S_max]."""
    return max(off_line_pct(branch) for branch in runs.main_loop().sensing_branches("strain"))


def segment_ab_pct(runs: RunCache) -> float:
    """Return the fraction of the strain before B on heating [%]."""
    return 100.0 * (1.0 - runs.main_loop().gaps.segments.transformation_fraction)


def segment_bc_pct(runs: RunCache) -> float:
    """Return the rest of the strain, from B to C on heating [%]."""
    return 100.0 - segment_ab_pct(runs)


def segment_bc_cooling_pct(runs: RunCache) -> float:
    """Return the fraction of the strain from C to B on cooling [%]."""
    return 100.0 * runs.main_loop().gaps.segments.cooling_transformation_fraction


def gap_ratio(runs: RunCache) -> float:
    """Return the gap over voltage as a multiple of the gap over resistance."""
    loop = runs.main_loop()
    return drive_gap_pct(loop) / loop.strain_gap_pct


def sweep_settings_n() -> list[float]:
    """Return the pretensions of the 125 um sweep between those printed with Fig. 4, about 0.25 N apart."""
    low, high = read_published("lan_fan_2010")["strain_gap_125um"]["pretension_n"]
    return [round(float(force), 2) for force in np.linspace(low, high, SWEEP_POINTS)]


def distance_of_branches_pct(runs: RunCache, *, force_n: float) -> float:
    """Return the largest distance of the 125 um wire's heating branch from its cooling branch [% of S_max]."""
    loop = runs.loop(SWEEP_WIRE, force_n)
    return 100.0 * largest_distance(*loop.sensing_branches("strain")) / loop.gaps.segments.strain_max


def strain_gap_pct(runs: RunCache, *, force_n: float) -> float:
    """Return the strain gap of the 125 um wire at a pretension [%]."""
    return runs.loop(SWEEP_WIRE, force_n).strain_gap_pct


def force_gap_pct(runs: RunCache, *, force_n: float) -> float:
    """Return the force gap of the 125 um wire at a pretension [%]."""
    return runs.loop(SWEEP_WIRE, force_n).force_gap_pct


def falling_count(runs: RunCache) -> float:
    """Return the number of steps of the sweep at which the strain gap falls."""
    return falling_steps([strain_gap_pct(runs, force_n=force) for force in sweep_settings_n()])


def sweep_force_gaps_pct(runs: RunCache) -> list[float]:
    """Return the force gap at each setting of the sweep."""
    return [force_gap_pct(runs, force_n=force) for force in sweep_settings_n()]


def smallest_force_gap_at_n(runs: RunCache) -> float:
    """Return the pretension of the smallest force gap."""
    return lowest_place(sweep_settings_n(), sweep_force_gaps_pct(runs))


def force_gap_rise_pct(runs: RunCache) -> float:
    """Return the rise of the force gap at the end of the sweep above its minimum; below 0 if it still falls."""
    gaps = sweep_force_gaps_pct(runs)
    return gaps[-1] - min(gaps[:-1])


def force_gap_fall(runs: RunCache, *, until_n: float) -> float:
    """Return the rank correlation of force gap and pretension over the settings up to ``until_n`` [N]."""
    pairs = zip(sweep_settings_n(), sweep_force_gaps_pct(runs), strict=True)
    forces, gaps = zip(*((force, gap) for force, gap in pairs if force <= until_n), strict=True)
    return rank_correlation(forces, gaps)


def force_less_strain_at_largest_pct(runs: RunCache) -> float:
    """Return force gap less strain gap of the 125 um wire at the largest pretension of the sweep [%]."""
    loop = runs.loop(SWEEP_WIRE, sweep_settings_n()[-1])
    return loop.force_gap_pct - loop.strain_gap_pct


def loop_of_stiffness(runs: RunCache, factor: float) -> SlowSineLoop:
    """Return the loop of Figs. 7 and 8 with a multiple of the printed stiffness."""
    paper = read_published("lan_fan_2010")
    stiffness = factor * paper["setup"]["spring_stiffness_n_per_m"]
    return runs.loop(MAIN_WIRE, paper["stiffness_100um"]["pretension_n"], stiffness_n_per_m=stiffness)


def strain_distance_pct(runs: RunCache, *, soft: float, stiff: float) -> float:
    """Return the largest distance of two strain curves at equal resistance [% of S_max]."""
    one, other = (loop_of_stiffness(runs, factor) for factor in (soft, stiff))
    largest = max(loop.gaps.segments.strain_max for loop in (one, other))
    pairs = zip(one.sensing_branches("strain"), other.sensing_branches("strain"), strict=True)
    distances = [largest_distance(first, second) for first, second in pairs]
    return 100.0 * max(distances) / largest


def stiffness_force_ratio(runs: RunCache, *, soft: float, stiff: float) -> float:
    """Return the force with the stiffer spring over that with the softer one, at equal resistance."""
    return force_ratio_of(loop_of_stiffness(runs, soft), loop_of_stiffness(runs, stiff))
