"""Which grains of a wire change phase as temperature and stress move: compiled.

A grain moves only when one of its six drives has risen, and only if that drive's threshold swept over it. So a step
looks at the few grains between the thresholds before and after, whatever their number in all.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from musclewire.compiled import compiled
from musclewire.physics.transformation import advantage_k, cooled_grain, heated_grain
from musclewire.simulate.state import Drives, FloatArray, WireConstants

__all__ = ["cool_swept", "cooled_plain", "drives_at", "drives_from", "heat_swept", "keep_drives", "switch_grains"]


@compiled
def drives_at(constants: WireConstants, temperature_k: float, stress_pa: float, barrier_factor: float) -> Drives:
    """Return the six drives at a temperature and a stress."""
    martensite = advantage_k(
        temperature_k,
        stress_pa,
        constants.martensite_temperature_k,
        constants.martensite_stress_rate_pa_per_k,
    )
    r_phase = constants.r_phase_entropy_ratio * advantage_k(
        temperature_k, stress_pa, constants.r_phase_temperature_k, constants.r_phase_stress_rate_pa_per_k
    )
    preference = martensite - r_phase
    # A load may close the hysteresis, not turn it inside out; and no detour by way of austenite may be easier than
    # the straight way between R-phase and martensite: else there is no return-point memory.
    barrier = barrier_factor * max(
        constants.martensite_barrier_k + constants.martensite_barrier_per_pa * stress_pa, 0.0
    )
    r_to_m_barrier = min(constants.r_to_m_barrier_k, barrier + constants.r_phase_barrier_k)
    return Drives(
        martensite - barrier,
        r_phase - constants.r_phase_barrier_k,
        preference - r_to_m_barrier,
        -martensite - barrier,
        -r_phase - constants.r_phase_barrier_k,
        -preference - r_to_m_barrier,
        stress_pa,
    )


@compiled
def spreads(constants: WireConstants, stress_pa: float) -> tuple[float, float, float]:
    """Return the spreads [K] over the grains of f_M, f_R and f_M - f_R at a stress.

    Load pulls grains apart: each is turned differently to the wire's axis and feels its own share of the stress.
    A spread under a microkelvin counts as that: a switch rather than a ramp.
    """
    spread_m = constants.martensite_spread_k + constants.martensite_spread_per_pa * stress_pa
    spread_r = constants.r_phase_entropy_ratio * constants.r_phase_spread_k
    spread_p = spread_m - spread_r
    if abs(spread_p) < 1e-6:
        spread_p = 1e-6
    return max(spread_m, 1e-6), max(spread_r, 1e-6), spread_p


@compiled
def grain_at(edges: FloatArray, place: float) -> int:
    """Return the number of the grain that holds a place in units of the spread; -1 and n_grains lie outside."""
    low = -1
    high = edges.shape[0]
    while high - low > 1:
        middle = (low + high) // 2
        if edges[middle] <= place:
            low = middle
        else:
            high = middle
    return low


@compiled
def grains_swept(edges: FloatArray, before: float, after: float) -> tuple[int, int]:
    """Return first and past-the-last grain between two places of a moving threshold, both places included."""
    first = grain_at(edges, min(before, after))
    last = grain_at(edges, max(before, after))
    return max(first, 0), min(last + 1, edges.shape[0] - 1)


@compiled
def cool_swept(
    constants: WireConstants,
    drives: Drives,
    first: int,
    last: int,
    grain_martensite: FloatArray,
    grain_r_phase: FloatArray,
) -> None:
    """Let grains ``first`` to before ``last`` follow the cooling drives, in place."""
    spread_m, spread_r, spread_p = spreads(constants, drives.stress_pa)
    for j in range(first, last):
        middle = constants.grain_middle[j]
        per_width = 1.0 / constants.grain_width[j]
        grain_martensite[j], grain_r_phase[j] = cooled_grain(
            grain_martensite[j],
            grain_r_phase[j],
            drives.a_to_m_k + spread_m * middle,
            drives.a_to_r_k + spread_r * middle,
            drives.r_to_m_k + spread_p * middle,
            per_width / spread_m,
            per_width / spread_r,
            per_width / abs(spread_p),
        )


@compiled
def heat_swept(
    constants: WireConstants,
    drives: Drives,
    first: int,
    last: int,
    grain_martensite: FloatArray,
    grain_r_phase: FloatArray,
) -> None:
    """Let grains ``first`` to before ``last`` follow the heating drives, in place."""
    spread_m, spread_r, spread_p = spreads(constants, drives.stress_pa)
    for j in range(first, last):
        middle = constants.grain_middle[j]
        per_width = 1.0 / constants.grain_width[j]
        grain_martensite[j], grain_r_phase[j] = heated_grain(
            grain_martensite[j],
            grain_r_phase[j],
            drives.m_to_a_k - spread_m * middle,
            drives.r_to_a_k - spread_r * middle,
            drives.m_to_r_k - spread_p * middle,
            per_width / spread_m,
            per_width / spread_r,
            per_width / abs(spread_p),
        )


@compiled
def switch_grains(
    constants: WireConstants,
    drives: Drives,
    seen: Drives,
    grain_martensite: FloatArray,
    grain_r_phase: FloatArray,
) -> tuple[float, float]:
    """Let every grain follow drives that changed from ``seen``, in place; return the change of both sums of shares.

    A grain moves only when one of its drives has risen, and only if that drive's threshold swept over it: so a
    step looks at the few grains between the thresholds before and after, whatever their number in all.
    """
    spread_m, spread_r, spread_p = spreads(constants, drives.stress_pa)
    seen_m, seen_r, seen_p = spreads(constants, seen.stress_pa)
    edges = constants.grain_edges
    grains = constants.grain_middle.shape[0]
    change_m = 0.0
    change_r = 0.0
    for change in range(6):
        if change == 0:
            new, old, spread, seen_spread = drives.a_to_m_k, seen.a_to_m_k, -spread_m, -seen_m
        elif change == 1:
            new, old, spread, seen_spread = drives.a_to_r_k, seen.a_to_r_k, -spread_r, -seen_r
        elif change == 2:
            new, old, spread, seen_spread = drives.r_to_m_k, seen.r_to_m_k, -spread_p, -seen_p
        elif change == 3:
            new, old, spread, seen_spread = drives.m_to_a_k, seen.m_to_a_k, spread_m, seen_m
        elif change == 4:
            new, old, spread, seen_spread = drives.r_to_a_k, seen.r_to_a_k, spread_r, seen_r
        else:
            new, old, spread, seen_spread = drives.m_to_r_k, seen.m_to_r_k, spread_p, seen_p
        place, seen_place = new / spread, old / seen_spread
        # The threshold stands where a grain's offset makes its drive zero; it moves as the drive or the spread changes.
        if spread * seen_spread < 0.0:
            first, last = 0, grains  # the order of the grains has turned over: all may be due
        elif (place - seen_place) * spread > 0.0:
            first, last = grains_swept(edges, seen_place, place)
        else:
            continue
        for j in range(first, last):
            change_m -= grain_martensite[j]
            change_r -= grain_r_phase[j]
        if change < 3:
            cool_swept(constants, drives, first, last, grain_martensite, grain_r_phase)
        else:
            heat_swept(constants, drives, first, last, grain_martensite, grain_r_phase)
        for j in range(first, last):
            change_m += grain_martensite[j]
            change_r += grain_r_phase[j]
    return change_m, change_r


@compiled
def drives_from(kept: FloatArray) -> Drives:
    """Return the drives kept in a wire's state, (7,)."""
    return Drives(kept[0], kept[1], kept[2], kept[3], kept[4], kept[5], kept[6])


@compiled
def keep_drives(drives: Drives, kept: FloatArray) -> None:
    """Write drives into a wire's state, (7,), in place."""
    kept[0] = drives.a_to_m_k
    kept[1] = drives.a_to_r_k
    kept[2] = drives.r_to_m_k
    kept[3] = drives.m_to_a_k
    kept[4] = drives.r_to_a_k
    kept[5] = drives.m_to_r_k
    kept[6] = drives.stress_pa


@compiled
def cooled_plain(
    constant_values: tuple[Any, ...], stress_pa: float, temperature_k: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return martensite and R-phase of the grains, and drives, after cooling from all austenite at one stress.

    On cooling all three drives only rise, and shares only rise to bounds that the drives set: the way there leaves no
    trace, so one look at its end is enough.
    """
    constants = WireConstants(*constant_values)
    grains = constants.grain_middle.shape[0]
    grain_martensite = np.zeros(grains)
    grain_r_phase = np.zeros(grains)
    drives = drives_at(constants, temperature_k, stress_pa, 1.0)
    cool_swept(constants, drives, 0, grains, grain_martensite, grain_r_phase)
    seen = np.zeros(7)
    keep_drives(drives, seen)
    return grain_martensite, grain_r_phase, seen
