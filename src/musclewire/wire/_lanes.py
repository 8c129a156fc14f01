"""Sixteen wires side by side in vector registers, compiled: a sample of fixed steps of all of them in a few loops.

Each loop calls the functions of one wire (``_fronts.py``, ``_balance.py``, ``_step.py``), which are free of branches,
so that the compiler makes vector instructions of it; look-ups in tables have loops of their own. While a block runs,
its states and constants lie lane by lane next to what a step works with. A wire whose first Newton step does not
suffice is solved in its row by the solver of one wire. All of it is strict IEEE 754 arithmetic in the order of one
wire: a wire here has the same bits as alone.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled_inline, compiled_inner
from musclewire.wire._balance import TrialPoint, balance_at, contraction_of, convection_w_per_m2_k, settled, strain_at
from musclewire.wire._fronts import (
    PhaseFractions,
    ShakedownEffects,
    TransformationFronts,
    cumulative_at,
    fronts_after,
    phases_of_class,
)
from musclewire.wire._lane_views import (
    CONSTANTS,
    WIRE,
    constants_in,
    give_wire,
    take_constants,
    take_wire,
    wire_in,
)
from musclewire.wire._row import CLASSES, Rows, StepConstants, WireState
from musclewire.wire._step import (
    NO_HEAT_J,
    NO_PUSH,
    SMALL_BEND_N,
    SOLVED_K,
    Equilibrium,
    HalfStepWire,
    RunningWire,
    connector_after,
    equilibrium_of,
    guess_after,
    load_at,
    middle_of_step,
    solve,
)
from musclewire.wire._stepping import DURATION, STEPS, VOLTAGE, SourceOutput, WireInstant, circuit_at, owed_j

# Wires in a block: two of the widest vector registers. Eight would be unrolled into scalar code.
LANES = 16

# With more lanes than this in which a Newton step does not suffice, another one for all is quicker than the solver.
FEW = 3.0

# A record of ``workspace`` in compiled code.
Workspace = Any

# Numbers of a step in progress, a lane each: drive and circuit at its start, its middle, the guess, what Newton's step
# finds, and the sums over the sample.
IN_PROGRESS = [
    "drive_v",
    "current_a",
    "power_w",
    "loss_w",
    "middle_k",
    "middle_ohm",
    "middle_temperature_slope",
    "middle_stress_slope",
    "coefficient",
    "within_w",
    "heat_j",
    "trial_k",
    "trial_pa",
    "missed",
    "evaluations",
    "rise_k",
    "rise_pa",
    "temperature_k",
    "stress_pa",
    "contraction",
    "connector_contraction",
    "friction_n",
    "martensite",
    "r_phase",
    "resistance_ohm",
    "temperature_slope",
    "stress_slope",
    "contraction_slope",
    "voltage_sum",
    "current_sum",
    "moved_sum",
    "stress_sum",
]
# Per class and lane: both fronts with their slopes, and the distribution at both.
CLASS_IN_PROGRESS = [
    "class_austenite",
    "class_martensite",
    "class_austenite_per_k",
    "class_austenite_per_pa",
    "class_martensite_per_k",
    "class_martensite_per_pa",
    "class_martensite_fraction",
    "class_martensite_density",
    "class_austenite_fraction",
    "class_austenite_density",
]


@cache
def workspace_layout(classes: int) -> np.dtype[np.void]:
    """Return the layout of a workspace: the same object for the same number of classes."""
    plain: list[tuple[str, str, tuple[int, ...]]] = [(name, "f8", (LANES,)) for name in IN_PROGRESS]
    per_class: list[tuple[str, str, tuple[int, ...]]] = [(name, "f8", (classes, LANES)) for name in CLASS_IN_PROGRESS]
    wires = [
        (f"{WIRE}{item.name}", "f8", (*item.shape(classes), LANES))
        for item in WireState.fields
        if item.length in (None, CLASSES)
    ]
    # The air's table stays in the row: it is looked up and has no place in a vector.
    constants = [
        (f"{CONSTANTS}{item.name}", "f8", (*item.shape(classes), LANES))
        for item in StepConstants.fields
        if item.length in (None, CLASSES)
    ]
    return np.dtype((np.record, [*plain, *per_class, *wires, *constants]))


def workspace(classes: int) -> Rows:
    """Return room for the step of a block of wires with so many classes of barrier, an array of one record, (1,)."""
    return np.zeros(1, workspace_layout(classes))


@compiled_inline
def look_up_air(rows: Rows, work: Workspace, temperature_k: FloatArray) -> None:
    """Look up the air's coefficient at a temperature of each lane, in the tables of the wires' rows of constants."""
    for lane in range(LANES):
        work.coefficient[lane] = convection_w_per_m2_k(constants_in(work, lane), rows[lane], temperature_k[lane])


@compiled_inline
def begin(rows: Rows, work: Workspace) -> None:
    """Take circuit and air at the start of a sample; its drives are in place."""
    for lane in range(LANES):
        work.temperature_k[lane] = wire_in(work, lane).temperature_k
    look_up_air(rows, work, work.temperature_k)
    for lane in range(LANES):
        state, drive = wire_in(work, lane), SourceOutput(work.drive_v[lane], VOLTAGE)
        now = circuit_at(
            constants_in(work, lane), drive, state.resistance_ohm, state.temperature_k, work.coefficient[lane]
        )
        work.current_a[lane], work.power_w[lane], work.loss_w[lane] = now.current_a, now.power_w, now.loss_w
        work.voltage_sum[lane] = work.current_sum[lane] = work.moved_sum[lane] = work.stress_sum[lane] = 0.0


@compiled_inline
def look_ahead(work: Workspace, step_s: float) -> None:
    """Predict the middle of the step in all lanes."""
    for lane in range(LANES):
        half_heat_j = 0.5 * step_s * (work.power_w[lane] - work.loss_w[lane])
        middle = middle_of_step(wire_in(work, lane), constants_in(work, lane), half_heat_j)
        work.middle_k[lane], work.middle_ohm[lane] = middle.temperature_k, middle.resistance_ohm
        work.middle_temperature_slope[lane] = middle.temperature_slope_k_per_j
        work.middle_stress_slope[lane] = middle.stress_slope_pa_per_j
        work.evaluations[lane] = 1.0


@compiled_inline
def guess(work: Workspace, step_s: float) -> None:
    """Take the heat of the step, and guess temperature and stress at its end, in all lanes."""
    for lane in range(LANES):
        drive = SourceOutput(work.drive_v[lane], VOLTAGE)
        state, k = wire_in(work, lane), constants_in(work, lane)
        within = circuit_at(k, drive, work.middle_ohm[lane], work.middle_k[lane], work.coefficient[lane])
        heat_j = (within.power_w - within.loss_w) * step_s + state.carried_heat_j
        middle = HalfStepWire(
            work.middle_k[lane],
            work.middle_ohm[lane],
            work.middle_temperature_slope[lane],
            work.middle_stress_slope[lane],
        )
        work.within_w[lane] = within.power_w - within.loss_w
        work.heat_j[lane] = heat_j
        work.trial_k[lane], work.trial_pa[lane] = guess_after(state, middle, heat_j)


@compiled_inline
def move_fronts(cells: Rows, work: Workspace, row: int) -> None:
    """Let the fronts of a class follow the guess, and look the distribution up there, in all lanes."""
    for lane in range(LANES):
        k, state = constants_in(work, lane), wire_in(work, lane)
        before = (state.front_austenite[row], state.front_martensite[row])
        after = fronts_after(k, work.trial_k[lane], work.trial_pa[lane], 1.0, k.class_barrier_k[row], before)
        work.class_austenite[row, lane], work.class_martensite[row, lane] = after.austenite, after.martensite
        work.class_austenite_per_k[row, lane] = after.austenite_per_k
        work.class_austenite_per_pa[row, lane] = after.austenite_per_pa
        work.class_martensite_per_k[row, lane] = after.martensite_per_k
        work.class_martensite_per_pa[row, lane] = after.martensite_per_pa
    for lane in range(LANES):
        found = cumulative_at(constants_in(work, lane), cells, row, work.class_martensite[row, lane])
        work.class_martensite_fraction[row, lane], work.class_martensite_density[row, lane] = found
    for lane in range(LANES):
        found = cumulative_at(constants_in(work, lane), cells, row, work.class_austenite[row, lane])
        work.class_austenite_fraction[row, lane], work.class_austenite_density[row, lane] = found


@compiled_inline
def phases_of_lane(constants: StepConstants, work: Workspace, lane: int) -> PhaseFractions:
    """Return the volume fractions that follow from the guess."""
    whole = PhaseFractions(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for row in range(constants.class_weight.shape[0]):
        fronts = TransformationFronts(
            work.class_austenite[row, lane],
            work.class_martensite[row, lane],
            work.class_austenite_per_k[row, lane],
            work.class_austenite_per_pa[row, lane],
            work.class_martensite_per_k[row, lane],
            work.class_martensite_per_pa[row, lane],
        )
        martensite = (work.class_martensite_fraction[row, lane], work.class_martensite_density[row, lane])
        austenite = (work.class_austenite_fraction[row, lane], work.class_austenite_density[row, lane])
        part = phases_of_class(constants.class_weight[row], fronts, martensite, austenite)
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
def newton_step(cells: Rows, load: Rows, work: Workspace) -> float:
    """Take Newton's step in all lanes; mark those in which it does not suffice, and return how many. No wire moves."""
    for row in range(work.class_austenite.shape[0]):
        move_fronts(cells, work, row)
    over = ShakedownEffects(1.0, 0.0, 1.0)
    for lane in range(LANES):
        k, state = constants_in(work, lane), wire_in(work, lane)
        trial = (work.trial_k[lane], work.trial_pa[lane], state.enthalpy_j + work.heat_j[lane])
        before = (state.connector_contraction, state.friction_n)
        phases = phases_of_lane(k, work, lane)
        strain = strain_at(k, trial[0], trial[1], phases.martensite, phases.r_phase)
        force = load_at(k, load, contraction_of(k, over, strain), before, NO_PUSH)
        balance = balance_at(k, over, phases, strain, force, trial)
        rise_k, rise_pa = balance.rise_k, balance.rise_pa
        point = TrialPoint(phases, strain, force, balance)
        after = settled(k, over, point, (rise_k, rise_pa), trial)
        moved = balance.contraction_per_k * rise_k + balance.contraction_per_pa * rise_pa
        beyond = load_at(k, load, balance.contraction + moved, before, NO_PUSH)
        bend_n = abs(beyond.force_n - (force.force_n + force.per_contraction_n * moved))
        small = (abs(rise_k) < SOLVED_K) & (abs(rise_pa) * k.martensite_k_per_pa < SOLVED_K)
        taut = (trial[1] > 0.0) & (after.stress_pa > 0.0)
        work.missed[lane] = 0.0 if small & taut & (bend_n < SMALL_BEND_N) else 1.0
        found = equilibrium_of(point, after, 1, True)
        take_found(work, lane, found, (after.contraction, after.friction_n))
    missed = 0.0
    for lane in range(LANES):
        missed += work.missed[lane]
    return missed


@compiled_inline
def follow_newton(work: Workspace) -> None:
    """Let the guess of each marked lane follow its Newton step, as the solver does, while the wire is taut."""
    for lane in range(LANES):
        stress_pa = work.trial_pa[lane] + work.rise_pa[lane]
        follows = (work.missed[lane] > 0.0) & (work.trial_pa[lane] > 0.0) & (stress_pa > 0.0)
        work.trial_k[lane] = work.trial_k[lane] + work.rise_k[lane] if follows else work.trial_k[lane]
        work.trial_pa[lane] = stress_pa if follows else work.trial_pa[lane]
        work.evaluations[lane] += 1.0 if follows else 0.0


@compiled_inline
def take_found(work: Workspace, lane: int, found: Equilibrium, connector: tuple[float, float]) -> None:
    """Take what was found for a lane, with the connector's contraction and friction [N] there."""
    after = found.wire
    work.rise_k[lane], work.rise_pa[lane] = after.rise_k, after.rise_pa
    work.temperature_k[lane], work.stress_pa[lane] = after.temperature_k, after.stress_pa
    work.contraction[lane] = after.contraction
    work.connector_contraction[lane], work.friction_n[lane] = connector
    work.martensite[lane], work.r_phase[lane] = after.martensite, after.r_phase
    work.resistance_ohm[lane] = after.resistance_ohm
    work.temperature_slope[lane] = found.temperature_slope_k_per_j
    work.stress_slope[lane] = found.stress_slope_pa_per_j
    work.contraction_slope[lane] = found.contraction_slope_per_j


@compiled_inner
def solve_lane(state: WireState, constants: StepConstants, cells: Rows, load: Rows, work: Workspace, lane: int) -> None:
    """Solve one lane, in its row, by the solver of one wire, in place of what Newton's step found from the guess."""
    give_wire(work, lane, state)
    wire, trial = RunningWire(state, constants, cells, load), (work.trial_k[lane], work.trial_pa[lane])
    over = ShakedownEffects(1.0, 0.0, 1.0)
    found = solve(wire, over, state.enthalpy_j + work.heat_j[lane], trial, NO_PUSH)
    take_found(work, lane, found, connector_after(wire, found, NO_PUSH))
    for row in range(state.front_austenite.shape[0]):
        place = 6 * row
        work.class_austenite[row, lane] = state.front_trial[place]
        work.class_martensite[row, lane] = state.front_trial[place + 1]
        work.class_austenite_per_k[row, lane] = state.front_trial[place + 2]
        work.class_austenite_per_pa[row, lane] = state.front_trial[place + 3]
        work.class_martensite_per_k[row, lane] = state.front_trial[place + 4]
        work.class_martensite_per_pa[row, lane] = state.front_trial[place + 5]
    work.evaluations[lane] = found.evaluations
    if not found.solved:
        wire_in(work, lane).unsolved_steps += 1.0


@compiled_inline
def finish(work: Workspace, step_s: float) -> None:
    """Move all wires by the step, and make up its accounts: heat, what it owes, error and sums."""
    for lane in range(LANES):
        state, k = wire_in(work, lane), constants_in(work, lane)
        drive, heat_j = SourceOutput(work.drive_v[lane], VOLTAGE), work.heat_j[lane]
        resistance_ohm, temperature_slope = work.resistance_ohm[lane], work.temperature_slope[lane]
        ended = circuit_at(k, drive, resistance_ohm, work.temperature_k[lane], work.coefficient[lane])
        started = WireInstant(work.current_a[lane], work.power_w[lane], work.loss_w[lane])
        owes_j = owed_j(started, WireInstant(0.0, work.within_w[lane], 0.0), ended, step_s)
        slope_before = work.middle_temperature_slope[lane]
        error_k = abs(owes_j) * (temperature_slope if temperature_slope > slope_before else slope_before)
        work.voltage_sum[lane] += step_s * (started.current_a * state.resistance_ohm + ended.current_a * resistance_ohm)
        work.current_sum[lane] += step_s * (started.current_a + ended.current_a)
        work.moved_sum[lane] += step_s * (state.connector_contraction + work.connector_contraction[lane])
        work.stress_sum[lane] += step_s * (state.stress_pa + work.stress_pa[lane])
        work.current_a[lane], work.power_w[lane], work.loss_w[lane] = ended.current_a, ended.power_w, ended.loss_w
        state.carried_heat_j = owes_j
        state.heat_in_j += 0.5 * (started.power_w + ended.power_w) * step_s
        state.heat_out_j += 0.5 * (started.loss_w + ended.loss_w) * step_s
        state.step_error_k = error_k if error_k > state.step_error_k else state.step_error_k
        state.evaluations += work.evaluations[lane]
        state.enthalpy_j += heat_j
        state.cycles += 0.5 * abs(work.martensite[lane] - state.martensite_fraction)
        slope = (resistance_ohm - state.resistance_ohm) / heat_j
        state.resistance_slope_ohm_per_j = slope if abs(heat_j) > NO_HEAT_J else state.resistance_slope_ohm_per_j
        state.last_heat_j = heat_j
        state.temperature_slope_k_per_j, state.stress_slope_pa_per_j = temperature_slope, work.stress_slope[lane]
        state.contraction_slope_per_j = work.contraction_slope[lane]
        state.temperature_k, state.stress_pa = work.temperature_k[lane], work.stress_pa[lane]
        state.contraction, state.connector_contraction = work.contraction[lane], work.connector_contraction[lane]
        state.friction_n, state.resistance_ohm = work.friction_n[lane], resistance_ohm
        state.martensite_fraction, state.r_phase_fraction = work.martensite[lane], work.r_phase[lane]
        for row in range(state.front_austenite.shape[0]):
            state.front_austenite[row] = (
                work.class_austenite[row, lane]
                + work.class_austenite_per_k[row, lane] * work.rise_k[lane]
                + work.class_austenite_per_pa[row, lane] * work.rise_pa[lane]
            )
            state.front_martensite[row] = (
                work.class_martensite[row, lane]
                + work.class_martensite_per_k[row, lane] * work.rise_k[lane]
                + work.class_martensite_per_pa[row, lane] * work.rise_pa[lane]
            )


@compiled_inner
def advance_lanes(wires: Rows, constants: Rows, cells: Rows, load: Rows, work: Workspace, plan: FloatArray) -> None:
    """Advance the block of wires in the workspace (:func:`take_block`) by a sample, leaving its sums there.

    ``wires`` and ``constants`` are their rows of states and of derived constants, (LANES,) each; ``cells`` and ``load``
    the records of the distribution and the load that they share.
    """
    step_s = plan[DURATION] / plan[STEPS]
    begin(constants, work)
    for _ in range(int(plan[STEPS])):
        look_ahead(work, step_s)
        look_up_air(constants, work, work.middle_k)
        guess(work, step_s)
        missed = newton_step(cells, load, work)
        if missed > FEW:
            follow_newton(work)
            missed = newton_step(cells, load, work)
        if missed > 0.0:
            guess(work, step_s)
            for lane in range(LANES):
                if work.missed[lane] > 0.0:
                    solve_lane(wires[lane], constants[lane], cells, load, work, lane)
        look_up_air(constants, work, work.temperature_k)
        finish(work, step_s)
    for lane in range(LANES):
        wire_in(work, lane).time_s += plan[DURATION]


@compiled_inner
def take_block(wires: Rows, constants: Rows, work: Workspace) -> None:
    """Copy the rows of a block's states and constants, (LANES,) each, into the workspace."""
    for lane in range(LANES):
        take_wire(work, lane, wires[lane])
        take_constants(work, lane, constants[lane])


@compiled_inner
def give_block(wires: Rows, work: Workspace) -> None:
    """Copy the states of a block back into their rows."""
    for lane in range(LANES):
        give_wire(work, lane, wires[lane])
