"""Many wires side by side in vector registers, compiled: one step of sixteen wires in a few loops over lanes.

Each loop calls the functions of one wire (``_fronts.py``, ``_balance.py``), which are free of branches, so that
the compiler makes vector instructions of it; look-ups in tables have loops of their own. A lane whose first Newton step
does not suffice is solved by the solver of one wire. All of it is strict IEEE 754 arithmetic in the order of one wire:
a wire in a batch has the same bits as alone.
"""

from __future__ import annotations

from musclewire.compiled import compiled, compiled_inline
from musclewire.wire._balance import TrialPoint, balance_at, contraction_of, convection_w_per_m2_k, settled, strain_at
from musclewire.wire._constants import StepConstants
from musclewire.wire._fronts import (
    PhaseFractions,
    ShakedownEffects,
    TransformationFronts,
    cumulative_at,
    fronts_after,
    phases_of_class,
)
from musclewire.wire._lane_layout import LANES, Block, constants_of_lane, state_of_lane
from musclewire.wire._row import Rows
from musclewire.wire._state import WireState
from musclewire.wire._step import (
    NO_HEAT_J,
    NO_PUSH,
    SMALL_BEND_N,
    SOLVED_K,
    HalfStepWire,
    RunningWire,
    accept,
    guess_after,
    load_at,
    middle_of_step,
    solve,
)
from musclewire.wire._stepping import SourceOutput, WireInstant, circuit_at, owed_j

__all__ = ["advance_block"]


@compiled_inline
def begin(b: Block, first: int, rows: Rows) -> None:
    """Take circuit and air at the start of a sample; its drives are in place."""
    for lane in range(LANES):
        k = constants_of_lane(b, lane)
        coefficient = convection_w_per_m2_k(k, rows[min(first + lane, rows.shape[0] - 1)], b.s_temperature_k[lane])
        drive = SourceOutput(b.t_drive_v[lane], False)
        now = circuit_at(k, drive, b.s_resistance_ohm[lane], b.s_temperature_k[lane], coefficient)
        b.t_current_a[lane], b.t_power_w[lane], b.t_loss_w[lane] = now.current_a, now.power_w, now.loss_w
        b.t_voltage_sum[lane] = b.t_current_sum[lane] = b.t_moved_sum[lane] = b.t_stress_sum[lane] = 0.0


@compiled_inline
def look_ahead(b: Block, step_s: float) -> None:
    """Predict the middle of the step in all lanes."""
    for lane in range(LANES):
        k, state = constants_of_lane(b, lane), state_of_lane(b, lane)
        middle = middle_of_step(state, k, 0.5 * step_s * (b.t_power_w[lane] - b.t_loss_w[lane]))
        b.t_middle_k[lane], b.t_middle_ohm[lane] = middle.temperature_k, middle.resistance_ohm
        b.t_temperature_slope[lane], b.t_stress_slope[lane] = (
            middle.temperature_slope_k_per_j,
            middle.stress_slope_pa_per_j,
        )
        b.t_resistance_ohm[lane], b.t_stress_pa[lane] = state.resistance_ohm, state.stress_pa
        b.t_connector_contraction[lane], b.t_friction_n[lane] = b.s_connector_contraction[lane], b.s_friction_n[lane]
        b.t_martensite[lane], b.t_cycles[lane] = b.s_martensite_fraction[lane], b.s_cycles[lane]
        b.t_resistance_slope[lane] = state.resistance_slope_ohm_per_j


@compiled_inline
def look_up_middle(b: Block, first: int, rows: Rows) -> None:
    """Look up the air's coefficient at the middle of the step, lane by lane."""
    for lane in range(LANES):
        k = constants_of_lane(b, lane)
        b.t_coefficient[lane] = convection_w_per_m2_k(k, rows[min(first + lane, rows.shape[0] - 1)], b.t_middle_k[lane])


@compiled_inline
def look_up_end(b: Block, first: int, rows: Rows) -> None:
    """Look up the air's coefficient at the end of the step, lane by lane."""
    for lane in range(LANES):
        k = constants_of_lane(b, lane)
        b.t_coefficient[lane] = convection_w_per_m2_k(
            k, rows[min(first + lane, rows.shape[0] - 1)], b.s_temperature_k[lane]
        )


@compiled_inline
def guess(b: Block, step_s: float) -> None:
    """Take the heat of the step, and guess temperature and stress at its end, in all lanes."""
    for lane in range(LANES):
        k, state = constants_of_lane(b, lane), state_of_lane(b, lane)
        drive = SourceOutput(b.t_drive_v[lane], False)
        within = circuit_at(k, drive, b.t_middle_ohm[lane], b.t_middle_k[lane], b.t_coefficient[lane])
        heat_j = (within.power_w - within.loss_w) * step_s + b.s_carried_heat_j[lane]
        middle = HalfStepWire(
            b.t_middle_k[lane], b.t_middle_ohm[lane], b.t_temperature_slope[lane], b.t_stress_slope[lane]
        )
        trial = guess_after(state, middle, heat_j)
        b.t_within_w[lane] = within.power_w - within.loss_w
        b.t_heat_j[lane] = heat_j
        b.t_trial_k[lane], b.t_trial_pa[lane] = trial


@compiled_inline
def move_fronts(b: Block, row: int) -> None:
    """Let the fronts of a class follow the guess, in all lanes."""
    for lane in range(LANES):
        k = constants_of_lane(b, lane)
        before = (b.s_front_austenite[row, lane], b.s_front_martensite[row, lane])
        b.t_class_austenite_before[row, lane], b.t_class_martensite_before[row, lane] = before
        after = fronts_after(k, b.t_trial_k[lane], b.t_trial_pa[lane], 1.0, b.k_class_barrier_k[row, lane], before)
        b.t_class_austenite[row, lane], b.t_class_martensite[row, lane] = after.austenite, after.martensite
        b.t_class_austenite_per_k[row, lane], b.t_class_austenite_per_pa[row, lane] = (
            after.austenite_per_k,
            after.austenite_per_pa,
        )
        b.t_class_martensite_per_k[row, lane] = after.martensite_per_k
        b.t_class_martensite_per_pa[row, lane] = after.martensite_per_pa


@compiled_inline
def look_up_martensite(b: Block, cells: Rows, row: int) -> None:
    """Look up the distribution at the martensite fronts of a class, lane by lane."""
    for lane in range(LANES):
        found = cumulative_at(constants_of_lane(b, lane), cells, row, b.t_class_martensite[row, lane])
        b.t_class_martensite_fraction[row, lane], b.t_class_martensite_density[row, lane] = found


@compiled_inline
def look_up_austenite(b: Block, cells: Rows, row: int) -> None:
    """Look up the distribution at the austenite fronts of a class, lane by lane."""
    for lane in range(LANES):
        found = cumulative_at(constants_of_lane(b, lane), cells, row, b.t_class_austenite[row, lane])
        b.t_class_austenite_fraction[row, lane], b.t_class_austenite_density[row, lane] = found


@compiled_inline
def fronts_of_lane(b: Block, row: int, lane: int) -> TransformationFronts:
    """Return the fronts of a class that follow from the guess."""
    return TransformationFronts(
        b.t_class_austenite[row, lane],
        b.t_class_martensite[row, lane],
        b.t_class_austenite_per_k[row, lane],
        b.t_class_austenite_per_pa[row, lane],
        b.t_class_martensite_per_k[row, lane],
        b.t_class_martensite_per_pa[row, lane],
    )


@compiled_inline
def phases_of_lane(b: Block, lane: int) -> PhaseFractions:
    """Return the volume fractions that follow from the guess."""
    whole = PhaseFractions(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for row in range(b.k_class_weight.shape[0]):
        martensite = (b.t_class_martensite_fraction[row, lane], b.t_class_martensite_density[row, lane])
        austenite = (b.t_class_austenite_fraction[row, lane], b.t_class_austenite_density[row, lane])
        part = phases_of_class(b.k_class_weight[row, lane], fronts_of_lane(b, row, lane), martensite, austenite)
        whole = PhaseFractions(
            whole.martensite + part.martensite,
            whole.r_phase + part.r_phase,
            whole.martensite_per_k + part.martensite_per_k,
            whole.martensite_per_pa + part.martensite_per_pa,
            whole.r_phase_per_k + part.r_phase_per_k,
            whole.r_phase_per_pa + part.r_phase_per_pa,
        )
    return whole


@compiled_inline
def settle(b: Block, load: Rows) -> None:
    """Take Newton's step in all lanes, move their states, and mark the lanes in which it does not suffice.

    A marked lane keeps nothing of this: it is overwritten by the solver of one wire.
    """
    for lane in range(LANES):
        k = constants_of_lane(b, lane)
        over = ShakedownEffects(1.0, 0.0, 1.0)
        heat_j, trial_k, trial_pa = b.t_heat_j[lane], b.t_trial_k[lane], b.t_trial_pa[lane]
        before = (b.s_connector_contraction[lane], b.s_friction_n[lane])
        resistance_before, slope_before = b.s_resistance_ohm[lane], b.s_resistance_slope_ohm_per_j[lane]
        enthalpy_j = b.s_enthalpy_j[lane] + heat_j
        phases = phases_of_lane(b, lane)
        strain = strain_at(k, trial_k, trial_pa, phases.martensite, phases.r_phase)
        force = load_at(k, load, contraction_of(k, over, strain), before, NO_PUSH)
        balance = balance_at(k, over, phases, strain, force, (trial_k, trial_pa, enthalpy_j))
        point = TrialPoint(phases, strain, force, balance)
        rise_k, rise_pa = balance.rise_k, balance.rise_pa
        after = settled(k, over, point, (rise_k, rise_pa), (trial_k, trial_pa, enthalpy_j))
        moved = balance.contraction_per_k * rise_k + balance.contraction_per_pa * rise_pa
        beyond = load_at(k, load, balance.contraction + moved, before, NO_PUSH)
        bend_n = abs(beyond.force_n - (force.force_n + force.per_contraction_n * moved))
        small = (abs(rise_k) < SOLVED_K) & (abs(rise_pa) * k.martensite_k_per_pa < SOLVED_K)
        taut = (trial_pa > 0.0) & (after.stress_pa > 0.0)
        b.t_missed[lane] = 0.0 if small & taut & (bend_n < SMALL_BEND_N) else 1.0
        slope = (after.resistance_ohm - resistance_before) / heat_j
        b.s_resistance_slope_ohm_per_j[lane] = slope if abs(heat_j) > NO_HEAT_J else slope_before
        b.s_enthalpy_j[lane] = enthalpy_j
        b.s_cycles[lane] += 0.5 * abs(after.martensite - b.s_martensite_fraction[lane])
        b.s_last_heat_j[lane] = heat_j
        temperature_slope = balance.excess_per_pa * balance.per_determinant
        stress_slope = -balance.excess_per_k * balance.per_determinant
        b.s_temperature_slope_k_per_j[lane], b.s_stress_slope_pa_per_j[lane] = temperature_slope, stress_slope
        b.s_contraction_slope_per_j[lane] = (
            balance.contraction_per_k * temperature_slope + balance.contraction_per_pa * stress_slope
        )
        b.s_temperature_k[lane], b.s_stress_pa[lane] = after.temperature_k, after.stress_pa
        b.s_contraction[lane] = b.s_connector_contraction[lane] = after.contraction
        b.s_friction_n[lane] = after.friction_n
        b.s_martensite_fraction[lane], b.s_r_phase_fraction[lane] = after.martensite, after.r_phase
        b.s_resistance_ohm[lane] = after.resistance_ohm
        for row in range(b.k_class_weight.shape[0]):
            front = fronts_of_lane(b, row, lane)
            b.s_front_austenite[row, lane] = (
                front.austenite + front.austenite_per_k * rise_k + front.austenite_per_pa * rise_pa
            )
            b.s_front_martensite[row, lane] = (
                front.martensite + front.martensite_per_k * rise_k + front.martensite_per_pa * rise_pa
            )


@compiled
def solve_lane(b: Block, lane: int, constants: StepConstants, cells: Rows, load: Rows, scratch: WireState) -> None:
    """Solve one lane by the solver of one wire, from the same guess, and overwrite its state."""
    for row in range(b.k_class_weight.shape[0]):
        scratch.front_austenite[row] = b.t_class_austenite_before[row, lane]
        scratch.front_martensite[row] = b.t_class_martensite_before[row, lane]
    scratch.connector_contraction, scratch.friction_n = b.t_connector_contraction[lane], b.t_friction_n[lane]
    scratch.martensite_fraction, scratch.cycles = b.t_martensite[lane], b.t_cycles[lane]
    scratch.resistance_ohm, scratch.resistance_slope_ohm_per_j = b.t_resistance_ohm[lane], b.t_resistance_slope[lane]
    scratch.unsolved_steps = b.s_unsolved_steps[lane]
    wire = RunningWire(scratch, constants, cells, load)
    trial = (b.t_trial_k[lane], b.t_trial_pa[lane])
    found = solve(wire, ShakedownEffects(1.0, 0.0, 1.0), b.s_enthalpy_j[lane], trial, NO_PUSH)
    accept(wire, found, b.t_heat_j[lane], NO_PUSH)
    for row in range(b.k_class_weight.shape[0]):
        b.s_front_austenite[row, lane] = scratch.front_austenite[row]
        b.s_front_martensite[row, lane] = scratch.front_martensite[row]
    b.s_temperature_k[lane], b.s_stress_pa[lane] = scratch.temperature_k, scratch.stress_pa
    b.s_contraction[lane], b.s_connector_contraction[lane] = scratch.contraction, scratch.connector_contraction
    b.s_friction_n[lane], b.s_cycles[lane] = scratch.friction_n, scratch.cycles
    b.s_martensite_fraction[lane], b.s_r_phase_fraction[lane] = scratch.martensite_fraction, scratch.r_phase_fraction
    b.s_resistance_ohm[lane] = scratch.resistance_ohm
    b.s_temperature_slope_k_per_j[lane] = scratch.temperature_slope_k_per_j
    b.s_stress_slope_pa_per_j[lane] = scratch.stress_slope_pa_per_j
    b.s_contraction_slope_per_j[lane] = scratch.contraction_slope_per_j
    b.s_resistance_slope_ohm_per_j[lane] = scratch.resistance_slope_ohm_per_j
    b.s_unsolved_steps[lane] = scratch.unsolved_steps


@compiled_inline
def finish(b: Block, step_s: float) -> None:
    """Make up the accounts of the step in all lanes: heat, what it owes, error and means."""
    for lane in range(LANES):
        k = constants_of_lane(b, lane)
        drive = SourceOutput(b.t_drive_v[lane], False)
        ended = circuit_at(k, drive, b.s_resistance_ohm[lane], b.s_temperature_k[lane], b.t_coefficient[lane])
        started = WireInstant(b.t_current_a[lane], b.t_power_w[lane], b.t_loss_w[lane])
        owes_j = owed_j(started, WireInstant(0.0, b.t_within_w[lane], 0.0), ended, step_s)
        slope_before, slope_after = b.t_temperature_slope[lane], b.s_temperature_slope_k_per_j[lane]
        error_k = abs(owes_j) * (slope_after if slope_after > slope_before else slope_before)
        error_before_k = b.s_step_error_k[lane]
        b.s_carried_heat_j[lane] = owes_j
        b.s_heat_in_j[lane] += 0.5 * (started.power_w + ended.power_w) * step_s
        b.s_heat_out_j[lane] += 0.5 * (started.loss_w + ended.loss_w) * step_s
        b.s_step_error_k[lane] = error_k if error_k > error_before_k else error_before_k
        b.t_voltage_sum[lane] += step_s * (
            started.current_a * b.t_resistance_ohm[lane] + ended.current_a * b.s_resistance_ohm[lane]
        )
        b.t_current_sum[lane] += step_s * (started.current_a + ended.current_a)
        b.t_moved_sum[lane] += step_s * (b.t_connector_contraction[lane] + b.s_connector_contraction[lane])
        b.t_stress_sum[lane] += step_s * (b.t_stress_pa[lane] + b.s_stress_pa[lane])
        b.t_current_a[lane], b.t_power_w[lane], b.t_loss_w[lane] = ended.current_a, ended.power_w, ended.loss_w


@compiled
def advance_block(
    b: Block, first: int, rows: Rows, tables: tuple[Rows, Rows], scratch: WireState, step_s: float, steps: int
) -> None:
    """Advance a block in place by a sample of fixed steps; its drives are in ``t_drive_v``.

    ``rows`` are the derived constants of all wires, (n_wires,), of which ``first`` is in lane 0; ``tables`` the records
    of distribution and load; ``scratch`` a state to work with.
    """
    cells, load = tables
    begin(b, first, rows)
    for _ in range(steps):
        look_ahead(b, step_s)
        look_up_middle(b, first, rows)
        guess(b, step_s)
        for row in range(b.k_class_weight.shape[0]):
            move_fronts(b, row)
            look_up_martensite(b, cells, row)
            look_up_austenite(b, cells, row)
        settle(b, load)
        missed = 0.0
        for lane in range(LANES):
            missed += b.t_missed[lane]
        if missed > 0.0:
            for lane in range(LANES):
                if b.t_missed[lane] > 0.0:
                    solve_lane(b, lane, rows[min(first + lane, rows.shape[0] - 1)], cells, load, scratch)
        look_up_end(b, first, rows)
        finish(b, step_s)
