"""A parameter, and the groups of parameters that describe an alloy, a wire and a bench.

A parameter file states each number with its SI unit, its source and its kind. A value without a source is an
error, and so is an unknown key: a typo must not become a silent default.
"""

from __future__ import annotations

from math import ceil, floor
from typing import Annotated, Any, Literal, Protocol, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic.fields import FieldInfo

LARGEST = 1e15
Kind = Literal["measured", "datasheet", "fitted", "derived", "assumed"]


class Parameter(BaseModel):
    """One number: value, SI unit, source, and the kind of knowledge it is.

    Parameters
    ----------
    value
        The number, finite, in ``unit``: at most 1e15, which is beyond every constant of a material.
    unit
        SI, as "ohm/m"; "1" for a fraction.
    kind
        "measured", "datasheet", "fitted", "derived" or "assumed".
    source
        Its source, in words.
    note
        Remarks.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    value: float = Field(allow_inf_nan=False, ge=-LARGEST, le=LARGEST)
    unit: str
    kind: Kind
    source: str = Field(min_length=3)
    note: str = ""


Range = Literal["positive", "not negative", "any", "whole", "fraction"]


def parameter(unit: str, description: str, allowed: Range = "positive", *, absent: Parameter | None = None) -> Any:
    """Return the field of a parameter: unit and range; ``absent`` holds for a file without it."""
    extra: dict[str, Any] = {"unit": unit, "allowed": allowed}
    if absent is None:
        return Field(description=description, json_schema_extra=extra)
    return Field(default=absent, description=description, json_schema_extra=extra)


def checked(key: str, item: Parameter, field: FieldInfo) -> None:
    """Raise ValueError if a parameter has another unit than its field declares, or is outside its range."""
    declared = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
    if item.unit != declared["unit"]:
        raise ValueError(f"{key} has the unit '{item.unit}', it must be given in '{declared['unit']}'")
    if declared["allowed"] == "positive" and item.value <= 0.0:
        raise ValueError(f"{key} is {item.value:g} {item.unit}, it must be above 0")
    if declared["allowed"] == "not negative" and item.value < 0.0:
        raise ValueError(f"{key} is {item.value:g} {item.unit}, it must be 0 or more")
    if declared["allowed"] == "fraction" and not 0.0 <= item.value < 1.0:
        raise ValueError(f"{key} is {item.value:g}, it must be 0 or more and below 1")
    if declared["allowed"] == "whole" and (item.value < 1.0 or item.value % 1.0):
        around = sorted({max(floor(item.value), 1), max(ceil(item.value), 1)})
        near = " or ".join(f"{number:g}" for number in around)
        raise ValueError(f"{key} is {item.value:g}, it must be a whole number of 1 or more, as {near}")


class Numbers(Protocol):
    """Numbers by name, in SI: a plain mapping, or a group of parameters."""

    def __getitem__(self, name: str, /) -> float:
        """Return a number."""


class ParameterGroup(BaseModel):
    """A named set of parameters read from one TOML file; every field but the texts is a Parameter."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str = Field(description="name by which it is loaded")
    description: str = Field(description="description for people")

    @model_validator(mode="after")
    def _units_and_ranges_are_as_declared(self) -> ParameterGroup:
        for key, item in self.items():
            checked(key, item, type(self).model_fields[key])
        return self

    def __getitem__(self, name: str) -> float:
        """Return the bare number of a parameter."""
        number: float = getattr(self, name).value
        return number

    def values(self) -> dict[str, float]:
        """Return the bare numbers, by name."""
        return {key: item.value for key, item in self.items()}

    def with_values(self, **values: float) -> Self:
        """Return the group with other numbers, of which unit, kind and source stay."""
        changed = {key: getattr(self, key).model_copy(update={"value": value}) for key, value in values.items()}
        return self.model_copy(update=changed)

    def items(self) -> list[tuple[str, Parameter]]:
        """Return all parameters in the order of the schema."""
        pairs = ((key, getattr(self, key)) for key in type(self).model_fields)
        return [(key, item) for key, item in pairs if isinstance(item, Parameter)]


Finite = Annotated[float, Field(allow_inf_nan=False)]


class GrainQuantiles(BaseModel):
    """Measured quantiles of the grains, in place of the family of distributions.

    Parameters
    ----------
    fraction
        Fractions of the grains, ascending from 0 to 1, first those that transform first on heating; two or more.
    offset
        Offset below which each fraction lies, in units of the spread, ascending; as many.
    kind
        "measured", "datasheet", "fitted", "derived" or "assumed".
    source
        Their source, in words.
    note
        Remarks.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    fraction: tuple[Finite, ...] = Field(min_length=2)
    offset: tuple[Finite, ...] = Field(min_length=2)
    kind: Kind
    source: str = Field(min_length=3)
    note: str = ""

    @model_validator(mode="after")
    def _they_are_a_distribution(self) -> GrainQuantiles:
        if len(self.fraction) != len(self.offset):
            raise ValueError(
                f"fraction has {len(self.fraction)} numbers and offset {len(self.offset)}: give one for each fraction"
            )
        if self.fraction[0] != 0.0 or self.fraction[-1] != 1.0:
            raise ValueError(
                f"fraction goes from {self.fraction[0]:g} to {self.fraction[-1]:g}: let it begin with 0 and end with 1"
            )
        for key in ("fraction", "offset"):
            values = getattr(self, key)
            place = next((place for place in range(1, len(values)) if values[place] <= values[place - 1]), None)
            if place is not None:
                raise ValueError(
                    f"{key} must ascend, and {values[place]:g} comes after {values[place - 1]:g}: sort the table by "
                    "fraction and leave out points with the same value"
                )
        return self


class CoveredRange(BaseModel):
    """A range that an alloy's data cover, in SI, with the data as its source."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    low: Finite
    high: Finite
    unit: str
    kind: Kind
    source: str = Field(min_length=3)
    note: str = ""

    @model_validator(mode="after")
    def _low_is_below_high(self) -> CoveredRange:
        if not 0.0 <= self.low < self.high:
            raise ValueError(f"low is {self.low:g} and high {self.high:g}: low must be 0 or more, and below high")
        return self


class Validity(BaseModel):
    """The stresses and temperatures that an alloy's data cover, the vendor's stress, and where annealing begins.

    Parameters
    ----------
    stress
        Stress in the wire [Pa] of the data that the alloy was fitted to.
    temperature
        Temperature of the wire [K] in these data.
    working_stress
        Largest stress of a heated wire [Pa] that the vendor names for many cycles.
    annealing_temperature
        Temperature of the wire [K] above which it must not be heated, as it costs memory.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    stress: CoveredRange
    temperature: CoveredRange
    working_stress: Parameter
    annealing_temperature: Parameter

    @model_validator(mode="after")
    def _units_are_si(self) -> Validity:
        units = {"stress": "Pa", "temperature": "K", "working_stress": "Pa", "annealing_temperature": "K"}
        for key, unit in units.items():
            if getattr(self, key).unit != unit:
                raise ValueError(f"{key} has the unit '{getattr(self, key).unit}', it must be given in '{unit}'")
        if self.annealing_temperature.value < self.temperature.low or self.working_stress.value <= 0.0:
            raise ValueError(
                f"annealing_temperature ({self.annealing_temperature.value:g} K) must be above the temperatures "
                f"covered, working_stress ({self.working_stress.value:g} Pa) above 0"
            )
        return self


ONE_POPULATION = "no early grains, one population: what a file without this key means"
NO_EARLY_GRAINS = Parameter(value=0.0, unit="1", kind="assumed", source=ONE_POPULATION)
ANY_EARLY_WIDTH = Parameter(value=1.0, unit="1", kind="assumed", source=ONE_POPULATION)


class Alloy(ParameterGroup):
    """The metal, independent of the wire's size. Symbols as in docs/reference/symbols.md."""

    martensite_temperature_k: Parameter = parameter("K", "T_M0: austenite and martensite in balance, no stress")
    martensite_stress_rate_pa_per_k: Parameter = parameter("Pa/K", "C_M: Clausius-Clapeyron slope of martensite")
    martensite_barrier_k: Parameter = parameter(
        "K", "h_M: half the hysteresis between austenite and martensite", "not negative"
    )
    martensite_barrier_per_pa: Parameter = parameter("K/Pa", "change of h_M with stress", "any")
    martensite_spread_k: Parameter = parameter("K", "w_M: spread of T_M0 over the grains", "not negative")
    martensite_spread_per_pa: Parameter = parameter("K/Pa", "growth of w_M with stress", "not negative")
    grain_skew: Parameter = parameter("1", "stretch of the upper against the lower half of the spread", "any")
    grain_tail: Parameter = parameter("1", "power of the tails: 0 is a normal distribution", "not negative")
    early_fraction: Parameter = parameter(
        "1", "fraction of the grains spread evenly below all others", "fraction", absent=NO_EARLY_GRAINS
    )
    early_width: Parameter = parameter("1", "width of that fraction, in spreads", absent=ANY_EARLY_WIDTH)
    grain_quantiles: GrainQuantiles | None = Field(
        default=None, description="measured quantiles of the grains, in place of skew, tail and early grains"
    )
    validity: Validity | None = Field(
        default=None, description="stresses and temperatures that the alloy's data cover, and the vendor's limits"
    )
    r_phase_temperature_k: Parameter = parameter("K", "T_R0: austenite and R-phase in balance, no stress")
    r_phase_stress_rate_pa_per_k: Parameter = parameter("Pa/K", "C_R: Clausius-Clapeyron slope of the R-phase")
    r_phase_spread_k: Parameter = parameter("K", "w_R: spread of T_R0 over the grains", "not negative")
    r_phase_entropy_ratio: Parameter = parameter("1", "r: entropy of A to R over that of A to M", "not negative")
    r_phase_barrier_k: Parameter = parameter("K", "h_R: barrier between austenite and R-phase", "not negative")
    r_to_m_barrier_k: Parameter = parameter("K", "h_RM: barrier between R-phase and martensite", "not negative")
    strain_at_no_stress: Parameter = parameter(
        "1", "H_0: transformation strain of martensite at no stress", "not negative"
    )
    strain_saturated: Parameter = parameter("1", "H_sat: transformation strain at high stress")
    strain_stress_scale_pa: Parameter = parameter("Pa", "sigma_k: stress over which H saturates")
    r_phase_strain: Parameter = parameter("1", "H_R: strain of the R-phase", "not negative")
    austenite_modulus_pa: Parameter = parameter("Pa", "E_A")
    martensite_modulus_pa: Parameter = parameter("Pa", "E_M")
    austenite_expansion_per_k: Parameter = parameter("1/K", "thermal expansion of austenite", "any")
    martensite_expansion_per_k: Parameter = parameter("1/K", "thermal expansion of martensite", "any")
    austenite_resistivity_ohm_m: Parameter = parameter("ohm m", "rho_A at 20 C")
    austenite_resistivity_per_k: Parameter = parameter("1/K", "temperature coefficient of rho_A", "any")
    r_phase_resistivity_ohm_m: Parameter = parameter("ohm m", "rho_R at 20 C")
    r_phase_resistivity_per_k: Parameter = parameter("1/K", "temperature coefficient of rho_R", "any")
    martensite_resistivity_ohm_m: Parameter = parameter("ohm m", "rho_M at 20 C, oriented martensite")
    martensite_resistivity_per_k: Parameter = parameter("1/K", "temperature coefficient of rho_M", "any")
    specific_heat_j_per_kg_k: Parameter = parameter("J/(kg K)", "c")
    density_kg_per_m3: Parameter = parameter("kg/m^3", "density")
    latent_heat_j_per_kg: Parameter = parameter(
        "J/kg", "heat of the transformation austenite to martensite", "not negative"
    )
    shakedown_cycles: Parameter = parameter("1", "cycles over which a new wire settles")
    shakedown_strain: Parameter = parameter("1", "lasting strain a new wire gains", "not negative")
    shakedown_resistivity: Parameter = parameter("1", "excess of rho_M in a new wire, relative", "any")
    shakedown_barrier: Parameter = parameter("1", "excess of h_M in a new wire, relative", "not negative")


class Wire(ParameterGroup):
    """One wire off one spool: an alloy drawn to a diameter."""

    alloy: str = Field(description="name of the alloy")
    diameter_m: Parameter = parameter("m", "diameter")
    resistance_per_metre_ohm_per_m: Parameter = parameter("ohm/m", "as sold, martensite, room temperature")
    resistivity_factor: Parameter = parameter("1", "this spool's resistivity over the alloy's")
    temperature_shift_k: Parameter = parameter("K", "this spool's transformation temperatures over the alloy's", "any")
    r_phase_shift_k: Parameter = parameter(
        "K", "this spool's R-phase temperature over the alloy's, on top of temperature_shift_k", "any"
    )
    martensite_barrier_shift_k: Parameter = parameter(
        "K", "half width of this spool's hysteresis between austenite and martensite over the alloy's", "any"
    )
    maximum_force_n: Parameter = parameter("N", "largest force allowed, one leg pair as the paper's Table 1 has it")
    nominal_force_n: Parameter = parameter("N", "force that stretches the cold wire")
    convection_factor: Parameter = parameter("1", "measured or fitted convection over Churchill and Chu's")
    drive_amplitude_v: Parameter = parameter("V", "amplitude of the slow sine that completes the transformation")
    maximum_voltage_v: Parameter = parameter("V", "highest drive voltage allowed")


class Bench(ParameterGroup):
    """The test bench around a wire: mechanics, circuit, acquisition, reference instruments."""

    wire_length_m: Parameter = parameter("m", "overall length of the V-shaped wire")
    legs: Parameter = parameter("1", "wires in parallel that share the force: 2 for a V", "whole")
    spring_stiffness_n_per_m: Parameter = parameter("N/m", "bias spring", "not negative")
    pretension_n: Parameter = parameter("N", "F_p, both legs together, set by the linear stage", "not negative")
    guide_friction_n: Parameter = parameter("N", "Coulomb friction of the guide", "not negative")
    guide_presliding_m: Parameter = parameter("m", "elastic travel before the guide slides")
    sense_voltage_v: Parameter = parameter("V", "lowest drive voltage, so that resistance stays measurable")
    shunt_resistance_ohm: Parameter = parameter("ohm", "R of Eq. 1")
    lead_resistance_ohm: Parameter = parameter("ohm", "leads and clamps outside the measured voltages", "not negative")
    amplifier_resolution_v: Parameter = parameter("V", "step of the output converter behind the buffer amplifier")
    acquisition_range_v: Parameter = parameter("V", "half of the input range")
    acquisition_bits: Parameter = parameter("1", "resolution of the input converter", "whole")
    acquisition_noise_v: Parameter = parameter("V", "input noise, rms per reading", "not negative")
    acquisition_readings: Parameter = parameter("1", "readings averaged into one sample", "whole")
    sample_period_s: Parameter = parameter("s", "time between samples")
    displacement_noise_m: Parameter = parameter("m", "LVDT noise, rms per sample", "not negative")
    force_noise_n: Parameter = parameter("N", "load cell noise, rms per sample", "not negative")
    endpoint_noise_m: Parameter = parameter(
        "m", "noise of the laser on a finger's endpoint, rms per sample", "not negative"
    )
    endpoint_force_noise_n: Parameter = parameter(
        "N", "noise of the load cell under an object that a finger touches, rms per sample", "not negative"
    )
    ambient_temperature_k: Parameter = parameter("K", "temperature of the still air around the wire")
    time_step_s: Parameter = parameter(
        "s", "fixed step of the simulation; 0: as long as the tolerances allow", "not negative"
    )
    temperature_tolerance_k: Parameter = parameter("K", "error of a step in temperature that is accepted")
    resistance_tolerance: Parameter = parameter("1", "error of a step in resistance, as a fraction of it")
    strain_tolerance: Parameter = parameter("1", "error of a step in strain")
