"""One model of a wire from its slow loop: power and resistance on both branches, and the heat that a change takes.

A wire in air is a first-order heat balance with a play behind it, as the controller inverse-model has it:

    tau dw/dt = P - w - lambda dS/dt

P is the electrical power and w the power that would hold the present temperature. S rises only while w is on the
heating branch w_h and falls only on the cooling branch w_c; between them it rests, which is all the memory there is.
Each branch has a resistance, too, and at one S it changes with w in proportion from one to the other.

Below B the quantity hardly changes while the wire warms. There the place on a branch goes on with the power alone, by
the branch's own slope, so that one coordinate, the place v, runs from the cold wire to the hottest one: v is S over
its largest value from B on, and less than at B before it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, TypeVar

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, argument
from musclewire.sensing._branch_equations import evaluate
from musclewire.sensing._fit_report import FittedCurve, Rows
from musclewire.sensing._wire_balance import (
    ANY_LAW,
    HeatBalanceFound,
    WireMotion,
    heat_balance_of,
    law_of_minor_loops,
    steady_power_w,
)
from musclewire.sensing._wire_tables import PLACES, WireModel, WireNumber

FittedCurveKind = TypeVar("FittedCurveKind", bound=FittedCurve)

# What a closed loop runs unless another is named (docs/explanation/decisions/estimators-in-a-loop.md).
DEFAULT_ESTIMATOR = "filter"
# The one with which the paper's figures were made.
PAPER_ESTIMATOR = "polynomial"
# Branches nearer to each other than this part of the range of power count as that far apart.
MIN_GAP = 0.02
# The resistance of a cold wire rises by temperature alone in this part of its way to B.
COLD_PART = 0.3
NO_LOOP = (
    "the estimator filter needs the slow loop of its wire, and this model keeps none: fit a recording with voltages "
    "from cold to hot and back, or give "
)
NO_RISE = (
    "the slow loop that this model keeps shows no power that rises with the {quantity}, from a cold wire to C: record "
    "it from cold to hot and back, or give "
)
# Said of a number on which the branches of a slow loop do not depend.
SLOW_ENOUGH = "; the loop is so slow that its branches need neither time constant nor heat"


class Half(NamedTuple):
    """Rows of half a slow loop, from the cold wire to C: quantity, steady power [W], resistance; first sensed row."""

    quantity: FloatArray
    power_w: FloatArray
    resistance: FloatArray
    sensed: int

    def over(self, places: FloatArray, first: float, coldest_w: float, largest: float) -> tuple[FloatArray, FloatArray]:
        """Return power and resistance over the places; before the sensed rows a place goes on with the power."""
        power_w = np.maximum.accumulate(self.power_w)
        place = self.quantity / largest
        warmed = (power_w - coldest_w) / (power_w[self.sensed] - coldest_w)
        before = first + (place[self.sensed] - first) * warmed
        place = np.maximum.accumulate(np.where(np.arange(place.size) < self.sensed, before, place))
        moved = np.append(True, np.diff(place) > 0.0)
        over: FloatArray = np.array([np.interp(places, place[moved], one[moved]) for one in (power_w, self.resistance)])
        return over[0], over[1]


def wire_model_of(model: FittedCurve) -> WireModel:
    """Return a model's wire, from its fit or its slow loop. Raises CallerError if there is none from B to C."""
    return model.wire_model if model.wire_model and model.slow_loop else found_wire_model(model)


def default_estimator(model: FittedCurve) -> tuple[str, str]:
    """Return the name of the estimator that a model takes if none is named, and why it is the paper's; "" if not."""
    try:
        wire_model_of(model)
    except CallerError as error:
        return PAPER_ESTIMATOR, f"the paper's estimator, {PAPER_ESTIMATOR}, is taken: {error}"
    return DEFAULT_ESTIMATOR, ""


def with_wire_model(
    model: FittedCurveKind,
    loops: Sequence[Rows] = (),
    motion: WireMotion | None = None,
    minor_loop: WireMotion | None = None,
    stated: tuple[float, float] | None = None,
) -> FittedCurveKind:
    """Return a model with that of its wire, or without if its slow loop shows none; see ``found_wire_model``."""
    try:
        return replace(model, wire_model=found_wire_model(model, loops, motion, minor_loop, stated))
    except CallerError:
        return replace(model, wire_model=None)


def found_wire_model(
    model: FittedCurve,
    loops: Sequence[Rows] = (),
    motion: WireMotion | None = None,
    minor_loop: WireMotion | None = None,
    stated: tuple[float, float] | None = None,
) -> WireModel:
    """Return the model of a wire by its slow loop, other cycles of the recording, and the motion in all of it.

    The law of its minor loops is that of ``minor_loop``, the segment recorded for it, or else of the motion. Deviations
    of the tables are those between cycles, of one cycle the curve's own misfit, and what other heat balances would
    change. Raises CallerError as ``wire_model_of``.
    """
    if not model.slow_loop:
        raise CallerError(NO_LOOP + argument("estimator", "polynomial"))
    known = heat_balance_of(model, motion, stated)
    tau, heat = known
    wire = tables_of(model, model.slow_loop, known)
    changed = [
        known._replace(time_constant_s=replace(tau, value=tau.value + tau.std)),
        known._replace(transformation_heat_j=replace(heat, value=heat.value + heat.std)),
    ]
    others = [one for one in (tables_or_none(model, model.slow_loop, one) for one in changed) if one]
    cycles = [one for one in (tables_or_none(model, rows, known) for rows in loops) if one]
    misfit = model.rmse_average / (model.quantity_max - model.quantity_min)

    def deviated(name: str, unit: float) -> WireNumber:
        number = wire.numbers[name]
        values = [one.numbers[name].value for one in cycles]
        spread = float(np.std(values, ddof=1)) if len(cycles) > 1 else misfit * unit
        by_balance = [one.numbers[name].value - number.value for one in others]
        how = f"between {len(cycles)} cycles" if len(cycles) > 1 else "by the curve's misfit"
        return WireNumber(number.value, math.hypot(spread, *by_balance), f"the slow loop, deviation {how}")

    seen_from = WireNumber(wire.sensed_from.value, misfit, "the slow loop, deviation by the curve's misfit")
    range_w = wire.heating_power_w[-1] - wire.heating_power_w[0]
    moved_w = [float(np.abs(one.tables[:, :2] - wire.tables[:, :2]).max()) for one in others]
    turning = minor_loop or motion
    no_need = len(others) == len(changed) and max(moved_w) < MIN_GAP * range_w
    return replace(
        wire,
        phase_resistance=deviated("phase_resistance", 1.0),
        lowest_power_w=deviated("lowest_power_w", range_w),
        highest_power_w=deviated("highest_power_w", range_w),
        sensed_from=seen_from,
        time_constant_s=with_need_in_origin(wire.time_constant_s, no_need),
        heat_j_per_unit=with_need_in_origin(wire.heat_j_per_unit, no_need),
        minor_loops=wire.minor_loops if turning is None else law_of_minor_loops(wire, known, turning),
    )


def with_need_in_origin(number: WireNumber, no_need: bool) -> WireNumber:
    """Return a number that says if the loop was so slow that its branches do not depend on the heat balance."""
    return replace(number, origin=f"{number.origin}{SLOW_ENOUGH if no_need else ''}")


def tables_or_none(model: FittedCurve, rows: Rows, known: HeatBalanceFound) -> WireModel | None:
    """Return what one loop shows, None for one that does not go through B to C with such a heat balance."""
    try:
        return tables_of(model, rows, known)
    except CallerError:
        return None


def tables_of(model: FittedCurve, rows: Rows, known: HeatBalanceFound) -> WireModel:
    """Return what one loop shows of a wire with a heat balance; deviations of what the loop shows are not known yet."""
    largest = model.quantity_max
    heating, cooling = halves_of(model, rows, known)
    coldest_w = float(min(heating.power_w.min(), cooling.power_w.min()))
    # The cold wire is where heating from B backwards comes to it by its own mean slope.
    risen, rise_w = ((values[-1] - values[heating.sensed]) for values in (heating.quantity, heating.power_w))
    at_b, warmed_w = float(heating.quantity[heating.sensed]), heating.power_w[heating.sensed] - coldest_w
    if not (risen > 0.0 and rise_w > 0.0 and warmed_w > 0.0 and cooling.power_w[cooling.sensed] > coldest_w):
        raise CallerError(NO_RISE.format(quantity=model.quantity) + argument("estimator", "polynomial"))
    first = (at_b - risen / rise_w * warmed_w) / largest
    last = min(float(half.quantity.max()) for half in (heating, cooling)) / largest
    places = np.linspace(first, last, PLACES)
    heating_w, heating_resistance = heating.over(places, first, coldest_w, largest)
    cooling_w, cooling_resistance = cooling.over(places, first, coldest_w, largest)
    cooling_w = np.minimum(cooling_w, heating_w - MIN_GAP * (heating_w[-1] - heating_w[0]))
    sensed_from = model.quantity_min / largest
    rises_by = cooling_resistance - heating_resistance + per_watt(heating) * (heating_w - cooling_w)
    noise_ohm, seen = model.resistance_noise_ohm, "the slow loop"
    return WireModel(
        first_place=float(first),
        place_spacing=float(places[1] - places[0]),
        heating_power_w=tuple(heating_w.tolist()),
        cooling_power_w=tuple(cooling_w.tolist()),
        heating_resistance=tuple(heating_resistance.tolist()),
        cooling_resistance=tuple(cooling_resistance.tolist()),
        time_constant_s=known.time_constant_s,
        heat_j_per_unit=known.transformation_heat_j.times(1.0 / largest),
        resistance_noise_ohm=WireNumber(noise_ohm, noise_ohm / math.sqrt(2.0 * max(model.samples, 1)), seen),
        sensed_from=WireNumber(sensed_from, 0.0, seen),
        phase_resistance=WireNumber(float(rises_by[places > sensed_from].mean()), 0.0, seen),
        minor_loops=ANY_LAW,
        lowest_power_w=WireNumber(float(heating_w[0]), 0.0, seen),
        highest_power_w=WireNumber(float(heating_w[-1]), 0.0, seen),
    )


def halves_of(model: FittedCurve, rows: Rows, known: HeatBalanceFound) -> tuple[Half, Half]:
    """Return both halves of a slow loop, heating and cooling, each from the cold wire to C."""
    time_s, power_w, resistance_ohm = np.array(rows).T
    resistance = (resistance_ohm - model.resistance_min_ohm) / (model.resistance_max_ohm - model.resistance_min_ohm)
    inside = np.clip(resistance, model.normalised_min, model.normalised_max)
    up, down = (evaluate(one, inside) for one in (model.heating_coefficients, model.cooling_coefficients))
    hottest = int(np.argmin(resistance))
    first = sensed_row(resistance[: hottest + 1], model.normalised_max)
    last = resistance.size - 1 - sensed_row(resistance[hottest:][::-1], model.normalised_max)
    up[:first], down[last + 1 :] = up[first], down[last]
    quantity = np.where(np.arange(resistance.size) <= hottest, up, down)
    motion = WireMotion(time_s, power_w, quantity / model.quantity_max, resistance)
    steady_w = steady_power_w(motion, *(number.value for number in known))
    coldest = int(np.argmin(steady_w[: first + 1]))
    up_rows, down_rows = slice(coldest, hottest + 1), slice(None, hottest - 1 if hottest else None, -1)
    return (
        Half(quantity[up_rows], steady_w[up_rows], resistance[up_rows], first - coldest),
        Half(quantity[down_rows], steady_w[down_rows], resistance[down_rows], resistance.size - 1 - last),
    )


def per_watt(heating: Half) -> float:
    """Return how a cold wire's normalised resistance rises with its power [1/W]; 0 if the loop shows no cold wire."""
    b = int(np.argmax(heating.resistance))
    warmed_w = heating.power_w[: b + 1] - heating.power_w[0]
    some = int(np.searchsorted(np.maximum.accumulate(warmed_w), COLD_PART * warmed_w[-1]))
    return float((heating.resistance[some] - heating.resistance[0]) / warmed_w[some]) if warmed_w[some] > 0.0 else 0.0


def sensed_row(resistance: FloatArray, sensed_below: float) -> int:
    """Return the first sensed row on the way from a cold wire to C: past B, which on cooling may be a lower maximum."""
    end = min(sensed_below, float(resistance.max()))
    return int(np.flatnonzero(resistance >= end)[-1])
