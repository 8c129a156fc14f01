"""Phases of a wire as two fronts in the distribution of its grains, compiled.

Grains differ by an offset from the mean transformation temperatures. While the three spreads are positive, austenite
lies below the front q_F, martensite above the front q_M >= q_F, and R-phase between them, after any history of
temperature and stress: each of the six changes of phase moves one front, and one way only. Two numbers are therefore
all that an ensemble of grains remembers, whatever the shape of its distribution.

All functions are free of branches on numbers, so that a loop over many wires becomes vector instructions. ``constants``
is one record of ``StepConstants``, or the same names taken from one of many wires.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from musclewire.compiled import compiled_inline
from musclewire.wire._row import Rows, StepConstants

# A spread that stress made smaller than this is a switch rather than a ramp.
MIN_SPREAD_K = 1e-6


class ShakedownEffects(NamedTuple):
    """Effects of the shakedown that a wire has behind it."""

    barrier_factor: float  # on the barrier between austenite and martensite, 1 or more
    residual_strain: float  # gained since the wire was new
    resistivity_factor: float  # on the resistivity of martensite


class Thresholds(NamedTuple):
    """Offsets, in units of the spread, at which the six changes of phase are due, with slopes by stress.

    A threshold's slope over temperature is ``per_spread`` of its pair of phases for all changes. Cooling moves fronts
    down to the first three, heating up to the last three. The slope over stress of R to A equals that of A to R.
    """

    austenite_martensite: float
    austenite_r_phase: float
    r_phase_martensite: float
    martensite_austenite: float
    r_phase_austenite: float
    martensite_r_phase: float
    austenite_martensite_per_pa: float
    austenite_r_phase_per_pa: float
    r_phase_martensite_per_pa: float
    martensite_austenite_per_pa: float
    martensite_r_phase_per_pa: float
    m_per_k: float  # slopes over temperature: of A-M, A-R and R-M
    r_per_k: float
    p_per_k: float


class PhaseFractions(NamedTuple):
    """Volume fractions of a wire with their slopes over temperature [1/K] and stress [1/Pa]."""

    martensite: float
    r_phase: float
    martensite_per_k: float
    martensite_per_pa: float
    r_phase_per_k: float
    r_phase_per_pa: float


class TransformationFronts(NamedTuple):
    """Both fronts after a temperature and a stress, with their slopes, which are 0 while a front stands still."""

    austenite: float  # q_F, in units of the spread
    martensite: float  # q_M, in units of the spread
    austenite_per_k: float
    austenite_per_pa: float
    martensite_per_k: float
    martensite_per_pa: float


@compiled_inline
def shakedown_of(constants: StepConstants, cycles: float) -> ShakedownEffects:
    """Return the effects of a wire's shakedown after full transformation cycles; half a cycle counts as half.

    The part exp(-cycles / shakedown_cycles) of the shakedown remains; none of a wire whose shakedown was over at the
    start.

    References
    ----------
    The form is assumed; the signs are those of Churchill and Shaw, SMASIS2009-48968, and Hartwich et al. 2021,
    doi 10.3390/s21206804.
    """
    k = constants
    if k.shakedown_cycles == 0.0:
        return ShakedownEffects(1.0, 0.0, 1.0)
    remaining = math.exp(-cycles / k.shakedown_cycles)
    return ShakedownEffects(
        1.0 + k.shakedown_barrier * remaining,
        k.shakedown_strain * (1.0 - remaining),
        1.0 + k.shakedown_resistivity * remaining,
    )


@compiled_inline
def thresholds_at(
    constants: StepConstants, temperature_k: float, stress_pa: float, barrier_factor: float, barrier_k: float
) -> Thresholds:
    """Return where in the distribution the six changes of phase are due at a temperature and a stress.

    ``barrier_k`` is that of this class of grains beyond the alloy's. Stress may close the hysteresis but not invert it,
    and the detour via austenite must not be easier than the direct change between R-phase and martensite: otherwise
    return-point memory is lost.

    References
    ----------
    Threshold switching as in Preisach's operator: Mayergoyz 1986, doi 10.1103/PhysRevLett.56.1518. The phase boundaries
    are those of Brinson 1993, doi 10.1177/1045389X9300400213.
    """
    k, ratio = constants, constants.r_phase_entropy_ratio
    force_m = k.martensite_temperature_k + stress_pa * k.martensite_k_per_pa - temperature_k
    force_r = ratio * (k.r_phase_temperature_k + stress_pa * k.r_phase_k_per_pa - temperature_k)
    preference = force_m - force_r
    stress_barrier_k = barrier_factor * (k.martensite_barrier_k + barrier_k + k.martensite_barrier_per_pa * stress_pa)
    stress_barrier_per_pa = barrier_factor * k.martensite_barrier_per_pa
    barrier = stress_barrier_k if stress_barrier_k > 0.0 else 0.0
    barrier_per_pa = stress_barrier_per_pa if stress_barrier_k > 0.0 else 0.0
    detour_k = barrier + k.r_phase_barrier_k
    direct_k = k.r_to_m_barrier_k
    preference_barrier = direct_k if direct_k < detour_k else detour_k
    preference_barrier_per_pa = 0.0 if direct_k < detour_k else barrier_per_pa
    spread_m = k.martensite_spread_k + k.martensite_spread_per_pa * stress_pa
    spread_p = spread_m - k.r_phase_spread_k
    spread_p = spread_p if spread_p > MIN_SPREAD_K else MIN_SPREAD_K
    per_m, per_r, per_p = 1.0 / spread_m, k.per_r_phase_spread, 1.0 / spread_p
    widening = k.martensite_spread_per_pa
    force_m_per_pa = k.martensite_k_per_pa
    preference_per_pa = k.martensite_k_per_pa - ratio * k.r_phase_k_per_pa
    austenite_martensite = (barrier - force_m) * per_m
    austenite_r_phase = (k.r_phase_barrier_k - force_r) * per_r
    r_phase_martensite = (preference_barrier - preference) * per_p
    martensite_austenite = (-force_m - barrier) * per_m
    r_phase_austenite = (-force_r - k.r_phase_barrier_k) * per_r
    martensite_r_phase = (-preference - preference_barrier) * per_p
    return Thresholds(
        austenite_martensite=austenite_martensite,
        austenite_r_phase=austenite_r_phase,
        r_phase_martensite=r_phase_martensite,
        martensite_austenite=martensite_austenite,
        r_phase_austenite=r_phase_austenite,
        martensite_r_phase=martensite_r_phase,
        austenite_martensite_per_pa=(barrier_per_pa - force_m_per_pa - austenite_martensite * widening) * per_m,
        austenite_r_phase_per_pa=-ratio * k.r_phase_k_per_pa * per_r,
        r_phase_martensite_per_pa=(preference_barrier_per_pa - preference_per_pa - r_phase_martensite * widening)
        * per_p,
        martensite_austenite_per_pa=(-barrier_per_pa - force_m_per_pa - martensite_austenite * widening) * per_m,
        martensite_r_phase_per_pa=(-preference_barrier_per_pa - preference_per_pa - martensite_r_phase * widening)
        * per_p,
        m_per_k=per_m,
        r_per_k=ratio * per_r,
        p_per_k=(1.0 - ratio) * per_p,
    )


@compiled_inline
def moved_fronts(at: Thresholds, front_austenite: float, front_martensite: float) -> TransformationFronts:
    """Return the fronts that thresholds leave behind, those that none has reached with slopes of 0.

    Cooling: q_F = min(q_F, z_AM, z_AR), then q_M = min(q_M, max(q_F, z_RM)). Heating: q_M = max(q_M, z_MA, z_MR), then
    q_F = max(q_F, min(q_M, z_RA)).
    """
    direct = at.austenite_martensite < at.austenite_r_phase
    low = at.austenite_martensite if direct else at.austenite_r_phase
    moves = low < front_austenite
    f = low if moves else front_austenite
    f_k = (at.m_per_k if direct else at.r_per_k) if moves else 0.0
    f_pa = (at.austenite_martensite_per_pa if direct else at.austenite_r_phase_per_pa) if moves else 0.0

    follows = f > at.r_phase_martensite
    low = f if follows else at.r_phase_martensite
    moves = low < front_martensite
    m = low if moves else front_martensite
    m_k = (f_k if follows else at.p_per_k) if moves else 0.0
    m_pa = (f_pa if follows else at.r_phase_martensite_per_pa) if moves else 0.0

    direct = at.martensite_austenite > at.martensite_r_phase
    high = at.martensite_austenite if direct else at.martensite_r_phase
    moves = high > m
    m = high if moves else m
    m_k = (at.m_per_k if direct else at.p_per_k) if moves else m_k
    m_pa = (at.martensite_austenite_per_pa if direct else at.martensite_r_phase_per_pa) if moves else m_pa

    follows = m < at.r_phase_austenite
    high = m if follows else at.r_phase_austenite
    moves = high > f
    f = high if moves else f
    f_k = (m_k if follows else at.r_per_k) if moves else f_k
    f_pa = (m_pa if follows else at.austenite_r_phase_per_pa) if moves else f_pa
    return TransformationFronts(f, m, f_k, f_pa, m_k, m_pa)


@compiled_inline
def fronts_after(
    constants: StepConstants,
    temperature_k: float,
    stress_pa: float,
    barrier_factor: float,
    barrier_k: float,
    fronts: tuple[float, float],
) -> TransformationFronts:
    """Return the fronts q_F, q_M of a class of grains after a temperature and a stress: both functions above in one."""
    at = thresholds_at(constants, temperature_k, stress_pa, barrier_factor, barrier_k)
    return moved_fronts(at, fronts[0], fronts[1])


@compiled_inline
def phases_of_class(
    weight: float, fronts: TransformationFronts, martensite: tuple[float, float], austenite: tuple[float, float]
) -> PhaseFractions:
    """Return a class's part of the wire's volume fractions, from cumulative fraction and density at its fronts."""
    loss_per_k = weight * martensite[1] * fronts.martensite_per_k
    loss_per_pa = weight * martensite[1] * fronts.martensite_per_pa
    return PhaseFractions(
        weight * (1.0 - martensite[0]),
        weight * (martensite[0] - austenite[0]),
        -loss_per_k,
        -loss_per_pa,
        loss_per_k - weight * austenite[1] * fronts.austenite_per_k,
        loss_per_pa - weight * austenite[1] * fronts.austenite_per_pa,
    )


@compiled_inline
def cumulative_at(constants: StepConstants, cells: Rows, row: int, offset: float) -> tuple[float, float]:
    """Return the fraction of a class's grains below an offset, and the density there, 0 outside the table."""
    count = cells.table.shape[1]
    row = row if cells.table.shape[0] > 1 else 0  # all classes may share one distribution
    k = constants
    core = offset if offset > k.distribution_core_start else k.distribution_core_start
    core = core if core < k.distribution_core_end else k.distribution_core_end
    per_offset = k.distribution_per_core_step if core == offset else k.distribution_per_step
    place = k.distribution_core_place + (core - k.distribution_core_start) * k.distribution_per_core_step
    place += (offset - core) * k.distribution_per_step
    inside = place if place > 0.0 else 0.0
    inside = inside if inside < count else float(count)
    cell = int(inside)
    cell = cell if cell < count else count - 1
    part = inside - cell
    a, b = cells.table[row, cell, 0], cells.table[row, cell, 1]
    c, d = cells.table[row, cell, 2], cells.table[row, cell, 3]
    density = (b + part * (2.0 * c + part * (3.0 * d))) * per_offset
    density = density if (place > 0.0) & (place < count) else 0.0
    return a + part * (b + part * (c + part * d)), density
