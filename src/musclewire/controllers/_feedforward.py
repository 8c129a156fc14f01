"""Feedforward from the inverse model and the heat balance, and gain-scheduled feedback; state in, state out.

A wire in air is a first-order heat balance with hysteresis behind it:

    tau dw/dt = P - w - lambda dS/dt,   w = G (T - T_air)

P is the electrical power, w the power that would hold the present temperature, S the quantity and lambda the heat that
one unit of it takes. S rises only while w is on the heating branch w_h(S) and falls only on the cooling branch w_c(S);
between them it stands still. Both branches are known from a slow loop. So a new target is answered with:

- the steady power of its branch, w_h or w_c, which includes the gap between the branches if the direction turns;
- a pulse of heat, tau times that change plus lambda times the step, delivered as fast as the limits permit. What a
  limit holds back remains due: heating is fast, and cooling is as fast as still air lets it be;
- a PI on the error from where the wire should be by then. Its gain follows direction and strain:
  K_c = (tau dw/dS + lambda) / (tau_c + theta), T_i = min(tau_e, 4 (tau_c + theta)) (SIMC, Skogestad 2003).

Heating from cold is the same: below B resistance does not determine strain, so the heat alone brings the wire there.
No windup: the integral stops at a limit that it would press on. The heat balance of the commanded power never exceeds
that of the highest temperature.

What it cannot know it learns during a run, and says so in the recording:

- the gap: a wire that stands still on the wrong side of its target jumps over a part of it, and half as far from then
  on when that was too far; a target that turns takes no more of it than was given;
- lateness (``lag_s``): how much later than expected the wire is half way at large steps; it is then expected later, and
  SIMC's tau_c and theta both grow by it;
- what the estimate is worth: an error counts for the integral as far as it is above the estimate's deviation, and a
  wire that has come to rest is not pushed about by less;
- an oscillation (``gain_factor``): a drive that swings to and fro at one target halves the gain from then on;
- C (``beyond_c``): where more power than the slow loop ever took makes the estimate fall back, less is tried; if the
  estimate does not fall then, the wire is beyond C, where resistance rises with temperature, and gets no more than
  the slow loop's largest power.

References: Skogestad 2003, doi 10.1016/S0959-1524(02)00062-8, for the rule of K_c and T_i.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inner, row_in
from musclewire.controllers._controller import ControllerSetup, settings_of_kind, step_error
from musclewire.controllers._schema import StrictModel
from musclewire.errors import CallerError
from musclewire.signals import (
    CONTROLLER_ANSWERS,
    UNKNOWN_WIRE,
    CompiledTick,
    ControlStep,
    Drive,
    QuantityEstimate,
    Reason,
)

Positive = Annotated[float, Field(gt=0.0)]
# Times of a loop: a day is longer than any; beyond, an integral would be none.
Seconds = Annotated[float, Field(gt=0.0, le=86400.0)]
Table = Annotated[tuple[Positive, ...], Field(min_length=3)]
# A branch is never taken as flatter or steeper than its median by more than these factors: near the ends of the loop
# its slope is that of few samples.
FLATTEST, STEEPEST = 0.5, 4.0
SMOOTHED_LEVELS = 5


class FeedforwardSettings(StrictModel):
    """What the feedforward controller knows of a wire, and how fast it follows; ``musclewire.tune`` finds all of it.

    Parameters
    ----------
    quantity
        "strain", "displacement" or "force": the unit of ``lowest``, ``highest`` and ``tolerance``.
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
    pulse_time_s
        Time constant [s] of the pulse of heat; three samples.
    tolerance
        Error, in the quantity's unit, from which a wire that stands still jumps over the gap; the deviation of the
        estimate, where that is larger.
    gap_fraction
        Fraction of the gap that the first jump takes; the rest is the feedback's, as no gap is known exactly.
    maximum_steady_power_w
        Power [W] in the heat balance at the highest permitted temperature, in the air of the characterization.

    Raises
    ------
    CallerError
        For an unknown key, tables of different length, branches that cross, a number that is not positive, or a time of
        more than a day.
    """

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
    pulse_time_s: Seconds = 0.15
    tolerance: Positive
    gap_fraction: Annotated[float, Field(ge=0.0, le=1.0)] = 0.4
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
        """Return the slopes of both branches at each level, smoothed and limited.

        Returns
        -------
        dw/dS of heating and of cooling branch [W per unit of the quantity], (n,) each.
        """
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


# The numbers that the compiled tick reads, then its state, a record that it changes in place.
SETTINGS = np.dtype(
    [
        (name, np.float64)
        for name in (
            "sense_voltage_v", "maximum_voltage_v", "shunt_resistance_ohm", "thermal_time_constant_s", "heat_per_unit",
            "response_s", "dead_time_s", "integral_time_s", "pulse_time_s", "tolerance", "gap_fraction",
            "maximum_steady_power_w", "lowest", "spacing",
        )
    ]
)  # fmt: skip
# What is due: the drive, its power, the steady power, that of the heat balance, the pulse of heat, and the part of it
# down to which a wire from cold is only heated. Where the wire was when the target came, on which branch, where between
# the branches the steady power given is, and whether the wire stands. Which way the target moved last, for how long it
# has held, and for how long it has moved that way or rested. What was learned: the part of the gap that a jump takes,
# how late the wire follows, the part of the gain that is left, and the largest steady power; by how much the steady
# power has grown without an estimate. Then the watches: of a swinging drive, of a step on its way, and of a wire
# beyond C.
STATE = np.dtype(
    [
        (name, np.float64)
        for name in (
            "started", "drive_voltage_v", "power_w", "steady_w", "balance_w", "pulse_j", "cold_j",
            "target", "start_value", "place", "given", "anchor", "still_s", "jumped", "arrived",
            "way", "held_s", "since_s",
            "known_gap", "lag_s", "gain_factor", "ceiling_w", "blind_w",
            "swing", "extreme_v", "reversals", "calm_s",
            "step", "expected_s", "lagged",
            "highest", "doubts", "probing_s", "probe_w", "beyond_c", "power_limited",
        )
    ]
)  # fmt: skip
TABLES = ("heating_power_w", "cooling_power_w", "resistance_ohm", "heating_slope", "cooling_slope")
N_TABLES = len(TABLES)
HEATING, COOLING, RESISTANCE, HEATING_SLOPE, COOLING_SLOPE = range(N_TABLES)
N_SETTINGS = len(SETTINGS.names or ())
NO_CURRENT, COLD, NOT_READY = float(Reason.NO_CURRENT), float(Reason.COLD), float(Reason.NOT_READY)
# A wire counts as still that has moved by less than half the tolerance for this long [s]: two samples of 50 ms, so
# motion that has just turned does not count as standing.
STILL_S = 0.09
# Of an error e the part |e| / (|e| + DOUBT times the deviation of the estimate) counts for the integral. While one
# target holds, and the error is within that deviation, the steady power changes by no more than this part of itself
# per second: an estimator that takes its branch from the power would take more for a turn, and the loop would answer
# its own doing.
DOUBT, SETTLED_S, CREEP_PER_S = 2.0, 2.0, 0.005
# A target rests that has held for so long [s]; pauses between the samples of a moving one are shorter.
REST_S = 1.0
# From cold, errors count once this part of the heat is left.
FROM_COLD = 0.35
# Lateness is measured at steps above so many tolerances, up to the longest that a wire which need not cross the gap
# has, and each counts for half; half of it goes into where the wire is expected.
LARGE_STEP, LATEST_S, LEARNT, LAG_PART = 3.0, 0.4, 0.5, 0.5
# Power above the slow loop's largest, and time constants of the air for which less is tried, to find a wire beyond C.
HOTTER, PROBE_TIME_CONSTANTS = 1.05, 1.5
# An oscillation: so many reversals of more than this swing [V], each within a time [s] of the one before, from a second
# after the target turned or came to rest on. Three come within 3 s at the periods of 0.4 to 2 s that dead times up to
# 0.3 s give.
OSCILLATION_REVERSALS, SWING_V, SETTLING_S, MAX_HALF_PERIOD_S = 3.0, 0.5, 1.0, 1.5
MIN_GAIN = 0.0625
PowerLimits = tuple[float, float, float]
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
def power_limits_w(wire: KnownWire, value: float, ceiling_w: float) -> PowerLimits:
    """Return the power of the lowest and of the highest drive, and the highest steady one: a limit's, or a ceiling."""
    lowest_w = power_w(wire, wire.settings["sense_voltage_v"], value)
    highest_w = power_w(wire, wire.settings["maximum_voltage_v"], value)
    return lowest_w, highest_w, max(min(highest_w, ceiling_w), lowest_w)


@compiled_inner
def heat_per_value(wire: KnownWire, table: int, value: float) -> float:
    """Return the heat that moves the quantity by one on a branch: to warm the wire and to transform it."""
    return float(
        wire.settings["thermal_time_constant_s"] * table_value(wire, table, value) + wire.settings["heat_per_unit"]
    )


@compiled
def feedforward_tick(constants: FloatArray, state: FloatArray, given: FloatArray, answer: FloatArray) -> None:
    """Control by feedforward of power and heat, and by a PI on what that leaves."""
    state_row = row_in(state, STATE)
    wire = KnownWire(row_in(constants, SETTINGS), constants[N_SETTINGS:].reshape(N_TABLES, -1))
    target, value, std, valid, reason, dt_s = given[:6]
    answer[0], answer[1] = state_row["drive_voltage_v"], 0.0
    answer[2], answer[3] = state_row["steady_w"], state_row["pulse_j"]
    answer[4], answer[5], answer[6] = state_row["gain_factor"], state_row["beyond_c"], state_row["lag_s"]
    answer[7] = state_row["power_limited"]
    if reason == NO_CURRENT:
        return
    if not math.isfinite(target - value) or not dt_s > 0.0 or not math.isfinite(dt_s):
        answer[1] = 1.0
        return
    cold = reason in (COLD, NOT_READY)
    if cold:
        value = min(value, wire.settings["lowest"])
    first = state_row["started"] == 0.0
    if first:
        take_over(wire, state_row, value)
    limits_w = power_limits_w(wire, value, state_row["ceiling_w"])
    if target != state_row["target"]:
        new_target(wire, state_row, target, value, first and valid == 0.0, limits_w)
    count_target(state_row, dt_s)
    error = lagged(wire, state_row, expected(wire, state_row, target), value, valid, dt_s) - value
    tolerance = max(wire.settings["tolerance"], std) if valid != 0.0 else math.inf
    # Below B there is no estimate, and no error to act on as long as most of the heat from cold is still to come.
    on_the_way = valid == 0.0 and state_row["pulse_j"] > state_row["cold_j"]
    if on_the_way or probe_beyond_c(wire, state_row, value, error, cold, dt_s):
        error = 0.0
    else:
        cross_the_gap(wire, state_row, value, error, tolerance, dt_s, limits_w)
    if valid != 0.0 and state_row["blind_w"] > 0.0:
        give_back(state_row, limits_w)
    before_w = state_row["steady_w"]
    command(wire, state_row, value, error, std if valid != 0.0 else 0.0, dt_s, limits_w)
    grew_w = state_row["steady_w"] - before_w if valid == 0.0 else 0.0
    state_row["blind_w"] = state_row["blind_w"] + grew_w if state_row["arrived"] == 0.0 else 0.0
    notice_oscillation(state_row, dt_s)
    answer[0], answer[2], answer[3] = state_row["drive_voltage_v"], state_row["steady_w"], state_row["pulse_j"]
    answer[4], answer[5], answer[6] = state_row["gain_factor"], state_row["beyond_c"], state_row["lag_s"]
    answer[7] = state_row["power_limited"]


@compiled_inner
def take_over(wire: KnownWire, state: Row, value: float) -> None:
    """Start from the drive that is applied, as one that has been there for long."""
    state["started"] = 1.0
    state["power_w"] = power_w(wire, state["drive_voltage_v"], value)
    state["steady_w"] = state["balance_w"] = state["power_w"]
    state["target"] = state["start_value"] = state["anchor"] = value
    state["lagged"], state["ceiling_w"] = value, wire.settings["maximum_steady_power_w"]
    state["doubts"], state["cold_j"] = 1.0, math.inf
    state["known_gap"], state["gain_factor"] = wire.settings["gap_fraction"], 1.0


@compiled_inner
def new_target(wire: KnownWire, state: Row, target: float, value: float, cold: bool, limits_w: PowerLimits) -> None:
    """Add what a new target takes: steady power of its branch, and the heat for the way there.

    Of the gap it takes what the other branch needs beyond what was given: a wire that has jumped over a part of the gap
    gets no more than that part taken away again, however many samples a moving target has.
    """
    lowest_w, _, steady_limit_w = limits_w
    side = 1.0 if target > state["target"] else -1.0
    place, given = (state["place"], state["given"]) if state["place"] != 0.0 else (side, side)
    moves = target - state["target"]
    if cold:  # no branch is known of a cold wire: all that the target takes, from A on, where the quantity is 0
        change_w = edge_w(wire, 1.0, target) - state["steady_w"]
        moves = target
    else:
        here_w = edge_w(wire, side, state["target"])
        gap_w = here_w - edge_w(wire, given, state["target"])
        change_w = edge_w(wire, side, target) - here_w + gap_w
    steady_w = min(max(state["steady_w"] + change_w, lowest_w), steady_limit_w)
    warming_j = wire.settings["thermal_time_constant_s"] * (steady_w - state["steady_w"])
    state["pulse_j"] += warming_j + wire.settings["heat_per_unit"] * moves
    if cold:
        state["cold_j"] = FROM_COLD * state["pulse_j"]
    state["probe_w"] += steady_w - state["steady_w"]  # a probe that ends goes back to what this target needs
    state["steady_w"], state["start_value"], state["place"], state["target"] = steady_w, value, side, target
    state["given"], state["arrived"] = side, 0.0
    if side != state["way"] or state["held_s"] >= REST_S:
        state["since_s"] = state["jumped"] = state["swing"] = state["reversals"] = 0.0
        state["beyond_c"] = state["probing_s"] = 0.0
    state["way"], state["held_s"], state["expected_s"] = side, 0.0, -1.0
    state["step"] = target - value if place == side else 0.0


@compiled_inner
def count_target(state: Row, dt_s: float) -> None:
    """Count for how long the target has held, and for the watches since when it has moved one way, or rested.

    Each sample of a moving target is a new one, and a watch that began again with each would never see anything.
    """
    moved = state["held_s"] < REST_S
    state["held_s"] += dt_s
    state["since_s"] += dt_s
    if moved and state["held_s"] >= REST_S:
        state["since_s"], state["swing"], state["reversals"] = state["held_s"], 0.0, 0.0


@compiled_inner
def expected(wire: KnownWire, state: Row, target: float) -> float:
    """Return where the wire should be by now: short of its target by the heat that is still to come."""
    table = HEATING_SLOPE if state["place"] >= 0.0 else COOLING_SLOPE
    short = target - state["pulse_j"] / heat_per_value(wire, table, target)
    return float(min(max(short, min(state["start_value"], target)), max(state["start_value"], target)))


@compiled_inner
def lagged(wire: KnownWire, state: Row, ahead: float, value: float, valid: float, dt_s: float) -> float:
    """Return where the wire should be by now if it follows as late as it has been seen to follow.

    At every large step it is measured by how much later than expected the wire is half way.
    """
    step, half = state["step"], 0.5 * state["step"]
    large = abs(step) > LARGE_STEP * wire.settings["tolerance"]
    if large and state["expected_s"] < 0.0 and (ahead - state["start_value"] - half) * step > 0.0:
        state["expected_s"] = state["held_s"]
    if large and valid != 0.0 and (value - state["start_value"] - half) * step > 0.0:
        if state["expected_s"] >= 0.0:
            late_s = state["held_s"] - state["expected_s"]
            if late_s <= LATEST_S:
                state["lag_s"] += LEARNT * (late_s - state["lag_s"])
        state["step"] = 0.0
    lag_s = LAG_PART * state["lag_s"]
    state["lagged"] += (ahead - state["lagged"]) * dt_s / (dt_s + lag_s)
    return float(state["lagged"])


@compiled_inner
def give_back(state: Row, limits_w: PowerLimits) -> None:
    """Take back, once there is an estimate, by how much the steady power has grown without one on the way to a target.

    A wire that comes from cold seems not to move until B, and what the integral makes of that would take it beyond its
    target. What the steady power grows by after the heat of the way has been given is kept: the air is colder, or
    moves faster, than the slow loop's did.
    """
    state["steady_w"] = max(state["steady_w"] - state["blind_w"], limits_w[0])
    state["blind_w"] = 0.0


@compiled_inner
def cross_the_gap(
    wire: KnownWire, state: Row, value: float, error: float, tolerance: float, dt_s: float, limits_w: PowerLimits
) -> None:
    """Let a wire that stands on the wrong side of its target jump over a part of the gap between the branches.

    Where a jump has taken the wire beyond its target, the gap is smaller than it was taken for: half of it from then
    on.
    """
    lowest_w, _, steady_limit_w = limits_w
    watch(wire, state, value, dt_s)
    side = 1.0 if error > 0.0 else -1.0
    table = HEATING_SLOPE if state["place"] >= 0.0 else COOLING_SLOPE
    pulse_over = abs(state["pulse_j"]) < wire.settings["tolerance"] * heat_per_value(wire, table, state["target"])
    if pulse_over:
        state["arrived"] = 1.0
    still = state["still_s"] >= STILL_S
    far = abs(error) > tolerance
    if pulse_over and still and far and state["place"] * side <= 0.0:
        if state["jumped"] * side < 0.0:
            state["known_gap"] *= 0.5
        state["jumped"] = side
        gap_w = state["known_gap"] * (edge_w(wire, side, value) - edge_w(wire, state["place"], value))
        state["steady_w"] = min(max(state["balance_w"] + gap_w, lowest_w), steady_limit_w)
        state["pulse_j"] += wire.settings["thermal_time_constant_s"] * gap_w
        state["given"] = state["place"] + state["known_gap"] * (side - state["place"])
        state["place"] = side


@compiled_inner
def probe_beyond_c(wire: KnownWire, state: Row, value: float, error: float, cold: bool, dt_s: float) -> bool:
    """Return whether the drive is lowered to see on which side of C the wire is.

    Beyond C resistance rises with temperature, which reads as a wire that falls back, and a loop would heat it all the
    more. So where the power is above all that the slow loop took, and the estimate has fallen back meanwhile, less is
    tried: the estimate of a wire between B and C falls then, and that of one beyond C does not. From then on the wire
    gets no more than the slow loop's largest power. One that is cold of B is not beyond C.
    """
    top_w, little = wire.tables[HEATING][-1], 0.5 * wire.settings["tolerance"]
    if state["probing_s"] == 0.0:
        if cold or not (state["steady_w"] > HOTTER * top_w and error > little):
            state["highest"] = value
            return False
        state["highest"] = max(state["highest"], value)
        if state["highest"] - value < little * state["doubts"]:
            return False
        state["probe_w"], state["highest"], state["pulse_j"] = state["steady_w"], value, 0.0
        state["steady_w"] = edge_w(wire, 1.0, state["target"])
    state["probing_s"] += dt_s
    fallen = cold or state["highest"] - value > little
    if fallen:
        state["steady_w"], state["probing_s"], state["highest"] = state["probe_w"], 0.0, value
        state["doubts"] *= 2.0
        return False
    if state["probing_s"] > PROBE_TIME_CONSTANTS * wire.settings["thermal_time_constant_s"]:
        state["beyond_c"], state["ceiling_w"], state["probing_s"] = 1.0, top_w, 0.0
        return False
    return True


@compiled_inner
def notice_oscillation(state: Row, dt_s: float) -> None:
    """Halve the gain for the rest of the run where the drive swings and the target does not turn."""
    drive_v = state["drive_voltage_v"]
    state["calm_s"] += dt_s
    begins = state["arrived"] == 0.0 or state["since_s"] < SETTLING_S or state["probing_s"] > 0.0
    if begins or state["calm_s"] > MAX_HALF_PERIOD_S:
        state["reversals"] = state["swing"] = state["calm_s"] = 0.0
        state["extreme_v"] = drive_v
        return
    away_v = drive_v - state["extreme_v"]
    if state["swing"] * away_v > 0.0:
        state["extreme_v"] = drive_v
    elif abs(away_v) > SWING_V:
        state["reversals"] += abs(state["swing"])
        state["swing"] = 1.0 if away_v > 0.0 else -1.0
        state["extreme_v"], state["calm_s"] = drive_v, 0.0
    if state["reversals"] >= OSCILLATION_REVERSALS:
        state["reversals"] = 0.0
        state["gain_factor"] = max(0.5 * state["gain_factor"], MIN_GAIN)
        state["known_gap"] *= 0.5


@compiled_inner
def watch(wire: KnownWire, state: Row, value: float, dt_s: float) -> None:
    """Measure for how long the wire has stood still."""
    if abs(value - state["anchor"]) > 0.5 * wire.settings["tolerance"]:
        state["anchor"], state["still_s"] = value, 0.0
    else:
        state["still_s"] += dt_s


@compiled_inner
def command(
    wire: KnownWire, state: Row, value: float, error: float, std: float, dt_s: float, limits_w: PowerLimits
) -> None:
    """Set the drive voltage, then advance integral, pulse and heat balance with the power within the limits."""
    lowest_w, highest_w, steady_limit_w = limits_w
    tau_s = wire.settings["thermal_time_constant_s"]
    # SIMC with the dead time that was seen: tau_c and theta both grow by how late the wire is.
    late_s = max(state["lag_s"] - wire.settings["dead_time_s"], 0.0)
    response_s = (wire.settings["response_s"] + 2.0 * late_s) / state["gain_factor"]
    gain = heat_per_value(wire, HEATING_SLOPE if error > 0.0 else COOLING_SLOPE, value) / response_s
    # With this power the heat balance is at the limit after this sample, not above it.
    warmest_w = steady_limit_w + max(0.0, steady_limit_w - state["balance_w"]) * tau_s / dt_s
    limit_w = max(min(highest_w, warmest_w), lowest_w)
    without_pulse_w = state["steady_w"] + gain * error
    if state["ceiling_w"] < wire.settings["maximum_steady_power_w"]:
        without_pulse_w = min(without_pulse_w, state["ceiling_w"])
    wanted_w = without_pulse_w + state["pulse_j"] / wire.settings["pulse_time_s"]
    given_w = min(max(wanted_w, lowest_w), limit_w)
    limited = wanted_w > limit_w and warmest_w < highest_w and error > wire.settings["tolerance"]
    state["power_limited"] = 1.0 if limited else 0.0
    by_pulse_w = given_w - min(max(without_pulse_w, lowest_w), limit_w)
    state["pulse_j"] -= dt_s * (by_pulse_w + state["pulse_j"] / tau_s)
    integral_w = integrated_w(wire, state, gain, error, std, dt_s)
    if not ((wanted_w > limit_w and integral_w > 0.0) or (wanted_w < lowest_w and integral_w < 0.0)):
        state["steady_w"] = min(max(state["steady_w"] + integral_w, lowest_w), steady_limit_w)
    state["balance_w"] += min(dt_s / tau_s, 1.0) * (given_w - state["balance_w"])
    set_drive(wire, state, value, given_w, lowest_w, highest_w)


@compiled_inner
def integrated_w(wire: KnownWire, state: Row, gain: float, error: float, std: float, dt_s: float) -> float:
    """Return by how much the steady power grows for an error: as far as the estimate is trusted."""
    if error == 0.0:
        return 0.0
    trusted = error * abs(error) / (abs(error) + DOUBT * std)
    integral_w = gain * trusted * dt_s / wire.settings["integral_time_s"] * state["gain_factor"]
    if state["held_s"] > SETTLED_S and abs(error) < std:
        limit_w = CREEP_PER_S * dt_s * state["steady_w"]
        integral_w = min(max(integral_w, -limit_w), limit_w)
    return float(integral_w)


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


class FeedforwardController:
    """Feedforward of steady power and heat, and a gain-scheduled PI; brings a cold wire to its first target at once.

    Parameters
    ----------
    setup
        Limits of the drive, and ``FeedforwardSettings``.

    Raises
    ------
    CallerError
        Without settings, or with those of another controller.
    """

    name = "feedforward"
    _tick, _state = staticmethod(feedforward_tick), STATE
    columns: tuple[str, ...] = (
        *("steady_power_w", "pending_heat_j", "gain_factor", "beyond_c", "lag_s", "power_limited"),
    )
    # The first target is reached from cold within its first second, so it needs no time before the first step.
    approach_s = 0.0

    def __init__(self, setup: ControllerSetup) -> None:
        """Take limits and settings, and pack them for the tick."""
        if setup.settings is None:
            raise CallerError(
                f"the controller {self.name} needs the gains of its wire: fit keeps them in a new model, and for this "
                "one tune finds them: 'musclewire tune MODEL RECORDING', or settings=tune(model, recording).settings"
            )
        self.settings: FeedforwardSettings = settings_of_kind(setup, FeedforwardSettings)
        self.limits = setup.limits
        self._constants = self._packed()
        self.step(self.start(self.limits.sense_voltage_v), 0.0, QuantityEstimate(0.0, 0.0, True), 1.0)

    def _packed(self) -> FloatArray:
        """Return limits, settings and tables as the array that the tick reads."""
        known = known_numbers(self.settings) | {
            "sense_voltage_v": self.limits.sense_voltage_v,
            "maximum_voltage_v": self.limits.maximum_voltage_v,
        }
        numbers = [known[name] for name in SETTINGS.names or ()]
        return np.concatenate([numbers, *(known[name] for name in TABLES)])

    def start(self, drive_voltage_v: float) -> tuple[float, ...]:
        """Return the state before the first estimate: the applied drive [V], within the limits."""
        state = np.zeros(1, self._state)
        state["drive_voltage_v"] = self.limits.clamp(float(drive_voltage_v))
        return tuple(state.view(np.float64).tolist())

    def step(self, state: tuple[float, ...], target: float, estimate: QuantityEstimate, dt_s: float) -> ControlStep:
        """Return the drive for an estimate; without current the last one."""
        numbers, answer = np.array(state), np.zeros(len(CONTROLLER_ANSWERS) + len(self.columns))
        wire = UNKNOWN_WIRE if estimate.wire is None else estimate.wire
        given = np.array((target, *estimate[:4], dt_s, *wire), dtype=np.float64)
        self._tick(self._constants, numbers, given, answer)
        drive_voltage_v, failed, *recorded = answer.tolist()
        if failed:
            raise step_error(target, estimate.value, dt_s)
        return ControlStep(Drive(drive_voltage_v), tuple(numbers.tolist()), tuple(recorded))

    def compiled_tick(self, drive_voltage_v: float) -> CompiledTick:
        """Return ``step`` as a compiled function."""
        return CompiledTick(feedforward_tick, self._constants, np.array(self.start(drive_voltage_v)))
