"""A wire on its spring through time, written a second time from the published equations, without the kernel.

Plain NumPy and SciPy in continuous time. Enthalpy is integrated by ``solve_ivp`` with an error estimate; at each
enthalpy ``brentq`` finds the temperature, and at each temperature the stress at which wire and spring agree. Every
class of grains is looked at every time, convection is the correlation itself and not a table of it, the drive is a
function of time and not held, and nothing is predicted from a step before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.stats import norm

from musclewire.parameters import Alloy, Bench, Wire

Array = NDArray[np.float64]
TWENTY_DEGC_K = 293.15


class Memory(NamedTuple):
    """What a history leaves behind: shares of each class, (n_classes,); contraction and friction [N]."""

    martensite: Array
    formed: Array  # martensite and R-phase together
    contraction: float
    friction_n: float


class Moment(NamedTuple):
    """The wire at one enthalpy."""

    temperature_k: float
    stress_pa: float
    contraction: float
    resistance_ohm: float
    force_n: float
    memory: Memory


def churchill_chu_w_per_m2_k(wall_k: float, ambient_k: float, diameter_m: float) -> float:
    """Return the convection of a horizontal wire in air (doi 10.1016/0017-9310(75)90222-7)."""
    film = (wall_k + ambient_k) / 2
    viscosity = 1.458e-6 * film**1.5 / (film + 110.4)
    conductivity = 2.64638e-3 * film**1.5 / (film + 245.4 * 10 ** (-12 / film))
    prandtl = 1006.0 * viscosity / conductivity
    kinematic = viscosity * 287.05 * film / 101325.0
    rayleigh = 9.80665 * abs(wall_k - ambient_k) / film * diameter_m**3 * prandtl / kinematic**2
    nusselt = (0.6 + 0.387 * rayleigh ** (1 / 6) / (1 + (0.559 / prandtl) ** (9 / 16)) ** (8 / 27)) ** 2
    return nusselt * conductivity / diameter_m


def class_edges(classes: int, p: Mapping[str, float]) -> Array:
    """Return the edges of classes of equal share, (n_classes + 1,), in units of the spread.

    An offset is z (z^2 + 0.3^2)^(tail/2), z a normal quantile, times 1 + skew above and 1 - skew below the middle.
    Early grains lie evenly over their width below the quantile that their fraction is. The outermost classes are as
    wide outwards of their middle quantile as inwards.
    """
    early, skew = p["early_fraction"], p["grain_skew"]
    share = np.concatenate(([0.5], np.arange(1, classes), [classes - 0.5])) / classes
    z = norm.ppf(np.maximum(share, early))
    edges = np.where(z > 0, 1 + skew, 1 - skew) * z * (z**2 + 0.3**2) ** (p["grain_tail"] / 2)
    if early > 0:
        edges -= p["early_width"] * np.maximum(1 - share / early, 0)
    edges[0], edges[-1] = 2 * edges[0] - edges[1], 2 * edges[-1] - edges[-2]
    return edges


def share_due(excess_k: Array) -> Array:
    """Return which share of each class is beyond its barrier, from the excess at the edges of the classes."""
    low, high = excess_k[:-1], excess_k[1:]
    return np.clip(np.maximum(low, high) / np.abs(high - low), 0.0, 1.0)


class PlainWire:
    """A settled wire on the paper's bench, held together by nothing but its equations."""

    def __init__(self, alloy: Alloy, wire: Wire, bench: Bench, classes: int = 640) -> None:
        self.p = p = {**alloy.values(), **wire.values(), **bench.values()}
        self.edges = class_edges(classes, p)
        self.area_m2 = math.pi / 4 * p["diameter_m"] ** 2
        self.section_m2 = p["legs"] * self.area_m2
        self.leg_m = p["wire_length_m"] / p["legs"]
        mass = self.area_m2 * p["wire_length_m"] * p["density_kg_per_m3"]
        self.capacity_j_per_k = mass * p["specific_heat_j_per_kg_k"]
        self.latent_j = mass * p["latent_heat_j_per_kg"]
        self.start_stress_pa = p["pretension_n"] / self.section_m2
        # Cooled from hot: all drives have only ever risen, so where they stand now says it all.
        all_austenite = Memory(np.zeros(self.edges.size - 1), np.zeros(self.edges.size - 1), 0.0, 0.0)
        cold = self.shares(all_austenite, p["ambient_temperature_k"], self.start_stress_pa)
        self.cold_strain = 0.0
        self.cold_strain = sum(self.strains(p["ambient_temperature_k"], self.start_stress_pa, *self.fractions(*cold)))
        self.start = Memory(*cold, 0.0, 0.0)

    def shares(self, memory: Memory, temperature_k: float, stress_pa: float) -> tuple[Array, Array]:
        """Return martensite, and martensite with R-phase, of each class at a temperature and a stress."""
        p, r = self.p, self.p["r_phase_entropy_ratio"]
        spread_m = p["martensite_spread_k"] + p["martensite_spread_per_pa"] * stress_pa
        middle_m = p["martensite_temperature_k"] + p["temperature_shift_k"]
        middle_r = p["r_phase_temperature_k"] + p["temperature_shift_k"] + p["r_phase_shift_k"]
        f_m = middle_m + stress_pa / p["martensite_stress_rate_pa_per_k"] - temperature_k + spread_m * self.edges
        f_r = r * (
            middle_r
            + stress_pa / p["r_phase_stress_rate_pa_per_k"]
            - temperature_k
            + p["r_phase_spread_k"] * self.edges
        )
        barrier = p["martensite_barrier_k"] + p["martensite_barrier_shift_k"]
        h_m = max(barrier + p["martensite_barrier_per_pa"] * stress_pa, 0.0)
        h_r = p["r_phase_barrier_k"]
        h_rm = min(p["r_to_m_barrier_k"], h_m + h_r)
        left_austenite = np.maximum(share_due(f_m - h_m), share_due(f_r - h_r))
        formed = np.maximum(memory.formed, left_austenite)
        martensite = np.maximum(memory.martensite, np.minimum(share_due(f_m - f_r - h_rm), formed))
        left_martensite = np.maximum(share_due(-f_m - h_m), share_due(f_r - f_m - h_rm))
        martensite = np.minimum(martensite, 1 - left_martensite)
        return martensite, np.minimum(formed, np.maximum(martensite, 1 - share_due(-f_r - h_r)))

    @staticmethod
    def fractions(martensite: Array, formed: Array) -> tuple[float, float]:
        """Return the fractions of martensite and R-phase."""
        x_m = float(martensite.mean())
        return x_m, float(formed.mean()) - x_m

    def strains(self, temperature_k: float, stress_pa: float, x_m: float, x_r: float) -> tuple[float, float, float]:
        """Return transformation, elastic and thermal strain."""
        p = self.p
        h_0, h_sat = p["strain_at_no_stress"], p["strain_saturated"]
        h = h_0 + (h_sat - h_0) * (1 - math.exp(-stress_pa / p["strain_stress_scale_pa"]))
        compliance = (1 - x_m) / p["austenite_modulus_pa"] + x_m / p["martensite_modulus_pa"]
        expansion = (1 - x_m) * p["austenite_expansion_per_k"] + x_m * p["martensite_expansion_per_k"]
        return h * x_m + p["r_phase_strain"] * x_r, stress_pa * compliance, expansion * (temperature_k - TWENTY_DEGC_K)

    def load(self, memory: Memory, contraction: float) -> tuple[float, float]:
        """Return the force that spring and guide put on the wire, and the guide's part (Dahl, exponent 0)."""
        limit, friction = self.p["guide_friction_n"], 0.0
        if limit > 0:
            moved = (contraction - memory.contraction) * self.leg_m
            friction = min(max(memory.friction_n + limit / self.p["guide_presliding_m"] * moved, -limit), limit)
        spring = self.p["pretension_n"] + self.p["spring_stiffness_n_per_m"] * contraction * self.leg_m
        return spring + friction, friction

    def contraction(self, memory: Memory, temperature_k: float, stress_pa: float) -> float:
        """Return by how much the wire is shorter than cold under pretension."""
        strains = self.strains(
            temperature_k, stress_pa, *self.fractions(*self.shares(memory, temperature_k, stress_pa))
        )
        return (self.cold_strain - sum(strains)) / (1 + self.cold_strain)

    def stress_at(self, memory: Memory, temperature_k: float, guess_pa: float) -> float:
        """Return the stress at which wire and spring agree."""

        def missing_pa(stress_pa: float) -> float:
            contraction = self.contraction(memory, temperature_k, stress_pa)
            return stress_pa - self.load(memory, contraction)[0] / self.section_m2

        return root(missing_pa, guess_pa, 1.0)

    def moment(self, memory: Memory, enthalpy_j: float, guess: Sequence[float]) -> Moment:
        """Return the wire at an enthalpy, coming from what it remembers; ``guess`` is a temperature and a stress."""

        def missing_k(temperature_k: float) -> float:
            stress_pa = self.stress_at(memory, temperature_k, guess[1])
            x_m, x_r = self.fractions(*self.shares(memory, temperature_k, stress_pa))
            latent = self.latent_j * (x_m + self.p["r_phase_entropy_ratio"] * x_r)
            return temperature_k - TWENTY_DEGC_K - (enthalpy_j + latent) / self.capacity_j_per_k

        temperature_k = root(missing_k, guess[0], 1e-7)
        stress_pa = self.stress_at(memory, temperature_k, guess[1])
        shares = self.shares(memory, temperature_k, stress_pa)
        strains = self.strains(temperature_k, stress_pa, *self.fractions(*shares))
        contraction = (self.cold_strain - sum(strains)) / (1 + self.cold_strain)
        force, friction = self.load(memory, contraction)
        resistance = self.resistance_ohm(temperature_k, strains, *self.fractions(*shares))
        return Moment(temperature_k, stress_pa, contraction, resistance, force, Memory(*shares, contraction, friction))

    def resistance_ohm(
        self, temperature_k: float, strains: tuple[float, float, float], x_m: float, x_r: float
    ) -> float:
        """Return rho l / A: phases mixed by volume, the section thinned by each strain in its own way."""
        rho = self.p["resistivity_factor"] * sum(
            share
            * self.p[f"{phase}_resistivity_ohm_m"]
            * (1 + self.p[f"{phase}_resistivity_per_k"] * (temperature_k - TWENTY_DEGC_K))
            for phase, share in (("austenite", 1 - x_m - x_r), ("r_phase", x_r), ("martensite", x_m))
        )
        transformation, elastic, thermal = strains
        length = self.p["wire_length_m"] / (1 + self.cold_strain)
        shape = (1 + transformation) ** 2 * (1 + elastic) / (1 - 0.33 * elastic) ** 2 / (1 + thermal)
        return rho * length / self.area_m2 * shape

    def heating_w(self, moment: Moment, drive_v: float) -> float:
        """Return Joule heat less convection."""
        p = self.p
        series = p["shunt_resistance_ohm"] + p["lead_resistance_ohm"]
        joule = (drive_v / (moment.resistance_ohm + series)) ** 2 * moment.resistance_ohm
        h = p["convection_factor"] * churchill_chu_w_per_m2_k(
            moment.temperature_k, p["ambient_temperature_k"], p["diameter_m"]
        )
        surface = math.pi * p["diameter_m"] * p["wire_length_m"]
        return joule - h * surface * (moment.temperature_k - p["ambient_temperature_k"])

    def run(self, drive_v: Callable[[float], float], times_s: Array) -> Array:
        """Return temperature, stress, contraction, resistance and force after each of ``times_s``, (n_times, 5).

        Starts cold at time 0. What the grains and the guide remember is brought up to date at each of the times. Within
        a stretch in one direction that changes nothing; a turning point between two times is forgotten, so they must
        stand close where the wire turns.
        """
        x_m, x_r = self.fractions(self.start.martensite, self.start.formed)
        ambient = self.p["ambient_temperature_k"]
        enthalpy = self.capacity_j_per_k * (ambient - TWENTY_DEGC_K) - self.latent_j * (
            x_m + self.p["r_phase_entropy_ratio"] * x_r
        )
        now = self.moment(self.start, enthalpy, (ambient, self.start_stress_pa))
        found, before_s, step_s = [], 0.0, 1e-3
        for time_s in times_s:
            memory, guess = now.memory, [now.temperature_k, now.stress_pa]

            def slope(at_s: float, y: Array, memory: Memory = memory, guess: list[float] = guess) -> list[float]:
                moment = self.moment(memory, float(y[0]), guess)
                guess[:] = moment[:2]
                return [self.heating_w(moment, drive_v(at_s))]

            solved = solve_ivp(
                slope,
                (before_s, time_s),
                [enthalpy],
                rtol=1e-6,
                atol=1e-6 * self.capacity_j_per_k,
                first_step=min(step_s, time_s - before_s),
            )
            step_s = max(float(np.diff(solved.t).max()), 1e-5)
            enthalpy, before_s = float(solved.y[0, -1]), float(time_s)
            now = self.moment(memory, enthalpy, guess)
            found.append(now[:5])
        return np.array(found)


def root(function: Callable[[float], float], guess: float, tolerance: float) -> float:
    """Return the root of a function that rises by at least 1 for each 1, which is how far the root can be away."""
    at_guess = function(guess)
    if at_guess == 0.0:
        return guess
    far = guess - 1.000001 * at_guess - math.copysign(tolerance, at_guess)
    return float(brentq(function, guess, far, xtol=tolerance, rtol=1e-14))
