"""Steps of one wire and of a pair: how a sample is divided, the circuit at a moment, a step that was tried."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inline, compiled_inner
from musclewire.errors import CallerError, NumericsError
from musclewire.wire._balance import BalancedWire, convection_w_per_m2_k, loss_w
from musclewire.wire._fronts import shakedown_of
from musclewire.wire._row import Rows, StepConstants, WireState
from musclewire.wire._step import (
    NO_HEAT_J,
    NO_PUSH,
    Equilibrium,
    RunningWire,
    accept,
    guess_after,
    middle_of_step,
    solve,
)

# A fixed step must divide the sample; this much of a step may be left over by rounding.
RAGGED = 1e-6


# Places of a plan's numbers.
DURATION, STEPS, TEMPERATURE, RESISTANCE, STRAIN = range(5)
# How a chosen step follows from the error of the last one:
SAFETY = 0.9  # of the tolerance's step, so that few are refused
MAX_SHRINK = 0.2  # smallest factor from one step to the next
MAX_GROWTH = 3.0  # largest factor
# Steps this short are taken whatever their error: only a jump of a load or a drive asks for shorter ones.
MIN_STEP_S = 1e-5
# A step with a larger estimated error in temperature shows the step, not the wire.
MAX_STEP_ERROR_K = 2.0
# Resistance changes by a fifth over the latent heat; the prediction allows for twice as steep a change and more.
STEEPEST = 0.5
TEN_K = 10.0  # [K] whose heat is added to the latent heat: a wire without one has a finite slope, too
# A smaller motion of a coupled wire is within what its solution may be off.
MOVED = 1e-11


class StepControl(NamedTuple):
    """How a sample is divided into steps.

    By default steps are chosen: a sample is one step, and is split where the estimated error of a step in temperature,
    resistance or strain would be above its tolerance. The defaults keep each of them below what instruments show.
    """

    fixed_s: float = 0.0  # length of every step; 0 for chosen steps
    temperature_k: float = 5e-3  # tolerance of temperature
    resistance: float = 3e-5  # tolerance of resistance, as a fraction of it
    strain: float = 1e-5  # tolerance of strain, as a fraction


def fixed_steps(step_s: float) -> StepControl:
    """Return steps of one length.

    Parameters
    ----------
    step_s
        Length of every step [s].

    Returns
    -------
    The stepping.

    Raises
    ------
    CallerError
        If the length is not positive and finite.
    """
    if not 0.0 < step_s < math.inf:
        raise CallerError(f"a step of {step_s} s cannot be: give a positive number of seconds")
    return StepControl(fixed_s=step_s)


def steps_within(stepping: StepControl, duration_s: float) -> int:
    """Return how many fixed steps a duration has, 0 for chosen ones; CallerError if they do not divide it."""
    if not 0.0 < duration_s < math.inf:
        raise CallerError(f"a sample of {duration_s} s cannot be: give a positive number of seconds")
    if not min(stepping.temperature_k, stepping.resistance, stepping.strain) > 0.0:
        raise CallerError(f"tolerances must be above 0: {stepping}")
    if stepping.fixed_s == 0.0:
        return 0
    ratio = duration_s / stepping.fixed_s
    if not ratio >= 1.0 - RAGGED or abs(ratio - round(ratio)) > RAGGED * max(ratio, 1.0):
        raise CallerError(f"a step of {stepping.fixed_s:g} s must divide a sample of {duration_s:g} s without a rest")
    return round(ratio)


CHOSEN = StepControl()


# What a source holds.
VOLTAGE, CURRENT, POWER = range(3)


class SourceOutput(NamedTuple):
    """What is held during a sample: a voltage [V] of the circuit, a current [A], or the power in the wire [W].

    Of a power that was measured the circuit does not matter: the wire's voltage is then shown for 1 A, and so its
    resistance.
    """

    value: float
    kind: int  # VOLTAGE, CURRENT or POWER


class WireInstant(NamedTuple):
    """A wire in its circuit and in the air at one moment: current [A], electrical power and heat loss [W]."""

    current_a: float
    power_w: float
    loss_w: float


class HeatSlopes(NamedTuple):
    """Slopes over heat in a step: of temperature, stress, contraction and resistance."""

    temperature_k_per_j: float
    stress_pa_per_j: float
    contraction_per_j: float
    resistance_ohm_per_j: float


class StepAttempt(NamedTuple):
    """A step that was tried."""

    found: Equilibrium  # the wire at the end
    within: WireInstant  # circuit and air in the middle
    ended: WireInstant  # circuit and air at the end
    heat_j: float  # with what the step before owed
    owed_j: float  # heat by the trapezoidal rule less that by the middle: what this step owes the next
    error_k: float  # what that means in temperature: the estimated error of the step


@compiled_inline
def circuit_at(
    constants: StepConstants,
    drive: SourceOutput,
    resistance_ohm: float,
    temperature_k: float,
    coefficient_w_per_m2_k: float,
) -> WireInstant:
    """Return current, power and loss of a wire: the source drives wire, shunt and leads in series."""
    loss = loss_w(constants, coefficient_w_per_m2_k, temperature_k)
    if drive.kind == POWER:
        return WireInstant(1.0, drive.value, loss)
    in_series_ohm = resistance_ohm + constants.series_resistance_ohm
    current_a = drive.value if drive.kind == CURRENT else drive.value / in_series_ohm
    return WireInstant(current_a, current_a * current_a * resistance_ohm, loss)


@compiled_inline
def instant_of(
    constants: StepConstants, drive: SourceOutput, resistance_ohm: float, temperature_k: float
) -> WireInstant:
    """Return current, power and loss of a wire, with the air's coefficient from the wire's table."""
    coefficient = convection_w_per_m2_k(constants, constants, temperature_k)
    return circuit_at(constants, drive, resistance_ohm, temperature_k, coefficient)


@compiled_inline
def owed_j(started: WireInstant, within: WireInstant, ended: WireInstant, step_s: float) -> float:
    """Return the heat of a step by the trapezoidal rule less that by its middle [J]."""
    both_w = 0.5 * (started.power_w - started.loss_w + ended.power_w - ended.loss_w)
    return (both_w - (within.power_w - within.loss_w)) * step_s


@compiled_inline
def bounded_slope(rise: float, heat_j: float, low: float, high: float) -> float:
    """Return a rise over a heat, within limits: a load that jumps at hardly any heat makes it meaningless."""
    slope = rise / heat_j if abs(heat_j) > NO_HEAT_J else 0.0
    return min(max(slope, low), high)


@compiled_inline
def rises_over(
    constants: StepConstants, before: WireState, after: BalancedWire | WireState, heat_j: float
) -> HeatSlopes:
    """Return the slopes of a coupled wire over its own heat: what it did in a step, as far as heat can do it.

    Temperature rises as without latent heat at most, stress with it as the phases' balance does; resistance and
    contraction change over the latent heat as in a whole transformation, or more than twice as steeply.
    """
    k = constants
    steepest_per_j = STEEPEST / (k.latent_heat_j + TEN_K * k.capacity_j_per_k)
    ohm_per_j, per_j = after.resistance_ohm * steepest_per_j, 5.0 * k.strain_saturated * steepest_per_j
    pa_per_j = k.per_capacity_k_per_j / k.martensite_k_per_pa
    moved = after.contraction - before.connector_contraction
    moved = moved if abs(moved) > MOVED else 0.0
    return HeatSlopes(
        bounded_slope(after.temperature_k - before.temperature_k, heat_j, 0.0, k.per_capacity_k_per_j),
        bounded_slope(after.stress_pa - before.stress_pa, heat_j, -pa_per_j, pa_per_j),
        bounded_slope(moved, heat_j, -per_j, per_j),
        bounded_slope(after.resistance_ohm - before.resistance_ohm, heat_j, -ohm_per_j, ohm_per_j),
    )


@compiled_inline
def error_ratio(
    state: WireState, tried: StepAttempt, started: WireInstant, step_s: float, plan: FloatArray | tuple[float, ...]
) -> float:
    """Return the largest error of a step over its tolerance: of temperature, resistance and strain.

    Resistance and contraction are also shown as means over a sample: how far the mean of both ends may be from the mean
    in between follows from the rates at both ends.
    """
    found, after = tried.found, tried.found.wire
    at_start_w = started.power_w - started.loss_w
    at_end_w = tried.ended.power_w - tried.ended.loss_w
    turned = at_start_w * state.last_heat_j < 0.0
    resistance_slope = (after.resistance_ohm - state.resistance_ohm) / tried.heat_j if tried.heat_j != 0.0 else 0.0
    before = 0.0 if turned else state.resistance_slope_ohm_per_j
    bend_ohm = abs(before * at_start_w - resistance_slope * at_end_w)
    before = 0.0 if turned else state.contraction_slope_per_j
    bend = abs(before * at_start_w - found.contraction_slope_per_j * at_end_w)
    mean = step_s / 12.0
    resistance_ohm = max(abs(tried.owed_j * resistance_slope), bend_ohm * mean)
    strain = max(abs(tried.owed_j * found.contraction_slope_per_j), bend * mean)
    return max(
        tried.error_k / plan[TEMPERATURE],
        max(resistance_ohm / (plan[RESISTANCE] * state.resistance_ohm), strain / plan[STRAIN]),
    )


@compiled_inline
def longest_step_s(state: WireState, duration_s: float) -> float:
    """Return the step to try first [s]: what the last one suggests, or the whole duration."""
    return min(state.step_s, duration_s) if state.step_s > 0.0 else duration_s


@compiled_inline
def shorter_step_s(step_s: float, ratio: float) -> float:
    """Return the step to try in place of one whose error was above its tolerance by this ratio."""
    return step_s * max(SAFETY / math.sqrt(ratio), MAX_SHRINK)


@compiled_inline
def next_step_s(step_s: float, ratio: float) -> float:
    """Return the step that suits the tolerance after one with this ratio of error to tolerance."""
    return step_s * min(max(SAFETY / math.sqrt(max(ratio, 1e-6)), MAX_SHRINK), MAX_GROWTH)


@lru_cache(maxsize=64)
def plan_of(stepping: StepControl, duration_s: float) -> FloatArray:
    """Return a stepping over a positive duration for compiled code, (5,): duration [s], fixed steps, tolerances."""
    steps = steps_within(stepping, duration_s)
    return np.array([duration_s, steps, stepping.temperature_k, stepping.resistance, stepping.strain])


@compiled_inner
def is_resolved(state: WireState) -> bool:
    """Whether all steps of a wire were solved, and none too long for what happened in it."""
    # Not a number is not less than anything: written so that it is not resolved.
    solved = state.unsolved_steps == 0.0 and state.step_error_k <= MAX_STEP_ERROR_K
    return solved and abs(state.temperature_k) < math.inf


@compiled
def are_resolved(states: Rows) -> bool:
    """Whether the steps of all wires, (n_wires,), were solved, and none too long for what happened in it."""
    for wire in range(states.shape[0]):  # noqa: SIM110  # Numba compiles no generators
        if not is_resolved(states[wire]):
            return False
    return True


def require_resolved(after: WireState, stepping: StepControl, sample_s: float, before: WireState | None = None) -> None:
    """Raise NumericsError if steps since ``before`` (by default all) were not solved, or too long for what happened."""
    numbers = after.record
    missed = numbers.unsolved_steps - (before.unsolved_steps if before is not None else 0.0)
    if missed == 0.0 and numbers.step_error_k <= MAX_STEP_ERROR_K and abs(numbers.temperature_k) < math.inf:
        return
    length_s = stepping.fixed_s or sample_s
    steps = f"steps of {1e3 * length_s:g} ms" if stepping.fixed_s else f"chosen steps of {1e3 * length_s:g} ms at most"
    raise NumericsError(
        f"the simulation does not resolve what the wire does up to {numbers.time_s:.3f} s: {steps} leave an error of "
        f"{numbers.step_error_k:.3g} K in temperature and {missed:.0f} balances unsolved; "
        + (
            "set time_step_s to 0 for steps chosen by tolerance, or to a fraction of this"
            if stepping.fixed_s
            else "look for a load or a drive that no wire could follow, or lower the tolerances"
        )
    )


# One step a sample up to the paper's 50 ms: a hypothesis needs no more, its power is a mean over the sample anyway.
MAX_HEATED_S = 0.05


@compiled_inline
def attempt(wire: RunningWire, drive: SourceOutput, started: WireInstant, step_s: float) -> StepAttempt:
    """Return a step of a wire; the wire itself does not move yet.

    Power and loss in the middle of the step give its heat. The trapezoidal rule with the end as found would give a
    little more or less: that is made good in the next step, and is the estimate of this one's error.
    """
    state, k = wire.state, wire.constants
    middle = middle_of_step(state, k, 0.5 * step_s * (started.power_w - started.loss_w))
    within = instant_of(k, drive, middle.resistance_ohm, middle.temperature_k)
    heat_j = (within.power_w - within.loss_w) * step_s + state.carried_heat_j
    shakedown = shakedown_of(k, state.cycles)
    found = solve(wire, shakedown, state.enthalpy_j + heat_j, guess_after(state, middle, heat_j), NO_PUSH)
    ended = instant_of(k, drive, found.wire.resistance_ohm, found.wire.temperature_k)
    owes_j = owed_j(started, within, ended, step_s)
    slope = max(found.temperature_slope_k_per_j, middle.temperature_slope_k_per_j)
    return StepAttempt(found, within, ended, heat_j, owes_j, abs(owes_j) * slope)


@compiled_inline
def accept_step(wire: RunningWire, tried: StepAttempt, started: WireInstant, step_s: float) -> None:
    """Move a wire by a step that was tried, in place."""
    state = wire.state
    accept(wire, tried.found, tried.heat_j, NO_PUSH)
    state.carried_heat_j = tried.owed_j
    state.heat_in_j += 0.5 * (started.power_w + tried.ended.power_w) * step_s
    state.heat_out_j += 0.5 * (started.loss_w + tried.ended.loss_w) * step_s
    state.step_error_k = max(state.step_error_k, tried.error_k)


@compiled_inline
def advance_wire(
    wire: RunningWire, drive: SourceOutput, plan: FloatArray | tuple[float, ...]
) -> tuple[float, float, float, float]:
    """Advance a wire in place by a duration; return the means of :func:`advance`."""
    state, k = wire.state, wire.constants
    started = instant_of(k, drive, state.resistance_ohm, state.temperature_k)
    fixed = plan[STEPS] > 0.0
    left_s = duration_s = plan[DURATION]
    step_s = duration_s / plan[STEPS] if fixed else longest_step_s(state, duration_s)
    steps_left = int(plan[STEPS])
    voltage_sum = current_sum = moved_sum = stress_sum = 0.0
    while steps_left > 0 if fixed else left_s > 0.0:
        if not fixed:  # equal steps over what is left, none longer than the tolerance asks for
            step_s = left_s / math.ceil(left_s / step_s * (1.0 - 1e-9))
        tried = attempt(wire, drive, started, step_s)
        if not fixed:
            ratio = error_ratio(state, tried, started, step_s, plan)
            if ratio > 1.0 and step_s > MIN_STEP_S:
                step_s = shorter_step_s(step_s, ratio)
                continue
            state.step_s = next_step_s(step_s, ratio)
        resistance_ohm, connector, stress_pa = state.resistance_ohm, state.connector_contraction, state.stress_pa
        accept_step(wire, tried, started, step_s)
        # The trapezoidal rule for all four alike: otherwise strain would be late or early compared with resistance.
        ended = tried.ended
        voltage_sum += step_s * (started.current_a * resistance_ohm + ended.current_a * state.resistance_ohm)
        current_sum += step_s * (started.current_a + ended.current_a)
        moved_sum += step_s * (connector + state.connector_contraction)
        stress_sum += step_s * (stress_pa + state.stress_pa)
        started = ended
        left_s -= step_s
        steps_left -= 1
        step_s = step_s if fixed else state.step_s
    # Adding up time step by step would accumulate rounding errors.
    state.time_s += duration_s
    mean = 0.5 / duration_s
    return (
        mean * voltage_sum,
        mean * current_sum * k.shunt_resistance_ohm,
        mean * moved_sum * k.leg_length_m,
        mean * stress_sum * k.section_m2,
    )


@compiled
def advance_heated(wire: RunningWire, power_w: float, duration_s: float) -> tuple[float, float, float]:
    """Advance a wire in place at a mean electrical power, in one step up to 50 ms; return means of what is measured.

    Resistance [ohm], contraction of the connector over the leg's length, force of all legs [N].
    """
    steps = float(math.ceil(duration_s / MAX_HEATED_S - 1e-6))
    plan = (duration_s, steps, 0.0, 0.0, 0.0)
    resistance_ohm, _, displacement_m, force_n = advance_wire(wire, SourceOutput(power_w, POWER), plan)
    return resistance_ohm, displacement_m / wire.constants.leg_length_m, force_n
