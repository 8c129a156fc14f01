"""A wire heated by a power that was measured, without circuit or source; compiled."""

from __future__ import annotations

import math

from musclewire.compiled import compiled
from musclewire.wire._balance import convection_w_per_m2_k, loss_w
from musclewire.wire._fronts import shakedown_of
from musclewire.wire._step import NO_PUSH, RunningWire, accept, guess_after, middle_of_step, solve

__all__ = ["MAX_STEP_S", "advance_heated"]

# One step a sample up to the paper's 50 ms: a hypothesis needs no more, its power is a mean over the sample anyway.
MAX_STEP_S = 0.05


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
        The duration [s].

    Returns
    -------
    Means of resistance [ohm], of the connector's contraction over the leg's length, and of the force of all legs [N].
    """
    state, k = wire.state, wire.constants
    steps = math.ceil(duration_s / MAX_STEP_S - 1e-6)
    step_s = duration_s / steps
    resistance_ohm = contraction = stress_pa = 0.0
    for _ in range(steps):
        before_ohm, before, before_pa = state.resistance_ohm, state.connector_contraction, state.stress_pa
        started_w = loss_w(k, convection_w_per_m2_k(k, k, state.temperature_k), state.temperature_k)
        middle = middle_of_step(state, k, 0.5 * step_s * (power_w - started_w))
        within_w = loss_w(k, convection_w_per_m2_k(k, k, middle.temperature_k), middle.temperature_k)
        heat_j = (power_w - within_w) * step_s + state.carried_heat_j
        shakedown = shakedown_of(k, state.cycles)
        found = solve(wire, shakedown, state.enthalpy_j + heat_j, guess_after(state, middle, heat_j), NO_PUSH)
        accept(wire, found, heat_j, NO_PUSH)
        ended_w = loss_w(k, convection_w_per_m2_k(k, k, state.temperature_k), state.temperature_k)
        state.carried_heat_j = (within_w - 0.5 * (started_w + ended_w)) * step_s
        resistance_ohm += before_ohm + state.resistance_ohm
        contraction += before + state.connector_contraction
        stress_pa += before_pa + state.stress_pa
    mean = 0.5 / steps
    return mean * resistance_ohm, mean * contraction, mean * stress_pa * k.section_m2
