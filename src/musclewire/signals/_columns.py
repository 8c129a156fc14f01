"""The columns a recording may have: one name, one SI unit, one meaning each.

Files of other programs use other names; ``data/synonyms.toml`` lists those that are recognised.
"""

from __future__ import annotations

import functools
import importlib.resources
import re
import tomllib
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, Literal

from musclewire.errors import CallerError, nearest_hint

ColumnKind = Literal["time", "electrical", "reference", "control", "table"]


@dataclass(frozen=True)
class Column:
    """One column: its name, SI unit as pint spells it ("" when dimensionless), meaning and kind."""

    name: str
    unit: str
    description: str
    kind: ColumnKind


_ALL = (
    Column("time_s", "s", "time since the recording began; must rise", "time"),
    Column("drive_voltage_v", "V", "voltage commanded across wire and shunt", "electrical"),
    Column("wire_voltage_v", "V", "voltage measured across the wire (V_SMA)", "electrical"),
    Column("shunt_voltage_v", "V", "voltage measured across the shunt resistor (V_R)", "electrical"),
    Column("wire_current_a", "A", "current through the wire, instead of a shunt voltage", "electrical"),
    Column("wire_resistance_ohm", "ohm", "resistance of the wire, instead of voltages", "electrical"),
    Column("reference_strain", "", "strain from an instrument, contraction positive", "reference"),
    Column("displacement_m", "m", "displacement from an instrument, contraction positive", "reference"),
    Column("force_n", "N", "force from a load cell", "reference"),
    Column("endpoint_displacement_m", "m", "displacement of a finger's endpoint, bending positive", "reference"),
    Column("endpoint_force_n", "N", "force on a finger's endpoint; absent if it can touch nothing", "reference"),
    Column("stress_pa", "Pa", "tensile stress in the wire", "reference"),
    Column("wire_temperature_k", "K", "temperature of the wire", "reference"),
    Column("ambient_temperature_k", "K", "temperature of the air around the wire", "reference"),
    Column("target_strain", "", "target strain of the controller", "control"),
    Column("target_displacement_m", "m", "target displacement of the controller", "control"),
    Column("target_force_n", "N", "target force of the controller", "control"),
    Column("estimated_strain", "", "strain estimated from resistance", "control"),
    Column("estimated_displacement_m", "m", "displacement estimated from resistance", "control"),
    Column("estimated_force_n", "N", "force estimated from resistance", "control"),
    Column("estimate_std", "", "standard deviation of the estimate, in the unit of its quantity", "control"),
    Column(
        "announced_miss",
        "",
        "how far from its target a wire is at best, by the speed limits said before the run, in the quantity's unit",
        "control",
    ),
    Column("resistance_misfit_ohm", "ohm", "resistance that hypotheses expect less the measured one", "control"),
    Column("estimated_temperature_k", "K", "temperature of the wire, estimated by its heat balance", "control"),
    Column("convection_ratio", "", "estimated loss to the air over that of the characterization", "control"),
    Column("air_shift_w", "W", "estimated power that the air takes off what holds each strain", "control"),
    Column("balance_power_w", "W", "estimated power that would hold the wire's temperature in still air", "control"),
    Column("wire_power_w", "W", "electrical power in the wire over the sample, as measured", "control"),
    Column("heating_part", "", "where between its branches the wire is: 0 cooling, 1 heating", "control"),
    Column("ambient_change_k", "K", "estimated change of the air's temperature since the characterization", "control"),
    Column("load_change_n", "N", "estimated change of the load's constant force since the characterization", "control"),
    Column("stiffness_ratio", "", "estimated stiffness of the load over that of the characterization", "control"),
    Column("changed_air", "", "probability that the air has changed, in temperature or flow", "control"),
    Column("changed_load", "", "probability that force or stiffness of the load has changed", "control"),
    Column("health", "", "what is wrong: 0 nothing known, 1 saturation, 2 load, 3 air, 4 wire, 5 stalled", "control"),
    Column("target_grip_force_n", "N", "target of the force between fingers and object", "control"),
    Column("estimated_grip_force_n", "N", "force between fingers and object estimated from resistance", "control"),
    Column("contact_score", "", "evidence for contact against no contact, in standard deviations", "control"),
    Column("contact", "", "1 once contact has been found, 0 before", "control"),
    Column("valid", "", "1 if the estimate is valid, 0 if not", "control"),
    Column("proportional_gain", "", "proportional gain at this tick", "control"),
    Column("integral_gain", "", "integral gain at this tick", "control"),
    Column("derivative_gain", "", "derivative gain at this tick", "control"),
    Column("steady_power_w", "W", "steady power by which the controller holds the wire", "control"),
    Column("pending_heat_j", "J", "heat that the controller has still to give, or to let go", "control"),
    Column("gain_factor", "", "part of its gain that a controller of versions before 0.2 used", "control"),
    Column("beyond_c", "", "1 while a controller of versions before 0.2 lowered the drive", "control"),
    Column("power_limited", "", "1 while no more power is given, since that holds the highest temperature", "control"),
    Column("lag_s", "s", "by how much later than expected a wire followed, in versions before 0.2", "control"),
    Column(
        "resistance_factor",
        "",
        "factor on the resistance that the estimator saw, by the height of B or by a known strain",
        "control",
    ),
    Column(
        "slow_correction",
        "",
        "a late correction, of versions before 0.2: 0 none due, 1 applied, 2 late, 3 failed",
        "control",
    ),
    Column("pulse_duration_s", "s", "length of the pulse that a row is of", "table"),
    Column("cold_resistance_ohm", "ohm", "resistance before the pulse that a row is of", "table"),
    Column("cycle", "", "number of the cycle this row belongs to; 0 in a minor loop after them", "control"),
    Column("resistance_ohm", "ohm", "resistance at which both branches are given", "table"),
    Column("strain_heating", "", "strain on the heating branch at this resistance", "table"),
    Column("strain_cooling", "", "strain on the cooling branch at this resistance", "table"),
)

# How columns of others' estimators and controllers are named. One of the second kind is known in any program and file,
# one of the first where the estimator is, and in files that musclewire has written.
OWN_NAME = re.compile(r"[a-z][a-z0-9]*(?:_[a-z0-9]+)*")
EXTRA_NAME = re.compile(r"extra_[a-z0-9]+(?:_[a-z0-9]+)*")
# What every loop records as well, and the one electrical column that an estimator records, too.
OF_THE_LOOP = frozenset({"estimate_std", "valid"}) | {
    f"{what}_{quantity}" for what in ("target", "estimated") for quantity in ("strain", "displacement_m", "force_n")
}
OF_THE_ESTIMATE = "wire_resistance_ohm"
UNIT_ENDINGS = {
    "s": "s",
    "v": "V",
    "a": "A",
    "ohm": "ohm",
    "m": "m",
    "n": "N",
    "k": "K",
    "pa": "Pa",
    "w": "W",
    "j": "J",
}


class _Columns(dict[str, Column]):
    """All columns by name; one of others is created when it is looked up, if it is declared or begins with extra_."""

    declared: ClassVar[set[str]] = set()

    def __missing__(self, name: str) -> Column:
        """Return a column of others. Raises KeyError for any other name."""
        if name not in self:
            raise KeyError(name)
        words = name.removeprefix("extra_").split("_")
        unit = UNIT_ENDINGS.get(words[-1], "") if len(words) > 1 else ""
        return Column(name, unit, "recorded by an estimator or controller of another package", "control")

    def get(self, name: str, default: Any = None) -> Any:
        """Return a column by its name, one of others included, or a default."""
        try:
            return self[name]
        except KeyError:
            return default

    def __contains__(self, name: object) -> bool:
        """Return whether a recording may have a column of this name."""
        of_others = isinstance(name, str) and (name in self.declared or EXTRA_NAME.fullmatch(name) is not None)
        return super().__contains__(name) or of_others


COLUMNS: Mapping[str, Column] = MappingProxyType(_Columns({column.name: column for column in _ALL}))

# Three kinds of table have no clock, and these columns stand in for one: a printed loop; what a test machine writes
# while it heats and cools a wire under constant stress, where only the order of the rows counts; pulses, a row each.
BRANCH_TABLE = ("resistance_ohm", "strain_heating", "strain_cooling")
ISOBAR_TABLE = ("wire_temperature_k", "reference_strain", "stress_pa")
PULSE_TABLE = ("pulse_duration_s", "wire_current_a", "wire_resistance_ohm")


def needs_no_clock(names: Collection[str]) -> bool:
    """Return whether columns of these names make a table without ``time_s``."""
    return any(set(table) <= set(names) for table in (BRANCH_TABLE, ISOBAR_TABLE, PULSE_TABLE))


def known_column(name: str) -> Column:
    """Return the column called ``name``; raises CallerError with the nearest name if there is none."""
    try:
        return COLUMNS[name]
    except KeyError:
        raise CallerError(f"unknown column '{name}'{nearest_hint(str(name), COLUMNS)}") from None


def check_columns(kind: Any, whose: str) -> None:
    """Declare the columns that an estimator or controller records, or its class; CallerError for one that cannot be."""
    names = getattr(kind, "columns", ())
    for name in names if isinstance(names, tuple) else ():
        if not (isinstance(name, str) and OWN_NAME.fullmatch(name)):
            raise CallerError(
                f"{whose} records {name!r}: a column is named by words in lower case, joined by _, of which the last "
                "is its unit if it has one, as play_power_w"
            )
        declare_column(name)
        known = COLUMNS[name]
        measured = known.kind != "control" and name != OF_THE_ESTIMATE
        if measured or name in OF_THE_LOOP or names.count(name) > 1:
            is_taken = "twice" if names.count(name) > 1 else f"which is already the {known.description}"
            raise CallerError(f"{whose} records '{name}', {is_taken}: give its column a name of its own")


def declare_column(name: str) -> bool:
    """Let recordings of this program have a column of others. Return whether it can be named so."""
    if name not in COLUMNS and OWN_NAME.fullmatch(name):
        _Columns.declared.add(name)
    return name in COLUMNS


def key_of_header(text: str) -> str:
    """Return a header as it is compared: only its letters and digits, in lower case."""
    return "".join(character for character in text.lower() if character.isalnum())


def columns_called(header_name: str) -> tuple[Column, ...]:
    """Return the columns that a name without its unit may mean, the likeliest first: "T" is a time or a temperature."""
    return _synonyms().get(key_of_header(header_name), ())


@functools.cache
def _synonyms() -> dict[str, tuple[Column, ...]]:
    file = importlib.resources.files("musclewire.signals").joinpath("data/synonyms.toml")
    table = tomllib.loads(file.read_text(encoding="utf-8"))
    found: dict[str, tuple[Column, ...]] = {}
    for name, other_names in table.items():
        for other in other_names:
            key = key_of_header(other)
            found[key] = (*found.get(key, ()), COLUMNS[name])
    return found
