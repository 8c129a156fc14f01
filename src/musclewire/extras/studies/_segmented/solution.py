"""The common stress of segments in series, with the temperature of each from its enthalpy; compiled.

One force goes through all segments, and their contractions add up at the connector. Stress and all temperatures are
found together: a stress that lagged by a step would swing against so soft a spring. Newton's method, in which each
temperature is eliminated by its own enthalpy, leaves one equation for the stress. Where that does not end, the stress
is found in a bracket, with each temperature in a bracket of its own: both residuals rise.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from musclewire.compiled import compiled, compiled_inline
from musclewire.extras.studies._segmented.state import SampleSetting, WholeWire
from musclewire.physics import REFERENCE_TEMPERATURE_K
from musclewire.wire import (
    SOLVED_K,
    Rows,
    RunningWire,
    ShakedownEffects,
    StepConstants,
    StrainSlopes,
    contraction_of,
    friction_at,
    phases_at,
    resistance_at,
    strain_at,
)

__all__ = ["LoadAtContraction", "CompiledSegments", "equilibrium", "no_shakedown", "settle"]

PLAIN_STEPS = 12
MAX_EVALUATIONS = 200
# Bend of the load within the last Newton step that may be left [N].
SMALL_BEND_N = 1e-6
SMALL_BRACKET_PA = 1.0
# Resistance changes by a fifth over the latent heat; the prediction allows for twice as steep a change and more.
STEEPEST, TEN_K = 0.5, 10.0


class CompiledSegments(NamedTuple):
    """A wire in segments in compiled code: arrays of records, and records."""

    states: Rows
    places: Rows
    whole: WholeWire
    now: SampleSetting
    constants: StepConstants
    cells: Rows
    load: Rows


class LoadAtContraction(NamedTuple):
    """Load at a contraction: force and its slope over contraction [N], friction [N], and the connector's place."""

    force_n: float
    per_contraction_n: float
    friction_n: float


class SegmentsNewtonStep(NamedTuple):
    """A Newton step of all segments together.

    ``moved`` is the contraction it adds, ``wide_k`` the largest step of any temperature [K].
    """

    contraction: float
    moved_at_stress: float
    moved_per_pa: float
    excess_pa: float
    rise_pa: float
    wide_k: float


@compiled_inline
def no_shakedown(setting: SampleSetting) -> ShakedownEffects:
    """Return the effects of age on strain; barriers and resistivity keep those of a trained wire."""
    return ShakedownEffects(1.0, setting.residual_strain, 1.0)


@compiled_inline
def try_segment(run: CompiledSegments, number: int, stress_pa: float) -> None:
    """Evaluate a segment at its trial temperature and a stress: phases, contraction, missing heat, all with slopes."""
    state, k = run.states[number], run.constants
    shakedown = no_shakedown(run.now)
    temperature_k = state.trial_k
    shift_k = run.places[number].temperature_shift_k + run.now.temperature_shift_k
    # A shift of all transformation temperatures is a shift of the temperature that the grains feel.
    phases = phases_at(RunningWire(state, k, run.cells, run.load), shakedown, temperature_k - shift_k, stress_pa)
    strain = strain_at(k, temperature_k, stress_pa, phases.martensite, phases.r_phase)
    warm_k = temperature_k - REFERENCE_TEMPERATURE_K
    per_martensite = strain.oriented + stress_pa * k.added_compliance_per_pa + k.added_expansion_per_k * warm_k
    expansion = k.austenite_expansion_per_k + phases.martensite * k.added_expansion_per_k
    compliance = k.austenite_compliance_per_pa + phases.martensite * k.added_compliance_per_pa
    per_k = per_martensite * phases.martensite_per_k + k.r_phase_strain * phases.r_phase_per_k + expansion
    per_pa = per_martensite * phases.martensite_per_pa + k.r_phase_strain * phases.r_phase_per_pa
    per_pa += compliance + phases.martensite * strain.oriented_per_pa
    ratio, latent = k.r_phase_entropy_ratio, k.latent_heat_j
    state.trial_martensite, state.trial_r_phase = phases.martensite, phases.r_phase
    state.trial_martensite_per_k, state.trial_martensite_per_pa = phases.martensite_per_k, phases.martensite_per_pa
    state.trial_r_phase_per_k, state.trial_r_phase_per_pa = phases.r_phase_per_k, phases.r_phase_per_pa
    state.trial_contraction = contraction_of(k, shakedown, strain)
    state.contraction_per_k, state.contraction_per_pa = -per_k * k.per_stretch, -per_pa * k.per_stretch
    held_j = state.enthalpy_j + state.heat_j
    state.missing_j = k.capacity_j_per_k * warm_k - latent * (phases.martensite + ratio * phases.r_phase) - held_j
    state.missing_per_k = k.capacity_j_per_k - latent * (phases.martensite_per_k + ratio * phases.r_phase_per_k)
    state.missing_per_pa = -latent * (phases.martensite_per_pa + ratio * phases.r_phase_per_pa)


@compiled_inline
def load_after(run: CompiledSegments, contraction: float) -> LoadAtContraction:
    """Return spring and guide at a contraction, after the motion from where the connector is."""
    k, setting, whole = run.constants, run.now, run.whole
    moved = contraction - whole.connector_contraction
    friction_n, slope_n = friction_at(k.friction_n, 0.0, k.per_presliding, whole.friction_n, moved)
    return LoadAtContraction(
        setting.force_n + setting.spring_n * contraction + friction_n, setting.spring_n + slope_n, friction_n
    )


@compiled_inline
def newton_at(run: CompiledSegments, stress_pa: float) -> SegmentsNewtonStep:
    """Evaluate all segments at their trial temperatures and a stress; return the Newton step from there."""
    contraction = -run.now.zero_contraction
    moved = moved_per_pa = 0.0
    for number in range(run.states.shape[0]):
        try_segment(run, number, stress_pa)
        state, weight = run.states[number], run.places[number].weight
        contraction += weight * state.trial_contraction
        per_heat = state.contraction_per_k / state.missing_per_k
        moved -= weight * per_heat * state.missing_j
        moved_per_pa += weight * (state.contraction_per_pa - per_heat * state.missing_per_pa)
    load = load_after(run, contraction)
    per_section = run.constants.per_section_m2
    excess_pa = stress_pa - (load.force_n + load.per_contraction_n * moved) * per_section
    rise_pa = -excess_pa / (1.0 - load.per_contraction_n * moved_per_pa * per_section)
    if stress_pa <= 0.0 and rise_pa < 0.0:  # slack: temperature alone meets the enthalpy
        rise_pa = 0.0
    wide_k = 0.0
    for number in range(run.states.shape[0]):
        state = run.states[number]
        wide_k = max(wide_k, abs(state.missing_j + state.missing_per_pa * rise_pa) / state.missing_per_k)
    return SegmentsNewtonStep(contraction, moved, moved_per_pa, excess_pa, rise_pa, wide_k)


@compiled_inline
def bend_n(run: CompiledSegments, found: SegmentsNewtonStep) -> float:
    """Return how far the load after a Newton step is from its straight continuation [N]."""
    if run.constants.friction_n == 0.0:
        return 0.0
    moved = found.moved_at_stress + found.moved_per_pa * found.rise_pa
    before = load_after(run, found.contraction)
    return abs(load_after(run, found.contraction + moved).force_n - before.force_n - before.per_contraction_n * moved)


@compiled_inline
def equilibrium(run: CompiledSegments, guess_pa: float) -> tuple[float, float, int]:
    """Find stress and all temperatures at the enthalpies after the step's heat.

    Parameters
    ----------
    run
        The segments, with trial temperatures to begin with and the heat of the step.
    guess_pa
        Stress to begin with [Pa].

    Returns
    -------
    The trial stress [Pa], the last Newton step from there [Pa], and evaluations: below 0 if the balances are not met.
    """
    stress_pa = guess_pa
    for evaluation in range(1, PLAIN_STEPS + 1):
        found = newton_at(run, stress_pa)
        small = found.wide_k < SOLVED_K and abs(found.rise_pa) * run.constants.martensite_k_per_pa < SOLVED_K
        if small and bend_n(run, found) < SMALL_BEND_N:
            return stress_pa, found.rise_pa, evaluation
        for number in range(run.states.shape[0]):
            state = run.states[number]
            state.trial_k -= (state.missing_j + state.missing_per_pa * found.rise_pa) / state.missing_per_k
        stress_pa = max(stress_pa + found.rise_pa, 0.0)
    return bracketed(run, max(guess_pa, 0.0))


@compiled
def bracketed(run: CompiledSegments, guess_pa: float) -> tuple[float, float, int]:
    """Find the stress in a bracket, each temperature balanced at it; returns as ``equilibrium`` does."""
    low_pa, high_pa, stress_pa = 0.0, math.inf, guess_pa
    for evaluation in range(MAX_EVALUATIONS):
        warm_at(run, stress_pa)
        found = newton_at(run, stress_pa)
        close = abs(found.rise_pa) * run.constants.martensite_k_per_pa < 0.1 * SOLVED_K
        slack = stress_pa <= 0.0 and found.excess_pa > 0.0
        if slack or high_pa - low_pa < SMALL_BRACKET_PA or (close and bend_n(run, found) < SMALL_BEND_N):
            return stress_pa, 0.0, PLAIN_STEPS + evaluation + 1
        if found.excess_pa > 0.0:
            high_pa = stress_pa
        else:
            low_pa = stress_pa
        new_pa = stress_pa + found.rise_pa
        if not low_pa < new_pa < high_pa or evaluation > 60:
            new_pa = 0.5 * (low_pa + high_pa) if high_pa < math.inf else 2.0 * stress_pa + 1e7
            if found.excess_pa > 0.0 and low_pa == 0.0 and stress_pa < SMALL_BRACKET_PA:
                new_pa = 0.0
        stress_pa = new_pa
    return stress_pa, 0.0, -(PLAIN_STEPS + MAX_EVALUATIONS)


@compiled
def warm_at(run: CompiledSegments, stress_pa: float) -> None:
    """Find the temperature of each segment at a stress; the missing heat rises with it at least as the capacity."""
    per_capacity = run.constants.per_capacity_k_per_j
    for number in range(run.states.shape[0]):
        state = run.states[number]
        try_segment(run, number, stress_pa)
        reach_k = state.missing_j * per_capacity
        low_k, high_k = state.trial_k - max(reach_k, 0.0), state.trial_k - min(reach_k, 0.0)
        for evaluation in range(MAX_EVALUATIONS):
            rise_k = -state.missing_j / state.missing_per_k
            if abs(rise_k) < 1e-6 * SOLVED_K or high_k - low_k < 1e-6 * SOLVED_K:
                break
            if state.missing_j > 0.0:
                high_k = state.trial_k
            else:
                low_k = state.trial_k
            new_k = state.trial_k + rise_k
            state.trial_k = new_k if low_k < new_k < high_k and evaluation < 60 else 0.5 * (low_k + high_k)
            try_segment(run, number, stress_pa)


@compiled_inline
def limited(rise: float, heat_j: float, low: float, high: float) -> float:
    """Return a rise over a heat, within limits: the next middle is predicted by it.

    A load that jumps, or other segments, change a segment that takes hardly any heat: such a ratio means nothing.
    """
    slope = rise / heat_j if abs(heat_j) > 1e-12 else 0.0
    return min(max(slope, low), high)


@compiled_inline
def settle(run: CompiledSegments, number: int, stress_pa: float, rise_pa: float) -> None:
    """Move a segment to the solution: the last Newton step applied linearly, its temperature from its enthalpy.

    So energy is kept to rounding.
    """
    state, k = run.states[number], run.constants
    rise_k = -(state.missing_j + state.missing_per_pa * rise_pa) / state.missing_per_k
    for row in range(state.front_austenite.shape[0]):
        trial, place = state.front_trial, 6 * row
        state.front_austenite[row] = trial[place] + trial[place + 2] * rise_k + trial[place + 3] * rise_pa
        state.front_martensite[row] = trial[place + 1] + trial[place + 4] * rise_k + trial[place + 5] * rise_pa
    martensite = state.trial_martensite + state.trial_martensite_per_k * rise_k
    martensite += state.trial_martensite_per_pa * rise_pa
    r_phase = state.trial_r_phase + state.trial_r_phase_per_k * rise_k + state.trial_r_phase_per_pa * rise_pa
    state.enthalpy_j += state.heat_j
    transformed_j = k.latent_heat_j * (martensite + k.r_phase_entropy_ratio * r_phase)
    warm_k = (state.enthalpy_j + transformed_j) * k.per_capacity_k_per_j
    temperature_k = REFERENCE_TEMPERATURE_K + warm_k
    stress_pa = max(stress_pa + rise_pa, 0.0)
    strain: StrainSlopes = strain_at(k, temperature_k, stress_pa, martensite, r_phase)
    shakedown = no_shakedown(run.now)
    resistance_ohm = resistance_at(k, shakedown, strain, temperature_k, martensite, r_phase)
    heat_j = state.heat_j
    state.temperature_slope_k_per_j = limited(temperature_k - state.temperature_k, heat_j, 0.0, k.per_capacity_k_per_j)
    steepest = STEEPEST * resistance_ohm / (k.latent_heat_j + TEN_K * k.capacity_j_per_k)
    state.resistance_slope_ohm_per_j = limited(resistance_ohm - state.resistance_ohm, heat_j, -steepest, steepest)
    state.last_heat_j = heat_j
    state.contraction = contraction_of(k, shakedown, strain)
    state.temperature_k, state.resistance_ohm = temperature_k, resistance_ohm
    state.martensite_fraction, state.r_phase_fraction = martensite, r_phase
