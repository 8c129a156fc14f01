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
    """A force on the connector that adds to the load's: that of a second wire or an object, linear around a point.

    Parameters
    ----------
    force_n
        Force at that point [N].
    per_contraction_n
        Its slope over contraction [N].
    contraction
        The point.
    """

    force_n: float
    per_contraction_n: float
    contraction: float


class LoadPoint(NamedTuple):
    """Force of the load at a contraction, friction included.

    Parameters
    ----------
    force_n
        Pretension, spring, table, push and friction [N].
    per_contraction_n
        Its slope over contraction [N].
    friction_n
        Friction alone [N], positive against contraction.
    friction_per_contraction_n
        Slope of the friction [N].
    limit_n
        Friction at which the guide slides [N], 0 or more.
    """

    force_n: float
    per_contraction_n: float
    friction_n: float
    friction_per_contraction_n: float
    limit_n: float


class StrainSlopes(NamedTuple):
    """Strain of a wire at a temperature, a stress and its phases, with slopes.

    Parameters
    ----------
    transformation, elastic, thermal
        Its three parts; each positive for a longer wire.
    oriented
        Transformation strain of pure martensite at this stress.
    oriented_per_pa
        Its slope over stress [1/Pa].
    """

    transformation: float
    elastic: float
    thermal: float
    oriented: float
    oriented_per_pa: float


class BalancedWire(NamedTuple):
    """A wire in both balances.

    Parameters
    ----------
    temperature_k, stress_pa, contraction
        Temperature [K], stress [Pa] and contraction.
    friction_n
        Friction of guide and load [N].
    martensite, r_phase
        Its volume fractions.
    resistance_ohm
        Its resistance [ohm].
    rise_k, rise_pa
        Last correction of temperature [K] and stress [Pa], for the fronts.
    """

    temperature_k: float
    stress_pa: float
    contraction: float
    friction_n: float
    martensite: float
    r_phase: float
    resistance_ohm: float
    rise_k: float
    rise_pa: float


class BalanceResidual(NamedTuple):
    """What is missing from both balances, and the Newton step that would meet them.

    Parameters
    ----------
    heat_j
        Enthalpy at the trial point less the enthalpy there is [J].
    excess_pa
        Trial stress less the stress at which the load is balanced [Pa].
    rise_k, rise_pa
        Newton step in temperature [K] and stress [Pa].
    contraction
        Contraction at the trial point.
    contraction_per_k, contraction_per_pa
        Its slopes.
    heat_per_k, heat_per_pa
        Slopes of the missing heat [J/K, J/Pa].
    excess_per_k, excess_per_pa
        Slopes of the excess stress [Pa/K, 1].
    per_determinant
        Reciprocal of the Jacobian's determinant [K/J].
    """

    heat_j: float
    excess_pa: float
    rise_k: float
    rise_pa: float
    contraction: float
    contraction_per_k: float
    contraction_per_pa: float
    heat_per_k: float
    heat_per_pa: float
    excess_per_k: float
    excess_per_pa: float
    per_determinant: float


class TrialPoint(NamedTuple):
    """A point at which both balances have been evaluated."""

    phases: PhaseFractions
    strain: StrainSlopes
    load: LoadPoint
    balance: BalanceResidual


@compiled_inline
def decay(exponent: float) -> float:
    """Return exp(-exponent) for exponents of 0 to 32, and that of 32 beyond; within 3e-14 of the exact value.

    The library's exponential would keep a loop over wires from becoming vector instructions. Taylor's series of a
    128th of the exponent, squared seven times.
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

    Parameters
    ----------
    constants
        One record of the wire's derived constants.
    temperature_k
        Temperature of the wire [K].
    stress_pa
        Stress of a leg [Pa].
    martensite
        Volume fraction of martensite, 0 to 1.
    r_phase
        Volume fraction of R-phase, 0 to 1 - ``martensite``.

    Returns
    -------
    Transformation, elastic and thermal strain, with what martensite alone would have.

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

    Enthalpy: C (T - 20 C) - L (x_M + r x_R) = H. Force: sigma = load over section.

    Parameters
    ----------
    constants
        One record of the wire's derived constants.
    shakedown
        Effects of its shakedown.
    phases
        Its phases at the trial point.
    strain
        Its strain there.
    load
        The load at the contraction that this strain means.
    trial
        Temperature [K], stress [Pa], and the enthalpy to be met [J].

    Returns
    -------
    Both residuals, the contraction and the Newton step.

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
    """Return the wire after the last Newton step, applied linearly.

    Temperature follows from enthalpy and the corrected fractions, so that energy is kept to rounding.

    Parameters
    ----------
    constants
        One record of the wire's derived constants.
    shakedown
        Effects of its shakedown.
    point
        What was found at the trial point.
    step
        The last Newton step in temperature [K] and stress [Pa]: small, or 0 to take the point as it is.
    trial
        Temperature [K], stress [Pa] and enthalpy [J] of the trial point.

    Returns
    -------
    The wire with its resistance. A negative stress becomes 0: a slack wire carries nothing.
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
    """Return the contraction of a wire relative to its cold length under pretension.

    Parameters
    ----------
    constants
        One record of the wire's derived constants.
    shakedown
        Effects of its shakedown, of which it has gained strain.
    strain
        Its strain relative to stress-free austenite at 20 C.

    Returns
    -------
    The contraction, positive for a shorter wire.
    """
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
    """Return the resistance of a wire [ohm]: phases mixed by volume, then the change of shape.

    Parameters
    ----------
    constants
        One record of the wire's derived constants.
    shakedown
        Effects of its shakedown, which raises the resistivity of martensite.
    strain
        Its strain.
    temperature_k
        Its temperature [K].
    martensite, r_phase
        Its volume fractions.

    Returns
    -------
    Resistance of the whole wire [ohm], without leads and shunt.

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
