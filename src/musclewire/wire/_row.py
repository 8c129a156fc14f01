"""The rows of a wire: its state, its constants, and the numbers derived from these that a step reads.

A row is a NumPy record of named numbers. Compiled code reads and writes it in place, by attribute; in Python it is read
through a class whose attributes are the fields, and changed only by making another. Many wires are an array of such
rows. A list of fields is the only definition of a row: the layout in memory, attributes in Python and in compiled code
and the page on the row of a wire follow from it. A new field of the state is one line here, and the line of the step
that writes it.
"""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError

# Records as compiled code takes them, (n_wires,); each element has the fields of its Row as attributes.
Rows = Any

# Array lengths that depend on the number of classes of barrier, as the documentation names them, and how many numbers
# of each class they hold.
CLASSES, CLASS_SLOPES = "classes", "6 x classes"
PER_CLASS = {CLASSES: 1, CLASS_SLOPES: 6}


class Field:
    """One field of a row: a float, or an array of floats if it has a length."""

    name: str

    def __init__(self, unit: str, meaning: str, length: int | str | None) -> None:
        """Take the unit, what the field means, and its length: None for one number."""
        self.unit, self.meaning, self.length = unit, meaning, length

    def __set_name__(self, owner: type, name: str) -> None:
        """Take the name that this field has in its row."""
        self.name = name

    def __get__(self, row: Row | None, owner: type | None = None) -> Any:
        """Return the value in a row: a float, or a view of its array that cannot be written."""
        if row is None:
            return self
        values = row.row[self.name]
        if self.length is None:
            return values.item()
        values.flags.writeable = False
        return values[0]

    def __set__(self, row: Row, value: object) -> None:
        """Refuse to write: from Python a row never changes."""
        raise AttributeError(f"{self.name} of a {type(row).__name__} cannot be written: use replace({self.name}=...)")

    def shape(self, classes: int) -> tuple[int, ...]:
        """Return the shape in the row of a wire with so many classes of barrier."""
        if self.length is None:
            return ()
        return (self.length,) if isinstance(self.length, int) else (classes * PER_CLASS[self.length],)


def field(unit: str, meaning: str, length: int | str | None = None) -> Any:
    """Return a field for the body of a :class:`Row`: its SI unit, what it means, and an array's length."""
    return Field(unit, meaning, length)


class Row:
    """A row of named numbers. A subclass lists its fields, ``name: float = field(unit, meaning)``, and nothing else.

    ``row`` is an array of one record, (1,), which is what compiled code takes; a batch is a longer one. Make a row by
    ``from_values``, ``zeros`` or ``replace``; it owns its numbers, plain ones in the order of its fields.
    """

    fields: ClassVar[tuple[Field, ...]] = ()

    def __init_subclass__(cls) -> None:
        """Collect the fields in the order of their lines, those of the base class first."""
        cls.fields = (*cls.fields, *(item for item in vars(cls).values() if isinstance(item, Field)))

    def __init__(self, numbers: FloatArray, layout: np.dtype[np.void]) -> None:
        """Take the plain numbers of a row, which this object owns from now on, and their layout."""
        # A view with names over plain numbers: NumPy creates and copies these ten times faster than records.
        self.numbers = numbers
        self.row: NDArray[np.void] = np.ndarray(1, layout, numbers)

    @classmethod
    @cache
    def layout(cls, classes: int = 1) -> np.dtype[np.void]:
        """Return the layout in memory for so many classes of barrier; the same object for the same number."""
        # As np.record its records have attributes without compilation, too.
        return np.dtype((np.record, [(item.name, np.float64, item.shape(classes)) for item in cls.fields]))

    @classmethod
    def zeros(cls, classes: int = 1) -> Self:
        """Return a row in which every number is 0."""
        layout = cls.layout(classes)
        return cls(np.zeros(layout.itemsize // np.dtype(np.float64).itemsize), layout)

    @classmethod
    def from_values(cls, classes: int, **values: object) -> Self:
        """Return a row of these values. Raises CallerError if a field is missing or unknown."""
        missing = [item.name for item in cls.fields if item.name not in values]
        if missing:
            raise CallerError(f"a {cls.__name__} needs {', '.join(missing)}")
        return cls.zeros(classes).replace(**values)

    @property
    def record(self) -> Any:
        """The only record of ``row``, as a compiled function of one wire takes it."""
        return self.row[0]

    @property
    def classes(self) -> int:
        """Number of classes of barrier that this row has room for."""
        sized = next(item for item in self.fields if item.length == CLASSES)
        return int(self.row.dtype[sized.name].shape[0])

    def copy(self) -> Self:
        """Return an independent row of the same numbers."""
        return type(self)(self.numbers.copy(), self.row.dtype)

    def replace(self, **changes: object) -> Self:
        """Return a row with other values of some fields. Raises CallerError for an unknown field."""
        changed = self.copy()
        for name, value in changes.items():
            if name not in (changed.row.dtype.names or ()):
                raise CallerError(
                    f"a {type(self).__name__} has no field '{name}'; it has {', '.join(changed.row.dtype.names or ())}"
                )
            changed.row[name] = value
        return changed

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the plain numbers; the view with names is rebuilt over them."""
        return type(self), (self.numbers, self.row.dtype)

    def values(self) -> dict[str, Any]:
        """Return every field by name."""
        return {item.name: getattr(self, item.name) for item in self.fields}

    def __repr__(self) -> str:
        """Show the single numbers; arrays would fill a screen."""
        shown = ", ".join(f"{item.name}={getattr(self, item.name):g}" for item in self.fields if item.length is None)
        return f"{type(self).__name__}({shown})"


class WireState(Row):
    """All that a wire remembers from one step to the next."""

    time_s: float = field("s", "time since the wire was first at rest")
    temperature_k: float = field("K", "temperature")
    stress_pa: float = field("Pa", "stress of one leg")
    contraction: float = field("1", "contraction relative to the cold length under pretension")
    connector_contraction: float = field(
        "1", "displacement of the connector over the leg's length; above the contraction while friction holds it"
    )
    friction_n: float = field("N", "friction of guide and load, positive against contraction")
    enthalpy_j: float = field("J", "enthalpy, 0 for austenite at 20 C")
    heat_in_j: float = field("J", "electrical heat since the start")
    heat_out_j: float = field("J", "heat lost to the air since the start")
    cycles: float = field("1", "full transformation cycles since the start")
    martensite_fraction: float = field("1", "volume fraction of martensite")
    r_phase_fraction: float = field("1", "volume fraction of R-phase")
    resistance_ohm: float = field("ohm", "resistance")
    front_austenite: FloatArray = field(
        "1", "front below which grains are austenite, in units of the spread, for each class of barrier", CLASSES
    )
    front_martensite: FloatArray = field(
        "1", "front above which grains are martensite; R-phase lies between both fronts", CLASSES
    )
    temperature_slope_k_per_j: float = field("K/J", "slope of temperature over heat in the last step")
    stress_slope_pa_per_j: float = field("Pa/J", "slope of stress over heat in the last step")
    contraction_slope_per_j: float = field("1/J", "slope of contraction over heat in the last step")
    resistance_slope_ohm_per_j: float = field("ohm/J", "slope of resistance over heat in the last step")
    last_heat_j: float = field("J", "heat of the last step")
    carried_heat_j: float = field("J", "heat that the last step owes by the trapezoidal rule; the next one takes it")
    step_s: float = field("s", "length of step that the tolerance asks for next; 0 before the first")
    step_error_k: float = field("K", "largest estimated error of a step in temperature since the start")
    evaluations: float = field("1", "evaluations of the balances since the start")
    unsolved_steps: float = field("1", "steps since the start whose balances were not met")
    front_trial: FloatArray = field(
        "1, 1/K, 1/Pa",
        "fronts of the solution in progress, with their slopes over temperature and stress",
        CLASS_SLOPES,
    )

    @property
    def slack(self) -> float:
        """Length by which friction holds the connector ahead of the slack wire, over the leg's length."""
        return self.connector_contraction - self.contraction


CONVECTION_POINTS = 301
NO_LOAD_TABLE = np.zeros((2, 2))
NO_CELLS = np.zeros((1, 1, 4))


class WireConstants(Row):
    """Everything that does not change while a wire runs, built by ``wire._building``.

    Its plain numbers are one row, in the order of its fields; the two tables are not in it: the load's length differs
    from load to load, and many wires share one distribution.
    """

    # Force of the load in addition to pretension and spring, and friction in addition to the guide's, (2, n_points), at
    # displacements of 0, 1, 2... times ``load_step_m``.
    load_table_n: FloatArray
    # Coefficients of a cubic in each cell of the grains' thresholds, (classes, n_cells, 4), or (1, n_cells, 4) for all.
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
        """Return row, distribution and load as arrays of one record: tables as records cost no reference counting."""
        return self.derived.row, as_record(self.distribution_cells), as_record(self.load_table_n)


class StepConstants(Row):
    """Numbers that a step reads, derived from :class:`WireConstants`: products and reciprocals made once."""

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
