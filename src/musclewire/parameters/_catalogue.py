"""The Flexinol catalogue: every size on sale, whether each number is corroborated, and the wires that follow from it.

The numbers are in ``data/catalogue/flexinol.toml`` in the vendor's units; here they are SI.
"""

from __future__ import annotations

import math
import re
import tomllib
from functools import cache
from importlib.resources import files
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from musclewire.errors import CallerError, nearest_hint
from musclewire.parameters._parameter_groups import Parameter, Wire
from musclewire.parameters._validation import validated

Status = Literal["corroborated", "unverified", "suspect"]
# Wires that start to contract near 70 C and near 90 C.
CLASSES = {"lt": "70 C (LT)", "ht": "90 C (HT)"}
INCH_M = 0.0254
GRAM_FORCE_N = 9.80665e-3
# The highest drive voltage allowed exceeds the largest one needed by this factor.
VOLTAGE_MARGIN = 1.125
# The catalogue's sizes are driven on the paper's bench by default.
DEFAULT_LENGTH_M = 0.14
DEFAULT_SHUNT_OHM = 1.0

Checked = ConfigDict(extra="forbid", frozen=True)


class CatalogueCell(BaseModel):
    """One number of the catalogue, in the vendor's unit, and the source that corroborates it."""

    model_config = Checked

    value: float = Field(gt=0.0, allow_inf_nan=False)
    status: Status
    source: str = ""
    note: str = ""

    @property
    def corroborated(self) -> bool:
        """Whether another source prints the same number."""
        return self.status == "corroborated"


class CatalogueRow(BaseModel):
    """One size of wire. Properties give SI; ``diameter_m`` is the inch size, of which the metric one is a rounding."""

    model_config = Checked

    name: str
    diameter_in: float = Field(gt=0.0)
    diameter_mm: float = Field(gt=0.0)
    holding_lt_ma: float = Field(gt=0.0)
    holding_ht_ma: float = Field(gt=0.0)
    resistance_ohm_per_m: CatalogueCell
    pull_force_g: CatalogueCell
    cooling_force_g: CatalogueCell
    current_ma: CatalogueCell
    cooling_lt_s: CatalogueCell
    cooling_ht_s: CatalogueCell

    @property
    def diameter_m(self) -> float:
        """Diameter of the wire [m]."""
        return self.diameter_in * INCH_M

    @property
    def area_m2(self) -> float:
        """Cross section [m2]."""
        return 0.25 * math.pi * self.diameter_m**2

    @property
    def pull_force_n(self) -> float:
        """Rated pull of the hot wire [N]."""
        return self.pull_force_g.value * GRAM_FORCE_N

    @property
    def cooling_force_n(self) -> float:
        """Force that stretches the cold wire again [N]."""
        return self.cooling_force_g.value * GRAM_FORCE_N

    @property
    def current_a(self) -> float:
        """Current for a contraction in about one second [A]."""
        return 1e-3 * self.current_ma.value

    def cooling_cell(self, wire_class: str) -> CatalogueCell:
        """Return the cell of the cooling time of class 'lt' or 'ht'."""
        return self.cooling_lt_s if wire_class == "lt" else self.cooling_ht_s

    def cells(self) -> list[tuple[str, CatalogueCell]]:
        """Return all cells in the order of the table."""
        pairs = ((key, getattr(self, key)) for key in type(self).model_fields)
        return [(key, item) for key, item in pairs if isinstance(item, CatalogueCell)]


class WireRules(BaseModel):
    """The rules by which a row of the catalogue becomes a wire, stated once for all sizes."""

    model_config = Checked

    alloy: str
    reference_wire: str
    high_temperature_shift_wire: str
    low_temperature_below_high_k: float
    low_temperature_source: str
    largest_stress_mpa: float
    largest_stress_source: str
    holding_source: str


class Catalogue(BaseModel):
    """The whole file."""

    model_config = Checked

    title: str
    source: str
    conditions: str
    wire: WireRules
    row: tuple[CatalogueRow, ...]


@cache
def load_catalogue() -> Catalogue:
    """Return the Flexinol catalogue, checked."""
    file = files("musclewire.parameters") / "data" / "catalogue" / "flexinol.toml"
    return validated(Catalogue, tomllib.loads(file.read_text("utf-8")), "catalogue flexinol")


def catalogue_names() -> list[str]:
    """Return the names of all wires of the catalogue, thinnest first, such as 'flexinol-0.10-ht'."""
    return [f"flexinol-{row.name}-{wire_class}" for row in load_catalogue().row for wire_class in CLASSES]


def catalogue_row(name: str) -> CatalogueRow:
    """Return the row of a wire's name. Raises CallerError for a name that is not in the catalogue."""
    for row in load_catalogue().row:
        if name in {f"flexinol-{row.name}-{wire_class}" for wire_class in CLASSES}:
            return row
    hint = same_size_hint(name) or nearest_hint(name, catalogue_names())
    raise CallerError(f"there is no wire called '{name}' in the catalogue{hint}")


# How people write a diameter: a number, and a unit or none.
METRES_PER = {
    "mm": 1e-3,
    "um": 1e-6,
    "\N{MICRO SIGN}m": 1e-6,
    "\N{GREEK SMALL LETTER MU}m": 1e-6,
    "micron": 1e-6,
    "inch": 25.4e-3,
    "in": 25.4e-3,
    '"': 25.4e-3,
    "mil": 25.4e-6,
    "thou": 25.4e-6,
}
SIZE = re.compile(rf"(\d*\.?\d+)\s*({'|'.join(METRES_PER)})?", re.IGNORECASE)
# A number without a unit is in mm, from here on in um, and below the thinnest wire in inches.
BARE_UM_FROM = 10.0
# A size that is further than this factor from each of the catalogue's is none of them.
NEAR_SIZE = 1.6


def diameter_in_m(name: str) -> float | None:
    """Return the diameter [m] that somebody wrote for a wire's name; of several numbers the one with a unit counts."""
    found = sorted(SIZE.findall(name), key=lambda size: not size[1])
    if not found or float(found[0][0]) == 0.0:
        return None
    number, unit = float(found[0][0]), found[0][1].lower()
    if unit:
        return number * METRES_PER[unit]
    if number >= BARE_UM_FROM:
        return number * METRES_PER["um"]
    thinnest_m = min(row.diameter_m for row in load_catalogue().row)
    return number * METRES_PER["mm" if number * METRES_PER["mm"] > 0.9 * thinnest_m else "in"]


def same_size_hint(name: str) -> str:
    """Return a hint at the catalogue's wire that is nearest to a size, LT unless HT is named; "" without a size."""
    diameter_m = diameter_in_m(name)
    if diameter_m is None:
        return ""
    off, nearest = min((abs(math.log(row.diameter_m / diameter_m)), row.name) for row in load_catalogue().row)
    if off > math.log(NEAR_SIZE):
        return ""
    wire_class = next((one for one in CLASSES if re.search(rf"(?i)(?<![a-z]){one}\b", name)), "lt")
    return f"; did you mean 'flexinol-{nearest}-{wire_class}'?"


def class_of(name: str) -> str:
    """Return 'lt' or 'ht' from a catalogue wire's name."""
    return name.rpartition("-")[2]


def catalogue_wire(name: str, shift_wire: Wire, reference_wire: Wire) -> Wire:
    """Return a size of the catalogue as a wire; each number states its source.

    ``shift_wire`` gives the temperatures of 90 C wire; ``reference_wire`` gives the convection factor, and its
    resistivity counts as 1.
    """
    catalogue = load_catalogue()
    row, wire_class, rules = catalogue_row(name), class_of(name), catalogue.wire
    largest_n = 1e6 * rules.largest_stress_mpa * row.area_m2
    values = {
        "diameter_m": given(row.diameter_m, "m", "datasheet", catalogue.source, f"{row.diameter_in:g} inch"),
        "resistance_per_metre_ohm_per_m": parameter_of_cell(row.resistance_ohm_per_m, "ohm/m", catalogue.source),
        "resistivity_factor": resistivity_factor(row, reference_wire),
        "temperature_shift_k": temperature_shift(wire_class, shift_wire, rules),
        "r_phase_shift_k": given(0.0, "K", "assumed", "the alloy's own R-phase temperature"),
        "martensite_barrier_shift_k": given(0.0, "K", "assumed", "the alloy's own hysteresis"),
        "maximum_force_n": given(largest_n, "N", "derived", rules.largest_stress_source),
        "nominal_force_n": parameter_of_cell(row.cooling_force_g, "N", catalogue.source, GRAM_FORCE_N),
        "convection_factor": reference_wire.convection_factor.model_copy(
            update={"note": f"that of {reference_wire.name}, for a wire in any direction"}
        ),
        **drive_voltages(row, wire_class, rules),
    }
    description = f"Flexinol, {row.name} mm ({row.diameter_in:g} inch), {CLASSES[wire_class]}, from the catalogue"
    return validated(
        Wire, {"name": name, "description": description, "alloy": rules.alloy, **values}, f"catalogue wire {name}"
    )


def given(value: float, unit: str, kind: str, source: str, note: str = "") -> dict[str, Any]:
    """Return a parameter as a file states it."""
    return Parameter.model_validate(
        {"value": value, "unit": unit, "kind": kind, "source": source, "note": note}
    ).model_dump()


def parameter_of_cell(cell: CatalogueCell, unit: str, source: str, to_si: float = 1.0) -> dict[str, Any]:
    """Return a cell as a parameter whose note says whether it is corroborated."""
    where = f"{cell.status}: {cell.source}" if cell.source else cell.status
    return given(cell.value * to_si, unit, "datasheet", source, "; ".join(filter(None, (where, cell.note))))


def resistivity_factor(row: CatalogueRow, reference: Wire) -> dict[str, Any]:
    """Return this size's resistivity over that of the wire to which the alloy's resistivities were fitted."""
    of_reference = reference.resistance_per_metre_ohm_per_m.value * reference.diameter_m.value**2
    factor = row.resistance_ohm_per_m.value * row.diameter_m**2 / of_reference * reference.resistivity_factor.value
    return given(
        factor,
        "1",
        "derived",
        f"resistance per metre times section, over the same of {reference.name}, to which the alloy was fitted",
        f"{row.resistance_ohm_per_m.value:g} ohm/m is {row.resistance_ohm_per_m.status}",
    )


def temperature_shift(wire_class: str, shift_wire: Wire, rules: WireRules) -> dict[str, Any]:
    """Return the stated difference between the temperatures of a class and those of the alloy."""
    shift = shift_wire.temperature_shift_k
    if wire_class == "ht":
        return given(shift.value, "K", "derived", f"that of {shift_wire.name}, whose isobars match 90 C wire")
    return given(
        shift.value - rules.low_temperature_below_high_k,
        "K",
        "derived",
        rules.low_temperature_source,
        f"{rules.low_temperature_below_high_k:g} K below 90 C wire, which is at {shift.value:+g} K",
    )


def drive_voltages(row: CatalogueRow, wire_class: str, rules: WireRules) -> dict[str, Any]:
    """Return amplitude of the slow sine and highest drive voltage for 14 cm in series with 1 ohm."""
    cold_ohm = row.resistance_ohm_per_m.value * DEFAULT_LENGTH_M + DEFAULT_SHUNT_OHM
    holding_a = 1e-3 * (row.holding_lt_ma if wire_class == "lt" else row.holding_ht_ma)
    holding_v, one_second_v = holding_a * cold_ohm, row.current_a * cold_ohm
    return {
        "drive_amplitude_v": given(holding_v, "V", "derived", rules.holding_source, "for 14 cm behind 1 ohm"),
        "maximum_voltage_v": given(
            VOLTAGE_MARGIN * max(holding_v, one_second_v),
            "V",
            "derived",
            "an eighth above the larger of the slow sine's amplitude and what the one-second current needs cold",
            "for 14 cm behind 1 ohm; held for long it may overheat the wire",
        ),
    }
