"""How fast a wire is: time constant and heat of its transformation, as known before and by its own motion.

Before a recording is looked at, both are known from the heat balance that a rig states, from the wire's diameter, or as
widely as the diameters that are sold. At both ends of its motion, where it rests, a wire's resistance follows its
temperature: R = a + b w + c w^2 + d S, with the steady power w(t) of the heat balance along the whole recording. That
holds on the way there and back for the right time constant alone, so that both are found by least squares (Gauss and
Newton, each end's a to d eliminated), what was known before counting as a measurement.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.parameters import load_alloy, load_wire, names
from musclewire.sensing._fit_report import FittedCurve
from musclewire.sensing._wire_tables import WireModel, WireNumber
from musclewire.wire import HeatBalance

# Of a wire whose loop states no heat balance:
TYPICAL_DIAMETER_M = 150e-6  # the size that is sold most often, if none is stated
SOLD_M = (25e-6, 510e-6)  # the thinnest and the thickest Flexinol that is sold
TYPICAL_AIR_K = 295.15  # a room
TYPICAL_MIDDLE_K = 350.0  # under load in the middle of the transformation
# Standard deviations of logarithms:
CORRELATION_STD = 0.15  # of correlations of a wire's loss in calm air (Churchill and Chu 1975: about 15 %)
UNKNOWN_MIDDLE_STD = 0.25  # of middle and air of a wire that no rig knows, from the typical ones
LATENT_STD = 0.3  # of the latent heats of alloys (DSC of NiTi: 15 to 30 J/g)
# Standard deviation of the logarithm of a wire's loss per kelvin, from its cold to its hot end: no motion shows one
# time constant better.
LOSS_STD = 0.1
AT_REST = 0.03  # of the stroke: nearer to one of its ends a wire rests
FEWEST_ROWS = 8  # rows at an end of the stroke: fewer determine no time constant
MIN_NOISE = 1e-5  # of the span of resistance: no reading is better, and no weight larger
MAX_STEP = 0.5  # of a logarithm in one step of Gauss and Newton: a longer one leaves the range in which slopes hold
STEPS = 20  # of Gauss and Newton at most: it converges in a few
HALF_DIFFERENCE = 0.02  # of a logarithm, to either side, over which a slope is a difference
BEGINNINGS = 15  # time constants of which the likeliest begins the search
BEGUN_WITHIN = 2.0  # standard deviations of what was known before, within which these lie
MEASURED = "the motion of this recording"
TURNS_BETWEEN = (0.15, 0.85)  # of the stroke: nearer to an end a turn is that of the loop itself, not of a minor loop
TURN = 0.1  # of the stroke: a smaller motion is no turn
LAWS_DIFFER = 0.02  # of the stroke: rows in which both laws differ by less distinguish none
# Any law between play (0) and scaled copies (1) is as likely.
ANY_LAW = WireNumber(0.5, 1.0 / math.sqrt(12.0), "any law is as likely: no minor loop shows it")


class WireMotion(NamedTuple):
    """A whole recording, each (n_rows,): time [s], power [W], quantity over its largest, normalised resistance."""

    time_s: FloatArray
    power_w: FloatArray
    place: FloatArray
    resistance: FloatArray


class HeatBalanceFound(NamedTuple):
    """Time constant [s] and heat [J] of the whole transformation."""

    time_constant_s: WireNumber
    transformation_heat_j: WireNumber


def heat_balance_of(
    model: FittedCurve, motion: WireMotion | None = None, stated: tuple[float, float] | None = None
) -> HeatBalanceFound:
    """Return a wire's heat balance: what its rig states, or by its diameter and, if there is one, its motion.

    ``stated`` are time constant [s] and heat [J] of the whole transformation, by default those of the model's gains;
    they stay as they are, since the protection is by the same.
    """
    tau_s, per_unit = (model.gains.get(name) for name in ("thermal_time_constant_s", "heat_per_unit"))
    if stated is None and isinstance(tau_s, float) and isinstance(per_unit, float):
        stated = tau_s, per_unit * model.quantity_max
    if stated is not None:
        return balance(*stated, CORRELATION_STD, "the heat balance that its slow loop states")
    known = by_diameter(model)
    return known if motion is None else by_motion(known, motion)


def balance(tau_s: float, heat_j: float, std: float, origin: str) -> HeatBalanceFound:
    """Return a heat balance known before, by the deviation of the logarithm of its time constant."""
    heat_std = math.hypot(std, LATENT_STD)
    return HeatBalanceFound(WireNumber(tau_s, std * tau_s, origin), WireNumber(heat_j, heat_std * heat_j, origin))


def by_diameter(model: FittedCurve) -> HeatBalanceFound:
    """Return the heat balance of a wire that is known by its diameter at best, in still air (Churchill and Chu)."""
    stated_m, name = model.wire.get("wire_diameter_m"), str(model.wire.get("wire", ""))
    is_stated, is_known = isinstance(stated_m, float), name in names("wire")
    by_name_m = load_wire(name).diameter_m.value if is_known else TYPICAL_DIAMETER_M
    size_m = stated_m if isinstance(stated_m, float) else by_name_m
    alloy = load_alloy(load_wire(name).alloy if is_known else "flexinol")
    tau_s, min_s, max_s = (
        HeatBalance.of_wire(alloy, one_m, 1.0, TYPICAL_AIR_K).with_loss_at(TYPICAL_MIDDLE_K).lag_s
        for one_m in (size_m, *SOLD_M)
    )
    middle_ohm = 0.5 * (model.resistance_min_ohm + model.resistance_max_ohm)
    middle_w = float(np.median([power_w for _, power_w, ohm in model.slow_loop if ohm < middle_ohm]))
    latent_k = alloy.latent_heat_j_per_kg.value / alloy.specific_heat_j_per_kg_k.value
    heat_j = tau_s * middle_w * latent_k / (TYPICAL_MIDDLE_K - TYPICAL_AIR_K)
    if is_stated or is_known:
        std = math.hypot(CORRELATION_STD, UNKNOWN_MIDDLE_STD)
        return balance(tau_s, heat_j, std, f"a wire of {1e3 * size_m:.3g} mm in still air")
    sizes = f"{1e3 * SOLD_M[0]:.3g} to {1e3 * SOLD_M[1]:.3g} mm"
    return balance(
        tau_s,
        heat_j,
        math.log(max_s / min_s) / math.sqrt(12.0),
        f"any wire of {sizes} in still air, as no size is stated",
    )


def steady_power_w(motion: WireMotion, time_constant_s: float, heat_j: float) -> FloatArray:
    """Return the power [W] that would hold each row's temperature, (n_rows,): the heat balance, from a steady start."""
    # Where a kelvin loses a watt, temperatures above the air are the powers that hold them.
    time_s, power_w, place, _ = motion
    in_watts = HeatBalance(time_constant_s, loss_w_per_k=1.0, air_k=0.0)
    return in_watts.along_k(time_s, power_w, place, heat_j, float(power_w[0]))


def by_motion(known: HeatBalanceFound, motion: WireMotion) -> HeatBalanceFound:
    """Return a heat balance by least squares of resistance at both ends of the motion, and what was known before."""
    ends = rows_at_rest(motion, 3.0 * known.time_constant_s.value)
    if not ends:
        return known
    tau_s, heat_j = (number.value for number in known)
    tau_std = known.time_constant_s.std / tau_s
    before = np.diag([tau_std**-2.0, LATENT_STD**-2.0])
    first = np.log([tau_s, heat_j / tau_s])
    away = np.linspace(-BEGUN_WITHIN * tau_std, BEGUN_WITHIN * tau_std, BEGINNINGS)
    found = min(
        (first + np.array([one, 0.0]) for one in away),
        key=lambda one: negative_log_likelihood(motion, ends, one, first, before),
    )
    bounded, by_rows = 1.0, np.zeros((2, 2))
    for _ in range(STEPS):
        left = residuals_at_ends(motion, ends, found)
        weights = [row_weight(one) for one in left]
        slopes = np.column_stack(
            [
                weighted(residuals_at_ends(motion, ends, found + away), weights)
                - weighted(residuals_at_ends(motion, ends, found - away), weights)
                for away in HALF_DIFFERENCE * np.eye(2)
            ]
        ) / (2.0 * HALF_DIFFERENCE)
        by_rows = slopes.T @ slopes
        bounded = 1.0 / (1.0 + LOSS_STD**2 * by_rows[0, 0])
        pull = bounded * slopes.T @ weighted(left, weights) + before @ (found - first)
        step = np.clip(-np.linalg.solve(bounded * by_rows + before, pull), -MAX_STEP, MAX_STEP)
        found = found + step
        if np.abs(step).max() < HALF_DIFFERENCE**2:
            break
    covariance = np.linalg.inv(bounded * by_rows + before)
    of_tau, of_heat = covariance[0, 0], covariance.sum()
    value_s, value_j = math.exp(found[0]), math.exp(found.sum())
    return HeatBalanceFound(
        origin_of(known.time_constant_s, value_s, math.sqrt(of_tau)),
        origin_of(known.transformation_heat_j, value_j, math.sqrt(of_heat)),
    )


def negative_log_likelihood(
    motion: WireMotion, ends: list[NDArray[np.intp]], at: FloatArray, first: FloatArray, before: FloatArray
) -> float:
    """Return minus the logarithm of a heat balance's likelihood, at the scatter that it leaves and as known before."""
    left = residuals_at_ends(motion, ends, at)
    of_rows = sum(independent(one) * math.log(max(float(one @ one) / one.size, MIN_NOISE**2)) for one in left)
    return 0.5 * (of_rows + float((at - first) @ before @ (at - first)))


def origin_of(known: WireNumber, value: float, std: float) -> WireNumber:
    """Return a number with the origin that shows more of it: the motion, or what was known before."""
    by_rows = 2.0 * std**2 < (known.std / known.value) ** 2
    return WireNumber(value, std * value, MEASURED if by_rows else known.origin)


def rows_at_rest(motion: WireMotion, settled_s: float) -> list[NDArray[np.intp]]:
    """Return the rows at the cold and at the hot end of the motion, without those before the balance has settled."""
    low, high = np.percentile(motion.place, 1.0), motion.place.max()
    if not high > low:
        return []
    part = (motion.place - low) / (high - low)
    settled = motion.time_s - motion.time_s[0] > settled_s
    ends = [np.flatnonzero(settled & near) for near in (part < AT_REST, part > 1.0 - AT_REST)]
    return [rows for rows in ends if rows.size >= FEWEST_ROWS]


def residuals_at_ends(motion: WireMotion, ends: list[NDArray[np.intp]], logarithms: FloatArray) -> list[FloatArray]:
    """Return what no quadratic in the steady power and no line in the place explains of the resistance, at each end."""
    steady = steady_power_w(motion, math.exp(logarithms[0]), math.exp(logarithms.sum()))
    found = []
    for rows in ends:
        power, read = steady[rows] / motion.power_w.max(), motion.resistance[rows]
        explained = np.column_stack([np.ones(rows.size), power, power**2, motion.place[rows]])
        found.append(read - explained @ np.linalg.lstsq(explained, read, rcond=None)[0])
    return found


def row_weight(left: FloatArray) -> float:
    """Return the weight of an end's rows: by their scatter, and only as many as change sides independently."""
    return math.sqrt(independent(left) / left.size / max(float(left @ left) / left.size, MIN_NOISE**2))


def independent(left: FloatArray) -> float:
    """Return how many residuals count: white noise changes its sign at every other row, what is left out seldom."""
    changes = int(np.count_nonzero(np.diff(np.sign(left))))
    return float(min(max(2 * changes, 2), left.size))


def weighted(left: list[FloatArray], weights: list[float]) -> FloatArray:
    """Return the residuals of all ends in one array, each by its weight."""
    return np.concatenate([one * weight for one, weight in zip(left, weights, strict=True)])


def law_of_minor_loops(wire: WireModel, balance: HeatBalanceFound, motion: WireMotion) -> WireNumber:
    """Return where between play and scaled copies the wire's minor loops are, by least squares; any if it has none.

    One number is one law for all turns: by how much they differ is part of its deviation, and of a single one nobody
    knows it.
    """
    steady = steady_power_w(motion, balance.time_constant_s.value, balance.transformation_heat_j.value)
    # Places below 0 are of a cold wire, whose quantity is that at B whatever its power.
    places = np.maximum(wire.places, 0.0)
    up, down = (np.interp(steady, one, places) for one in (wire.heating_power_w, wire.cooling_power_w))
    largest, ways = float(places[-1]), []
    turns = turns_of(motion.place)
    for turn, following in pairwise(turns[1:]):
        at, rows = float(motion.place[turn]), slice(turn, following)
        if not TURNS_BETWEEN[0] < at < TURNS_BETWEEN[1]:
            continue
        if motion.place[following] < at:
            play, scaled = np.minimum(at, down[rows]), at * down[rows] / largest
        else:
            play, scaled = np.maximum(at, up[rows]), at + (largest - at) * up[rows] / largest
        differ_enough = np.abs(scaled - play) > LAWS_DIFFER
        ways.append(np.array([scaled - play, motion.place[rows] - play])[:, differ_enough])
    apart, moved = np.concatenate(ways, axis=1) if ways else np.empty((2, 0))
    if apart.size < FEWEST_ROWS:
        return ANY_LAW
    squares = float(apart @ apart)
    seen = float(apart @ moved) / squares
    left = moved - seen * apart
    by_rows = max(float(left @ left), MIN_NOISE**2) / squares / independent(left)
    by_turns = [float(one @ (other - seen * one)) ** 2 / float(one @ one) for one, other in ways if one.size]
    # So many turns of equal weight would know as much: one that is cut off short is hardly a second one. To what they
    # show of their differences comes one turn's worth of what was known before: that they differ by any law.
    count = squares**2 / sum(float(one @ one) ** 2 for one, _ in ways)
    precision = 1.0 / (by_rows + sum(by_turns) / squares / count + (ANY_LAW.std / count) ** 2)
    before = ANY_LAW.std**-2.0
    value = (precision * seen + before * ANY_LAW.value) / (precision + before)
    return WireNumber(min(max(value, 0.0), 1.0), (precision + before) ** -0.5, "minor loops of this recording")


def turns_of(place: FloatArray) -> list[int]:
    """Return the rows at which the motion turns, by more than so much, with its first and last."""
    turns, rising = [0], 0.0
    for row in range(1, place.size):
        moved = float(place[row] - place[turns[-1]])
        if rising * moved > 0.0:
            turns[-1] = row
        elif abs(moved) > TURN:
            turns.append(row)
            rising = math.copysign(1.0, moved)
    return [*turns, place.size - 1]
