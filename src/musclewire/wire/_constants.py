"""The constants of a wire, and the numbers derived from them that a step reads.

Two lists of fields are the only definition, as for the state (``wire/_state.py``).
"""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any, Self

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.wire._row import CLASSES, Row, Rows, field

CONVECTION_POINTS = 301
NO_LOAD_TABLE = np.zeros((2, 2))
NO_CELLS = np.zeros((1, 1, 4))


class WireConstants(Row):
    """Everything that does not change while a wire runs, built by ``wire._building``.

    Parameters
    ----------
    numbers
        The plain numbers of the row in the order of its fields, one-dimensional.
    layout
        Their layout in memory: ``WireConstants.layout(classes)``.
    load_table_n
        Force of the load in addition to pretension and spring, and friction in addition to the guide's [N],
        (2, n_points), at displacements of 0, 1, 2... times ``load_step_m``; by default neither. It is not in the row,
        as its length differs from load to load.
    distribution_cells
        Distribution of the grains' thresholds, (classes, n_cells, 4), or (1, n_cells, 4) if all classes have the same:
        the coefficients of a cubic in each cell. It is not in the row either; many wires share one.
    """

    load_table_n: FloatArray
    distribution_cells: FloatArray

    wire_length_m: float = field("m", "cold length under pretension")
    leg_length_m: float = field("m", "length of one leg of the V")
    legs: float = field("1", "number of legs")
    austenite_length_m: float = field("m", "length as stress-free austenite at 20 C")
    area_m2: float = field("m2", "cross section")
    surface_m2: float = field("m2", "surface area in contact with the air")
    heat_capacity_j_per_k: float = field("J/K", "heat capacity without latent heat")
    latent_heat_j: float = field("J", "latent heat from martensite to austenite")
    series_resistance_ohm: float = field("ohm", "shunt and leads in series with the wire")
    shunt_resistance_ohm: float = field("ohm", "shunt")
    ambient_temperature_k: float = field("K", "temperature of the air")
    convection_factor: float = field("1", "heat transfer coefficient relative to that of the correlation")
    convection_table_start_k: float = field("K", "wall temperature of the convection table's first point")
    convection_table_step_k: float = field("K", "step in wall temperature of the convection table")
    convection_table_w_per_m2_k: FloatArray = field(
        "W/(m2 K)", "heat transfer coefficient of the correlation", CONVECTION_POINTS
    )
    pretension_n: float = field("N", "force of the cold wire")
    spring_stiffness_n_per_m: float = field("N/m", "stiffness of the spring")
    friction_n: float = field("N", "friction of the guide")
    friction_presliding_m: float = field("m", "motion over which friction rises from 0 to its limit")
    load_step_m: float = field("m", "step in displacement of the load's table")
    martensite_temperature_k: float = field("K", "equilibrium temperature of austenite and martensite without stress")
    martensite_stress_rate_pa_per_k: float = field("Pa/K", "Clausius-Clapeyron slope of martensite")
    martensite_barrier_k: float = field("K", "barrier between austenite and martensite")
    martensite_barrier_per_pa: float = field("K/Pa", "change of that barrier with stress")
    r_phase_temperature_k: float = field("K", "equilibrium temperature of austenite and R-phase without stress")
    r_phase_stress_rate_pa_per_k: float = field("Pa/K", "Clausius-Clapeyron slope of the R-phase")
    r_phase_entropy_ratio: float = field("1", "entropy of A to R over that of A to M")
    r_phase_barrier_k: float = field("K", "barrier between austenite and R-phase")
    r_to_m_barrier_k: float = field("K", "barrier between R-phase and martensite")
    strain_at_no_stress: float = field("1", "transformation strain of martensite without stress")
    strain_saturated: float = field("1", "transformation strain of martensite under high stress")
    strain_stress_scale_pa: float = field("Pa", "stress scale over which martensite is oriented")
    r_phase_strain: float = field("1", "transformation strain of the R-phase")
    austenite_modulus_pa: float = field("Pa", "modulus of austenite")
    martensite_modulus_pa: float = field("Pa", "modulus of martensite")
    austenite_expansion_per_k: float = field("1/K", "thermal expansion of austenite")
    martensite_expansion_per_k: float = field("1/K", "thermal expansion of martensite")
    austenite_resistivity_ohm_m: float = field("ohm m", "resistivity of austenite at 20 C")
    austenite_resistivity_per_k: float = field("1/K", "its relative change with temperature")
    r_phase_resistivity_ohm_m: float = field("ohm m", "resistivity of the R-phase at 20 C")
    r_phase_resistivity_per_k: float = field("1/K", "its relative change with temperature")
    martensite_resistivity_ohm_m: float = field("ohm m", "resistivity of martensite at 20 C")
    martensite_resistivity_per_k: float = field("1/K", "its relative change with temperature")
    shakedown_cycles: float = field("1", "cycles after which 1/e of the shakedown is left")
    shakedown_strain: float = field("1", "strain that a new wire gains by shakedown")
    shakedown_resistivity: float = field("1", "relative rise of martensite's resistivity in a new wire")
    shakedown_barrier: float = field("1", "relative rise of martensite's barrier in a new wire")
    cold_strain: float = field(
        "1", "strain of the cold wire under pretension, relative to stress-free austenite at 20 C"
    )
    martensite_spread_k: float = field("K", "spread of martensite's transformation temperature over the grains")
    martensite_spread_per_pa: float = field("K/Pa", "change of that spread with stress")
    r_phase_spread_k: float = field("K", "spread of the R-phase's transformation temperature over the grains")
    distribution_start: float = field("1", "offset of the distribution's first cell, in units of the spread")
    distribution_step: float = field("1", "width of a cell outside the distribution's core")
    distribution_core_start: float = field("1", "offset at which the core begins")
    distribution_core_end: float = field("1", "offset at which the core ends; where it begins if there is none")
    distribution_core_step: float = field("1", "width of a cell in the core")
    class_weight: FloatArray = field("1", "fraction of the grains in each class of barrier; they add up to 1", CLASSES)
    class_barrier_k: FloatArray = field("K", "barrier of each class beyond `martensite_barrier_k`", CLASSES)

    def __init__(
        self,
        numbers: FloatArray,
        layout: np.dtype[np.void],
        load_table_n: FloatArray = NO_LOAD_TABLE,
        distribution_cells: FloatArray = NO_CELLS,
    ) -> None:
        """Take plain numbers, their layout, a load's table (the default is a plain spring) and a distribution."""
        super().__init__(numbers, layout)
        self.load_table_n = load_table_n
        self.distribution_cells = distribution_cells
        self._derived: StepConstants | None = None

    def copy(self) -> Self:
        """Return independent constants of the same numbers, load and distribution."""
        return type(self)(self.numbers.copy(), self.row.dtype, self.load_table_n, self.distribution_cells)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the load's table and the distribution with the numbers."""
        return type(self), (self.numbers, self.row.dtype, self.load_table_n, self.distribution_cells)

    @property
    def derived(self) -> StepConstants:
        """What a step reads, calculated once: constants never change."""
        if self._derived is None:
            self._derived = derived_from(self)
        return self._derived

    def step_arrays(self) -> tuple[Rows, Rows, Rows]:
        """Return what compiled code takes, arrays of one record: derived row, distribution and load.

        Tables as records cost no reference counting, which would take as long as the physics.
        """
        return self.derived.row, as_record(self.distribution_cells), as_record(self.load_table_n)


class StepConstants(Row):
    """Numbers that a step reads, derived from :class:`WireConstants`: products and reciprocals made once.

    Parameters
    ----------
    numbers
        The plain numbers of the row in the order of its fields, one-dimensional.
    layout
        Their layout in memory: ``StepConstants.layout(classes)``.
    """

    leg_length_m: float = field("m", "length of one leg")
    section_m2: float = field("m2", "cross section of all legs")
    per_section_m2: float = field("1/m2", "its reciprocal")
    per_stretch: float = field("1", "contraction per strain: 1 / (1 + cold strain)")
    cold_strain: float = field("1", "strain of the cold wire under pretension")
    length_over_area_per_m: float = field("1/m", "length over cross section as stress-free austenite at 20 C")
    capacity_j_per_k: float = field("J/K", "heat capacity without latent heat")
    per_capacity_k_per_j: float = field("K/J", "its reciprocal")
    latent_heat_j: float = field("J", "latent heat from martensite to austenite")
    series_resistance_ohm: float = field("ohm", "shunt and leads in series with the wire")
    shunt_resistance_ohm: float = field("ohm", "shunt")
    ambient_temperature_k: float = field("K", "temperature of the air")
    surface_factor_m2: float = field("m2", "surface times convection factor")
    convection_start_k: float = field("K", "wall temperature of the convection table's first point")
    convection_per_k: float = field("1/K", "points of that table per kelvin")
    pretension_n: float = field("N", "force of the cold wire")
    spring_n: float = field("N", "force of the spring per contraction")
    friction_n: float = field("N", "friction of the guide")
    per_presliding: float = field("1", "contraction per motion over which friction rises to its limit")
    load_points_per_contraction: float = field("1", "points of the load's table per contraction")
    martensite_temperature_k: float = field("K", "equilibrium temperature of austenite and martensite without stress")
    martensite_k_per_pa: float = field("K/Pa", "rise of that temperature with stress")
    martensite_barrier_k: float = field("K", "barrier between austenite and martensite")
    martensite_barrier_per_pa: float = field("K/Pa", "change of that barrier with stress")
    martensite_spread_k: float = field("K", "spread of that temperature over the grains")
    martensite_spread_per_pa: float = field("K/Pa", "change of that spread with stress")
    r_phase_temperature_k: float = field("K", "equilibrium temperature of austenite and R-phase without stress")
    r_phase_k_per_pa: float = field("K/Pa", "rise of that temperature with stress")
    r_phase_entropy_ratio: float = field("1", "entropy of A to R over that of A to M")
    r_phase_barrier_k: float = field("K", "barrier between austenite and R-phase")
    r_to_m_barrier_k: float = field("K", "barrier between R-phase and martensite")
    r_phase_spread_k: float = field("K", "spread of the R-phase's driving force over the grains")
    per_r_phase_spread: float = field("1/K", "its reciprocal")
    strain_at_no_stress: float = field("1", "transformation strain of martensite without stress")
    strain_saturated: float = field("1", "transformation strain of martensite under high stress")
    per_strain_scale_per_pa: float = field("1/Pa", "reciprocal of the stress scale of that strain")
    r_phase_strain: float = field("1", "transformation strain of the R-phase")
    austenite_compliance_per_pa: float = field("1/Pa", "compliance of austenite")
    added_compliance_per_pa: float = field("1/Pa", "compliance of martensite beyond that of austenite")
    austenite_expansion_per_k: float = field("1/K", "thermal expansion of austenite")
    added_expansion_per_k: float = field("1/K", "thermal expansion of martensite beyond that of austenite")
    austenite_resistivity_ohm_m: float = field("ohm m", "resistivity of austenite at 20 C")
    austenite_resistivity_per_k: float = field("1/K", "its relative change with temperature")
    r_phase_resistivity_ohm_m: float = field("ohm m", "resistivity of the R-phase at 20 C")
    r_phase_resistivity_per_k: float = field("1/K", "its relative change with temperature")
    martensite_resistivity_ohm_m: float = field("ohm m", "resistivity of martensite at 20 C")
    martensite_resistivity_per_k: float = field("1/K", "its relative change with temperature")
    shakedown_cycles: float = field("1", "cycles after which 1/e of the shakedown is left; 0 after shakedown")
    shakedown_strain: float = field("1", "strain that a new wire gains by shakedown")
    shakedown_resistivity: float = field("1", "relative rise of martensite's resistivity in a new wire")
    shakedown_barrier: float = field("1", "relative rise of martensite's barrier in a new wire")
    distribution_core_start: float = field("1", "offset at which the distribution's core begins")
    distribution_core_end: float = field("1", "offset at which it ends")
    distribution_core_place: float = field("1", "cells before the core")
    distribution_per_core_step: float = field("1", "cells per unit of the spread in the core")
    distribution_per_step: float = field("1", "cells per unit of the spread outside")
    class_weight: FloatArray = field("1", "fraction of the grains in each class of barrier", CLASSES)
    class_barrier_k: FloatArray = field("K", "barrier of each class beyond the common one", CLASSES)
    convection_w_per_m2_k: FloatArray = field(
        "W/(m2 K)", "heat transfer coefficient of the correlation over wall temperature", CONVECTION_POINTS
    )


@cache
def table_layout(shape: tuple[int, ...]) -> np.dtype[np.void]:
    """Return the layout of a record that holds one table, ``record.table``; the same object for the same shape."""
    return np.dtype((np.record, [("table", np.float64, shape)]))


def as_record(table: FloatArray) -> Rows:
    """Return a view of a contiguous table as an array of one record, (1,)."""
    return np.ndarray(1, table_layout(table.shape), table)


def derived_from(constants: WireConstants) -> StepConstants:
    """Return what a step reads; plain Python, because it runs once for a wire and compiling it takes seconds."""
    row = constants.row[0]
    k = SimpleNamespace(**{item.name: row[item.name] for item in WireConstants.fields})
    wears = k.shakedown_strain != 0.0 or k.shakedown_resistivity != 0.0 or k.shakedown_barrier != 0.0
    section_m2, r_phase_spread_k = k.legs * k.area_m2, k.r_phase_entropy_ratio * k.r_phase_spread_k
    with np.errstate(divide="ignore", invalid="ignore"):  # as compiled code divides by 0: a load without a table does
        per_step = 1.0 / k.distribution_step
        derived = {
            "section_m2": section_m2,
            "per_section_m2": 1.0 / section_m2,
            "per_stretch": 1.0 / (1.0 + k.cold_strain),
            "length_over_area_per_m": k.austenite_length_m / k.area_m2,
            "capacity_j_per_k": k.heat_capacity_j_per_k,
            "per_capacity_k_per_j": 1.0 / k.heat_capacity_j_per_k,
            "surface_factor_m2": k.surface_m2 * k.convection_factor,
            "convection_start_k": k.convection_table_start_k,
            "convection_per_k": 1.0 / k.convection_table_step_k,
            "convection_w_per_m2_k": k.convection_table_w_per_m2_k,
            "spring_n": k.spring_stiffness_n_per_m * k.leg_length_m,
            "per_presliding": k.leg_length_m / k.friction_presliding_m,
            "load_points_per_contraction": k.leg_length_m / k.load_step_m,
            "shakedown_cycles": k.shakedown_cycles if wears else 0.0,
            "martensite_k_per_pa": 1.0 / k.martensite_stress_rate_pa_per_k,
            "r_phase_k_per_pa": 1.0 / k.r_phase_stress_rate_pa_per_k,
            "r_phase_spread_k": r_phase_spread_k,
            "per_r_phase_spread": 1.0 / r_phase_spread_k,
            "per_strain_scale_per_pa": 1.0 / k.strain_stress_scale_pa,
            "austenite_compliance_per_pa": 1.0 / k.austenite_modulus_pa,
            "added_compliance_per_pa": 1.0 / k.martensite_modulus_pa - 1.0 / k.austenite_modulus_pa,
            "added_expansion_per_k": k.martensite_expansion_per_k - k.austenite_expansion_per_k,
            "distribution_per_core_step": 1.0 / k.distribution_core_step,
            "distribution_per_step": per_step,
            "distribution_core_place": (k.distribution_core_start - k.distribution_start) * per_step,
        }
    found = StepConstants.zeros(constants.classes)
    # All others are the wire's own numbers.
    found.row[0] = tuple(derived[item.name] if item.name in derived else row[item.name] for item in found.fields)
    return found
