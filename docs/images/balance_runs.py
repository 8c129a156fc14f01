"""What parts heating from cooling, and what closes it: the balance behind a section of docs/explanation/physics.md."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from physics_runs import NEVER_K, PHASES, LoopTruth, at_strain, constants_of_wire, resistivities, slow_loop

from musclewire.parameters import load_alloy, load_wire, published_ranges, read_published
from musclewire.wire import with_pretension

BALANCE_WIRES = ("paper-100um", "paper-125um")
FORCE_RATIOS = (0.25, 0.35, 0.45, 0.55, 0.65)
# For the picture: more finely, from the lowest pretension of the paper's Fig. 4.
FINE_RATIOS = tuple(round(float(ratio), 4) for ratio in np.linspace(0.235, FORCE_RATIOS[-1], 21))
STRESSES_MPA = (50.0, 100.0, 150.0, 200.0)
POINTS = 200
MPA = 1e6


class Balance(NamedTuple):
    """Resistance of the heating less that of the cooling branch at equal strain [ohm], mean over the strain, exactly.

    The temperature's part by phases, then R-phase and martensite in place of austenite, then geometry. With them the
    difference in temperature [K], the range of resistance that the branches share, and what temperature would make of
    these phases with the published coefficients and the distance of the isobars.
    """

    force_ratio: float
    loop: LoopTruth
    hotter_austenite: float
    hotter_r_phase: float
    hotter_martensite: float
    r_phase: float
    martensite: float
    geometry: float
    whole: float
    hotter_k: float
    range_ohm: float
    published_hotter: float

    @property
    def hotter(self) -> float:
        """What temperature makes of the difference, all phases."""
        return self.hotter_austenite + self.hotter_r_phase + self.hotter_martensite

    @property
    def small(self) -> float:
        """What is left next to temperature and R-phase."""
        return self.martensite + self.geometry


def balance_of(loop: LoopTruth, force_ratio: float) -> Balance:
    """Return the parts of a loop's difference in resistance.

    R = G sum x_i rho_i(T), G the geometry. A difference of products is exactly the sum of each factor's difference
    times the other factor's mean.
    """
    strain = np.linspace(*loop.shared_contraction, POINTS)
    branches = [at_strain(loop.heating, strain), at_strain(loop.cooling, strain)]
    fraction = np.array([[getattr(branch, phase) for phase in PHASES] for branch in branches])
    rho = np.array([resistivities(loop.constants, branch.temperature_k) for branch in branches])
    ohm = np.array([branch.resistance_ohm for branch in branches])
    mixed = (fraction * rho).sum(axis=1)
    shape = ohm / mixed
    mean_shape, mean_rho, mean_fraction = shape.mean(axis=0), rho.mean(axis=0), fraction.mean(axis=0)
    hotter = (mean_shape * mean_fraction * (rho[0] - rho[1])).mean(axis=1)
    instead = (mean_shape * (fraction[0] - fraction[1]) * (mean_rho - mean_rho[0])).mean(axis=1)
    per_k = (mean_shape * mean_fraction).mean(axis=1) @ published_ohm_m_per_k(loop)
    return Balance(
        force_ratio=force_ratio,
        loop=loop,
        hotter_austenite=float(hotter[0]),
        hotter_r_phase=float(hotter[1]),
        hotter_martensite=float(hotter[2]),
        r_phase=float(instead[1]),
        martensite=float(instead[2]),
        geometry=float(((shape[0] - shape[1]) * mixed.mean(axis=0)).mean()),
        whole=float((ohm[0] - ohm[1]).mean()),
        hotter_k=float((branches[0].temperature_k - branches[1].temperature_k).mean()),
        range_ohm=float(np.ptp(ohm.mean(axis=0))),
        published_hotter=float(per_k) * measured_distance_k(),
    )


def published_coefficients() -> tuple[float, float]:
    """Return the published temperature coefficients of austenite (its upper end) and martensite [1/K]."""
    ranges = published_ranges().parameters
    return ranges["austenite_resistivity_per_k"].high, ranges["martensite_resistivity_per_k"].high


def published_ohm_m_per_k(loop: LoopTruth) -> tuple[float, float, float]:
    """Return how resistivities would rise with published coefficients; R-phase has none and counts as austenite."""
    austenite, martensite = published_coefficients()
    constants = loop.constants
    return (
        austenite * constants.austenite_resistivity_ohm_m,
        austenite * constants.r_phase_resistivity_ohm_m,
        martensite * constants.martensite_resistivity_ohm_m,
    )


def measured_distances_k() -> dict[float, float]:
    """Return how far the measured isobars' branches are apart where half of the stroke is done, by stress [MPa]."""
    published = read_published("flexinol_isobars")
    found = {}
    for curves in (published, published["held_out"]):
        for mpa, up, down in zip(curves["stress_mpa"], curves["heating_degc"], curves["cooling_degc"], strict=True):
            found[mpa] = up[1] - down[1]
    return dict(sorted(found.items()))


def measured_distance_k() -> float:
    """Return the median over the isobars."""
    return float(np.median(list(measured_distances_k().values())))


def half_hysteresis_k(mpa: float) -> float:
    """Return the shipped alloy's barrier between austenite and martensite at a stress."""
    alloy = load_alloy("flexinol").values()
    return max(alloy["martensite_barrier_k"] + alloy["martensite_barrier_per_pa"] * MPA * mpa, 0.0)


def changed_wires() -> dict[str, dict[str, float]]:
    """Return what one changes in the shipped wire to see what a cause does, by its name on the page."""
    austenite, martensite = published_coefficients()
    barrier = {"martensite_barrier_per_pa": 0.0}
    coefficients = {"austenite_resistivity_per_k": austenite, "martensite_resistivity_per_k": martensite}
    return {
        "as shipped": {},
        "without an R-phase": {"r_phase_temperature_k": NEVER_K},
        "the same barrier at every stress": barrier,
        "published coefficients of austenite and martensite": coefficients,
        "both of these": barrier | coefficients,
        "an R-phase that does not lengthen the wire": {"r_phase_strain": 0.0},
        "no thermal expansion": {"austenite_expansion_per_k": 0.0, "martensite_expansion_per_k": 0.0},
    }


def other_spool(wire: str) -> dict[str, float]:
    """Return the transformation temperatures of the other of the two wires."""
    other = constants_of_wire(next(each for each in BALANCE_WIRES if each != wire))
    return {name: getattr(other, name) for name in ("martensite_temperature_k", "r_phase_temperature_k")}


def loop_at_ratio(wire: str, force_ratio: float, **changed: float) -> LoopTruth:
    """Return a slow loop of a shipped wire, or of one with some constants changed, at a force ratio of Fig. 6."""
    constants = constants_of_wire(wire)
    force_n = force_ratio * load_wire(wire).maximum_force_n.value
    return slow_loop(with_pretension(constants.replace(**changed) if changed else constants, force_n), wire)


def balances(wire: str, ratios: tuple[float, ...] = FORCE_RATIOS) -> list[Balance]:
    """Return the balance of a shipped wire at each force ratio."""
    return [balance_of(loop_at_ratio(wire, ratio), ratio) for ratio in ratios]
