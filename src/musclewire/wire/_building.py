"""From parameter files to a wire that can run: constants and the state of a wire at rest."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from musclewire.errors import CallerError
from musclewire.parameters import Alloy, Bench, Numbers, Wire
from musclewire.physics import REFERENCE_TEMPERATURE_K
from musclewire.wire._distribution import (
    ONE_CLASS,
    BarrierClass,
    OffsetDistribution,
    of_classes,
    quantile_distribution,
    two_population_distribution,
)
from musclewire.wire._heat_balance import TABLE_START_K, TABLE_STEP_K, convection_table
from musclewire.wire._loads import ConnectorLoad, spring_load
from musclewire.wire._prescribed import cool_from_hot
from musclewire.wire._row import WireConstants, WireState

# Stresses at which the spreads must be positive: none, and about the strength of the wire.
STRESSES_PA = (0.0, 1e9)
MIN_SPREAD_K = 1e-3
# Numbers of an alloy that say how its grains are distributed.
SHAPE = ("grain_skew", "grain_tail", "early_fraction", "early_width")


def constants_from(
    alloy: Alloy, wire: Wire, rig: Bench, *, load: ConnectorLoad | None = None, new_wire: bool = False
) -> WireConstants:
    """Return the constants of a wire on a rig; the cold reference strain is found by cooling it there.

    ``load`` replaces the rig's bias spring. The shakedown of a new wire is still to come; otherwise it is over and has
    no effect. Raises CallerError if the numbers cannot describe a wire (no length, no grains).
    """
    grains = measured_grains(alloy)
    return constants_of(alloy.values(), wire.values(), rig, load=load, new_wire=new_wire, distribution=grains)


def measured_grains(alloy: Alloy) -> OffsetDistribution | None:
    """Return the distribution through an alloy's measured quantiles, which ``Alloy.values`` lacks; None without any."""
    table = alloy.grain_quantiles
    return None if table is None else quantile_distribution(table.offset, table.fraction)


def constants_of(
    material: Mapping[str, float],
    spool: Mapping[str, float],
    bench: Numbers,
    *,
    load: ConnectorLoad | None = None,
    new_wire: bool = False,
    distribution: OffsetDistribution | None = None,
    classes: Sequence[BarrierClass] = ONE_CLASS,
) -> WireConstants:
    """Return the constants from plain numbers by name, as a search that tries thousands of sets needs them.

    Parameters
    ----------
    material, spool, bench
        Numbers of alloy, wire and bench by name, in SI: the ``values()`` of their parameter groups; of the bench
        also the group itself.
    load
        What the wire pulls; the bench's spring if None.
    new_wire
        Whether the shakedown of a new wire is still to come.
    distribution
        Distribution of the grains' offsets; that of the alloy's ``grain_skew``, ``grain_tail``, ``early_fraction`` and
        ``early_width`` if None.
    classes
        Grains by their barrier; one class by default.

    Returns
    -------
    The constants.

    Raises
    ------
    CallerError
        If the numbers cannot describe a wire, or its spreads have no order that two fronts could hold.
    """
    attached = load or spring_load(bench["spring_stiffness_n_per_m"])
    require_a_wire(material, spool, bench)
    spread = distribution or two_population_distribution(*(material[name] for name in SHAPE))
    weights, barriers_k = of_classes(classes)
    constants = WireConstants.from_values(
        len(weights),
        **alloy_on_spool(material, spool, new_wire=new_wire),
        **dimensions_and_heat(material, spool, bench),
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
        distribution_start=spread.start,
        distribution_step=spread.step,
        distribution_core_start=spread.core_start,
        distribution_core_end=spread.core_end,
        distribution_core_step=spread.core_step,
        class_weight=weights,
        class_barrier_k=barriers_k,
    )
    constants.distribution_cells = spread.cells[np.newaxis]
    constants.load_table_n = np.stack((attached.force_n, attached.friction_n))
    return with_pretension(constants, bench["pretension_n"])


def require_a_wire(material: Mapping[str, float], spool: Mapping[str, float], bench: Numbers) -> None:
    """Raise CallerError for numbers that cannot describe a wire."""
    for name, value in (
        *((key, bench[key]) for key in ("wire_length_m", "legs", "guide_presliding_m")),
        ("diameter_m", spool["diameter_m"]),
    ):
        if not value > 0.0:
            raise CallerError(f"{name} is {value:g}: it must be above 0")
    if bench["guide_friction_n"] < 0.0:
        raise CallerError(f"guide_friction_n is {bench['guide_friction_n']:g}: it must be 0 or more")
    require_spreads(material)
    if material["r_phase_entropy_ratio"] >= 1.0:
        ratio = material["r_phase_entropy_ratio"]
        raise CallerError(f"r_phase_entropy_ratio is {ratio:g}: it must be below 1, as A to R is a part of A to M")


def require_spreads(material: Mapping[str, float]) -> None:
    """Raise CallerError for spreads with which two fronts could not describe the phases.

    The driving force of martensite against R-phase must spread in the same order over the grains as that against
    austenite does: r_phase_entropy_ratio * r_phase_spread_k below the spread of martensite, at any stress.
    """
    spread_r = material["r_phase_entropy_ratio"] * material["r_phase_spread_k"]
    for stress_pa in STRESSES_PA:
        spread_m = material["martensite_spread_k"] + material["martensite_spread_per_pa"] * stress_pa
        if not spread_r >= MIN_SPREAD_K or not spread_m - spread_r >= MIN_SPREAD_K:
            raise CallerError(
                f"at {stress_pa / 1e6:g} MPa martensite's spread is {spread_m:.4g} K, the R-phase's (its ratio times "
                f"r_phase_spread_k) {spread_r:.4g} K: that must be {MIN_SPREAD_K:g} K or more, and martensite's larger "
                "by as much: raise martensite_spread_k or lower r_phase_spread_k"
            )


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


def dimensions_and_heat(material: Mapping[str, float], spool: Mapping[str, float], bench: Numbers) -> dict[str, float]:
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
    """Return the constants at a pretension of 0 or more; contraction is relative to the cold wire there."""
    if not 0.0 <= pretension_n < math.inf:
        raise CallerError(f"pretension is {pretension_n} N: a wire cannot be pushed, give 0 or more")
    stress = pretension_n / (constants.legs * constants.area_m2)
    ambient = constants.ambient_temperature_k
    cold, _ = cool_from_hot(WireState.zeros(constants.classes).row, *constants.step_arrays(), ambient, stress)
    return constants.replace(
        pretension_n=pretension_n,
        cold_strain=cold,
        austenite_length_m=constants.wire_length_m / (1.0 + cold),
    )


def cooled_wire(constants: WireConstants, stress_pa: float, temperature_k: float) -> WireState:
    """Return a row with the phases of a wire cooled from hot to a temperature under a stress; all else is 0."""
    state = WireState.zeros(constants.classes)
    cool_from_hot(state.row, *constants.step_arrays(), temperature_k, stress_pa)
    return state


def resting_state(constants: WireConstants) -> WireState:
    """Return a wire at rest, cooled to ambient under its pretension."""
    k, state = constants.derived.record, WireState.zeros(constants.classes)
    temperature_k, stress_pa = float(k.ambient_temperature_k), float(k.pretension_n * k.per_section_m2)
    _, resistance_ohm = cool_from_hot(state.row, *constants.step_arrays(), temperature_k, stress_pa)
    latent = state.martensite_fraction + k.r_phase_entropy_ratio * state.r_phase_fraction
    return state.replace(
        temperature_k=temperature_k,
        stress_pa=stress_pa,
        enthalpy_j=k.capacity_j_per_k * (temperature_k - REFERENCE_TEMPERATURE_K) - k.latent_heat_j * latent,
        resistance_ohm=resistance_ohm,
        temperature_slope_k_per_j=k.per_capacity_k_per_j,
    )
