"""One wire through time, compiled: in its circuit, at a current or at a power, whichever its drive is."""

from __future__ import annotations

import math

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inline
from musclewire.wire._fronts import shakedown_of
from musclewire.wire._step import NO_PUSH, RunningWire, accept, guess_after, middle_of_step, solve
from musclewire.wire._stepping import (
    DURATION,
    MIN_STEP_S,
    POWER,
    STEPS,
    SourceOutput,
    StepAttempt,
    WireInstant,
    error_ratio,
    instant_of,
    longest_step_s,
    next_step_s,
    owed_j,
    shorter_step_s,
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
    """Advance a wire in place by a duration at a mean electrical power; return means of what would be measured.

    Parameters
    ----------
    wire
        The wire; its state changes.
    power_w
        Electrical power in the wire [W].
    duration_s
        The duration [s], in one step up to 50 ms.

    Returns
    -------
    Means of resistance [ohm], of the connector's contraction over the leg's length, and of the force of all legs [N].
    """
    steps = float(math.ceil(duration_s / MAX_HEATED_S - 1e-6))
    plan = (duration_s, steps, 0.0, 0.0, 0.0)
    resistance_ohm, _, displacement_m, force_n = advance_wire(wire, SourceOutput(power_w, POWER), plan)
    return resistance_ohm, displacement_m / wire.constants.leg_length_m, force_n
