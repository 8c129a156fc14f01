"""Phase changes of grains, each an interval of transformation temperatures, as temperature and stress change.

A grain changes only if one of six driving forces has risen and that force's threshold has swept over it, so only the
grains between the thresholds before and after are evaluated. The thresholds are those of grains as
intervals; order between states is preserved as Sethna et al. 1993, doi 10.1103/PhysRevLett.70.3347, ask for.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from grain_wire.compiling import compiled

Array = Any  # of floats; compiled code infers the rest

COOLINGS = 3  # of the six changes the first three happen on cooling


class Grains(NamedTuple):
    """Grains as adjacent intervals in units of the spread, their phases, and the driving forces they have followed.

    ``edges`` is (n + 1,), ``followed`` is (7,): six forces [K] and their stress [Pa]; all others are (n,).
    """

    edges: Array
    middle: Array
    width: Array
    martensite: Array
    r_phase: Array
    followed: Array


class Forces(NamedTuple):
    """Thermodynamic driving forces [K] of a grain of offset 0: a change is due from 0 on; and their stress [Pa]."""

    a_to_m_k: float
    a_to_r_k: float
    r_to_m_k: float
    m_to_a_k: float
    r_to_a_k: float
    m_to_r_k: float
    stress_pa: float


@compiled
def forces_at(constants: Any, temperature_k: float, stress_pa: float, barrier_factor: float) -> Forces:
    """Return the driving forces at a temperature and a stress: straight phase boundaries, and barriers."""
    martensite = (
        constants.martensite_temperature_k + stress_pa / constants.martensite_stress_rate_pa_per_k - temperature_k
    )
    r_phase = constants.r_phase_entropy_ratio * (
        constants.r_phase_temperature_k + stress_pa / constants.r_phase_stress_rate_pa_per_k - temperature_k
    )
    preference = martensite - r_phase
    # Stress may close the hysteresis but not invert it; no detour by way of austenite is easier than the direct change.
    barrier = barrier_factor * max(
        constants.martensite_barrier_k + constants.martensite_barrier_per_pa * stress_pa, 0.0
    )
    r_to_m_barrier = min(constants.r_to_m_barrier_k, barrier + constants.r_phase_barrier_k)
    return Forces(
        martensite - barrier,
        r_phase - constants.r_phase_barrier_k,
        preference - r_to_m_barrier,
        -martensite - barrier,
        -r_phase - constants.r_phase_barrier_k,
        -preference - r_to_m_barrier,
        stress_pa,
    )


@compiled
def spreads(constants: Any, stress_pa: float) -> tuple[float, float, float]:
    """Return the spreads [K] of f_M, f_R and f_M - f_R; the last is negative if the R-phase's is the larger one."""
    spread_m = constants.martensite_spread_k + constants.martensite_spread_per_pa * stress_pa
    spread_r = constants.r_phase_entropy_ratio * constants.r_phase_spread_k
    spread_p = spread_m - spread_r
    if abs(spread_p) < 1e-6:
        spread_p = 1e-6
    return max(spread_m, 1e-6), max(spread_r, 1e-6), spread_p


@compiled
def beyond(force_k: float, per_width: float) -> float:
    """Return the fraction of a grain for which a change is due: 0.5 at its middle, linear over its interval."""
    return min(max(force_k * per_width + 0.5, 0.0), 1.0)


@compiled
def cool(constants: Any, forces: Forces, grains: Grains, first: int, last: int) -> None:
    """Apply the driving forces of cooling to grains, in place: both fractions only rise, to bounds."""
    spread_m, spread_r, spread_p = spreads(constants, forces.stress_pa)
    for j in range(first, last):
        middle = grains.middle[j]
        per_width = 1.0 / grains.width[j]
        has_left_a = max(
            beyond(forces.a_to_m_k + spread_m * middle, per_width / spread_m),
            beyond(forces.a_to_r_k + spread_r * middle, per_width / spread_r),
        )
        formed = max(grains.martensite[j] + grains.r_phase[j], has_left_a)
        no_longer_r = beyond(forces.r_to_m_k + spread_p * middle, per_width / abs(spread_p))
        grains.martensite[j] = max(grains.martensite[j], min(no_longer_r, formed))
        grains.r_phase[j] = formed - grains.martensite[j]


@compiled
def heat(constants: Any, forces: Forces, grains: Grains, first: int, last: int) -> None:
    """Apply the driving forces of heating to grains, in place: the mirror of cooling."""
    spread_m, spread_r, spread_p = spreads(constants, forces.stress_pa)
    for j in range(first, last):
        middle = grains.middle[j]
        per_width = 1.0 / grains.width[j]
        has_left_m = max(
            beyond(forces.m_to_a_k - spread_m * middle, per_width / spread_m),
            beyond(forces.m_to_r_k - spread_p * middle, per_width / abs(spread_p)),
        )
        martensite = min(grains.martensite[j], 1.0 - has_left_m)
        must_be_austenite = beyond(forces.r_to_a_k - spread_r * middle, per_width / spread_r)
        formed = min(grains.martensite[j] + grains.r_phase[j], max(martensite, 1.0 - must_be_austenite))
        grains.martensite[j] = martensite
        grains.r_phase[j] = formed - martensite


@compiled
def grain_at(edges: Array, place: float) -> int:
    """Return the index of the grain at an offset; -1 and n are outside."""
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
def swept(edges: Array, place: float, followed_place: float, spread: float, followed_spread: float) -> tuple[int, int]:
    """Return the first grain that a threshold has swept over and the one after the last; (0, 0) if none."""
    if spread * followed_spread < 0.0:
        return 0, edges.shape[0] - 1  # the order of the grains is reversed: all may change
    if not (place - followed_place) * spread > 0.0:
        return 0, 0
    first = grain_at(edges, min(followed_place, place))
    last = grain_at(edges, max(followed_place, place))
    return max(first, 0), min(last + 1, edges.shape[0] - 1)


@compiled
def follow(
    grains: Grains, constants: Any, temperature_k: float, stress_pa: float, barrier_factor: float
) -> tuple[float, float]:
    """Apply a temperature and a stress to the grains, in place; return the changes of both sums over them."""
    forces = forces_at(constants, temperature_k, stress_pa, barrier_factor)
    m, r, p = spreads(constants, stress_pa)
    m_before, r_before, p_before = spreads(constants, grains.followed[6])
    spread, spread_before = (-m, -r, -p, m, r, p), (-m_before, -r_before, -p_before, m_before, r_before, p_before)
    change_m, change_r = 0.0, 0.0
    for change in range(6):
        place, place_before = forces[change] / spread[change], grains.followed[change] / spread_before[change]
        first, last = swept(grains.edges, place, place_before, spread[change], spread_before[change])
        for j in range(first, last):
            change_m -= grains.martensite[j]
            change_r -= grains.r_phase[j]
        if change < COOLINGS:
            cool(constants, forces, grains, first, last)
        else:
            heat(constants, forces, grains, first, last)
        for j in range(first, last):
            change_m += grains.martensite[j]
            change_r += grains.r_phase[j]
    remember(grains, forces)
    return change_m, change_r


@compiled
def remember(grains: Grains, forces: Forces) -> None:
    """Store the driving forces that the grains have followed."""
    for change in range(7):
        grains.followed[change] = forces[change]


@compiled
def cool_from_hot(grains: Grains, constants: Any, temperature_k: float, stress_pa: float) -> None:
    """Set the grains to those of a wire cooled from austenite at constant stress: the path does not matter."""
    grains.martensite[:] = 0.0
    grains.r_phase[:] = 0.0
    forces = forces_at(constants, temperature_k, stress_pa, 1.0)
    cool(constants, forces, grains, 0, grains.middle.shape[0])
    remember(grains, forces)


def offsets(normal_quantile: Array, skew: float, tail: float) -> Array:
    """Return z (z^2 + 0.3^2)^(tail/2), stretched by 1 + skew above and 1 - skew below the middle."""
    z = np.asarray(normal_quantile, dtype=np.float64)
    return (1.0 + skew * np.sign(z)) * z * (z * z + 0.3**2) ** (0.5 * tail)
