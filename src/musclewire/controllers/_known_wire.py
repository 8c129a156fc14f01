"""What is known of a wire: the power that holds it on both branches, and the heat that a change of it takes.

A wire in air is a first-order heat balance with hysteresis behind it:

    tau dw/dt = P - w - lambda dS/dt,   w = G (T - T_air)

P is the electrical power, w the power that would hold the present temperature, S the quantity and lambda the heat that
one unit of it takes. S rises only while w is on the heating branch w_h(S) and falls only on the cooling branch w_c(S);
between them it stands still. Both branches are known from a slow loop. A PI on that has by SIMC (Skogestad 2003, doi
10.1016/S0959-1524(02)00062-8) the gain K_c = (tau dw/dS + lambda) / (tau_c + theta), and T_i = min(tau_e, 4 (tau_c +
theta)).
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Any, ClassVar, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled_inner
from musclewire.controllers._schema import StrictModel

Positive = Annotated[float, Field(gt=0.0)]
# Times of a loop: a day is longer than any; beyond, an integral would be none.
Seconds = Annotated[float, Field(gt=0.0, le=86400.0)]
Table = Annotated[tuple[Positive, ...], Field(min_length=3)]
# Bounds of a branch's slope, over its median: near the ends of the loop it is that of few samples.
FLATTEST = 0.5
STEEPEST = 4.0
SMOOTHED_LEVELS = 5


class FeedforwardSettings(StrictModel):
    """The gains of a wire: what is known of it, and how fast it is to follow; ``musclewire.tune`` finds all of it.

    Parameters
    ----------
    quantity
        "strain", "displacement" or "force": the unit of ``lowest`` and ``highest``.
    lowest
        First level of the tables, in the quantity's SI unit.
    highest
        Last level of the tables; the levels between are evenly spaced.
    heating_power_w
        Electrical power [W] that holds each level on the heating branch.
    cooling_power_w
        The same [W] on the cooling branch, at no level above that of heating.
    resistance_ohm
        Resistance of the wire [ohm] at each level.
    shunt_resistance_ohm
        R of Eq. 1 [ohm], in series with the wire.
    thermal_time_constant_s
        Heat capacity over heat loss to the air [s].
    heat_per_unit
        Heat [J] that the transformation takes for one unit of the quantity.
    closed_loop_time_s
        tau_c [s]; SIMC recommends the dead time.
    dead_time_s
        theta [s]: from a command to its effect on the estimate.
    integral_time_s
        T_i [s].
    maximum_steady_power_w
        Power [W] in the heat balance at the highest permitted temperature, in the air of the characterization.

    Raises
    ------
    CallerError
        For an unknown key, tables of different length, branches that cross, a number that is not positive, or a time of
        more than a day.
    """

    of_controller: ClassVar[str] = "inverse-model"
    quantity: str = "strain"
    lowest: float
    highest: float
    heating_power_w: Table
    cooling_power_w: Table
    resistance_ohm: Table
    shunt_resistance_ohm: Positive
    thermal_time_constant_s: Seconds
    heat_per_unit: Annotated[float, Field(ge=0.0)]
    closed_loop_time_s: Seconds
    dead_time_s: Seconds
    integral_time_s: Seconds
    maximum_steady_power_w: Positive

    @model_validator(mode="after")
    def _tables_fit_together(self) -> Self:
        if self.highest <= self.lowest:
            raise ValueError(f"highest ({self.highest:g}) must be above lowest ({self.lowest:g})")
        lengths = {len(self.heating_power_w), len(self.cooling_power_w), len(self.resistance_ohm)}
        if len(lengths) != 1:
            raise ValueError(f"the three tables must have one length, not {sorted(lengths)}")
        if any(c > h for h, c in zip(self.heating_power_w, self.cooling_power_w, strict=True)):
            raise ValueError(
                "cooling_power_w is above heating_power_w at a level: the branches are swapped, exchange the two rows"
            )
        for low, high in (pair for row in (self.heating_power_w, self.cooling_power_w) for pair in pairwise(row)):
            if high < low:
                raise ValueError(
                    f"the power of a branch must not fall from level to level, as from {low:g} to {high:g} W"
                )
        return self

    @property
    def levels(self) -> FloatArray:
        """Levels of the tables, in the quantity's unit, (n,)."""
        return np.linspace(self.lowest, self.highest, len(self.heating_power_w))

    def branch_slopes(self) -> tuple[FloatArray, FloatArray]:
        """Return dw/dS of heating and cooling branch [W per unit of the quantity], smoothed and limited."""
        return smoothed_slope(self.heating_power_w, self.levels), smoothed_slope(self.cooling_power_w, self.levels)


def smoothed_slope(power_w: tuple[float, ...], levels: FloatArray) -> FloatArray:
    """Return the slope of a branch over its levels, a mean of five, within bounds about its median."""
    half = SMOOTHED_LEVELS // 2
    padded = np.pad(np.gradient(np.asarray(power_w), levels), half, mode="edge")
    slope = np.convolve(padded, np.full(SMOOTHED_LEVELS, 1.0 / SMOOTHED_LEVELS), "valid")
    middle = float(np.median(slope))
    return np.asarray(np.clip(slope, FLATTEST * middle, STEEPEST * middle))


def known_numbers(settings: FeedforwardSettings) -> dict[str, Any]:
    """Return what is known of a wire by the names of ``SETTINGS`` and ``TABLES``, without the limits of the drive."""
    heating_slope, cooling_slope = settings.branch_slopes()
    return settings.model_dump() | {
        "response_s": settings.closed_loop_time_s + settings.dead_time_s,
        "spacing": (settings.highest - settings.lowest) / (len(settings.heating_power_w) - 1),
        "heating_slope": heating_slope,
        "cooling_slope": cooling_slope,
    }


# The numbers that a compiled tick reads; its tables follow, a row each.
SETTINGS = np.dtype(
    [
        (name, np.float64)
        for name in (
            *("sense_voltage_v", "maximum_voltage_v", "shunt_resistance_ohm", "thermal_time_constant_s"),
            *("heat_per_unit", "response_s", "integral_time_s", "maximum_steady_power_w", "lowest", "spacing"),
        )
    ]
)
TABLES = ("heating_power_w", "cooling_power_w", "resistance_ohm", "heating_slope", "cooling_slope")
N_TABLES = len(TABLES)
HEATING, COOLING, RESISTANCE, HEATING_SLOPE, COOLING_SLOPE = range(N_TABLES)
N_SETTINGS = len(SETTINGS.names or ())
# A record; mypy knows no fields of one.
Row = Any


class KnownWire(NamedTuple):
    """What is known of a wire: a record of ``SETTINGS``, and the tables, a row each with a number for every level."""

    settings: Row
    tables: FloatArray


@compiled_inner
def table_value(wire: KnownWire, table: int, value: float) -> float:
    """Return a table at a value of the quantity, linear between its levels and constant beyond them."""
    levels = wire.tables[table]
    last = levels.size - 1
    place = min(max((value - wire.settings["lowest"]) / wire.settings["spacing"], 0.0), float(last))
    left = min(int(place), last - 1)
    return float(levels[left] + (place - left) * (levels[left + 1] - levels[left]))


@compiled_inner
def edge_w(wire: KnownWire, place: float, value: float) -> float:
    """Return the power that holds a value at a place between the cooling branch (-1) and the heating branch (1)."""
    heating, cooling = table_value(wire, HEATING, value), table_value(wire, COOLING, value)
    return float(0.5 * ((1.0 + place) * heating + (1.0 - place) * cooling))


@compiled_inner
def power_w(wire: KnownWire, drive_voltage_v: float, value: float) -> float:
    """Return the electrical power in the wire at a drive voltage."""
    resistance = table_value(wire, RESISTANCE, value)
    current = drive_voltage_v / (resistance + wire.settings["shunt_resistance_ohm"])
    return float(current * current * resistance)


@compiled_inner
def heat_per_value(wire: KnownWire, table: int, value: float) -> float:
    """Return the heat that moves the quantity by one on a branch: to warm the wire and to transform it."""
    return float(
        wire.settings["thermal_time_constant_s"] * table_value(wire, table, value) + wire.settings["heat_per_unit"]
    )


@compiled_inner
def set_drive(wire: KnownWire, state: Row, value: float, given_w: float, lowest_w: float, highest_w: float) -> None:
    """Set the drive voltage of a power; at a limit of the power exactly that of the drive."""
    if given_w == lowest_w:
        state["drive_voltage_v"] = wire.settings["sense_voltage_v"]
    elif given_w == highest_w:
        state["drive_voltage_v"] = wire.settings["maximum_voltage_v"]
    elif given_w != state["power_w"]:
        resistance = table_value(wire, RESISTANCE, value)
        drive_v = math.sqrt(given_w / resistance) * (resistance + wire.settings["shunt_resistance_ohm"])
        state["drive_voltage_v"] = min(
            max(drive_v, wire.settings["sense_voltage_v"]), wire.settings["maximum_voltage_v"]
        )
    state["power_w"] = given_w
