"""Phase changes of a wire's grains as temperature and stress change, compiled.

A grain changes only if one of its six thermodynamic driving forces has risen and that force's threshold has swept over
it. A step therefore evaluates only the few grains between the thresholds before and after, whatever their number.

All code that accesses the grains of a row is in this file; the rest of the wire uses :func:`follow`,
:func:`phase_fractions` and :func:`cool_from_hot`.
"""

from __future__ import annotations

from typing import NamedTuple

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.physics.material import advantage_k, cooled_grain, heated_grain
from musclewire.wire.state import Rows, WireConstants, WireState

__all__ = [
    "DrivingForces",
    "cool_from_hot",
    "cool_swept",
    "driving_forces_at",
    "follow",
    "heat_swept",
    "phase_fractions",
    "switch_grains",
]


class DrivingForces(NamedTuple):
    """Thermodynamic driving forces [K] of the six phase changes of a grain of offset 0, and the stress they are for.

    A driving force is the advantage of the new phase less the barrier: the change is due from 0 on.

    Parameters
    ----------
    a_to_m_k, a_to_r_k, r_to_m_k
        Of the changes on cooling [K]: austenite to martensite, austenite to R-phase, R-phase to martensite.
    m_to_a_k, r_to_a_k, m_to_r_k
        Of the changes on heating [K], the reverse of these.
    stress_pa
        Stress of the leg [Pa], on which the spread over the grains depends.
    """

    a_to_m_k: float
    a_to_r_k: float
    r_to_m_k: float
    m_to_a_k: float
    r_to_a_k: float
    m_to_r_k: float
    stress_pa: float


@compiled
def driving_forces_at(
    constants: WireConstants, temperature_k: float, stress_pa: float, barrier_factor: float
) -> DrivingForces:
    """Return the six driving forces at a temperature and a stress.

    Parameters
    ----------
    constants
        The wire's constants, one record.
    temperature_k
        Temperature of the wire [K].
    stress_pa
        Stress of a leg [Pa].
    barrier_factor
        Factor on the barrier between austenite and martensite: above 1 in a new wire, 1 after shakedown.

    Returns
    -------
    The forces for a grain of offset 0 [K], with the stress; a change is due from 0 on.

    References
    ----------
    Threshold switching as in Preisach's operator: Mayergoyz 1986, doi 10.1103/PhysRevLett.56.1518. The phase boundaries
    are those of Brinson 1993, doi 10.1177/1045389X9300400213.
    """
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
    # Stress may close the hysteresis but not invert it, and the detour via austenite must not be easier than the direct
    # change between R-phase and martensite: otherwise return-point memory is lost.
    barrier = barrier_factor * max(
        constants.martensite_barrier_k + constants.martensite_barrier_per_pa * stress_pa, 0.0
    )
    r_to_m_barrier = min(constants.r_to_m_barrier_k, barrier + constants.r_phase_barrier_k)
    return DrivingForces(
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

    Stress widens the spreads, as grains are oriented differently to the wire's axis and carry different stresses. A
    spread is at least a microkelvin, which is a switch rather than a ramp.

    Parameters
    ----------
    constants
        The wire's constants, one record.
    stress_pa
        Stress of a leg [Pa].

    Returns
    -------
    The three spreads: of martensite against austenite, of R-phase against austenite, and of martensite against R-phase,
    which is negative if the R-phase's is the larger one.
    """
    spread_m = constants.martensite_spread_k + constants.martensite_spread_per_pa * stress_pa
    spread_r = constants.r_phase_entropy_ratio * constants.r_phase_spread_k
    spread_p = spread_m - spread_r
    if abs(spread_p) < 1e-6:
        spread_p = 1e-6
    return max(spread_m, 1e-6), max(spread_r, 1e-6), spread_p


@compiled
def grain_at(edges: FloatArray, place: float) -> int:
    """Return the index of the grain at an offset in units of the spread; -1 and n_grains are outside."""
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
    """Return the first grain between two positions of a moving threshold, and the one after the last."""
    first = grain_at(edges, min(before, after))
    last = grain_at(edges, max(before, after))
    return max(first, 0), min(last + 1, edges.shape[0] - 1)


@compiled
def cool_swept(
    constants: WireConstants,
    forces: DrivingForces,
    first: int,
    last: int,
    grain_martensite: FloatArray,
    grain_r_phase: FloatArray,
) -> None:
    """Apply the driving forces of cooling to the grains from ``first`` to before ``last``, in place."""
    spread_m, spread_r, spread_p = spreads(constants, forces.stress_pa)
    for j in range(first, last):
        middle = constants.grain_middle[j]
        per_width = 1.0 / constants.grain_width[j]
        grain_martensite[j], grain_r_phase[j] = cooled_grain(
            grain_martensite[j],
            grain_r_phase[j],
            forces.a_to_m_k + spread_m * middle,
            forces.a_to_r_k + spread_r * middle,
            forces.r_to_m_k + spread_p * middle,
            per_width / spread_m,
            per_width / spread_r,
            per_width / abs(spread_p),
        )


@compiled
def heat_swept(
    constants: WireConstants,
    forces: DrivingForces,
    first: int,
    last: int,
    grain_martensite: FloatArray,
    grain_r_phase: FloatArray,
) -> None:
    """Apply the driving forces of heating to the grains from ``first`` to before ``last``, in place."""
    spread_m, spread_r, spread_p = spreads(constants, forces.stress_pa)
    for j in range(first, last):
        middle = constants.grain_middle[j]
        per_width = 1.0 / constants.grain_width[j]
        grain_martensite[j], grain_r_phase[j] = heated_grain(
            grain_martensite[j],
            grain_r_phase[j],
            forces.m_to_a_k - spread_m * middle,
            forces.r_to_a_k - spread_r * middle,
            forces.m_to_r_k - spread_p * middle,
            per_width / spread_m,
            per_width / spread_r,
            per_width / abs(spread_p),
        )


@compiled
def switch_grains(
    constants: WireConstants,
    forces: DrivingForces,
    followed: DrivingForces,
    grain_martensite: FloatArray,
    grain_r_phase: FloatArray,
) -> tuple[float, float]:
    """Apply driving forces that changed from ``followed`` to all grains, in place; return the change of both sums.

    Only the grains between the thresholds before and after of a driving force that has risen are evaluated.
    """
    spread_m, spread_r, spread_p = spreads(constants, forces.stress_pa)
    followed_m, followed_r, followed_p = spreads(constants, followed.stress_pa)
    edges = constants.grain_edges
    grains = constants.grain_middle.shape[0]
    change_m = 0.0
    change_r = 0.0
    for change in range(6):
        if change == 0:
            new, old, spread, followed_spread = forces.a_to_m_k, followed.a_to_m_k, -spread_m, -followed_m
        elif change == 1:
            new, old, spread, followed_spread = forces.a_to_r_k, followed.a_to_r_k, -spread_r, -followed_r
        elif change == 2:
            new, old, spread, followed_spread = forces.r_to_m_k, followed.r_to_m_k, -spread_p, -followed_p
        elif change == 3:
            new, old, spread, followed_spread = forces.m_to_a_k, followed.m_to_a_k, spread_m, followed_m
        elif change == 4:
            new, old, spread, followed_spread = forces.r_to_a_k, followed.r_to_a_k, spread_r, followed_r
        else:
            new, old, spread, followed_spread = forces.m_to_r_k, followed.m_to_r_k, spread_p, followed_p
        place, followed_place = new / spread, old / followed_spread
        # The threshold is the offset at which a grain's driving force is zero; it moves with driving force and spread.
        if spread * followed_spread < 0.0:
            first, last = 0, grains  # the order of the grains is reversed: all may change
        elif (place - followed_place) * spread > 0.0:
            first, last = grains_swept(edges, followed_place, place)
        else:
            continue
        for j in range(first, last):
            change_m -= grain_martensite[j]
            change_r -= grain_r_phase[j]
        if change < 3:
            cool_swept(constants, forces, first, last, grain_martensite, grain_r_phase)
        else:
            heat_swept(constants, forces, first, last, grain_martensite, grain_r_phase)
        for j in range(first, last):
            change_m += grain_martensite[j]
            change_r += grain_r_phase[j]
    return change_m, change_r


@compiled
def follow(
    state: WireState, constants: WireConstants, temperature_k: float, stress_pa: float, barrier_factor: float
) -> tuple[float, float, int]:
    """Apply a temperature and a stress to the grains of a row.

    Parameters
    ----------
    state
        The wire's state, one record, written in place: its grains, and the driving forces that they have followed.
    constants
        The wire's constants, one record.
    temperature_k
        New temperature of the wire [K].
    stress_pa
        New stress of a leg [Pa].
    barrier_factor
        Factor on the barrier between austenite and martensite: above 1 in a new wire, 1 after shakedown.

    Returns
    -------
    The changes of the sums of martensite and of R-phase over the grains, and the number of grains.

    References
    ----------
    Mayergoyz 1986, doi 10.1103/PhysRevLett.56.1518, and Sethna et al. 1993, doi 10.1103/PhysRevLett.70.3347, for the
    return-point memory of such an ensemble.
    """
    forces = driving_forces_at(constants, temperature_k, stress_pa, barrier_factor)
    kept = state.followed_force_k
    followed = DrivingForces(kept[0], kept[1], kept[2], kept[3], kept[4], kept[5], state.followed_stress_pa)
    change_m, change_r = switch_grains(constants, forces, followed, state.grain_martensite, state.grain_r_phase)
    store_followed(state, forces)
    return change_m, change_r, constants.grain_middle.shape[0]


@compiled
def store_followed(state: WireState, forces: DrivingForces) -> None:
    """Store the driving forces that the grains have followed in their row."""
    kept = state.followed_force_k
    kept[0] = forces.a_to_m_k
    kept[1] = forces.a_to_r_k
    kept[2] = forces.r_to_m_k
    kept[3] = forces.m_to_a_k
    kept[4] = forces.r_to_a_k
    kept[5] = forces.m_to_r_k
    state.followed_stress_pa = forces.stress_pa


@compiled
def phase_fractions(state: WireState) -> tuple[float, float]:
    """Return the fractions of martensite and R-phase, as means over the grains."""
    return state.grain_martensite.mean(), state.grain_r_phase.mean()


@compiled
def cool_from_hot(states: Rows, constants: Rows, stress_pa: float, temperature_k: float) -> None:
    """Set the grains of a row, (1,), to those of a wire cooled from full austenite at constant stress.

    On cooling all three driving forces only rise, and fractions only rise to bounds that these set: the result does not
    depend on the path, so that evaluating its end is enough.
    """
    state, of = states[0], constants[0]
    state.grain_martensite[:] = 0.0
    state.grain_r_phase[:] = 0.0
    forces = driving_forces_at(of, temperature_k, stress_pa, 1.0)
    cool_swept(of, forces, 0, of.grain_middle.shape[0], state.grain_martensite, state.grain_r_phase)
    store_followed(state, forces)
