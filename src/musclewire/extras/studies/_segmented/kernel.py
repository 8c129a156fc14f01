"""A wire in segments through a sample, compiled: heat into each segment, then all of them in balance with the load.

Electrically the segments are in series: one current, which the sum of their resistances determines. Thermally each has
its own convection and conducts to its neighbours, the two at the ends to the clamps.
"""

from __future__ import annotations

from musclewire.compiled import compiled, compiled_inline
from musclewire.extras.studies._segmented.solution import (
    CompiledSegments,
    equilibrium,
    load_after,
    no_shakedown,
    settle,
)
from musclewire.physics import REFERENCE_TEMPERATURE_K
from musclewire.wire import (
    Rows,
    RunningWire,
    contraction_of,
    convection_w_per_m2_k,
    cool_from_hot,
    loss_w,
    resistance_at,
    strain_at,
)

__all__ = ["advance_segments", "rest_segments"]


@compiled_inline
def loss_of(run: CompiledSegments, number: int, temperature_k: float) -> float:
    """Return what a segment at a temperature loses to the air [W]."""
    k = run.constants
    coefficient = convection_w_per_m2_k(k, k, temperature_k)
    lost_w: float = loss_w(k, coefficient, temperature_k) * run.places[number].convection_factor
    return lost_w


@compiled_inline
def conducted_w(run: CompiledSegments, number: int) -> float:
    """Return the heat that neighbours and clamps conduct into a segment [W], by the trial temperatures."""
    states, place = run.states, run.places[number]
    last = states.shape[0] - 1
    own_k = states[number].trial_k
    before_k = states[number - 1].trial_k if number > 0 else run.now.ambient_k
    after_k = states[number + 1].trial_k if number < last else run.now.ambient_k
    into_w: float = place.before_w_per_k * (before_k - own_k) + place.after_w_per_k * (after_k - own_k)
    return into_w


@compiled_inline
def current_at(run: CompiledSegments, resistance_ohm: float) -> float:
    """Return the current [A] through segments of a resistance, leads and shunt in series."""
    return run.now.drive_voltage_v / (resistance_ohm + run.now.inside_ohm + run.now.outside_ohm)


@compiled_inline
def look(run: CompiledSegments) -> None:
    """Write down current, power, losses and each segment's net power of this moment."""
    whole, setting = run.whole, run.now
    total_ohm = 0.0
    for number in range(run.states.shape[0]):
        state = run.states[number]
        state.trial_k = state.temperature_k
        total_ohm += run.places[number].weight * state.resistance_ohm
    whole.resistance_ohm = total_ohm * setting.resistance_factor
    whole.current_a = current_at(run, whole.resistance_ohm)
    heating = whole.current_a * whole.current_a * setting.resistance_factor
    power_w = air_w = clamps_w = 0.0
    for number in range(run.states.shape[0]):
        state, weight = run.states[number], run.places[number].weight
        own_w, lost_w = heating * state.resistance_ohm, loss_of(run, number, state.temperature_k)
        conducted = conducted_w(run, number)
        state.net_w = own_w - lost_w + conducted
        power_w += weight * own_w
        air_w += weight * lost_w
        clamps_w -= weight * conducted  # what neighbours exchange cancels
    whole.power_w, whole.air_w, whole.clamps_w = power_w, air_w, clamps_w


@compiled_inline
def heat_of_step(run: CompiledSegments, step_s: float) -> float:
    """Write down the heat of a step by the power in its middle, and trial temperatures; return the mean heat [J].

    The middle is predicted by the slopes over heat of the last step. After a turn from heating to cooling or back no
    phase changes at first: then the slope is that of the capacity without latent heat.
    """
    k, setting = run.constants, run.now
    middle_ohm = 0.0
    for number in range(run.states.shape[0]):
        state = run.states[number]
        half_j = 0.5 * step_s * state.net_w
        if half_j * state.last_heat_j < 0.0:
            state.temperature_slope_k_per_j, state.resistance_slope_ohm_per_j = k.per_capacity_k_per_j, 0.0
        state.trial_k = state.temperature_k + state.temperature_slope_k_per_j * half_j
        middle_ohm += run.places[number].weight * (state.resistance_ohm + state.resistance_slope_ohm_per_j * half_j)
    current_a = current_at(run, middle_ohm * setting.resistance_factor)
    heating = current_a * current_a * setting.resistance_factor
    mean_j = 0.0
    for number in range(run.states.shape[0]):
        state = run.states[number]
        predicted_ohm = state.resistance_ohm + state.resistance_slope_ohm_per_j * 0.5 * step_s * state.net_w
        state.middle_w = heating * predicted_ohm - loss_of(run, number, state.trial_k) + conducted_w(run, number)
        state.heat_j = state.middle_w * step_s + state.carried_heat_j
        mean_j += run.places[number].weight * state.heat_j
    for number in range(run.states.shape[0]):
        state = run.states[number]
        state.trial_k = state.temperature_k + state.temperature_slope_k_per_j * state.heat_j
    return mean_j


@compiled_inline
def accept(run: CompiledSegments, stress_pa: float, rise_pa: float, heat_j: float) -> None:
    """Move all segments and the connector to the solution."""
    whole = run.whole
    contraction = -run.now.zero_contraction
    cycles = 0.0
    for number in range(run.states.shape[0]):
        state, weight = run.states[number], run.places[number].weight
        before = state.martensite_fraction
        settle(run, number, stress_pa, rise_pa)
        cycles += 0.5 * weight * abs(state.martensite_fraction - before)
        contraction += weight * state.contraction
        whole.hottest_k = max(whole.hottest_k, state.temperature_k)
    after_pa = max(stress_pa + rise_pa, 0.0)
    if abs(heat_j) > 1e-12:
        whole.stress_slope_pa_per_j = (after_pa - whole.stress_pa) / heat_j
    whole.last_heat_j = heat_j
    whole.stress_pa, whole.contraction = after_pa, contraction
    whole.cycles += cycles
    held = after_pa <= 0.0 and contraction < whole.connector_contraction
    place = held_connector(run, contraction) if held else contraction
    whole.friction_n = load_after(run, place).friction_n
    whole.connector_contraction = place


@compiled_inline
def held_connector(run: CompiledSegments, contraction: float) -> float:
    """Return where the connector of a slack wire stays: the load pushes it back as far as it overcomes the friction."""
    setting, friction_n = run.now, run.constants.friction_n
    balanced = (friction_n - setting.force_n) / setting.spring_n if setting.spring_n > 0.0 else contraction
    return min(max(balanced, contraction), run.whole.connector_contraction)


@compiled_inline
def step_segments(run: CompiledSegments, step_s: float) -> None:
    """Advance all segments by a step, in place."""
    whole = run.whole
    power_w, air_w, clamps_w = whole.power_w, whole.air_w, whole.clamps_w
    mean_j = heat_of_step(run, step_s)
    slope = 0.0 if mean_j * whole.last_heat_j < 0.0 else whole.stress_slope_pa_per_j
    stress_pa, rise_pa, evaluations = equilibrium(run, max(whole.stress_pa + slope * mean_j, 0.0))
    whole.evaluations += abs(evaluations)
    if evaluations < 0:
        whole.unsolved_steps += 1.0
    for number in range(run.states.shape[0]):  # until the end's power is known: the start's half of the trapezoid
        state = run.states[number]
        state.carried_heat_j = (0.5 * state.net_w - state.middle_w) * step_s
    accept(run, stress_pa, rise_pa, mean_j)
    look(run)
    for number in range(run.states.shape[0]):
        state = run.states[number]
        state.carried_heat_j += 0.5 * state.net_w * step_s
        slope_k = max(state.temperature_slope_k_per_j, 0.0)
        whole.step_error_k = max(whole.step_error_k, abs(state.carried_heat_j) * slope_k)
    whole.heat_in_j += 0.5 * (power_w + whole.power_w) * step_s
    whole.heat_to_air_j += 0.5 * (air_w + whole.air_w) * step_s
    whole.heat_to_clamps_j += 0.5 * (clamps_w + whole.clamps_w) * step_s


@compiled
def advance_segments(
    states: Rows, places: Rows, wholes: Rows, settings: Rows, constants: Rows, cells: Rows, load: Rows
) -> tuple[float, float, float, float]:
    """Advance a wire in segments by a sample, in place.

    Parameters
    ----------
    states, places
        The segments, (n_segments,).
    wholes, settings, constants, cells, load
        Arrays of one record, (1,).

    Returns
    -------
    Means over the sample, by the trapezoidal rule: voltage of the wire with the leads inside [V], current [A],
    contraction of the connector, stress [Pa].
    """
    run = CompiledSegments(states, places, wholes[0], settings[0], constants[0], cells[0], load[0])
    whole, setting = run.whole, run.now
    look(run)
    steps = int(setting.steps)
    step_s = setting.duration_s / steps
    voltage = current = moved = stress = 0.0
    for _ in range(steps):
        voltage += whole.current_a * (whole.resistance_ohm + setting.inside_ohm)
        current += whole.current_a
        moved += whole.connector_contraction
        stress += whole.stress_pa
        step_segments(run, step_s)
        voltage += whole.current_a * (whole.resistance_ohm + setting.inside_ohm)
        current += whole.current_a
        moved += whole.connector_contraction
        stress += whole.stress_pa
    whole.time_s += setting.duration_s
    mean = 0.5 / steps
    return mean * voltage, mean * current, mean * moved, mean * stress


@compiled_inline
def rest_segment(run: CompiledSegments, number: int, stress_pa: float) -> None:
    """Set a segment to rest: cooled from hot at a stress, at the temperature of the air."""
    state = run.states[number]  # with the names of fronts and phases that a WireState has
    k, temperature_k = run.constants, run.now.ambient_k
    shift_k = run.places[number].temperature_shift_k + run.now.temperature_shift_k
    cool_from_hot(RunningWire(state, k, run.cells, run.load), temperature_k - shift_k, stress_pa)
    martensite, r_phase = state.martensite_fraction, state.r_phase_fraction
    strain = strain_at(k, temperature_k, stress_pa, martensite, r_phase)
    shakedown = no_shakedown(run.now)
    state.temperature_k = temperature_k
    state.enthalpy_j = k.capacity_j_per_k * (temperature_k - REFERENCE_TEMPERATURE_K) - k.latent_heat_j * (
        martensite + k.r_phase_entropy_ratio * r_phase
    )
    state.resistance_ohm = resistance_at(k, shakedown, strain, temperature_k, martensite, r_phase)
    state.contraction = contraction_of(k, shakedown, strain)
    state.temperature_slope_k_per_j = k.per_capacity_k_per_j


@compiled
def rest_segments(
    states: Rows, places: Rows, wholes: Rows, settings: Rows, constants: Rows, cells: Rows, load: Rows
) -> float:
    """Set a wire in segments to rest under the load at its zero, in place; return its contraction there."""
    run = CompiledSegments(states, places, wholes[0], settings[0], constants[0], cells[0], load[0])
    stress_pa = run.now.force_n * run.constants.per_section_m2
    contraction = 0.0
    for number in range(states.shape[0]):
        rest_segment(run, number, stress_pa)
        contraction += places[number].weight * states[number].contraction
    run.whole.stress_pa = stress_pa
    run.whole.hottest_k = run.now.ambient_k
    return contraction
