"""A wire along a whole history in one compiled call: a drive over time, or prescribed temperatures.

Identification, tables and batches need thousands of histories; a rig advances sample by sample instead. A wire of given
temperature takes the same step: without loss and latent heat it is as warm as the power through it says.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.errors import CallerError
from musclewire.physics import REFERENCE_TEMPERATURE_K
from musclewire.wire._building import cooled_wire, resting_state
from musclewire.wire._fronts import shakedown_of
from musclewire.wire._prescribed import prescribe, resistance_of, total_strain
from musclewire.wire._row import Rows, WireConstants, WireState
from musclewire.wire._step import RunningWire
from musclewire.wire._stepping import (
    CHOSEN,
    CURRENT,
    POWER,
    VOLTAGE,
    SourceOutput,
    StepControl,
    advance_wire,
    fixed_steps,
    plan_of,
    require_resolved,
)

# Far below any spread of the grains, so that the balance is found from the stress before in one or two evaluations.
WARMING_STEP_K = 0.1
# A prescribed temperature a second, in one step each: the rate does not matter to what loses no heat.
A_SECOND = plan_of(fixed_steps(1.0), 1.0)
# What a wire at rest does not remember of how it was heated.
OF_THE_WAY = (
    "time_s", "heat_in_j", "heat_out_j", "last_heat_j", "carried_heat_j", "step_error_k", "stress_slope_pa_per_j",
    "contraction_slope_per_j", "resistance_slope_ohm_per_j",
)  # fmt: skip


class DrivenPath(NamedTuple):
    """Response of a wire to a drive, each (n_samples,): means over each sample, then the true state at its end."""

    wire_voltage_v: FloatArray
    shunt_voltage_v: FloatArray
    displacement_m: FloatArray
    force_n: FloatArray
    temperature_k: FloatArray
    stress_pa: FloatArray
    martensite_fraction: FloatArray
    r_phase_fraction: FloatArray
    resistance_ohm: FloatArray


class IsobaricPath(NamedTuple):
    """Response of a wire at constant stress to prescribed temperatures, each (n_points,)."""

    strain: FloatArray  # relative to stress-free austenite at 20 C
    resistance_ohm: FloatArray
    martensite_fraction: FloatArray
    r_phase_fraction: FloatArray


@compiled
def drive_rows(
    states: Rows,
    constants: Rows,
    cells: Rows,
    load: Rows,
    drive: FloatArray,
    kind: int,
    plan: FloatArray,
) -> FloatArray:
    """Drive a wire in place on arrays of one record; return the columns of a :class:`DrivenPath`."""
    wire = RunningWire(states[0], constants[0], cells[0], load[0])
    state = wire.state
    shown = np.empty((9, drive.shape[0]))
    for sample in range(drive.shape[0]):
        means = advance_wire(wire, SourceOutput(drive[sample], kind), plan)
        shown[0, sample] = means[0]
        shown[1, sample] = means[1]
        shown[2, sample] = means[2]
        shown[3, sample] = means[3]
        shown[4, sample] = state.temperature_k
        shown[5, sample] = state.stress_pa
        shown[6, sample] = state.martensite_fraction
        shown[7, sample] = state.r_phase_fraction
        shown[8, sample] = state.resistance_ohm
    return shown


def drive_path(
    constants: WireConstants,
    drive: FloatArray,
    *,
    sample_s: float,
    stepping: StepControl = CHOSEN,
    state: WireState | None = None,
    regulated_current: bool = False,
) -> tuple[DrivenPath, WireState]:
    """Return means and states of a wire for each sample of a drive, those of ``wire.advance`` to the bit, and its end.

    The drive, (n_samples,), is a voltage [V], or a current [A] that a source regulates. Without a state the wire begins
    cold and at rest. Raises NumericsError if a step was not solved, or too long for what the wire did in it.
    """
    plan = plan_of(stepping, sample_s)
    before = resting_state(constants) if state is None else state
    after = before.copy()
    held = np.ascontiguousarray(drive, dtype=np.float64)
    kind = CURRENT if regulated_current else VOLTAGE
    shown = drive_rows(after.row, *constants.step_arrays(), held, kind, plan)
    require_resolved(after, stepping, sample_s, before)
    return DrivenPath(*shown), after


@compiled
def isobaric_rows(
    states: Rows,
    constants: Rows,
    cells: Rows,
    load: Rows,
    stress_pa: float,
    temperature_k: FloatArray,
) -> FloatArray:
    """Follow temperatures in place on arrays of one record; return the columns of an :class:`IsobaricPath`."""
    wire = RunningWire(states[0], constants[0], cells[0], load[0])
    state, of = wire.state, wire.constants
    over = shakedown_of(of, np.inf)
    shown = np.empty((4, temperature_k.shape[0]))
    for point in range(temperature_k.shape[0]):
        prescribe(wire, over, temperature_k[point], stress_pa)
        martensite, r_phase = state.martensite_fraction, state.r_phase_fraction
        shown[0, point] = total_strain(of, stress_pa, martensite, r_phase, temperature_k[point])
        shown[1, point] = resistance_of(of, stress_pa, martensite, r_phase, temperature_k[point], np.inf)
        shown[2, point] = martensite
        shown[3, point] = r_phase
    return shown


def isobaric_path(constants: WireConstants, stress_pa: float, temperature_k: FloatArray) -> IsobaricPath:
    """Return strain and resistance of a wire under a stress of 0 or more along temperatures, (n_points,).

    Beforehand the wire is cooled from hot to the first temperature at that stress. There is no spring and no heat
    balance: the temperatures are prescribed.
    """
    if not stress_pa >= 0.0:
        raise CallerError(f"stress is {stress_pa} Pa: a wire cannot be pushed, give 0 or more")
    path = np.ascontiguousarray(temperature_k, dtype=np.float64)
    state = cooled_wire(constants, stress_pa, float(path[0]))
    return IsobaricPath(*isobaric_rows(state.row, *constants.step_arrays(), stress_pa, path))


def heated_state(constants: WireConstants, temperature_k: float) -> WireState:
    """Return a wire on its load, heated from cold in equilibrium throughout: it is on the heating branch."""
    ambient = constants.ambient_temperature_k
    if not temperature_k > ambient:
        raise CallerError(
            f"a heated wire must be above the {ambient - 273.15:.1f} C of the air around it, not at "
            f"{temperature_k - 273.15:.1f} C"
        )
    state = resting_state(constants)
    derived, cells, load = constants.step_arrays()
    only_capacity = derived.copy()
    only_capacity["latent_heat_j"] = only_capacity["surface_factor_m2"] = 0.0
    sensible_j = constants.heat_capacity_j_per_k * (temperature_k - REFERENCE_TEMPERATURE_K)
    state.row["enthalpy_j"] = constants.heat_capacity_j_per_k * (ambient - REFERENCE_TEMPERATURE_K)
    steps = int((temperature_k - ambient) / WARMING_STEP_K) + 1
    power_w = np.full(steps, (sensible_j - state.enthalpy_j) / steps)
    drive_rows(state.row, only_capacity, cells, load, power_w, POWER, A_SECOND)
    transformed = state.martensite_fraction + constants.r_phase_entropy_ratio * state.r_phase_fraction
    return state.replace(
        temperature_k=temperature_k,
        enthalpy_j=sensible_j - constants.latent_heat_j * transformed,
        **dict.fromkeys(OF_THE_WAY, 0.0),
    )
