"""A wire at prescribed temperature and stress: phases, strain and resistance without heat and load; compiled."""

from __future__ import annotations

import math

from musclewire.compiled import compiled, compiled_inner
from musclewire.wire._balance import resistance_at, strain_at
from musclewire.wire._fronts import ShakedownEffects, shakedown_of
from musclewire.wire._row import Rows, StepConstants
from musclewire.wire._step import RunningWire, phases_at


@compiled_inner
def prescribe(wire: RunningWire, shakedown: ShakedownEffects, temperature_k: float, stress_pa: float) -> None:
    """Apply a temperature and a stress to the phases of a wire, in place: its fronts and fractions change.

    References
    ----------
    Mayergoyz 1986, doi 10.1103/PhysRevLett.56.1518, and Sethna et al. 1993, doi 10.1103/PhysRevLett.70.3347, for the
    return-point memory of such an ensemble.
    """
    state = wire.state
    phases = phases_at(wire, shakedown, temperature_k, stress_pa)
    for row in range(state.front_austenite.shape[0]):
        state.front_austenite[row] = state.front_trial[6 * row]
        state.front_martensite[row] = state.front_trial[6 * row + 1]
    state.martensite_fraction = phases.martensite
    state.r_phase_fraction = phases.r_phase


@compiled
def cool_from_hot(
    states: Rows, constants: Rows, cells: Rows, load: Rows, temperature_k: float, stress_pa: float
) -> tuple[float, float]:
    """Set the phases of a wire, (1,), to those cooled from hot; return its strain and a new wire's resistance [ohm].

    On cooling fronts only move down to thresholds that fall: the result does not depend on the path, so that evaluating
    its end is enough.
    """
    wire = RunningWire(states[0], constants[0], cells[0], load[0])
    state, k = wire.state, wire.constants
    for row in range(state.front_austenite.shape[0]):
        state.front_austenite[row] = math.inf
        state.front_martensite[row] = math.inf
    prescribe(wire, shakedown_of(k, math.inf), temperature_k, stress_pa)
    martensite, r_phase = state.martensite_fraction, state.r_phase_fraction
    strain = strain_at(k, temperature_k, stress_pa, martensite, r_phase)
    resistance_ohm = resistance_at(k, shakedown_of(k, 0.0), strain, temperature_k, martensite, r_phase)
    return strain.transformation + strain.elastic + strain.thermal, resistance_ohm


@compiled
def total_strain(
    constants: StepConstants, stress_pa: float, martensite: float, r_phase: float, temperature_k: float
) -> float:
    """Return the strain relative to stress-free austenite at 20 C, without the residual strain of shakedown."""
    strain = strain_at(constants, temperature_k, stress_pa, martensite, r_phase)
    return strain.transformation + strain.elastic + strain.thermal


@compiled_inner
def resistance_of(
    constants: StepConstants,
    stress_pa: float,
    martensite: float,
    r_phase: float,
    temperature_k: float,
    cycles: float,
) -> float:
    """Return the resistance of the whole wire [ohm] at a state and an age, without leads and shunt."""
    strain = strain_at(constants, temperature_k, stress_pa, martensite, r_phase)
    return resistance_at(constants, shakedown_of(constants, cycles), strain, temperature_k, martensite, r_phase)
