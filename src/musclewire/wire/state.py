"""The row of a wire: all that it remembers, and what does not change while it runs.

These two lists of fields are the one definition. The layout in memory, attributes in Python and in compiled code and
docs/reference/wire_row.md follow from them; a new field is one line here, and the line of the step that writes it.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Self

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.wire.rows import GRAIN_EDGES, GRAINS, Row, Rows, field

__all__ = [
    "CONVECTION_POINTS",
    "DRIVING_FORCES",
    "FloatArray",
    "Rows",
    "RunningWire",
    "Shakedown",
    "WireConstants",
    "WireState",
]

CONVECTION_POINTS = 301
DRIVING_FORCES = 6
NO_LOAD_TABLE = np.zeros((2, 2))


class WireState(Row):
    """All that a wire remembers from one step to the next."""

    time_s: float = field("s", "time since the wire was first at rest")
    temperature_k: float = field("K", "temperature")
    stress_pa: float = field("Pa", "stress of one leg")
    contraction: float = field("1", "shortening over the length cold under pretension")
    friction_n: float = field("N", "friction of guide and load, positive against contraction")
    enthalpy_j: float = field("J", "enthalpy, 0 for austenite at 20 C")
    heat_in_j: float = field("J", "electrical heat in so far")
    heat_out_j: float = field("J", "heat given to the air so far")
    cycles: float = field("1", "full transformations there and back so far")
    martensite_fraction: float = field("1", "volume fraction of martensite")
    r_phase_fraction: float = field("1", "volume fraction of R-phase")
    resistance_ohm: float = field("ohm", "resistance")
    capacity_j_per_k: float = field("J/K", "heat capacity that the last step showed, latent heat included")
    stress_slope_pa_per_k: float = field("Pa/K", "stress over temperature in the last step")
    temperature_rate_k_per_s: float = field("K/s", "rate of the temperature in the last step")
    resistance_rate_ohm_per_s: float = field("ohm/s", "rate of the resistance in the last step")
    grain_martensite: FloatArray = field("1", "fraction of martensite of each grain", GRAINS)
    grain_r_phase: FloatArray = field("1", "fraction of R-phase of each grain", GRAINS)
    followed_force_k: FloatArray = field(
        "K",
        "driving forces that the grains have followed, in the order of `DrivingForces`",
        DRIVING_FORCES,
    )
    followed_stress_pa: float = field("Pa", "stress at which the grains have followed them")


class WireConstants(Row):
    """Everything that does not change while a wire runs, built by ``wire.building``.

    ``load_table_n``, (2, n_points), is not in the row, as its length differs from load to load: what the load pulls
    beyond pretension and spring, and its friction beyond the guide's, at displacements of 0, 1, 2... times
    ``load_step_m``.
    """

    load_table_n: FloatArray

    wire_length_m: float = field("m", "length cold under pretension")
    leg_length_m: float = field("m", "length of one leg of the V")
    legs: float = field("1", "number of legs")
    austenite_length_m: float = field("m", "length as stress-free austenite at 20 C")
    area_m2: float = field("m2", "cross section")
    surface_m2: float = field("m2", "surface that gives heat to the air")
    heat_capacity_j_per_k: float = field("J/K", "heat capacity without latent heat")
    latent_heat_j: float = field("J", "heat from martensite to austenite")
    series_resistance_ohm: float = field("ohm", "shunt and leads in series with the wire")
    shunt_resistance_ohm: float = field("ohm", "shunt")
    ambient_temperature_k: float = field("K", "temperature of the air")
    convection_factor: float = field("1", "heat transfer coefficient over that of the correlation")
    convection_table_start_k: float = field("K", "wall temperature of the convection table's first point")
    convection_table_step_k: float = field("K", "wall temperature from point to point of the convection table")
    convection_table_w_per_m2_k: FloatArray = field(
        "W/(m2 K)", "heat transfer coefficient of the correlation", CONVECTION_POINTS
    )
    pretension_n: float = field("N", "force of the cold wire")
    spring_stiffness_n_per_m: float = field("N/m", "stiffness of the spring")
    friction_n: float = field("N", "friction of the guide")
    friction_presliding_m: float = field("m", "motion until friction turns around")
    load_step_m: float = field("m", "displacement from point to point of the load's table")
    martensite_temperature_k: float = field("K", "equilibrium of austenite and martensite without stress")
    martensite_stress_rate_pa_per_k: float = field("Pa/K", "Clausius-Clapeyron slope of martensite")
    martensite_barrier_k: float = field("K", "barrier between austenite and martensite")
    martensite_barrier_per_pa: float = field("K/Pa", "change of that barrier with stress")
    r_phase_temperature_k: float = field("K", "equilibrium of austenite and R-phase without stress")
    r_phase_stress_rate_pa_per_k: float = field("Pa/K", "Clausius-Clapeyron slope of the R-phase")
    r_phase_entropy_ratio: float = field("1", "entropy of A to R over that of A to M")
    r_phase_barrier_k: float = field("K", "barrier between austenite and R-phase")
    r_to_m_barrier_k: float = field("K", "barrier between R-phase and martensite")
    strain_at_no_stress: float = field("1", "transformation strain of martensite without stress")
    strain_saturated: float = field("1", "transformation strain of martensite under high stress")
    strain_stress_scale_pa: float = field("Pa", "stress over which martensite is oriented")
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
    cold_strain: float = field("1", "strain cold under pretension, against stress-free austenite at 20 C")
    martensite_spread_k: float = field("K", "spread of martensite's temperatures over the grains")
    martensite_spread_per_pa: float = field("K/Pa", "change of that spread with stress")
    r_phase_spread_k: float = field("K", "spread of the R-phase's temperatures over the grains")
    grain_edges: FloatArray = field("1", "edges of the grains in units of the spread", GRAIN_EDGES)
    grain_middle: FloatArray = field("1", "middle of each grain in units of the spread", GRAINS)
    grain_width: FloatArray = field("1", "width of each grain in units of the spread", GRAINS)

    def __init__(
        self, numbers: FloatArray, layout: np.dtype[np.void], load_table_n: FloatArray = NO_LOAD_TABLE
    ) -> None:
        """Take bare numbers, their layout and a load's table; without one there is nothing beyond the spring."""
        super().__init__(numbers, layout)
        self.load_table_n = load_table_n

    def copy(self) -> Self:
        """Return constants of the same numbers and load that may be changed without changing these."""
        return type(self)(self.numbers.copy(), self.row.dtype, self.load_table_n)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the load's table with the numbers."""
        return type(self), (self.numbers, self.row.dtype, self.load_table_n)


class Shakedown(NamedTuple):
    """How much of a new wire's shakedown is left: 1 before its first cycle, 0 in the end, and what that does."""

    remaining: float
    residual_strain: float
    barrier_factor: float


class RunningWire(NamedTuple):
    """A wire inside compiled code: its two records, which a step changes in place, its load's table and shakedown."""

    state: WireState
    constants: WireConstants
    load_table_n: FloatArray
    shakedown: Shakedown
