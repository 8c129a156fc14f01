"""One model of a wire from its slow loop: power and resistance on both branches, and the heat that a change takes.

A wire in air is a first-order heat balance with a play behind it, as the feedforward controller has it:

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
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, argument
from musclewire.parameters import load_alloy, load_wire, names
from musclewire.physics import convection_coefficient_w_per_m2_k
from musclewire.sensing._branch_equations import evaluate
from musclewire.sensing._fit_report import FittedCurve

# Places in the tables of a wire, evenly spaced: about as many as a slow loop has rows on a branch.
PLACES = 128
# Branches nearer to each other than this part of the range of power count as that far apart.
MIN_GAP = 0.02
# By these notes on its wire a model of force, whose gains are those of another quantity, keeps the heat balance.
HEAT_NOTES = ("thermal_time_constant_s", "transformation_heat_j")
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
# Of a wire whose loop states no heat balance: the size that is sold most often, if none is stated, and how warm
# Flexinol under load is in the middle of its transformation.
TYPICAL_DIAMETER_M, TYPICAL_AIR_K, TYPICAL_MIDDLE_K = 150e-6, 295.15, 350.0


class ThermalResponse(NamedTuple):
    """Heat capacity over heat loss [s], heat [J] of the whole transformation, and in words where both are from."""

    time_constant_s: float
    transformation_heat_j: float
    origin: str


@dataclass(frozen=True, eq=False)
class WireModel:
    """What a slow loop shows of a wire besides its resistance curve.

    Parameters
    ----------
    first_place, place_spacing
        The place v of the first row of the tables, and the distance of two rows.
    heating_power_w, cooling_power_w
        Power [W] that holds each place on both branches, (n_places,); both rise.
    heating_resistance, cooling_resistance
        Normalised resistance of each place on both branches, (n_places,).
    sensed_from
        The place of B, from which on resistance shows the quantity.
    balance
        Time constant and heat of the transformation, and what they are known from.
    phase_resistance
        By how much the cooling branch's resistance at one place and temperature is above the heating branch's: the
        difference of both, and what the cold wire's resistance rises by with the power between them.
    """

    first_place: float
    place_spacing: float
    heating_power_w: FloatArray
    cooling_power_w: FloatArray
    heating_resistance: FloatArray
    cooling_resistance: FloatArray
    sensed_from: float
    balance: ThermalResponse
    phase_resistance: float

    @property
    def places(self) -> FloatArray:
        """The places of the tables, (n_places,)."""
        last = self.first_place + self.place_spacing * (self.heating_power_w.size - 1)
        return np.linspace(self.first_place, last, self.heating_power_w.size)

    @property
    def tables(self) -> FloatArray:
        """Powers and resistances of both branches, heating first, (n_places, 4)."""
        return np.column_stack(
            [self.heating_power_w, self.cooling_power_w, self.heating_resistance, self.cooling_resistance]
        )

    @property
    def middle_power_w(self) -> float:
        """Median power [W] of the heating branch where resistance shows the quantity: what noise is a part of."""
        return float(np.median(self.heating_power_w[self.places >= self.sensed_from]))


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
    """Return the model of a wire that its slow loop shows.

    Raises CallerError for a model without a slow loop, or with one that does not go through B to C.
    """
    if not model.slow_loop:
        raise CallerError(NO_LOOP + argument("estimator", "polynomial"))
    balance = heat_balance_of(model)
    largest = model.quantity_max
    heating, cooling = halves_of(model, balance)
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
    return WireModel(
        first_place=float(first),
        place_spacing=float(places[1] - places[0]),
        heating_power_w=heating_w,
        cooling_power_w=cooling_w,
        heating_resistance=heating_resistance,
        cooling_resistance=cooling_resistance,
        sensed_from=sensed_from,
        balance=balance,
        phase_resistance=float(rises_by[places > sensed_from].mean()),
    )


def heat_balance_of(model: FittedCurve) -> ThermalResponse:
    """Return a wire's heat balance: that of its gains, that which a model of force was given, or by its diameter."""
    tau_s, per_unit = (model.gains.get(name) for name in ("thermal_time_constant_s", "heat_per_unit"))
    if isinstance(tau_s, float) and isinstance(per_unit, float):
        return ThermalResponse(tau_s, per_unit * model.quantity_max, "the heat balance that its slow loop states")
    tau_s, heat_j = (model.wire.get(name) for name in HEAT_NOTES)
    if isinstance(tau_s, float) and isinstance(heat_j, float):
        return ThermalResponse(tau_s, heat_j, "the model that it was made from")
    return balance_by_diameter(model)


def balance_by_diameter(model: FittedCurve) -> ThermalResponse:
    """Return the heat balance of a wire that is known by its diameter at best, in still air (Churchill and Chu)."""
    stated_m = model.wire.get("wire_diameter_m")
    size_m = stated_m if isinstance(stated_m, float) else TYPICAL_DIAMETER_M
    name, above_k = str(model.wire.get("wire", "")), TYPICAL_MIDDLE_K - TYPICAL_AIR_K
    alloy = load_alloy(load_wire(name).alloy if name in names("wire") else "flexinol")
    loss_w_per_m2_k = convection_coefficient_w_per_m2_k(TYPICAL_MIDDLE_K, TYPICAL_AIR_K, size_m)
    heat_per_m3_k = alloy.density_kg_per_m3.value * alloy.specific_heat_j_per_kg_k.value
    tau_s = 0.25 * size_m * heat_per_m3_k / loss_w_per_m2_k
    middle_ohm = 0.5 * (model.resistance_min_ohm + model.resistance_max_ohm)
    middle_w = float(np.median([power_w for _, power_w, ohm in model.slow_loop if ohm < middle_ohm]))
    latent_k = alloy.latent_heat_j_per_kg.value / alloy.specific_heat_j_per_kg_k.value
    origin = f"a wire of {1e3 * size_m:.3g} mm in still air"
    return ThermalResponse(tau_s, tau_s * middle_w * latent_k / above_k, origin)


def halves_of(model: FittedCurve, balance: ThermalResponse) -> tuple[Half, Half]:
    """Return both halves of a model's slow loop, heating and cooling, each from the cold wire to C."""
    time_s, power_w, resistance_ohm = np.array(model.slow_loop).T
    resistance = (resistance_ohm - model.resistance_min_ohm) / (model.resistance_max_ohm - model.resistance_min_ohm)
    inside = np.clip(resistance, model.normalised_min, model.normalised_max)
    up, down = (evaluate(one, inside) for one in (model.heating_coefficients, model.cooling_coefficients))
    hottest = int(np.argmin(resistance))
    first = sensed_row(resistance[: hottest + 1], model.normalised_max)
    last = resistance.size - 1 - sensed_row(resistance[hottest:][::-1], model.normalised_max)
    up[:first], down[last + 1 :] = up[first], down[last]
    quantity = np.where(np.arange(resistance.size) <= hottest, up, down)
    steady_w = steady_power_w(time_s, power_w, quantity / model.quantity_max, balance)
    coldest = int(np.argmin(steady_w[: first + 1]))
    up_rows, down_rows = slice(coldest, hottest + 1), slice(None, hottest - 1 if hottest else None, -1)
    return (
        Half(quantity[up_rows], steady_w[up_rows], resistance[up_rows], first - coldest),
        Half(quantity[down_rows], steady_w[down_rows], resistance[down_rows], resistance.size - 1 - last),
    )


def per_watt(heating: Half) -> float:
    """Return by how much the normalised resistance of the cold wire rises with the power that warms it [1/W]."""
    b = int(np.argmax(heating.resistance))
    warmed_w = heating.power_w[: b + 1] - heating.power_w[0]
    some = int(np.searchsorted(np.maximum.accumulate(warmed_w), COLD_PART * warmed_w[-1]))
    return float((heating.resistance[some] - heating.resistance[0]) / warmed_w[some])


def sensed_row(resistance: FloatArray, sensed_below: float) -> int:
    """Return the first sensed row on the way from a cold wire to C: past B, which on cooling may be a lower maximum."""
    end = min(sensed_below, float(resistance.max()))
    return int(np.flatnonzero(resistance >= end)[-1])


def steady_power_w(time_s: FloatArray, power_w: FloatArray, place: FloatArray, balance: ThermalResponse) -> FloatArray:
    """Return the power [W] that would hold each row's temperature: the heat balance along the loop, from its start."""
    steady_w = np.empty_like(power_w)
    steady_w[0] = power_w[0]
    for row, dt_s in enumerate(np.diff(time_s).tolist(), start=1):
        taken_w = balance.transformation_heat_j * (place[row] - place[row - 1]) / dt_s
        given_w = 0.5 * (power_w[row] + power_w[row - 1]) - taken_w
        steady_w[row] = given_w + (steady_w[row - 1] - given_w) * math.exp(-dt_s / balance.time_constant_s)
    return steady_w
