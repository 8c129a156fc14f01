"""The gated estimator: Eq. 1, then the branch of the direction in which the wire is driven.

Samples without current are bridged, another wire's resistance is detected, and on a known spring the guide's
friction is added, all as the paper's estimator does. In contrast to it a reading that no wire of this model can have,
as a contact that jumps gives it, leaves the estimate as it is; and a wire that has cooled beyond B again is cold again.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from musclewire.arrays import FloatArray
from musclewire.compiled import callback, compiled, compiled_inner, row_in
from musclewire.sensing._curve import Row, branches, row_type
from musclewire.sensing._curve_estimator import (
    ESTIMATOR_NUMBERS,
    N_ARRAYS,
    CurveEstimator,
    add_friction,
    answer_with,
    answer_without_current,
    estimator_numbers,
    resistance_of,
)
from musclewire.sensing._estimator import EstimatorSetup
from musclewire.sensing._fit_report import FittedCurve
from musclewire.sensing._known_load import KnownSpring
from musclewire.sensing._polynomial_estimator import polynomial_tick
from musclewire.sensing._segment_tracking import AMBIGUOUS_ABOVE
from musclewire.signals import CompiledTick, Reason


class GateNumbers(NamedTuple):
    """Numbers of the method, chosen on the tuning seeds 1 to 10 of a population of wires.

    The variance of the range and the return where branches are crossed were chosen on 1 to 12 and on 107 to 118. Those
    of a cold rest follow from what a room may be. Resistance counts in units of R_max - R_min, the quantity in units of
    the model's range, times in seconds.
    """

    # Direction: time constant of the mean power, and by how much power must differ from it.
    mean_power_s: float = 3.0
    turning_fraction: float = 0.1
    # And of a drive too slow for that: by how much the mean power must have come back from its extreme since the turn,
    # as a fraction of it and in deviations of power from its mean.
    slow_turning_fraction: float = 0.02
    slow_turning_deviations: float = 1.0
    # Filter: variance that a still wire gains per second, one whose power differs from the mean by all of the mean, and
    # the part of an unexpected change; time over which noise is learnt.
    still_per_s: float = 2.5e-7
    driven_per_s: float = 0.16
    surprise_per_s: float = 0.15
    noise_s: float = 10.0
    # Of sparse samples at least so many; before as many are known, no motion shows that the wire has passed B.
    noise_samples: float = 5.0
    # Motion: resistance moves if it differs from its value a time constant ago by more than noise and a least change;
    # of sparse samples from its value at the last ones, each of which counts for no more than this part.
    lagging_s: float = 0.25
    max_lagging: float = 0.5
    motion_deviations: float = 1.7
    min_motion_variance: float = 1e-4
    # Without motion: approach of the branch while power is beyond its mean in that direction by a fraction (below 0: a
    # little less than the mean will do), and of the mean of both branches otherwise. Back to the branch from beyond;
    # where cooling lies above heating at one resistance, a wire that turns stays until its new branch comes to it, and
    # one that stands is not drawn to the mean of both: a loop that answers that drift by its drive would keep it up.
    supporting_fraction: float = -0.01
    approach_s: float = 1.0
    middle_s: float = 8.0
    return_s: float = 1.0
    crossed_return_s: float = 6.0
    # How far beyond the branches the quantity may be.
    beyond: float = 0.015
    # Standard deviation: part of the distance of the branches, and of the range (squared).
    gap_fraction: float = 0.2
    range_variance: float = 4.0e-5
    # Nearer to R_min than this a wire cannot be before B, as for the paper's estimator.
    ambiguous_above: float = AMBIGUOUS_ABOVE
    # A wire is cold whose mean power is below this part of that with which the slow loop cooled to its cold resistance
    # (half, for air that takes half as much heat), and whose resistance is no farther below it than a cold room's.
    cold_power_fraction: float = 0.5
    cold_margin: float = 0.05
    # Readings have at least the noise of a good converter, so that a gain never divides by nothing.
    min_noise: float = 1e-10
    # A power [W] beyond it is none of a wire; it keeps the mean finite whatever the channels say. The same for others.
    max_power_w: float = 1e6
    max_ratio: float = 10.0
    max_noise_v2: float = 1.0


GATES = GateNumbers()
# What follows for a curve and a sample period, by name: see ``gated_numbers``.
GATED_NUMBERS = (
    *ESTIMATOR_NUMBERS,
    *("dt_s", "beyond", "min_variance", "first_variance", "cold_power_w", "cold_above", "b_power_w"),
)
OK, COLD = float(Reason.OK), float(Reason.COLD)
OUT_OF_RANGE, MISMATCH = float(Reason.OUT_OF_RANGE), float(Reason.MISMATCH)


class GatedState(NamedTuple):
    """State of the gated estimator between two samples; all are numbers.

    Parameters
    ----------
    value
        The last value: the quantity, and on a known spring the friction.
    friction_n
        The friction [N] on a known spring.
    dropouts, mismatches
        Samples in a row without current, and with another wire's resistance.
    followed
        1 once there has been a sample; before it the numbers below do not count.
    quantity
        The quantity by the branches.
    resistance, lagging, variance
        Filtered resistance, its value about ``lagging_s`` ago, and the variance of the first; normalised.
    before, before_last
        The last two readings of the normalised resistance.
    noise_v2, learnt_s
        Variance of a reading, referred to the shunt's voltage [V2], and the time from which it is known [s]; -1 if only
        one reading is.
    mean_power_w
        Slow mean of the electrical power [W].
    extreme_power_w, power_variance_w2
        Largest of these means since the wire turned to heating, or smallest since it turned to cooling [W]; and the
        variance of power about its mean [W2].
    heating
        1 if the wire was last heating, 0 if it was cooling.
    sensing
        1 between B and C, 0 before B, where resistance does not determine the quantity.
    spring_known, spring_force_n
        1 once the force of a known spring has been estimated, and the last one [N].
    """

    value: float
    friction_n: float
    dropouts: float = 0.0
    mismatches: float = 0.0
    followed: float = 0.0
    quantity: float = 0.0
    resistance: float = 0.0
    lagging: float = 0.0
    variance: float = 0.0
    before: float = 0.0
    before_last: float = 0.0
    noise_v2: float = 0.0
    learnt_s: float = 0.0
    mean_power_w: float = 0.0
    extreme_power_w: float = 0.0
    power_variance_w2: float = 0.0
    heating: float = 0.0
    sensing: float = 0.0
    spring_known: float = 0.0
    spring_force_n: float = 0.0


NUMBERS_ROW, STATE_ROW, N_NUMBERS = row_type(GATED_NUMBERS), row_type(GatedState._fields), len(GATED_NUMBERS)


@compiled
def gated_tick(constants: FloatArray, state_array: FloatArray, given: FloatArray, answer: FloatArray) -> None:
    """Estimate one sample; see ``signals._compiled_tick`` for the arrays."""
    numbers, state = row_in(constants, NUMBERS_ROW), row_in(state_array, STATE_ROW)
    wire_voltage_v, shunt_voltage_v = given[2], given[3]
    resistance_ohm = resistance_of(numbers, wire_voltage_v, shunt_voltage_v)
    if resistance_ohm == 0.0:
        answer_without_current(numbers, state, answer)
        return
    state.dropouts = 0.0
    if not numbers.own_low_ohm <= resistance_ohm <= numbers.own_high_ohm:
        state.mismatches += 1.0
        answer_with(answer, state.value, numbers.quantity_span, MISMATCH, state.mismatches, resistance_ohm)
        return
    state.mismatches = 0.0
    power_w = min(wire_voltage_v * wire_voltage_v / resistance_ohm, GATES.max_power_w)
    if state.followed == 0.0:
        variance, on_curve = begin(numbers, state, constants[N_NUMBERS:], resistance_ohm, power_w)
    else:
        variance, on_curve = follow(numbers, state, constants[N_NUMBERS:], resistance_ohm, power_w, shunt_voltage_v)
    if numbers.stiffness_n_per_m > 0.0:
        add_friction(numbers, state, state.quantity)
    reason = OUT_OF_RANGE
    if on_curve:
        reason = OK if state.sensing != 0.0 else COLD
    state.value = state.quantity + state.friction_n
    std = math.sqrt(variance + numbers.scale_variance * state.quantity * state.quantity)
    answer_with(answer, state.value, min(std, numbers.quantity_span), reason, 0.0, resistance_ohm)


@compiled_inner
def begin(
    numbers: Row, state: Row, coefficients: FloatArray, resistance_ohm: float, power_w: float
) -> tuple[float, bool]:
    """Take the first sample, as the mean of the branches, heating; return variance, and whether it is on the curve."""
    read = (resistance_ohm - numbers.resistance_min_ohm) * numbers.per_ohm
    inside = min(max(read, numbers.normalised_min), numbers.normalised_max)
    hot, cold, slope = branches(coefficients, inside)
    state.followed = 1.0
    state.quantity = (hot + cold) / 2.0
    state.resistance = state.lagging = state.before = state.before_last = read
    state.variance, state.noise_v2, state.learnt_s = numbers.first_variance, 0.0, -1.0
    state.mean_power_w = state.extreme_power_w = power_w
    state.power_variance_w2, state.heating = 0.0, 1.0
    state.sensing = 0.0 if read >= GATES.ambiguous_above else 1.0
    half_gap, away = (hot - cold) / 2.0, slope / 2.0 * (read - inside)
    return half_gap * half_gap + away * away + numbers.min_variance, is_on_curve(numbers, read, 0.0)


@compiled_inner
def follow(
    numbers: Row,
    state: Row,
    coefficients: FloatArray,
    resistance_ohm: float,
    power_w: float,
    shunt_voltage_v: float,
) -> tuple[float, bool]:
    """Follow the branches by one sample; return variance, and whether the reading is on the curve."""
    read = (resistance_ohm - numbers.resistance_min_ohm) * numbers.per_ohm
    # What one volt of noise at the shunt is in normalised resistance.
    per_volt = resistance_ohm * numbers.per_ohm / shunt_voltage_v
    noise = state.noise_v2 * per_volt * per_volt + GATES.min_noise
    on_curve = is_on_curve(numbers, read, noise)
    state.mean_power_w += (power_w - state.mean_power_w) * gain(numbers.dt_s, GATES.mean_power_s)
    ratio = min(power_w / state.mean_power_w - 1.0, GATES.max_ratio)
    filter_resistance(numbers.dt_s, state, read, noise, ratio)
    learn_noise(numbers.dt_s, state, read, per_volt)
    # By how much power is beyond its mean in the direction of the wire.
    support = ratio if state.heating != 0.0 else -ratio
    slow_turn = has_come_back(numbers.dt_s, state, power_w - state.mean_power_w)
    if support < -GATES.turning_fraction or slow_turn:
        support = -support
        # Motion counts from the turn, and so do extremes of power.
        state.heating, state.lagging = 1.0 - state.heating, state.resistance
        state.extreme_power_w = state.mean_power_w
    moved = state.resistance - state.lagging
    if not moved * moved > GATES.motion_deviations * state.variance + GATES.min_motion_variance:
        moved = 0.0
    locate(numbers, state, moved, power_w)
    inside = min(max(state.resistance, numbers.normalised_min), numbers.normalised_max)
    hot, cold, slope = branches(coefficients, inside)
    move(numbers, state, hot, cold, moved, support)
    gap = GATES.gap_fraction * (hot - cold)
    slope = slope / 2.0
    off = slope * (state.resistance - inside)
    return gap * gap + slope * slope * state.variance + off * off + numbers.min_variance, on_curve


@compiled_inner
def gain(dt_s: float, time_constant_s: float) -> float:
    """Return the part of a difference that is gone after a time."""
    return dt_s / (dt_s + time_constant_s)


@compiled_inner
def has_come_back(dt_s: float, state: Row, away_w: float) -> bool:
    """Return whether the mean power has left its extreme of this direction for good, however slowly."""
    state.power_variance_w2 += (away_w * away_w - state.power_variance_w2) * gain(dt_s, GATES.noise_s)
    if state.heating != 0.0:
        state.extreme_power_w = max(state.extreme_power_w, state.mean_power_w)
    else:
        state.extreme_power_w = min(state.extreme_power_w, state.mean_power_w)
    back_w = abs(state.mean_power_w - state.extreme_power_w)
    min_back_w = GATES.slow_turning_fraction * state.extreme_power_w
    deviations_w2 = GATES.slow_turning_deviations * state.power_variance_w2
    return bool(back_w > min_back_w and back_w * back_w > deviations_w2)


@compiled_inner
def is_on_curve(numbers: Row, read: float, noise: float) -> bool:
    """Return whether a reading can be one of the valid range, within three deviations of its noise."""
    outside = max(numbers.valid_from - read, read - numbers.valid_to, 0.0)
    return bool(outside * outside <= 9.0 * noise)


@compiled_inner
def filter_resistance(dt_s: float, state: Row, read: float, noise: float, ratio: float) -> None:
    """Filter the resistance, of a wire whose power is beyond its mean by a ratio."""
    away = read - state.resistance
    surprise = max(away * away - noise - state.variance, 0.0)
    variance = state.variance + dt_s * (
        GATES.still_per_s + GATES.driven_per_s * ratio * ratio + GATES.surprise_per_s * surprise
    )
    weight = variance / (variance + noise)
    state.resistance += weight * away
    state.variance = variance - weight * variance
    state.lagging += (state.resistance - state.lagging) * min(gain(dt_s, GATES.lagging_s), GATES.max_lagging)


@compiled_inner
def learn_noise(dt_s: float, state: Row, read: float, per_volt: float) -> None:
    """Learn the noise from the second difference of the readings."""
    bend_v = ((read - state.before) - (state.before - state.before_last)) / per_volt
    state.before_last = state.before
    state.before = read
    if state.learnt_s < 0.0 or dt_s <= 0.0:
        state.learnt_s = 0.0
        return
    state.learnt_s = min(state.learnt_s + dt_s, max(GATES.noise_s, GATES.noise_samples * dt_s))
    noise_v2 = min(bend_v * bend_v / 6.0, GATES.max_noise_v2)
    state.noise_v2 += (noise_v2 - state.noise_v2) * (dt_s / state.learnt_s)


@compiled_inner
def locate(numbers: Row, state: Row, moved: float, power_w: float) -> None:
    """Follow whether the wire is between B and C: lost at the cold end, found where heating lowers resistance.

    From A to B resistance rises while the wire heats, from B to C it falls. A wire that passes B is as warm as in the
    slow loop there, however short a time it took: its mean power is not that of the rest before. In warmer or calmer
    air it passes with less power, and that is then its mean.
    """
    below = GATES.ambiguous_above - state.resistance
    known = state.learnt_s >= GATES.noise_samples * numbers.dt_s
    powerless = state.mean_power_w < numbers.cold_power_w and state.resistance > numbers.cold_above
    # Seldom read, a wire is not seen beyond B: it is lost within two deviations of it.
    until_b = numbers.normalised_max - state.resistance
    if powerless or until_b < 0.0 or until_b * until_b < 4.0 * state.variance:
        state.sensing = 0.0
        return
    falls = state.heating != 0.0 and moved < 0.0 and moved * moved > 9.0 * state.variance and known
    if falls or (below > 0.0 and below * below > 9.0 * state.variance):
        if state.sensing == 0.0:
            state.mean_power_w = max(state.mean_power_w, min(numbers.b_power_w, power_w))
        state.sensing = 1.0


@compiled_inner
def move(numbers: Row, state: Row, hot: float, cold: float, moved: float, support: float) -> None:
    """Move the quantity towards its branch and keep it within both."""
    quantity = state.quantity
    if state.heating != 0.0:
        branch, ahead, towards = hot, hot - quantity, -moved
    else:
        branch, ahead, towards = cold, quantity - cold, moved
    if ahead < 0.0:
        back_s = GATES.crossed_return_s if hot < cold else GATES.return_s
        quantity += (branch - quantity) * gain(numbers.dt_s, back_s)
    elif towards > 0.0:
        quantity = branch
    elif support > GATES.supporting_fraction:
        quantity += (branch - quantity) * gain(numbers.dt_s, GATES.approach_s)
    elif hot >= cold:
        quantity += ((hot + cold) / 2.0 - quantity) * gain(numbers.dt_s, GATES.middle_s)
    state.quantity = min(max(quantity, min(hot, cold) - numbers.beyond), max(hot, cold) + numbers.beyond)


class GatedEstimator(CurveEstimator):
    """Estimates by the branch of the direction in which electrical power drives the wire.

    Parameters
    ----------
    model
        The wire's resistance curve, with the slow loop that it was fitted to. One whose two branches are equal gives a
        filtered polynomial.
    shunt_resistance_ohm
        R [ohm] of Eq. 1.
    sample_period_s
        Time [s] between two samples.
    load
        A known spring, if the curve is one of the force on it; its friction is added in the direction of motion.
    """

    def __init__(
        self,
        model: FittedCurve,
        shunt_resistance_ohm: float,
        sample_period_s: float,
        load: KnownSpring | None = None,
    ) -> None:
        """Take the numbers; the state of a run is not kept here."""
        curve = model.curve()
        numbers = estimator_numbers(curve, shunt_resistance_ohm, load) | gated_numbers(model)
        numbers["dt_s"] = sample_period_s
        first_state = GatedState(curve.quantity_min, numbers["load_friction_n"])
        super().__init__(curve, gated_tick, [numbers[name] for name in GATED_NUMBERS], first_state)

    def compiled_tick(self) -> CompiledTick:
        """Return the tick that ``step`` runs."""
        return self._tick


def gated_numbers(model: FittedCurve) -> dict[str, float]:
    """Return the numbers of the gated branches that follow from a model, by name.

    Parameters
    ----------
    model
        The wire's resistance curve, with the slow loop that it was fitted to.

    Returns
    -------
    In the curve's quantity or its variance: how far beyond the branches the quantity may be, and the least variance of
    an estimate; the variance of the first resistance, normalised; the power [W] below which, and the normalised
    resistance above which, the wire is cold; and the power [W] with which the slow loop passed B.
    """
    curve = model.curve()
    per_ohm = curve.numbers["per_ohm"]
    span = curve.quantity_max - curve.quantity_min
    noise = curve.resistance_noise_ohm * per_ohm
    return {
        "beyond": GATES.beyond * span,
        "min_variance": curve.numbers["residual_variance"] + GATES.range_variance * span * span,
        "first_variance": noise * noise,
        "cold_power_w": GATES.cold_power_fraction * model.cold_power_w,
        "cold_above": (model.cold_resistance_ohm - curve.resistance_min_ohm) * per_ohm - GATES.cold_margin,
        "b_power_w": model.b_power_w,
    }


def gated_estimator(setup: EstimatorSetup) -> GatedEstimator:
    """Return the estimator by direction-gated branches for a loop.

    Parameters
    ----------
    setup
        Model, shunt, sample period, and the known spring if force is estimated.

    Returns
    -------
    The estimator.
    """
    return GatedEstimator(setup.model, setup.shunt_resistance_ohm, setup.sample_period_s, setup.load)


def compile_estimators() -> None:
    """Compile the ticks of the estimators on a curve, for a program that makes them later, with a rig switched on."""
    from musclewire.sensing._filter_estimator import filter_tick

    for tick in (gated_tick, polynomial_tick, filter_tick):
        callback(tick, N_ARRAYS)
