"""The two balances of a wire, of enthalpy and of force, at a trial temperature and stress, with all slopes; compiled.

Everything a Newton step needs is evaluated at once. As in ``wire/_fronts.py`` nothing branches on numbers, so that the
same functions serve one wire and vectors of wires, to the same bits.
"""

from __future__ import annotations

from typing import NamedTuple

from musclewire.compiled import compiled_inline
from musclewire.physics import ELASTIC_POISSON_RATIO, REFERENCE_TEMPERATURE_K
from musclewire.wire._fronts import PhaseFractions, ShakedownEffects
from musclewire.wire._row import Rows, StepConstants

# Beyond this exponent martensite is oriented to 13 digits.
MAX_EXPONENT = 32.0
SEVEN_HALVINGS = 1.0 / 128.0


class ConnectorForce(NamedTuple):
    """A force on the connector that adds to the load's: that of a second wire or an object, linear around a point."""

    force_n: float
    per_contraction_n: float  # slope over contraction [N]
    contraction: float  # the point


class LoadPoint(NamedTuple):
    """Force of the load at a contraction, friction included."""

    force_n: float  # pretension, spring, table, push and friction
    per_contraction_n: float  # its slope over contraction [N]
    friction_n: float  # friction alone, positive against contraction
    friction_per_contraction_n: float  # slope of the friction [N]
    limit_n: float  # friction at which the guide slides, 0 or more


class StrainSlopes(NamedTuple):
    """Strain of a wire at a temperature, a stress and its phases, with slopes; positive for a longer wire."""

    transformation: float
    elastic: float
    thermal: float
    oriented: float  # transformation strain of pure martensite at this stress
    oriented_per_pa: float  # its slope over stress


class BalancedWire(NamedTuple):
    """A wire in both balances."""

    temperature_k: float
    stress_pa: float
    contraction: float
    friction_n: float  # of guide and load
    martensite: float  # volume fraction
    r_phase: float  # volume fraction
    resistance_ohm: float
    rise_k: float  # last correction of temperature, for the fronts
    rise_pa: float  # last correction of stress, for the fronts


class BalanceResidual(NamedTuple):
    """What is missing from both balances, and the Newton step that would meet them."""

    heat_j: float  # enthalpy at the trial point less the enthalpy there is
    excess_pa: float  # trial stress less the stress at which the load is balanced
    rise_k: float  # Newton step in temperature
    rise_pa: float  # Newton step in stress
    contraction: float  # at the trial point
    contraction_per_k: float
    contraction_per_pa: float
    heat_per_k: float  # slopes of the missing heat [J/K, J/Pa]
    heat_per_pa: float
    excess_per_k: float  # slopes of the excess stress [Pa/K, 1]
    excess_per_pa: float
    per_determinant: float  # reciprocal of the Jacobian's determinant [K/J]


class TrialPoint(NamedTuple):
    """A point at which both balances have been evaluated."""

    phases: PhaseFractions
    strain: StrainSlopes
    load: LoadPoint
    balance: BalanceResidual


@compiled_inline
def decay(exponent: float) -> float:
    """Return exp(-exponent) for exponents of 0 to 32, and that of 32 beyond; within 3e-14 of the exact value.

    The library's exponential would keep a loop over wires from becoming vector instructions. Taylor's series of a 128th
    of the exponent, squared seven times.
    """
    limited = exponent if exponent < MAX_EXPONENT else MAX_EXPONENT
    y = -limited * SEVEN_HALVINGS
    square = y * y
    fourth = square * square
    # Taylor's terms in pairs: short chains of operations that depend on each other.
    low = (1.0 + y) + square * (1.0 / 2.0 + y * (1.0 / 6.0))
    middle = (1.0 / 24.0 + y * (1.0 / 120.0)) + square * (1.0 / 720.0 + y * (1.0 / 5040.0))
    high = (1.0 / 40320.0 + y * (1.0 / 362880.0)) + square * (1.0 / 3628800.0)
    part = low + fourth * (middle + fourth * high)
    part *= part
    part *= part
    part *= part
    part *= part
    part *= part
    part *= part
    return part * part


@compiled_inline
def strain_at(
    constants: StepConstants, temperature_k: float, stress_pa: float, martensite: float, r_phase: float
) -> StrainSlopes:
    """Return the strain of a wire relative to stress-free austenite at 20 C.

    References
    ----------
    Transformation strain after Lagoudas, Hartl, Chemisky, Machado and Popov 2012, doi 10.1016/j.ijplas.2011.10.009:
    H(sigma) = H_0 + (H_sat - H_0) (1 - exp(-sigma / sigma_k)). Compliance after Reuss 1929,
    doi 10.1002/zamm.19290090104: 1/E = (1 - xi) / E_A + xi / E_M.
    """
    k = constants
    unoriented = (k.strain_saturated - k.strain_at_no_stress) * decay(stress_pa * k.per_strain_scale_per_pa)
    oriented = k.strain_saturated - unoriented
    return StrainSlopes(
        oriented * martensite + k.r_phase_strain * r_phase,
        stress_pa * (k.austenite_compliance_per_pa + martensite * k.added_compliance_per_pa),
        (k.austenite_expansion_per_k + martensite * k.added_expansion_per_k)
        * (temperature_k - REFERENCE_TEMPERATURE_K),
        oriented,
        unoriented * k.per_strain_scale_per_pa,
    )


@compiled_inline
def balance_at(
    constants: StepConstants,
    shakedown: ShakedownEffects,
    phases: PhaseFractions,
    strain: StrainSlopes,
    load: LoadPoint,
    trial: tuple[float, float, float],
) -> BalanceResidual:
    """Return what is missing from both balances at a trial point, and the Newton step from there.

    Enthalpy: C (T - 20 C) - L (x_M + r x_R) = H. Force: sigma = load over section. ``trial``: temperature [K], stress
    [Pa], and the enthalpy to be met [J].

    References
    ----------
    Force balance: Lan and Fan 2010, Eq. 8, F_T = F_p + F.
    """
    k = constants
    temperature_k, stress_pa, enthalpy_j = trial
    warm_k = temperature_k - REFERENCE_TEMPERATURE_K
    ratio, latent, capacity = k.r_phase_entropy_ratio, k.latent_heat_j, k.capacity_j_per_k
    compliance = k.austenite_compliance_per_pa + phases.martensite * k.added_compliance_per_pa
    expansion = k.austenite_expansion_per_k + phases.martensite * k.added_expansion_per_k
    per_martensite = strain.oriented + stress_pa * k.added_compliance_per_pa + k.added_expansion_per_k * warm_k
    strain_per_k = per_martensite * phases.martensite_per_k + k.r_phase_strain * phases.r_phase_per_k + expansion
    strain_per_pa = (
        per_martensite * phases.martensite_per_pa
        + k.r_phase_strain * phases.r_phase_per_pa
        + compliance
        + phases.martensite * strain.oriented_per_pa
    )
    stiffness = load.per_contraction_n * k.per_section_m2 * k.per_stretch
    heat_j = capacity * warm_k - latent * (phases.martensite + ratio * phases.r_phase) - enthalpy_j
    excess_pa = stress_pa - load.force_n * k.per_section_m2
    heat_per_k = capacity - latent * (phases.martensite_per_k + ratio * phases.r_phase_per_k)
    heat_per_pa = -latent * (phases.martensite_per_pa + ratio * phases.r_phase_per_pa)
    excess_per_k = stiffness * strain_per_k
    excess_per_pa = 1.0 + stiffness * strain_per_pa
    per_determinant = 1.0 / (heat_per_k * excess_per_pa - heat_per_pa * excess_per_k)
    return BalanceResidual(
        heat_j,
        excess_pa,
        (heat_per_pa * excess_pa - excess_per_pa * heat_j) * per_determinant,
        (excess_per_k * heat_j - heat_per_k * excess_pa) * per_determinant,
        contraction_of(k, shakedown, strain),
        -strain_per_k * k.per_stretch,
        -strain_per_pa * k.per_stretch,
        heat_per_k,
        heat_per_pa,
        excess_per_k,
        excess_per_pa,
        per_determinant,
    )


@compiled_inline
def settled(
    constants: StepConstants,
    shakedown: ShakedownEffects,
    point: TrialPoint,
    step: tuple[float, float],
    trial: tuple[float, float, float],
) -> BalancedWire:
    """Return the wire after the last Newton step, applied linearly; a negative stress becomes 0, that of a slack wire.

    Temperature follows from enthalpy and the corrected fractions, so that energy is kept to rounding. ``trial`` as in
    ``balance_at``; ``step`` in temperature [K] and stress [Pa] is small, or 0 to take the point as it is.
    """
    k = constants
    _, stress_pa, enthalpy_j = trial
    phases, strain, load, balance = point
    rise_k, rise_pa = step
    martensite = phases.martensite + phases.martensite_per_k * rise_k + phases.martensite_per_pa * rise_pa
    r_phase = phases.r_phase + phases.r_phase_per_k * rise_k + phases.r_phase_per_pa * rise_pa
    moved = balance.contraction_per_k * rise_k + balance.contraction_per_pa * rise_pa
    friction_n = load.friction_n + load.friction_per_contraction_n * moved
    friction_n = friction_n if friction_n < load.limit_n else load.limit_n
    friction_n = friction_n if friction_n > -load.limit_n else -load.limit_n
    stress_pa = stress_pa + rise_pa
    stress_pa = stress_pa if stress_pa > 0.0 else 0.0
    transformed = martensite + k.r_phase_entropy_ratio * r_phase
    temperature_k = REFERENCE_TEMPERATURE_K + (enthalpy_j + k.latent_heat_j * transformed) * k.per_capacity_k_per_j
    oriented = strain.oriented + strain.oriented_per_pa * rise_pa
    after = StrainSlopes(
        oriented * martensite + k.r_phase_strain * r_phase,
        stress_pa * (k.austenite_compliance_per_pa + martensite * k.added_compliance_per_pa),
        (k.austenite_expansion_per_k + martensite * k.added_expansion_per_k)
        * (temperature_k - REFERENCE_TEMPERATURE_K),
        oriented,
        strain.oriented_per_pa,
    )
    return BalancedWire(
        temperature_k,
        stress_pa,
        balance.contraction + moved,
        friction_n,
        martensite,
        r_phase,
        resistance_at(k, shakedown, after, temperature_k, martensite, r_phase),
        rise_k,
        rise_pa,
    )


@compiled_inline
def contraction_of(constants: StepConstants, shakedown: ShakedownEffects, strain: StrainSlopes) -> float:
    """Return the contraction of a wire relative to its cold length under pretension, positive for a shorter wire."""
    total = strain.transformation + strain.elastic + strain.thermal + shakedown.residual_strain
    return (constants.cold_strain - total) * constants.per_stretch


@compiled_inline
def resistance_at(
    constants: StepConstants,
    shakedown: ShakedownEffects,
    strain: StrainSlopes,
    temperature_k: float,
    martensite: float,
    r_phase: float,
) -> float:
    """Return the resistance of a whole wire [ohm], without leads: phases mixed by volume, then the change of shape.

    References
    ----------
    R = rho l / A with the change of l and A by each strain: transformation keeps the volume, elastic strain thins by
    Poisson's ratio, expansion widens as it lengthens. rho of a phase is linear in temperature from 20 C, with the
    coefficients of the alloy's file.
    """
    k = constants
    warm_k = temperature_k - REFERENCE_TEMPERATURE_K
    martensite_ohm_m = k.martensite_resistivity_ohm_m * shakedown.resistivity_factor
    resistivity = (
        martensite * martensite_ohm_m * (1.0 + k.martensite_resistivity_per_k * warm_k)
        + r_phase * k.r_phase_resistivity_ohm_m * (1.0 + k.r_phase_resistivity_per_k * warm_k)
        + (1.0 - martensite - r_phase) * k.austenite_resistivity_ohm_m * (1.0 + k.austenite_resistivity_per_k * warm_k)
    )
    stretch = 1.0 + strain.transformation
    thinning = 1.0 - ELASTIC_POISSON_RATIO * strain.elastic
    return (
        resistivity
        * k.length_over_area_per_m
        * (stretch * stretch * (1.0 + strain.elastic))
        / (thinning * thinning * (1.0 + strain.thermal))
    )


@compiled_inline
def convection_w_per_m2_k(constants: StepConstants, row: Rows, temperature_k: float) -> float:
    """Return the correlation's heat transfer coefficient at a wall temperature, from the table in a wire's row.

    ``constants`` has the table's start and step: the row itself, or the same names of one of many wires.
    """
    last = row.convection_w_per_m2_k.shape[0] - 1
    place = (temperature_k - constants.convection_start_k) * constants.convection_per_k
    place = place if place > 0.0 else 0.0
    place = place if place < last else float(last)
    low = int(place)
    low = low if low < last else last - 1
    part = place - low
    return row.convection_w_per_m2_k[low] * (1.0 - part) + row.convection_w_per_m2_k[low + 1] * part


@compiled_inline
def loss_w(constants: StepConstants, coefficient_w_per_m2_k: float, temperature_k: float) -> float:
    """Return the heat lost to the air [W] at a heat transfer coefficient before the wire's own factor."""
    excess_k = temperature_k - constants.ambient_temperature_k
    lost_w: float = coefficient_w_per_m2_k * constants.surface_factor_m2 * excess_k
    return lost_w
