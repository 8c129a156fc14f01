"""A wire of a third family: hysteresis as a differential equation of Duhem's form, and phases side by side.

A plant of one's own, opened by ``kind = "python:duhem:DuhemWire"`` in a rig file (``duhem.toml`` next to this file).
Bench, circuit and instruments are those of ``liang_rogers`` next to it; the wire is another:

- The fraction of austenite a follows temperature by slopes that have no memory but a itself (Dutta and Ghorbel 2005,
  IEEE/ASME Transactions on Mechatronics 10): along the outer loop h+ (heating) and h- (cooling), both Gaussian
  distribution functions, da/dT = h+' (h- - a) / (h- - h+) on heating and h-' (a - h+) / (h- - h+) on cooling. Small
  cycles creep.
- Stress shifts both by one Clausius-Clapeyron slope.
- Both phases conduct side by side, so that conductivities are averaged, where ``liang_rogers`` puts them in series.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from liang_rogers import LiangRogersConfiguration, LiangRogersWire, State, delayed
from numba import njit

ZERO_C = 273.15


class DuhemMaterial(NamedTuple):
    """Numbers of the wire; fields in the order in which the compiled functions take them."""

    # Middle and spread of heating without stress: 70 C wire. Cooling lies below it by the rig file's hysteresis.
    heating_middle_k: float = ZERO_C + 70.0
    heating_spread_k: float = 4.0
    cooling_middle_k: float = ZERO_C + 50.0
    cooling_spread_k: float = 5.0
    # Assumed, these and what follows; the rate is near the 8 MPa/K of cooling in ``liang_rogers``.
    rate_pa_per_k: float = 7.5e6
    austenite_modulus_pa: float = 60.0e9
    martensite_modulus_pa: float = 28.0e9
    transformation_strain: float = 0.045
    density_kg_per_m3: float = 6450.0
    specific_heat_j_per_kg_k: float = 700.0
    latent_heat_j_per_kg: float = 20.0e3
    martensite_resistivity_ohm_m: float = 9.4e-7
    austenite_resistivity_ohm_m: float = 8.1e-7
    martensite_resistivity_per_k: float = 4e-4
    austenite_resistivity_per_k: float = 5e-4


class Phase(NamedTuple):
    """Temperature [K], stress [Pa], and the fraction of austenite."""

    temperature_k: float
    stress_pa: float
    austenite: float


@njit(cache=True)
def outer(effective_k, middle_k, spread_k):
    """Return a branch of the outer loop and its slope over temperature [1/K]."""
    away = (effective_k - middle_k) / spread_k
    slope = math.exp(-0.5 * away * away) / (spread_k * math.sqrt(2.0 * math.pi))
    return 0.5 * (1.0 + math.erf(away / math.sqrt(2.0))), slope


@njit(cache=True)
def slope_of(phase, warming, shift_k, material):
    """Return the change of the fraction of austenite with the effective temperature [1/K]."""
    m = material
    effective_k = phase.temperature_k - phase.stress_pa / m.rate_pa_per_k - shift_k
    heating, up = outer(effective_k, m.heating_middle_k, m.heating_spread_k)
    cooling, down = outer(effective_k, m.cooling_middle_k, m.cooling_spread_k)
    gap = cooling - heating
    if gap < 1e-9:
        return 0.0
    part = (cooling - phase.austenite) / gap if warming else (phase.austenite - heating) / gap
    return (up if warming else down) * min(max(part, 0.0), 1.0)


@njit(cache=True)
def modulus(austenite, material):
    """Return the modulus of the mixture [Pa]."""
    m = material
    return m.martensite_modulus_pa + austenite * (m.austenite_modulus_pa - m.martensite_modulus_pa)


@njit(cache=True)
def strain_at(phase, material):
    """Return the strain of the wire: elastic, and of the transformation."""
    return phase.stress_pa / modulus(phase.austenite, material) + material.transformation_strain * (
        1.0 - phase.austenite
    )


@njit(cache=True)
def resistance_at(phase, length_m, area_m2, material):
    """Return the resistance [ohm]: conductivities of both phases averaged, in a wire that keeps its volume."""
    m = material
    warm_k = phase.temperature_k - 293.15
    martensite = m.martensite_resistivity_ohm_m * (1.0 + m.martensite_resistivity_per_k * warm_k)
    austenite = m.austenite_resistivity_ohm_m * (1.0 + m.austenite_resistivity_per_k * warm_k)
    resistivity = 1.0 / (phase.austenite / austenite + (1.0 - phase.austenite) / martensite)
    return resistivity * length_m / area_m2 * (1.0 + strain_at(phase, material)) ** 2


@njit(cache=True)
def warmed(phase, heat_j, shift_k, body, material):
    """Return the wire after a small heat [J]: its capacity, its transformation and its load in one linear step.

    With da = k (dT - dF/c), a load that gives dF = q da, and heat = C dT + H da.
    """
    m = material
    elastic_pa = modulus(phase.austenite, m)
    stiffening = phase.stress_pa * (m.austenite_modulus_pa - m.martensite_modulus_pa) / elastic_pa**2
    stretch = m.transformation_strain + stiffening  # strain that is lost for one unit of austenite
    pull = body.spring_n_per_m * body.leg_length_m
    pa_per_austenite = pull * stretch / (body.section_m2 + pull / elastic_pa)
    slope = slope_of(phase, heat_j > 0.0, shift_k, m)
    slope /= 1.0 + slope * pa_per_austenite / m.rate_pa_per_k
    warmer_k = heat_j / (body.capacity_j_per_k + body.latent_j * slope)
    austenite = min(max(phase.austenite + slope * warmer_k, 0.0), 1.0)
    # The stress in balance with the load at this fraction, without the errors of many steps.
    by_austenite = material.transformation_strain * (1.0 - austenite)
    force_n = body.force_n + body.spring_n_per_m * body.leg_length_m * (body.cold_strain - by_austenite)
    stress_pa = max(force_n / (body.section_m2 + pull / modulus(austenite, m)), 0.0)
    return Phase(phase.temperature_k + warmer_k, stress_pa, austenite)


@njit(cache=True)
def advance(phase, drive_v, outside_ohm, inside_ohm, air, steps, step_s, shift_k, sizes, body, late_w, material):
    """Return the wire after a sample, and means of wire voltage, current, displacement and stress over it."""
    length_m, area_m2, factor = sizes
    ambient_k, loss_w_per_k = air
    sums = np.zeros(4)
    for _ in range(steps):
        ohm = factor * resistance_at(phase, length_m, area_m2, material)
        current_a = drive_v / (ohm + inside_ohm + outside_ohm)
        power_w = delayed(late_w, current_a**2 * ohm)
        heat_j = (power_w - loss_w_per_k * (phase.temperature_k - ambient_k)) * step_s
        phase = warmed(phase, heat_j, shift_k, body, material)
        contraction = body.cold_strain - strain_at(phase, material)
        sums += np.array([current_a * (ohm + inside_ohm), current_a, contraction * body.leg_length_m, phase.stress_pa])
    # Numbers, not the named tuple itself: on the way out Numba would call its class, and a signal that arrives then,
    # as Ctrl-C, ends in a crash.
    return (phase.temperature_k, phase.stress_pa, phase.austenite), sums / steps


class DuhemWire(LiangRogersWire):
    """The plant: the bench of ``liang_rogers`` with this wire on it."""

    configuration = LiangRogersConfiguration
    name = "duhem"

    def __init__(self, configuration, conditions=None, instruments=None, material=DuhemMaterial()):  # noqa: B008
        """Cool the wire under its pretension."""
        super().__init__(configuration, conditions, instruments, material)
        self.point = Phase(configuration.ambient_temperature, self.point.stress_pa, 0.0)

    @staticmethod
    def with_hysteresis(material, hysteresis_k):
        """Return the material with its cooling below its heating by a hysteresis [K], between the branches' middles."""
        return material._replace(cooling_middle_k=material.heating_middle_k - hysteresis_k)

    @staticmethod
    def cold_strain(stress_pa, material):
        """Return the strain of the cold wire."""
        return strain_at(Phase(293.15, stress_pa, 0.0), material)

    def advanced_wire(self, steps, step_s, shift_k, air, sizes, body):
        """Advance the wire; return the means of ``advance``."""
        point, means = advance(
            self.point,
            self.drive_voltage_v,
            self.of.shunt,
            self.instruments.lead_ohm(),
            air,
            steps,
            step_s,
            shift_k,
            sizes,
            body,
            self.late_w,
            self.material,
        )
        self.point = Phase(*point)
        return means

    @property
    def martensite(self):
        """The fraction of martensite."""
        return 1.0 - self.point.austenite

    @property
    def wire_state(self):
        """The true state of the wire."""
        ohm = resistance_at(self.point, self.of.wire_length, self.area_m2, self.material)
        strain = self.body.cold_strain - strain_at(self.point, self.material)
        return State(
            self.true_time_s,
            self.point.temperature_k,
            ohm,
            self.cycles,
            strain,
            self.mean_strain,
            self.point.stress_pa,
            self.martensite,
        )
