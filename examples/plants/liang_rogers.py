"""A wire of another family than musclewire's own simulator: one fraction of martensite with cosine kinetics.

A plant of one's own, opened by ``kind = "python:liang_rogers:LiangRogersWire"`` in a rig file (``liang_rogers.toml``
next to this file). There is one kind of martensite, no R-phase and no grains: martensite grows and shrinks along
cosines of temperature that stress shifts (Liang and Rogers 1990, doi 10.1177/1045389X9000100205). After a turn a branch
goes on as a scaled copy from where the wire is, so that small cycles drift instead of closing. The modulus is a mixture
of both phases' (Brinson 1993, doi 10.1177/1045389X9300400213). Resistance is that of layers of both phases in series,
each with its length and cross section.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
from numba import njit
from pydantic import Field

from musclewire import (
    SWITCHED_OFF,
    Conditions,
    DeviceConfiguration,
    DeviceFacts,
    InstrumentSettings,
    MountedWire,
    NumericsError,
    RawSample,
    RunningInstruments,
    air_thermal_conductivity_w_per_m_k,
    drive_voltage_of,
    measured_in,
    nusselt_morgan,
    rayleigh_of_wire,
    steady,
)

ZERO_C = 273.15
STEP_S = 2.5e-3


class Material(NamedTuple):
    """Numbers of the wire; fields in the order in which the compiled functions take them."""

    # Start and end of both changes without stress: the vendor's for 70 C wire (Flexinol slides, University of Bologna).
    austenite_start_k: float = ZERO_C + 68.0
    austenite_end_k: float = ZERO_C + 78.0
    martensite_start_k: float = ZERO_C + 52.0
    martensite_end_k: float = ZERO_C + 42.0
    # Rates of stress and moduli: Brinson 1993, from Dye 1990.
    austenite_rate_pa_per_k: float = 13.8e6
    martensite_rate_pa_per_k: float = 8.0e6
    austenite_modulus_pa: float = 67.0e9
    martensite_modulus_pa: float = 26.3e9
    # Assumed: the stroke of a trained actuator wire, below the 6.7 % of Brinson's wire.
    transformation_strain: float = 0.042
    # Density: the vendor's. Specific heat and latent heat: the vendor's 0.2 cal/(g C) and 5.78 cal/g.
    density_kg_per_m3: float = 6450.0
    specific_heat_j_per_kg_k: float = 837.0
    latent_heat_j_per_kg: float = 24.2e3
    # Assumed: martensite as the wire is sold; austenite a tenth lower, which its shape then lowers to a sixth.
    martensite_resistivity_ohm_m: float = 9.6e-7
    austenite_resistivity_ohm_m: float = 8.6e-7
    # Temperature coefficients: the order of those published for such wire, 2e-4 and 3e-4 1/K.
    martensite_resistivity_per_k: float = 3e-4
    austenite_resistivity_per_k: float = 2e-4


class Body(NamedTuple):
    """A wire of this material and what it pulls, in SI; ``force_n`` is that at the zero of the connector."""

    leg_length_m: float
    section_m2: float
    capacity_j_per_k: float
    latent_j: float
    cold_strain: float
    force_n: float
    spring_n_per_m: float


class Point(NamedTuple):
    """Temperature [K], stress [Pa], fraction of martensite, and the shift of all changes when it was reached [K]."""

    temperature_k: float
    stress_pa: float
    martensite: float
    shift_k: float = 0.0


@njit(cache=True)
def grown(effective_k, material):
    """Return the part of austenite that is left at a temperature on cooling, 1 at the start of martensite."""
    span_k = material.martensite_start_k - material.martensite_end_k
    inside = min(max((effective_k - material.martensite_end_k) / span_k, 0.0), 1.0)
    return 0.5 * (1.0 - math.cos(math.pi * inside))


@njit(cache=True)
def shrunk(effective_k, material):
    """Return the part of martensite that is left at a temperature on heating, 1 at the start of austenite."""
    span_k = material.austenite_end_k - material.austenite_start_k
    inside = min(max((effective_k - material.austenite_start_k) / span_k, 0.0), 1.0)
    return 0.5 * (1.0 + math.cos(math.pi * inside))


@njit(cache=True)
def martensite_after(before, temperature_k, stress_pa, shift_k, material):
    """Return the fraction of martensite after a temperature and a stress: each cosine begins at the one before."""
    m = material
    fraction = before.martensite
    old_k = before.temperature_k - before.stress_pa / m.austenite_rate_pa_per_k - before.shift_k
    new_k = temperature_k - stress_pa / m.austenite_rate_pa_per_k - shift_k
    left = shrunk(old_k, m)
    if new_k > old_k and fraction > 0.0:
        fraction = fraction * shrunk(new_k, m) / left if left > 0.0 else 0.0
    old_k = before.temperature_k - before.stress_pa / m.martensite_rate_pa_per_k - before.shift_k
    new_k = temperature_k - stress_pa / m.martensite_rate_pa_per_k - shift_k
    left = grown(old_k, m)
    if new_k < old_k and fraction < 1.0:
        fraction = 1.0 - (1.0 - fraction) * grown(new_k, m) / left if left > 0.0 else 1.0
    return fraction


@njit(cache=True)
def strain_of(stress_pa, martensite, material):
    """Return the strain of the wire: elastic by the mixed modulus, and of the transformation."""
    m = material
    modulus_pa = m.austenite_modulus_pa + martensite * (m.martensite_modulus_pa - m.austenite_modulus_pa)
    return stress_pa / modulus_pa + m.transformation_strain * martensite


@njit(cache=True)
def excess_pa(before, temperature_k, stress_pa, shift_k, body, material):
    """Return a stress less that of the load at the strain it means [Pa]; rises with the stress."""
    martensite = martensite_after(before, temperature_k, stress_pa, shift_k, material)
    displacement_m = (body.cold_strain - strain_of(stress_pa, martensite, material)) * body.leg_length_m
    return stress_pa - (body.force_n + body.spring_n_per_m * displacement_m) / body.section_m2


@njit(cache=True)
def stress_at(before, temperature_k, shift_k, body, material):
    """Return the stress in balance with the load at a temperature [Pa], 0 for a slack wire, by false position."""
    if excess_pa(before, temperature_k, 0.0, shift_k, body, material) >= 0.0:
        return 0.0
    low_pa = max(before.stress_pa - 2e6, 0.0)
    high_pa = before.stress_pa + 2e6
    low = excess_pa(before, temperature_k, low_pa, shift_k, body, material)
    high = excess_pa(before, temperature_k, high_pa, shift_k, body, material)
    while low > 0.0:
        low_pa = max(low_pa - 50e6, 0.0)
        low = excess_pa(before, temperature_k, low_pa, shift_k, body, material)
    while high < 0.0:
        high_pa += 50e6
        high = excess_pa(before, temperature_k, high_pa, shift_k, body, material)
    stress_pa = before.stress_pa
    for _ in range(100):
        stress_pa = low_pa + (high_pa - low_pa) * low / (low - high) if high > low else low_pa
        found = excess_pa(before, temperature_k, stress_pa, shift_k, body, material)
        if abs(found) < 1.0 or high_pa - low_pa < 1e-3:
            break
        if found > 0.0:
            high_pa, high, low = stress_pa, found, 0.5 * low
        else:
            low_pa, low, high = stress_pa, found, 0.5 * high
    return stress_pa


@njit(cache=True)
def point_at(before, temperature_k, shift_k, body, material):
    """Return the wire at a temperature, in balance with its load."""
    stress_pa = stress_at(before, temperature_k, shift_k, body, material)
    martensite = martensite_after(before, temperature_k, stress_pa, shift_k, material)
    return Point(temperature_k, stress_pa, martensite, shift_k)


@njit(cache=True)
def heated(before, heat_j, shift_k, body, material):
    """Return the wire after a heat [J]: capacity and latent heat take it; false position in temperature."""
    start_k = before.temperature_k
    found = point_at(before, start_k, shift_k, body, material)  # a load that has jumped transforms the wire at once
    near_k, near_j = start_k, -body.latent_j * (found.martensite - before.martensite) - heat_j
    if abs(near_j) < 1e-9:
        return found
    far_k = near_k - near_j / body.capacity_j_per_k  # latent heat only brings the root nearer
    found = point_at(before, far_k, shift_k, body, material)
    far_j = body.capacity_j_per_k * (far_k - start_k) - body.latent_j * (found.martensite - before.martensite) - heat_j
    for _ in range(100):
        if abs(far_j) < 1e-9 or near_j == far_j:
            break
        guess_k = near_k + (far_k - near_k) * near_j / (near_j - far_j)
        found = point_at(before, guess_k, shift_k, body, material)
        taken_j = body.capacity_j_per_k * (guess_k - start_k)
        missing_j = taken_j - body.latent_j * (found.martensite - before.martensite) - heat_j
        if abs(missing_j) < 1e-9 or abs(far_k - near_k) < 1e-9:
            break
        if missing_j * far_j > 0.0:
            far_k, far_j, near_j = guess_k, missing_j, 0.5 * near_j
        else:
            near_k, near_j, far_j = guess_k, missing_j, 0.5 * far_j
    return found


@njit(cache=True)
def resistance_of(point, length_m, area_m2, material):
    """Return the resistance [ohm] of layers of both phases in series; transformation keeps the volume of each."""
    m = material
    warm_k = point.temperature_k - 293.15
    stretch = 1.0 + m.transformation_strain
    martensite = m.martensite_resistivity_ohm_m * (1.0 + m.martensite_resistivity_per_k * warm_k) * stretch**2
    austenite = m.austenite_resistivity_ohm_m * (1.0 + m.austenite_resistivity_per_k * warm_k)
    resistivity = martensite * point.martensite + austenite * (1.0 - point.martensite)
    elastic = strain_of(point.stress_pa, point.martensite, m) - m.transformation_strain * point.martensite
    return resistivity * length_m / area_m2 * (1.0 + 1.6 * elastic)  # 1 + 2 Poisson's ratio of 0.3


@njit(cache=True)
def delayed(late_w, power_w):
    """Return the power that arrives now, and send another on its way."""
    if late_w.size == 0:
        return power_w
    arriving_w = late_w[0]
    late_w[:-1] = late_w[1:]
    late_w[-1] = power_w
    return arriving_w


@njit(cache=True)
def advance(point, drive_v, outside_ohm, inside_ohm, air, steps, step_s, shift_k, sizes, body, late_w, material):
    """Return the wire after a sample, and means of wire voltage, current, displacement and stress over it.

    ``late_w`` is the power on its way to the wire, one number for each step of the dead time; it is changed in place.
    """
    length_m, area_m2, factor = sizes
    ambient_k, loss_w_per_k = air
    sums = np.zeros(4)
    for _ in range(steps):
        ohm = factor * resistance_of(point, length_m, area_m2, material)
        current_a = drive_v / (ohm + inside_ohm + outside_ohm)
        power_w = delayed(late_w, current_a**2 * ohm)
        heat_j = (power_w - loss_w_per_k * (point.temperature_k - ambient_k)) * step_s
        point = heated(point, heat_j, shift_k, body, material)
        ohm = factor * resistance_of(point, length_m, area_m2, material)
        current_a = drive_v / (ohm + inside_ohm + outside_ohm)
        strain = strain_of(point.stress_pa, point.martensite, material)
        sums += np.array(
            [
                current_a * (ohm + inside_ohm),
                current_a,
                (body.cold_strain - strain) * body.leg_length_m,
                point.stress_pa,
            ]
        )
    # Numbers, not the named tuple itself: on the way out Numba would call its class, and a signal that arrives then,
    # as Ctrl-C, ends in a crash.
    return (point.temperature_k, point.stress_pa, point.martensite, point.shift_k), sums / steps


class State(NamedTuple):
    """The true state, for judging a result."""

    time_s: float
    temperature_k: float
    resistance_ohm: float
    cycles: float
    strain: float
    mean_strain: float
    stress_pa: float
    martensite_fraction: float


class LiangRogersConfiguration(MountedWire, DeviceConfiguration):
    """Keys of wire and circuit as on every real rig, and what this plant adds.

    Parameters
    ----------
    spring_stiffness
        Stiffness of the bias spring [N/m].
    hysteresis
        Difference [K] between the middles of heating and cooling without stress; the material's own by default.
    dead_time
        Time [s] from electrical power to heat in the wire: stands for whatever delays motion and is not modelled.
    seed
        Seed of the instruments' noise.
    """

    spring_stiffness: Annotated[float, measured_in("N/m"), Field(ge=0.0)] = 588.6
    hysteresis: Annotated[float, measured_in("K"), Field(gt=0.0)] | None = None
    dead_time: Annotated[float, measured_in("s"), Field(ge=0.0)] = 0.0
    seed: int = Field(default=1, ge=0)


class LiangRogersWire:
    """The plant: a Device with a true state, and with conditions that may be replaced at any time."""

    configuration = LiangRogersConfiguration
    partner_state = None
    name = "liang_rogers"

    def __init__(self, configuration, conditions=None, instruments=None, material=Material()):  # noqa: B008
        """Cool the wire under its pretension; instruments like those of the simulated rig unless others are given."""
        of = self.of = configuration
        wire = of.known_wire()
        self.conditions = conditions or steady()
        if of.hysteresis is not None:
            material = self.with_hysteresis(material, of.hysteresis)
        self.material = material
        settings = instruments or InstrumentSettings(244e-6, 16, 10.0, 10.0)
        self.instruments = RunningInstruments(settings, of.seed, of.sample_period)
        self.diameter_m = wire.diameter_m.value
        self.area_m2 = 0.25 * math.pi * self.diameter_m**2
        self.pretension_n = 1.9 if of.pretension is None else of.pretension
        stress_pa = self.pretension_n / (of.legs * self.area_m2)
        mass_kg = material.density_kg_per_m3 * self.area_m2 * of.wire_length
        self.body = Body(
            leg_length_m=of.leg_length_m,
            section_m2=of.legs * self.area_m2,
            capacity_j_per_k=mass_kg * material.specific_heat_j_per_kg_k,
            latent_j=mass_kg * material.latent_heat_j_per_kg,
            cold_strain=self.cold_strain(stress_pa, material),
            force_n=self.pretension_n,
            spring_n_per_m=of.spring_stiffness,
        )
        self.point = Point(of.ambient_temperature, stress_pa, 1.0, 0.0)
        self.drive_voltage_v, self.samples, self.is_off = 0.0, 0, False
        self.true_time_s = self.cycles = self.mean_strain = 0.0
        self.late_w = np.zeros(round(of.dead_time / STEP_S))
        self.facts = DeviceFacts(
            sample_period_s=of.sample_period,
            paced=False,
            leg_length_m=of.leg_length_m,
            drive_amplitude_v=of.drive_amplitude,
            limits=of.protection_limits(
                wire_range_v=settings.wire_range_v,
                shunt_range_v=settings.shunt_range_v,
                readings_noisy=settings.readings_noisy,
            ),
            reference_columns=("displacement_m", "force_n"),
            wire_temperature_k=of.ambient_temperature,
        )

    def metadata(self):
        """Return what a recording should say of this plant."""
        return {
            "rig": self.name,
            **self.of.facts(),
            "pretension_n": self.pretension_n,
            "spring_stiffness_n_per_m": self.of.spring_stiffness,
            "dead_time_s": self.of.dead_time,
            "seed": self.of.seed,
        }

    def loss_w_per_k(self, ambient_k):
        """Return the loss to still air per kelvin [W/K]: Morgan 1975, doi 10.1016/S0065-2717(08)70075-3."""
        wall_k = max(self.point.temperature_k, ambient_k + 1.0)
        nusselt = nusselt_morgan(rayleigh_of_wire(wall_k, ambient_k, self.diameter_m))
        conductivity = air_thermal_conductivity_w_per_m_k(0.5 * (wall_k + ambient_k))
        return nusselt * conductivity * math.pi * self.of.wire_length

    def exchange(self, command):
        """Hold a drive voltage for a sample period under the conditions of its beginning; return the readings."""
        self.drive_voltage_v = drive_voltage_of(command)
        if self.is_off:
            self.drive_voltage_v = 0.0
            return SWITCHED_OFF
        of, now = self.of, self.conditions(self.samples * self.of.sample_period)
        ambient_k = of.ambient_temperature if now.ambient_k is None else now.ambient_k
        if not np.isfinite([ambient_k, float(np.mean(now.convection_factor)), *now[2:]]).all():
            raise NumericsError(f"at {self.true_time_s:.2f} s these conditions are no numbers: {now}")
        duration_s = self.instruments.duration_s()
        steps = math.ceil(duration_s / STEP_S * (1.0 - 1e-9))
        means = self.advanced(now, ambient_k, steps, duration_s / steps)
        self.samples += 1
        self.true_time_s += duration_s
        time_s = self.samples * of.sample_period
        return RawSample(time_s, self.drive_voltage_v, *self.instruments.sample(means))

    def advanced(self, now: Conditions, ambient_k, steps, step_s):
        """Advance the wire; return the true means of both voltages, displacement and force."""
        of = self.of
        body = self.body._replace(
            force_n=self.pretension_n + now.load_force_n + now.pretension_force_n,
            spring_n_per_m=of.spring_stiffness * now.stiffness_factor,
        )
        loss = self.loss_w_per_k(ambient_k) * float(np.mean(now.convection_factor))
        sizes = (of.wire_length, self.area_m2, now.resistance_factor)
        before = self.martensite
        wire_v, current_a, displacement_m, stress_pa = self.advanced_wire(
            steps, step_s, now.transformation_shift_k, (ambient_k, loss), sizes, body
        )
        self.cycles += 0.5 * abs(self.martensite - before)
        self.mean_strain = displacement_m / of.leg_length_m
        return wire_v, current_a * of.shunt, displacement_m, stress_pa * self.body.section_m2

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
        self.point = Point(*point)
        return means

    @property
    def martensite(self):
        """The fraction of martensite."""
        return self.point.martensite

    @staticmethod
    def with_hysteresis(material, hysteresis_k):
        """Return the material with its cooling below its heating by a hysteresis [K], between the branches' middles."""
        middle_k = 0.5 * (material.austenite_start_k + material.austenite_end_k)
        half_k = 0.5 * (material.martensite_start_k - material.martensite_end_k)
        below_k = middle_k - hysteresis_k
        return material._replace(martensite_start_k=below_k + half_k, martensite_end_k=below_k - half_k)

    @staticmethod
    def cold_strain(stress_pa, material):
        """Return the strain of the cold wire."""
        return strain_of(stress_pa, 1.0, material)

    @property
    def wire_state(self):
        """The true state of the wire."""
        strain = self.body.cold_strain - strain_of(self.point.stress_pa, self.point.martensite, self.material)
        ohm = resistance_of(self.point, self.of.wire_length, self.area_m2, self.material)
        return State(
            self.true_time_s,
            self.point.temperature_k,
            ohm,
            self.cycles,
            strain,
            self.mean_strain,
            self.point.stress_pa,
            self.point.martensite,
        )

    def sense(self):
        """Go to the sense voltage."""
        self.drive_voltage_v = self.of.sense_voltage
        return True

    def off(self):
        """Switch off for good."""
        self.is_off, self.drive_voltage_v = True, 0.0
        return True
