"""A wire in segments through a sample, compiled: each segment is a wire, and all of them carry one stress.

Electrically the segments are in series: one current, which the sum of their resistances determines. Thermally each has
its own convection and conducts to its neighbours, the two at the ends to the clamps. Mechanically they share the force
of the load, and their contractions add up at the connector: a Newton iteration finds the stress at which both agree,
each segment solved for it as a wire under a dead weight. The wire as a whole, with the means of its segments, is
judged and moved like a single one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inline
from musclewire.wire import (
    DURATION,
    MIN_STEP_S,
    NO_PUSH,
    BalancedWire,
    ConnectorForce,
    Equilibrium,
    Row,
    Rows,
    RunningWire,
    StepAttempt,
    WireInstant,
    accept,
    accept_step,
    convection_w_per_m2_k,
    error_ratio,
    field,
    guess_after,
    load_at,
    longest_step_s,
    loss_w,
    middle_of_step,
    next_step_s,
    rises_over,
    shakedown_of,
    shorter_step_s,
    solve,
)


class SegmentPlace(Row):
    """Where a segment lies, and its numbers of the step in progress."""

    weight: float = field("1", "fraction of the wire's length")
    before_w_per_k: float = field("W/K", "conductance to the segment before, or to the clamp")
    after_w_per_k: float = field("W/K", "conductance to the segment after, or to the clamp")
    trial_k: float = field("K", "temperature at the moment that is looked at")
    trial_ohm: float = field("ohm", "resistance at that moment")
    net_w: float = field("W", "power less loss and conduction at that moment")
    started_w: float = field("W", "the same at the start of the step")
    within_w: float = field("W", "the same in the middle of the step")
    heat_j: float = field("J", "heat of the step")


class SegmentSums(Row):
    """Sums since the start that a wire does not have."""

    heat_to_clamps_j: float = field("J", "heat lost to the clamps since the start")
    hottest_k: float = field("K", "highest temperature of any segment since the start")


# The stress is found to within this: the force to some 2e-7 N.
CLOSE_PA = 10.0
PLAIN_TRIALS = 12  # of plain Newton, after which every second trial halves the bracket
MAX_TRIALS = 100  # after which the step counts as unsolved
NO_HEAT_J = 1e-12


class CompiledSegments(NamedTuple):
    """A wire in segments in compiled code."""

    states: Rows  # of the segments
    trials: Rows  # what they would be after the step that is tried
    constants: Rows  # of each segment, without a load of its own
    places: Rows  # where each segment lies
    whole: RunningWire  # the wire on its load, with means of phases, temperature and resistance
    sums: SegmentSums  # what only a wire in segments adds up


class SegmentsCircuit(NamedTuple):
    """Circuit during a sample: drive [V], and leads and contacts within the measured voltage of the wire [ohm]."""

    drive_voltage_v: float
    inside_ohm: float


class SegmentsInstant(NamedTuple):
    """All segments at one moment: circuit and loss of the whole wire, its resistance, and what goes to the clamps."""

    whole: WireInstant
    resistance_ohm: float
    clamps_w: float


class CommonStress(NamedTuple):
    """A stress in balance with the load [Pa], the contraction at it, and whether all balances are met."""

    stress_pa: float
    contraction: float
    friction_n: float
    solved: bool


@compiled_inline
def conducted_w(run: CompiledSegments, number: int) -> float:
    """Return the heat that neighbours and clamps conduct into a segment [W], by the temperatures looked at."""
    places, place = run.places, run.places[number]
    ambient_k = run.constants[number].ambient_temperature_k
    before_k = places[number - 1].trial_k if number > 0 else ambient_k
    after_k = places[number + 1].trial_k if number < places.shape[0] - 1 else ambient_k
    into_w: float = place.before_w_per_k * (before_k - place.trial_k) + place.after_w_per_k * (after_k - place.trial_k)
    return into_w


@compiled_inline
def instant_of_segments(run: CompiledSegments, circuit: SegmentsCircuit) -> SegmentsInstant:
    """Return the wire in its circuit and in the air at the temperatures looked at; each segment gets its net power."""
    total_ohm = 0.0
    for number in range(run.places.shape[0]):
        total_ohm += run.places[number].weight * run.places[number].trial_ohm
    in_series_ohm = circuit.inside_ohm + run.whole.constants.series_resistance_ohm
    current_a = circuit.drive_voltage_v / (total_ohm + in_series_ohm)
    lost_w = clamps_w = 0.0
    for number in range(run.places.shape[0]):
        place, k = run.places[number], run.constants[number]
        air_w = loss_w(k, convection_w_per_m2_k(k, k, place.trial_k), place.trial_k)
        conducted = conducted_w(run, number)
        place.net_w = current_a * current_a * place.trial_ohm - air_w + conducted
        lost_w += place.weight * (air_w - conducted)
        clamps_w -= place.weight * conducted  # what neighbours exchange cancels
    return SegmentsInstant(WireInstant(current_a, current_a * current_a * total_ohm, lost_w), total_ohm, clamps_w)


@compiled_inline
def heat_of_step(run: CompiledSegments, circuit: SegmentsCircuit, step_s: float) -> tuple[SegmentsInstant, float]:
    """Return the wire in the middle of a step, and the mean heat [J]; each segment gets its heat and its guess."""
    for number in range(run.states.shape[0]):
        state, place = run.states[number], run.places[number]
        middle = middle_of_step(state, run.constants[number], 0.5 * step_s * place.started_w)
        place.trial_k, place.trial_ohm = middle.temperature_k, middle.resistance_ohm
    within = instant_of_segments(run, circuit)
    mean_j = 0.0
    for number in range(run.states.shape[0]):
        state, place = run.states[number], run.places[number]
        middle = middle_of_step(state, run.constants[number], 0.5 * step_s * place.started_w)
        place.within_w = place.net_w
        place.heat_j = place.net_w * step_s + state.carried_heat_j
        place.trial_k, _ = guess_after(state, middle, place.heat_j)
        mean_j += place.weight * place.heat_j
    return within, mean_j


@compiled
def solve_segment(run: CompiledSegments, number: int, stress_pa: float) -> Equilibrium:
    """Return a segment at its enthalpy and a stress; its trial is moved there."""
    state, k, place = run.states[number], run.constants[number], run.places[number]
    wire = RunningWire(state, k, run.whole.cells, run.whole.load)
    push = ConnectorForce(stress_pa * k.section_m2, 0.0, 0.0)
    guess = (place.trial_k, stress_pa)
    found = solve(wire, shakedown_of(k, state.cycles), state.enthalpy_j + place.heat_j, guess, push)
    run.trials[number] = state
    accept(RunningWire(run.trials[number], k, run.whole.cells, run.whole.load), found, place.heat_j, push)
    place.trial_k = found.wire.temperature_k
    return found


@compiled_inline
def balance_segments(run: CompiledSegments, guess_pa: float) -> CommonStress:
    """Find the stress at which the segments contract to where the load has it, by Newton's method in a bracket."""
    k, state = run.whole.constants, run.whole.state
    before = (state.connector_contraction, state.friction_n)
    low_pa, high_pa, stress_pa = 0.0, math.inf, guess_pa
    trials = 0
    while True:
        trials += 1
        contraction = per_pa = 0.0
        solved = True
        for number in range(run.states.shape[0]):
            found, weight = solve_segment(run, number, stress_pa), run.places[number].weight
            contraction += weight * found.wire.contraction
            per_pa += weight / found.stress_per_contraction_pa
            solved = solved and found.solved
        load = load_at(k, run.whole.load, contraction, before, NO_PUSH)
        excess_pa = stress_pa - load.force_n * k.per_section_m2
        rise_pa = -excess_pa / (1.0 - load.per_contraction_n * per_pa * k.per_section_m2)
        slack = stress_pa <= 0.0 and excess_pa >= 0.0
        close = slack or abs(excess_pa) < CLOSE_PA or high_pa - low_pa < 1e-3 * CLOSE_PA
        if close or trials >= MAX_TRIALS or not abs(rise_pa) < math.inf:
            return CommonStress(stress_pa, contraction, load.friction_n, solved and close)
        if excess_pa > 0.0:
            high_pa = stress_pa
        else:
            low_pa = stress_pa
        after_pa = max(stress_pa + rise_pa, 0.0)
        halve = trials > PLAIN_TRIALS and trials % 2 == 0
        if halve or not (low_pa < after_pa < high_pa or after_pa == low_pa == 0.0):
            after_pa = 0.5 * (low_pa + high_pa) if high_pa < math.inf else 2.0 * stress_pa + 1e7
        stress_pa = after_pa


@compiled_inline
def judge_segment(run: CompiledSegments, number: int, step_s: float) -> float:
    """Return the error of a segment's temperature in a step [K]; its trial gets what it owes, and its slopes."""
    state, trial, k, place = run.states[number], run.trials[number], run.constants[number], run.places[number]
    trial.carried_heat_j = (0.5 * (place.started_w + place.net_w) - place.within_w) * step_s
    slopes = rises_over(k, state, trial, place.heat_j)
    trial.temperature_slope_k_per_j = slopes.temperature_k_per_j
    trial.resistance_slope_ohm_per_j = slopes.resistance_ohm_per_j
    error_k: float = abs(trial.carried_heat_j) * trial.temperature_slope_k_per_j
    return error_k


@compiled_inline
def mean_wire(run: CompiledSegments, found: CommonStress, mean_j: float, evaluations: int) -> Equilibrium:
    """Return the wire as a whole at the trials of its segments, with its slopes over the mean heat."""
    state = run.whole.state
    temperature_k = martensite = r_phase = resistance_ohm = 0.0
    for number in range(run.trials.shape[0]):
        trial, weight = run.trials[number], run.places[number].weight
        temperature_k += weight * trial.temperature_k
        martensite += weight * trial.martensite_fraction
        r_phase += weight * trial.r_phase_fraction
        resistance_ohm += weight * trial.resistance_ohm
    after = BalancedWire(
        temperature_k,
        found.stress_pa,
        found.contraction,
        found.friction_n,
        martensite,
        r_phase,
        resistance_ohm,
        0.0,
        0.0,
    )
    per_j = 1.0 / mean_j if abs(mean_j) > NO_HEAT_J else 0.0
    return Equilibrium(
        after,
        (temperature_k - state.temperature_k) * per_j,
        (found.stress_pa - state.stress_pa) * per_j,
        (found.contraction - state.contraction) * per_j,
        0.0,
        evaluations,
        found.solved,
    )


@compiled_inline
def attempt_segments(
    run: CompiledSegments, circuit: SegmentsCircuit, step_s: float
) -> tuple[StepAttempt, SegmentsInstant]:
    """Return a step of the wire as a whole, and its end; the segments' trials are there, the segments do not move."""
    state = run.whole.state
    within, mean_j = heat_of_step(run, circuit, step_s)
    slope = 0.0 if mean_j * state.last_heat_j < 0.0 else state.stress_slope_pa_per_j
    balanced = balance_segments(run, max(state.stress_pa + slope * mean_j, 0.0))
    counted = 0
    for number in range(run.trials.shape[0]):
        trial, place = run.trials[number], run.places[number]
        place.trial_k, place.trial_ohm = trial.temperature_k, trial.resistance_ohm
        counted += int(trial.evaluations - run.states[number].evaluations)
    found = mean_wire(run, balanced, mean_j, counted)
    ended = instant_of_segments(run, circuit)
    owes_j = error_k = 0.0
    for number in range(run.trials.shape[0]):
        error_k = max(error_k, judge_segment(run, number, step_s))
        owes_j += run.places[number].weight * run.trials[number].carried_heat_j
    return StepAttempt(found, within.whole, ended.whole, mean_j, owes_j, error_k), ended


@compiled_inline
def accept_segments(
    run: CompiledSegments, tried: StepAttempt, started: SegmentsInstant, ended: SegmentsInstant, step_s: float
) -> None:
    """Move the segments and the wire as a whole by a step that was tried, in place."""
    accept_step(run.whole, tried, started.whole, step_s)
    cycles = 0.0
    for number in range(run.states.shape[0]):
        run.states[number] = run.trials[number]
        run.places[number].started_w = run.places[number].net_w
        cycles += run.places[number].weight * run.states[number].cycles
        run.sums.hottest_k = max(run.sums.hottest_k, run.states[number].temperature_k)
    run.whole.state.cycles = cycles
    run.sums.heat_to_clamps_j += 0.5 * (started.clamps_w + ended.clamps_w) * step_s


@compiled
def advance_segments(
    rows: tuple[Rows, Rows, Rows, Rows],
    whole: tuple[Rows, Rows, Rows, Rows],
    sums: Rows,
    circuit_values: tuple[float, float],
    plan: FloatArray,
    longest_s: float,
) -> tuple[float, float, float, float]:
    """Advance a wire in segments by a sample, in place; return voltage [V], current [A], contraction, stress [Pa].

    These are means by the trapezoidal rule; the voltage includes leads and contacts [ohm], given with the drive [V].
    ``rows`` are states, room for trials, constants and places, (n_segments,) each; ``whole`` and ``sums`` arrays of one
    record.
    """
    one = RunningWire(whole[0][0], whole[1][0], whole[2][0], whole[3][0])
    run = CompiledSegments(rows[0], rows[1], rows[2], rows[3], one, sums[0])
    circuit, state = SegmentsCircuit(circuit_values[0], circuit_values[1]), one.state
    for number in range(run.states.shape[0]):
        place, segment = run.places[number], run.states[number]
        place.trial_k, place.trial_ohm = segment.temperature_k, segment.resistance_ohm
    started = instant_of_segments(run, circuit)
    for number in range(run.states.shape[0]):
        run.places[number].started_w = run.places[number].net_w
    left_s = duration_s = plan[DURATION]
    step_s = min(longest_step_s(state, duration_s), longest_s)
    voltage = current = moved = stress = 0.0
    while left_s > 0.0:
        step_s = left_s / math.ceil(left_s / step_s * (1.0 - 1e-9))
        tried, ended = attempt_segments(run, circuit, step_s)
        ratio = error_ratio(state, tried, started.whole, step_s, plan)
        if ratio > 1.0 and step_s > MIN_STEP_S:
            step_s = shorter_step_s(step_s, ratio)
            continue
        state.step_s = min(next_step_s(step_s, ratio), longest_s)
        connector, stress_pa = state.connector_contraction, state.stress_pa
        accept_segments(run, tried, started, ended, step_s)
        voltage += step_s * started.whole.current_a * (started.resistance_ohm + circuit.inside_ohm)
        voltage += step_s * ended.whole.current_a * (ended.resistance_ohm + circuit.inside_ohm)
        current += step_s * (started.whole.current_a + ended.whole.current_a)
        moved += step_s * (connector + state.connector_contraction)
        stress += step_s * (stress_pa + state.stress_pa)
        started = ended
        left_s -= step_s
        step_s = state.step_s
    state.time_s += duration_s
    mean = 0.5 / duration_s
    return mean * voltage, mean * current, mean * moved, mean * stress
