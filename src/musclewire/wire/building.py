"""From parameter files to a wire that can run: constants and the state of a wire at rest."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.parameters.parameter_groups import Alloy, Bench, Wire
from musclewire.physics.heat import convection_coefficient_w_per_m2_k
from musclewire.physics.resistance import REFERENCE_TEMPERATURE_K
from musclewire.wire.grains import spread_grains
from musclewire.wire.loads import ConnectorLoad, spring_load
from musclewire.wire.state import CONVECTION_POINTS, WireConstants, WireState
from musclewire.wire.step import resistance_of, total_strain
from musclewire.wire.switching import cool_from_hot

__all__ = ["constants_from", "constants_of", "cooled_wire", "resting_state", "with_pretension"]

MIN_PRESLIDING_M = 5e-6
TABLE_START_K = 200.0
TABLE_STEP_K = 2.0


@lru_cache(maxsize=64)
def convection_table(diameter_m: float, ambient_temperature_k: float) -> FloatArray:
    """Return the convection coefficient every 2 K from 200 K to 800 K at one ambient temperature, (301,)."""
    walls = TABLE_START_K + TABLE_STEP_K * np.arange(CONVECTION_POINTS)
    return np.array([convection_coefficient_w_per_m2_k(t, ambient_temperature_k, diameter_m) for t in walls])


def constants_from(
    alloy: Alloy, wire: Wire, rig: Bench, *, load: ConnectorLoad | None = None, new_wire: bool = False
) -> WireConstants:
    """Return the constants of a wire on a rig; the cold reference strain is found by cooling it there.

    ``load`` replaces the rig's bias spring. The shakedown of a new wire is still to come; otherwise it is over and has
    no effect. Raises CallerError if the numbers cannot describe a wire (no length, no grains).
    """
    return constants_of(alloy.values(), wire.values(), rig.values(), load=load, new_wire=new_wire)


def constants_of(
    material: Mapping[str, float],
    spool: Mapping[str, float],
    bench: Mapping[str, float],
    *,
    load: ConnectorLoad | None = None,
    new_wire: bool = False,
) -> WireConstants:
    """Return the constants from plain numbers by name, as a search that tries thousands of sets needs them."""
    attached = load or spring_load(bench["spring_stiffness_n_per_m"])
    require_a_wire(material, spool, bench, attached)
    grains = int(bench["grains"])
    spread = spread_grains(grains, material["grain_skew"], material["grain_tail"])
    constants = WireConstants.of(
        grains,
        **alloy_on_spool(material, spool, new_wire=new_wire),
        **body(material, spool, bench),
        series_resistance_ohm=bench["shunt_resistance_ohm"] + bench["lead_resistance_ohm"],
        shunt_resistance_ohm=bench["shunt_resistance_ohm"],
        ambient_temperature_k=bench["ambient_temperature_k"],
        convection_factor=spool["convection_factor"],
        convection_table_start_k=TABLE_START_K,
        convection_table_step_k=TABLE_STEP_K,
        convection_table_w_per_m2_k=convection_table(spool["diameter_m"], bench["ambient_temperature_k"]),
        pretension_n=bench["pretension_n"],
        spring_stiffness_n_per_m=attached.stiffness_n_per_m,
        load_step_m=attached.step_m,
        friction_n=bench["guide_friction_n"],
        friction_presliding_m=bench["guide_presliding_m"],
        cold_strain=0.0,
        grain_edges=spread.edges,
        grain_middle=spread.middle,
        grain_width=spread.width,
    )
    constants.load_table_n = attached.table_n()
    return with_pretension(constants, bench["pretension_n"])


def require_a_wire(
    material: Mapping[str, float], spool: Mapping[str, float], bench: Mapping[str, float], load: ConnectorLoad
) -> None:
    """Raise CallerError for numbers that cannot describe a wire, or with which a step would be unstable."""
    if min(bench["wire_length_m"], bench["legs"], spool["diameter_m"]) <= 0.0:
        raise CallerError("wire_length_m, legs and diameter_m must be above 0: there is no wire otherwise")
    rubs = bench["guide_friction_n"] > 0.0 or load.friction_n.max() > 0.0
    if rubs and bench["guide_presliding_m"] < MIN_PRESLIDING_M:
        raise CallerError(
            f"guide_presliding_m is {bench['guide_presliding_m']:g} m: below {MIN_PRESLIDING_M:g} m the friction of "
            "the guide is stiffer than the wire and the step cannot follow it"
        )
    if material["r_phase_entropy_ratio"] >= 1.0:
        raise CallerError("r_phase_entropy_ratio must be below 1: A to R is a part of the way from A to M")


def alloy_on_spool(material: Mapping[str, float], spool: Mapping[str, float], *, new_wire: bool) -> dict[str, float]:
    """Return the alloy's constants with the factors and shifts of a spool; without shakedown unless the wire is new."""
    same = {item.name: material[item.name] for item in WireConstants.fields if item.name in material}
    if not new_wire:
        same |= {"shakedown_strain": 0.0, "shakedown_resistivity": 0.0, "shakedown_barrier": 0.0}
    for name in ("austenite", "martensite", "r_phase"):
        same[f"{name}_resistivity_ohm_m"] *= spool["resistivity_factor"]
    for name in ("martensite", "r_phase"):
        same[f"{name}_temperature_k"] += spool["temperature_shift_k"]
    same["r_phase_temperature_k"] += spool["r_phase_shift_k"]
    same["martensite_barrier_k"] += spool["martensite_barrier_shift_k"]
    return same


def body(material: Mapping[str, float], spool: Mapping[str, float], bench: Mapping[str, float]) -> dict[str, float]:
    """Return the dimensions, heat capacity and latent heat of a wire."""
    length, legs, diameter = bench["wire_length_m"], bench["legs"], spool["diameter_m"]
    area = 0.25 * math.pi * diameter**2
    mass = area * length * material["density_kg_per_m3"]
    return {
        "wire_length_m": length,
        "leg_length_m": length / legs,
        "legs": legs,
        "austenite_length_m": length,
        "area_m2": area,
        "surface_m2": math.pi * diameter * length,
        "heat_capacity_j_per_k": mass * material["specific_heat_j_per_kg_k"],
        "latent_heat_j": mass * material["latent_heat_j_per_kg"],
    }


def with_pretension(constants: WireConstants, pretension_n: float) -> WireConstants:
    """Return the constants at another setting of the linear stage; contraction is relative to the cold wire there.

    Parameters
    ----------
    constants
        Those of the wire on its load at any pretension.
    pretension_n
        Force of the cold wire [N], 0 or more.

    Returns
    -------
    Constants with that pretension, and with the cold strain and the stress-free length that it implies.

    Raises
    ------
    CallerError
        For a pretension below 0 or not finite: a wire cannot be pushed.
    """
    if not 0.0 <= pretension_n < math.inf:
        raise CallerError(f"pretension is {pretension_n} N: a wire cannot be pushed, give 0 or more")
    stress = pretension_n / (constants.legs * constants.area_m2)
    ambient = constants.ambient_temperature_k
    martensite, r_phase = mean_phases(cooled_wire(constants, stress, ambient))
    cold = total_strain(constants.record, stress, martensite, r_phase, ambient)
    return constants.replace(
        pretension_n=pretension_n,
        cold_strain=cold,
        austenite_length_m=constants.wire_length_m / (1.0 + cold),
    )


def cooled_wire(constants: WireConstants, stress_pa: float, temperature_k: float) -> WireState:
    """Return a row with the grains of a wire cooled from hot to a temperature under a stress; all else is 0."""
    state = WireState.zeros(constants.grains)
    cool_from_hot(state.row, constants.row, stress_pa, temperature_k)
    return state


def mean_phases(state: WireState) -> tuple[float, float]:
    """Return the fractions of martensite and R-phase, as means over the grains."""
    return float(state.grain_martensite.mean()), float(state.grain_r_phase.mean())


def resting_state(constants: WireConstants) -> WireState:
    """Return a wire at rest, cooled to ambient under its pretension."""
    stress = constants.pretension_n / (constants.legs * constants.area_m2)
    temperature = constants.ambient_temperature_k
    cooled = cooled_wire(constants, stress, temperature)
    martensite, r_phase = mean_phases(cooled)
    transformed = martensite + constants.r_phase_entropy_ratio * r_phase
    return cooled.replace(
        temperature_k=temperature,
        stress_pa=stress,
        enthalpy_j=constants.heat_capacity_j_per_k * (temperature - REFERENCE_TEMPERATURE_K)
        - constants.latent_heat_j * transformed,
        martensite_fraction=martensite,
        r_phase_fraction=r_phase,
        resistance_ohm=resistance_of(constants.record, stress, martensite, r_phase, temperature, 1.0),
        capacity_j_per_k=constants.heat_capacity_j_per_k,
    )
