"""The variables of the FMU of a wire: inputs, outputs, numerics, and the parameters of wire, load and circuit."""

from __future__ import annotations

from collections.abc import Iterator

from musclewire.extras.interfaces._fmu.variables import FmuVariable, FmuVariables
from musclewire.wire import Field, StepControl, WireConstants

# Parameters of a wire that its user may change before it starts. All others follow from them, or from its geometry.
NOT_NEGATIVE = (
    "pretension_n",
    "spring_stiffness_n_per_m",
    "friction_n",
    "convection_factor",
    "martensite_barrier_k",
    "r_phase_barrier_k",
    "r_to_m_barrier_k",
    "r_phase_strain",
    "shakedown_strain",
    "shakedown_resistivity",
    "shakedown_barrier",
)
POSITIVE = (
    "series_resistance_ohm",
    "shunt_resistance_ohm",
    "friction_presliding_m",
    "martensite_temperature_k",
    "martensite_stress_rate_pa_per_k",
    "r_phase_temperature_k",
    "r_phase_stress_rate_pa_per_k",
    "r_phase_entropy_ratio",
    "strain_saturated",
    "strain_stress_scale_pa",
    "austenite_modulus_pa",
    "martensite_modulus_pa",
    "austenite_resistivity_ohm_m",
    "r_phase_resistivity_ohm_m",
    "martensite_resistivity_ohm_m",
    "shakedown_cycles",
    "martensite_spread_k",
    "r_phase_spread_k",
)
SIGNED = (
    "martensite_barrier_per_pa",
    "strain_at_no_stress",
    "austenite_expansion_per_k",
    "martensite_expansion_per_k",
    "austenite_resistivity_per_k",
    "r_phase_resistivity_per_k",
    "martensite_resistivity_per_k",
    "martensite_spread_per_pa",
)
SHOWN = (
    "wire_length_m",
    "leg_length_m",
    "legs",
    "area_m2",
    "surface_m2",
    "heat_capacity_j_per_k",
    "latent_heat_j",
)
# A positive parameter may be changed by this factor: more is a wrong unit.
MAX_CHANGE = 1e3
LARGE = 1e12


def wire_variables(
    constants: WireConstants, stepping: StepControl, maximum_voltage_v: float, *, finger: bool
) -> FmuVariables:
    """Return the variables of a wire, stepped like its rig, whose drive may reach a voltage [V]."""
    of_all = FmuVariables.from_files("wire", *(("finger",) if finger else ()))
    whole = of_all.changed(
        {
            "drive_voltage_v": {"maximum": maximum_voltage_v},
            "ambient_temperature_k": {"start": constants.ambient_temperature_k},
            "step_s": {"start": stepping.fixed_s},
            "tolerance_k": {"start": stepping.temperature_k},
            "resistance_tolerance": {"start": stepping.resistance},
            "strain_tolerance": {"start": stepping.strain},
        }
    ).and_also((*parameters(constants), *shown(constants)))
    fixed = tuple(variable.name for variable in whole.ordered if variable.role == "fixed")
    at_rest = {one.name: {"starts_with": (*fixed, *one.starts_with)} for one in whole.ordered if one.role == "output"}
    return whole.changed(at_rest)


def parameters(constants: WireConstants) -> Iterator[FmuVariable]:
    """Yield the parameters of wire, load and circuit."""
    for item in WireConstants.fields:
        value = getattr(constants, item.name)
        if item.name in POSITIVE:
            highest = min(value * MAX_CHANGE, 1.0) if item.name == "r_phase_entropy_ratio" else value * MAX_CHANGE
            yield parameter(item, value, value / MAX_CHANGE, highest)
        elif item.name in NOT_NEGATIVE:
            yield parameter(item, value, 0.0, LARGE)
        elif item.name in SIGNED:
            yield parameter(item, value, -LARGE, LARGE)


def parameter(item: Field, value: float, minimum: float, maximum: float) -> FmuVariable:
    """Return the parameter of a field."""
    return FmuVariable(item.name, "fixed", item.meaning, unit_of(item), start=value, minimum=minimum, maximum=maximum)


def shown(constants: WireConstants) -> Iterator[FmuVariable]:
    """Yield the numbers of the wire that follow from its geometry: they are shown and cannot be changed."""
    for item in WireConstants.fields:
        if item.name in SHOWN:
            yield FmuVariable(item.name, "constant", item.meaning, unit_of(item), start=getattr(constants, item.name))


def unit_of(item: Field) -> str:
    """Return the unit of a field as variables have it."""
    return "" if item.unit == "1" else item.unit
