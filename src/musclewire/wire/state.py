"""The row of a wire: its state, and the constants that do not change while it runs.

Two lists of fields are the only definition. The layout in memory, attributes in Python and in compiled code and
docs/reference/wire_row.md follow from them; a new field is one line here, and the line of the step that writes it.

A row is a NumPy record. Compiled code reads and writes it in place, by attribute; in Python it is read through a class
whose attributes are the fields, and changed only by making another. Many wires are an array of such rows.
"""

from __future__ import annotations

from functools import cache
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError

__all__ = [
    "GRAINS",
    "GRAIN_EDGES",
    "Row",
    "Rows",
    "field",
    "CONVECTION_POINTS",
    "DRIVING_FORCES",
    "FloatArray",
    "RunningWire",
    "Shakedown",
    "WireConstants",
    "WireState",
]

# Records as compiled code takes them, (n_wires,); each element has the fields of its Row as attributes.
Rows = Any

# Array lengths that depend on the number of grains, as the documentation names them, and their excess over it.
GRAINS, GRAIN_EDGES = "grains", "grains + 1"
BEYOND_GRAINS = {GRAINS: 0, GRAIN_EDGES: 1}


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

    def shape(self, grains: int) -> tuple[int, ...]:
        """Return the shape in the row of a wire of so many grains."""
        if self.length is None:
            return ()
        return (self.length,) if isinstance(self.length, int) else (grains + BEYOND_GRAINS[self.length],)


def field(unit: str, meaning: str, length: int | str | None = None) -> Any:
    """Return a field for the body of a :class:`Row`: its SI unit, what it means, and an array's length."""
    return Field(unit, meaning, length)


class Row:
    """A row of named numbers. A subclass lists its fields, ``name: float = field(unit, meaning)``, and nothing else.

    ``row`` is an array of one record, (1,), which is what compiled code takes; a batch is a longer one. Make a row by
    ``of``, ``zeros`` or ``replace``.

    Parameters
    ----------
    numbers
        The plain numbers of the row in the order of its fields, one-dimensional; the row owns them from now on.
    layout
        Their layout in memory: ``layout(grains)``.
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
    def layout(cls, grains: int) -> np.dtype[np.void]:
        """Return the layout in memory of a wire of so many grains; the same object for the same number."""
        # As np.record its records have attributes without compilation, too.
        return np.dtype((np.record, [(item.name, np.float64, item.shape(grains)) for item in cls.fields]))

    @classmethod
    def zeros(cls, grains: int) -> Self:
        """Return a row in which every number is 0."""
        layout = cls.layout(grains)
        return cls(np.zeros(layout.itemsize // np.dtype(np.float64).itemsize), layout)

    @classmethod
    def of(cls, grains: int, **values: object) -> Self:
        """Return a row of these values. Raises CallerError if a field is missing or unknown."""
        missing = [item.name for item in cls.fields if item.name not in values]
        if missing:
            raise CallerError(f"a {cls.__name__} needs {', '.join(missing)}")
        return cls.zeros(grains).replace(**values)

    @property
    def record(self) -> Any:
        """The only record of ``row``, as a compiled function of one wire takes it."""
        return self.row[0]

    @property
    def grains(self) -> int:
        """Number of grains that this row has room for."""
        sized = next(item for item in self.fields if item.length == GRAINS)
        return int(self.row.dtype[sized.name].shape[0])

    def copy(self) -> Self:
        """Return an independent row of the same numbers."""
        return type(self)(self.numbers.copy(), self.row.dtype)

    def replace(self, **changes: object) -> Self:
        """Return a row with other values of some fields. Raises CallerError for an unknown field."""
        changed = self.copy()
        for name, value in changes.items():
            if name not in (changed.row.dtype.names or ()):
                raise CallerError(f"a {type(self).__name__} has no field '{name}'")
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


CONVECTION_POINTS = 301
DRIVING_FORCES = 6
NO_LOAD_TABLE = np.zeros((2, 2))


class WireState(Row):
    """All that a wire remembers from one step to the next.

    Parameters
    ----------
    numbers
        The plain numbers of the row in the order of its fields, one-dimensional.
    layout
        Their layout in memory: ``WireState.layout(grains)``.
    """

    time_s: float = field("s", "time since the wire was first at rest")
    temperature_k: float = field("K", "temperature")
    stress_pa: float = field("Pa", "stress of one leg")
    contraction: float = field("1", "contraction relative to the cold length under pretension")
    friction_n: float = field("N", "friction of guide and load, positive against contraction")
    enthalpy_j: float = field("J", "enthalpy, 0 for austenite at 20 C")
    heat_in_j: float = field("J", "electrical heat since the start")
    heat_out_j: float = field("J", "heat lost to the air since the start")
    cycles: float = field("1", "full transformation cycles since the start")
    martensite_fraction: float = field("1", "volume fraction of martensite")
    r_phase_fraction: float = field("1", "volume fraction of R-phase")
    resistance_ohm: float = field("ohm", "resistance")
    capacity_j_per_k: float = field("J/K", "apparent heat capacity in the last step, latent heat included")
    stress_slope_pa_per_k: float = field("Pa/K", "slope of stress over temperature in the last step")
    temperature_rate_k_per_s: float = field("K/s", "rate of the temperature in the last step")
    resistance_rate_ohm_per_s: float = field("ohm/s", "rate of the resistance in the last step")
    grain_martensite: FloatArray = field("1", "fraction of martensite of each grain", GRAINS)
    grain_r_phase: FloatArray = field("1", "fraction of R-phase of each grain", GRAINS)
    followed_force_k: FloatArray = field(
        "K",
        "thermodynamic driving forces that the grains have followed, in the order of `DrivingForces`",
        DRIVING_FORCES,
    )
    followed_stress_pa: float = field("Pa", "stress of these driving forces")


class WireConstants(Row):
    """Everything that does not change while a wire runs, built by ``wire.building``.

    Parameters
    ----------
    numbers
        The plain numbers of the row in the order of its fields, one-dimensional.
    layout
        Their layout in memory: ``WireConstants.layout(grains)``.
    load_table_n
        Force of the load in addition to pretension and spring, and friction in addition to the guide's [N],
        (2, n_points), at displacements of 0, 1, 2... times ``load_step_m``; by default neither. It is not in the row,
        as its length differs from load to load.
    """

    load_table_n: FloatArray

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
    grain_edges: FloatArray = field("1", "edges of the grains in units of the spread", GRAIN_EDGES)
    grain_middle: FloatArray = field("1", "middle of each grain in units of the spread", GRAINS)
    grain_width: FloatArray = field("1", "width of each grain in units of the spread", GRAINS)

    def __init__(
        self, numbers: FloatArray, layout: np.dtype[np.void], load_table_n: FloatArray = NO_LOAD_TABLE
    ) -> None:
        """Take plain numbers, their layout and a load's table; the default is a plain spring."""
        super().__init__(numbers, layout)
        self.load_table_n = load_table_n

    def copy(self) -> Self:
        """Return independent constants of the same numbers and load."""
        return type(self)(self.numbers.copy(), self.row.dtype, self.load_table_n)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the load's table with the numbers."""
        return type(self), (self.numbers, self.row.dtype, self.load_table_n)


class Shakedown(NamedTuple):
    """Shakedown that remains of a new wire's, and its effects.

    Parameters
    ----------
    remaining
        Remaining fraction: 1 before the first cycle, 0 in the end.
    residual_strain
        Strain that the wire has gained since it was new.
    barrier_factor
        Factor on the barrier between austenite and martensite, 1 or more.
    """

    remaining: float
    residual_strain: float
    barrier_factor: float


class RunningWire(NamedTuple):
    """A wire in compiled code: its two records, of which a step changes the state, load table and shakedown."""

    state: WireState
    constants: WireConstants
    load_table_n: FloatArray
    shakedown: Shakedown
