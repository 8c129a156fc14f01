"""A wire through a whole history in one compiled call: a drive over time, or temperatures under a constant stress.

For whoever needs a thousand histories: identification, tables, batches. The rig goes sample by sample instead.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from musclewire.compiled import compiled
from musclewire.errors import CallerError
from musclewire.simulate.balances import resistance_of, total_strain
from musclewire.simulate.kernel import advance_plain
from musclewire.simulate.state import FloatArray, WireConstants, WireState
from musclewire.simulate.switching import drives_at, drives_from, keep_drives, switch_grains
from musclewire.simulate.wire import cooled_grains, resting_state

__all__ = ["DrivenPath", "IsobaricPath", "drive_path", "isobaric_path"]

NUMBERS = len(WireState._fields) - 3
# Places of temperature, stress, contraction, fractions and resistance among a state's numbers.
SHOWN = tuple(
    WireState._fields.index(name)
    for name in ("temperature_k", "stress_pa", "martensite_fraction", "r_phase_fraction", "resistance_ohm")
)
RESISTANCE_RATE = WireState._fields.index("resistance_rate_ohm_per_s")


class DrivenPath(NamedTuple):
    """What a drive did to a wire, sample by sample, each (n_samples,): means over the sample, then truth at its end."""

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
    """What a wire under constant stress did along given temperatures, each (n_points,).

    ``strain`` counts from stress-free austenite at 20 C.
    """

    strain: FloatArray
    resistance_ohm: FloatArray
    martensite_fraction: FloatArray
    r_phase_fraction: FloatArray


@compiled
def driven_plain(
    numbers: tuple[float, ...],
    grain_martensite: FloatArray,
    grain_r_phase: FloatArray,
    seen_drives: FloatArray,
    constant_values: tuple[Any, ...],
    drive: FloatArray,
    dt_s: float,
    steps: int,
    regulated_current: bool,
) -> tuple[tuple[Any, ...], FloatArray]:
    """Do the work of :func:`drive_path` on plain tuples; the shown numbers come as (n_samples, 9)."""
    series = WireConstants(*constant_values).series_resistance_ohm
    shown = np.empty((drive.shape[0], 9))
    for sample in range(drive.shape[0]):
        resistance = numbers[SHOWN[4]] + 0.5 * dt_s * numbers[RESISTANCE_RATE]  # as the kernel takes it for a step
        voltage = drive[sample] * (resistance + series) if regulated_current else drive[sample]
        numbers, means = advance_plain(
            numbers,
            grain_martensite,
            grain_r_phase,
            seen_drives,
            constant_values,
            voltage,
            dt_s,
            steps,
        )
        shown[sample, 0] = means[0]
        shown[sample, 1] = means[1]
        shown[sample, 2] = means[2]
        shown[sample, 3] = means[3]
        shown[sample, 4] = numbers[SHOWN[0]]
        shown[sample, 5] = numbers[SHOWN[1]]
        shown[sample, 6] = numbers[SHOWN[2]]
        shown[sample, 7] = numbers[SHOWN[3]]
        shown[sample, 8] = numbers[SHOWN[4]]
    return numbers, shown


def drive_path(
    constants: WireConstants,
    drive: FloatArray,
    *,
    dt_s: float,
    steps: int,
    state: WireState | None = None,
    regulated_current: bool = False,
) -> tuple[DrivenPath, WireState]:
    """Return what ``drive``, (n_samples,) in volts, does to a wire and the state it ends in.

    Each drive is held for ``steps`` steps of ``dt_s``. With ``regulated_current`` the drive is a current in amperes,
    which a source holds by what the wire's resistance was at the start of each sample. Starts at rest, cold, unless a
    ``state`` is given, which is left as it was. The same numbers, to the bit, as ``simulate.kernel.advance`` sample by
    sample. Raises CallerError for steps that are not positive.
    """
    if not dt_s > 0.0 or steps < 1:
        raise CallerError(f"a path needs a positive time step and at least one step a sample, got {dt_s} s and {steps}")
    start = resting_state(constants) if state is None else state
    martensite, r_phase, seen = start.grain_martensite.copy(), start.grain_r_phase.copy(), start.seen_drives.copy()
    held = np.ascontiguousarray(drive, dtype=np.float64)
    numbers: tuple[Any, ...] = tuple(start[:NUMBERS])
    after, shown = driven_plain(
        numbers, martensite, r_phase, seen, tuple(constants), held, dt_s, steps, regulated_current
    )
    return DrivenPath(*np.ascontiguousarray(shown.T)), WireState._make((*after, martensite, r_phase, seen))


@compiled
def isobaric_plain(
    constant_values: tuple[Any, ...],
    grain_martensite: FloatArray,
    grain_r_phase: FloatArray,
    seen_drives: FloatArray,
    stress_pa: float,
    temperature_k: FloatArray,
) -> FloatArray:
    """Do the work of :func:`isobaric_path` on plain tuples; the shown numbers come as (n_points, 4)."""
    constants = WireConstants(*constant_values)
    shown = np.empty((temperature_k.shape[0], 4))
    for point in range(temperature_k.shape[0]):
        drives = drives_at(constants, temperature_k[point], stress_pa, 1.0)
        switch_grains(constants, drives, drives_from(seen_drives), grain_martensite, grain_r_phase)
        keep_drives(drives, seen_drives)
        martensite, r_phase = grain_martensite.mean(), grain_r_phase.mean()
        shown[point, 0] = total_strain(constants, stress_pa, martensite, r_phase, temperature_k[point])
        shown[point, 1] = resistance_of(constants, stress_pa, martensite, r_phase, temperature_k[point], 0.0)
        shown[point, 2] = martensite
        shown[point, 3] = r_phase
    return shown


def isobaric_path(constants: WireConstants, stress_pa: float, temperature_k: FloatArray) -> IsobaricPath:
    """Return strain and resistance of a wire under ``stress_pa`` along ``temperature_k``, (n_points,).

    The wire was cooled from hot to the first temperature under that stress before. No spring, no heat balance: the
    temperatures are given. Raises CallerError for a negative stress.
    """
    if not stress_pa >= 0.0:
        raise CallerError(f"stress is {stress_pa} Pa: a wire cannot be pushed, give 0 or more")
    path = np.ascontiguousarray(temperature_k, dtype=np.float64)
    martensite, r_phase, seen = cooled_grains(constants, stress_pa, float(path[0]))
    return IsobaricPath(
        *np.ascontiguousarray(isobaric_plain(tuple(constants), martensite, r_phase, seen, stress_pa, path).T)
    )
