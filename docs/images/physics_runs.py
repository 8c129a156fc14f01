"""Simulated loops behind docs/explanation/physics.md: phases over strain, and why heating and cooling differ.

Noise-free: the truth of the simulated wire (``wire._paths``), not what its instruments would read.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.experiment import slow_sine
from musclewire.parameters import load_alloy, load_bench, load_wire, read_published
from musclewire.physics import REFERENCE_TEMPERATURE_K
from musclewire.sensing import find_segments, hysteresis_gap, signed_hysteresis_gap
from musclewire.wire import DrivenPath, WireConstants, constants_from, drive_path, with_pretension

FloatArray = NDArray[np.float64]

SWEEP_WIRE = "paper-125um"
PERIOD_S = 90.0
PHASES = ("austenite", "r_phase", "martensite")
SWEEP_POINTS = 28
# So cold that no R-phase forms on the way.
NEVER_K = 1.0


class Branch(NamedTuple):
    """A stretch of a loop over time: means over samples, each (n_samples,)."""

    contraction: FloatArray
    resistance_ohm: FloatArray
    temperature_k: FloatArray
    stress_pa: FloatArray
    austenite: FloatArray
    r_phase: FloatArray
    martensite: FloatArray


class LoopTruth(NamedTuple):
    """One slow loop: whole branches from A to C and C to A, the strains that both have in B to C, and the gaps."""

    constants: WireConstants
    pretension_n: float
    heating: Branch
    cooling: Branch
    shared_contraction: tuple[float, float]
    strain_gap: float
    signed_gap: float


class Parts(NamedTuple):
    """Resistance of the heating less that of the cooling branch at equal strain [ohm], and what it is made of."""

    contraction: FloatArray
    whole: FloatArray
    hotter: FloatArray
    r_phase: FloatArray
    rest: FloatArray


def constants_of_wire(name: str) -> WireConstants:
    """Return a shipped wire on the paper's bench."""
    wire = load_wire(name)
    return constants_from(load_alloy(wire.alloy), wire, load_bench("paper"))


def slow_loop(constants: WireConstants, wire: str) -> LoopTruth:
    """Return the second of two slow sines of a wire: the first one only settles it."""
    bench = load_bench("paper").values()
    sample_s = bench["sample_period_s"]
    drive = slow_sine(load_wire(wire).drive_amplitude_v.value, bench["sense_voltage_v"], PERIOD_S)
    times = sample_s * np.arange(round(2.0 * PERIOD_S / sample_s))
    path, _ = drive_path(constants, np.array([drive(t) for t in times]), sample_s=sample_s)
    means = means_of(path, constants)
    contraction = means.contraction
    found = find_segments(means.resistance_ohm, contraction)
    heating = slice(found.heating_b, found.heating_c + 1)
    cooling = slice(found.cooling_c, found.cooling_b + 1)
    return LoopTruth(
        constants=constants,
        pretension_n=constants.pretension_n,
        heating=Branch(*(each[found.heating_a : found.heating_c + 1] for each in means)),
        cooling=Branch(*(each[found.heating_c : found.cooling_a + 1] for each in means)),
        shared_contraction=(
            float(max(contraction[heating].min(), contraction[cooling].min())),
            float(min(contraction[heating].max(), contraction[cooling].max())),
        ),
        strain_gap=hysteresis_gap(found.heating, found.cooling),
        signed_gap=signed_hysteresis_gap(found.heating, found.cooling),
    )


def means_of(path: DrivenPath, constants: WireConstants) -> Branch:
    """Return means over each sample: a path gives voltages and displacement so, and the rest where samples end."""
    ends = np.array([path.temperature_k, path.stress_pa, path.r_phase_fraction, path.martensite_fraction])
    temperature_k, stress_pa, r_phase, martensite = 0.5 * (ends + np.hstack([ends[:, :1], ends[:, :-1]]))
    return Branch(
        path.displacement_m / constants.leg_length_m,
        path.wire_voltage_v / path.shunt_voltage_v * constants.shunt_resistance_ohm,
        temperature_k,
        stress_pa,
        1.0 - martensite - r_phase,
        r_phase,
        martensite,
    )


def loops_of_the_sweep() -> tuple[LoopTruth, LoopTruth, LoopTruth]:
    """Return the 125 um wire at the paper's lowest pretension, at the best one between, at its highest.

    Where the gap is smallest at one of the ends, the one between is that of the paper's smallest force gap.
    """
    paper = read_published("lan_fan_2010")
    lowest, highest = paper["strain_gap_125um"]["pretension_n"]
    constants = constants_of_wire(SWEEP_WIRE)
    settings = np.linspace(lowest, highest, SWEEP_POINTS)
    loops = [slow_loop(with_pretension(constants, float(force)), SWEEP_WIRE) for force in settings]
    best = min(range(SWEEP_POINTS), key=lambda place: loops[place].strain_gap)
    between = loops[best]
    if best in (0, SWEEP_POINTS - 1):
        middle = paper["force_gap_125um"]["pretension_n"]
        between = slow_loop(with_pretension(constants, middle), SWEEP_WIRE)
    return loops[0], between, loops[-1]


def without_r_phase(loop: LoopTruth, wire: str = SWEEP_WIRE) -> LoopTruth:
    """Return the same loop of a wire whose R-phase is out of reach, as a model of two phases has it."""
    constants = loop.constants.replace(r_phase_temperature_k=NEVER_K)
    return slow_loop(with_pretension(constants, loop.pretension_n), wire)


def at_strain(branch: Branch, contraction: FloatArray) -> Branch:
    """Return a branch at given contractions; it must not turn back between them."""
    rising = branch if branch.contraction[-1] > branch.contraction[0] else Branch(*(each[::-1] for each in branch))
    place = np.maximum.accumulate(rising.contraction)
    return Branch(*(np.interp(contraction, place, each) for each in rising))


def resistivities(constants: WireConstants, temperature_k: FloatArray) -> FloatArray:
    """Return the resistivity of austenite, R-phase and martensite at each temperature, (3, n)."""
    at_20_degc, per_k = (
        np.array([[getattr(constants, f"{phase}_{name}")] for phase in PHASES])
        for name in ("resistivity_ohm_m", "resistivity_per_k")
    )
    return np.asarray(at_20_degc * (1.0 + per_k * (temperature_k - REFERENCE_TEMPERATURE_K)))


def parts_of_the_difference(loop: LoopTruth, points: int = 200) -> Parts:
    """Return the parts of the difference in resistance between heating and cooling at equal strain.

    R = G rho with rho = sum x_i rho_i(T) and G the geometry. A difference of products is exactly the sum of each
    factor's difference times the other's mean. "Hotter" is the effect of temperature at the mean phases; "R-phase" is
    that of R-phase in place of austenite; the rest is that of the martensite fraction and the geometry.
    """
    low, high = loop.shared_contraction
    strain = np.linspace(low, high, points)
    hot, cold = at_strain(loop.heating, strain), at_strain(loop.cooling, strain)
    fractions = [np.array([getattr(branch, phase) for phase in PHASES]) for branch in (hot, cold)]
    rho = [resistivities(loop.constants, branch.temperature_k) for branch in (hot, cold)]
    shape = [
        branch.resistance_ohm / (fraction * each).sum(axis=0)
        for branch, fraction, each in zip((hot, cold), fractions, rho, strict=True)
    ]
    mean_shape, mean_rho = 0.5 * (shape[0] + shape[1]), 0.5 * (rho[0] + rho[1])
    hotter = mean_shape * (0.5 * (fractions[0] + fractions[1]) * (rho[0] - rho[1])).sum(axis=0)
    more_r = fractions[0][1] - fractions[1][1]
    r_phase = mean_shape * more_r * (mean_rho[1] - mean_rho[0])
    whole = hot.resistance_ohm - cold.resistance_ohm
    return Parts(strain, whole, hotter, r_phase, whole - hotter - r_phase)
