"""Constitutive law of NiTi wire: which phase is favoured, the strain that follows, and the friction of a guide.

Symbols: M martensite; T temperature, sigma stress; f advantage over austenite in kelvin; C stress rate
(Clausius-Clapeyron slope) in Pa/K. When phases change is in ``wire/_fronts.py``.
"""

from __future__ import annotations

import math

from musclewire.compiled import compiled


@compiled
def advantage_k(
    temperature_k: float, stress_pa: float, transformation_temperature_k: float, stress_rate_pa_per_k: float
) -> float:
    """Return the advantage [K] of a phase over austenite (Clausius-Clapeyron).

    Parameters
    ----------
    temperature_k
        T, temperature of the wire [K].
    stress_pa
        sigma, stress in the wire [Pa].
    transformation_temperature_k
        T_0, at which phase and austenite are in equilibrium without stress [K].
    stress_rate_pa_per_k
        C, the Clausius-Clapeyron slope of the phase [Pa/K], above 0.

    Returns
    -------
    f = T_0 + sigma / C - T [K], positive if the phase is favoured.

    References
    ----------
    The straight phase boundaries of Brinson 1993, J. Intell. Mater. Syst. Struct. 4, 229,
    doi 10.1177/1045389X9300400213.

    Examples
    --------
    >>> advantage_k(350.0, 150e6, 330.0, 7.5e6)
    0.0
    """
    return transformation_temperature_k + stress_pa / stress_rate_pa_per_k - temperature_k


@compiled
def maximum_transformation_strain(
    stress_pa: float, strain_at_no_stress: float, strain_saturated: float, stress_scale_pa: float
) -> float:
    """Return the strain that fully oriented martensite reaches at a stress.

    Parameters
    ----------
    stress_pa
        sigma, stress in the wire [Pa], not negative.
    strain_at_no_stress
        H_0, as a fraction.
    strain_saturated
        H_sat, as a fraction, reached at high stress.
    stress_scale_pa
        sigma_k, stress [Pa] over which H approaches H_sat by a factor e.

    Returns
    -------
    H, as a fraction: H(sigma) = H_0 + (H_sat - H_0) (1 - exp(-sigma / sigma_k)).

    References
    ----------
    Lagoudas, Hartl, Chemisky, Machado and Popov 2012, Int. J. Plasticity 32-33, 155, doi 10.1016/j.ijplas.2011.10.009.

    Examples
    --------
    >>> round(maximum_transformation_strain(190e6, 0.01, 0.05, 100e6), 5)
    0.04402
    """
    return strain_saturated - (strain_saturated - strain_at_no_stress) * math.exp(-stress_pa / stress_scale_pa)


@compiled
def maximum_transformation_strain_slope_per_pa(
    stress_pa: float, strain_at_no_stress: float, strain_saturated: float, stress_scale_pa: float
) -> float:
    """Return the derivative by stress [1/Pa] of :func:`maximum_transformation_strain`.

    Parameters
    ----------
    stress_pa
        sigma, stress in the wire [Pa], not negative.
    strain_at_no_stress
        H_0, as a fraction.
    strain_saturated
        H_sat, as a fraction.
    stress_scale_pa
        sigma_k [Pa].

    Returns
    -------
    dH/dsigma [1/Pa] = (H_sat - H_0) / sigma_k exp(-sigma / sigma_k).

    References
    ----------
    The derivative of Lagoudas et al. 2012, doi 10.1016/j.ijplas.2011.10.009.

    Examples
    --------
    >>> round(maximum_transformation_strain_slope_per_pa(0.0, 0.01, 0.05, 100e6) * 1e12)
    400
    """
    return (strain_saturated - strain_at_no_stress) / stress_scale_pa * math.exp(-stress_pa / stress_scale_pa)


@compiled
def reuss_modulus_pa(martensite_fraction: float, austenite_modulus_pa: float, martensite_modulus_pa: float) -> float:
    """Return the elastic modulus [Pa] of phases in series under one stress.

    Parameters
    ----------
    martensite_fraction
        xi, 0 to 1; the R-phase counts as austenite.
    austenite_modulus_pa
        E_A [Pa].
    martensite_modulus_pa
        E_M [Pa].

    Returns
    -------
    E [Pa] with 1/E = (1 - xi) / E_A + xi / E_M.

    References
    ----------
    Reuss 1929, Z. angew. Math. Mech. 9, 49, doi 10.1002/zamm.19290090104.

    Examples
    --------
    >>> round(reuss_modulus_pa(0.5, 60e9, 20e9) / 1e9, 6)
    30.0
    """
    return 1.0 / ((1.0 - martensite_fraction) / austenite_modulus_pa + martensite_fraction / martensite_modulus_pa)


@compiled
def friction_force_n(
    previous_friction_n: float, displacement_change_m: float, limit_n: float, presliding_m: float
) -> float:
    """Return the friction of a guide after a small motion: elastic up to ``presliding_m``, then Coulomb.

    Parameters
    ----------
    previous_friction_n
        Friction before the motion [N], from -``limit_n`` to ``limit_n``.
    displacement_change_m
        The motion [m], of either sign.
    limit_n
        Coulomb friction [N]; 0 or less is a guide without friction.
    presliding_m
        Motion [m] over which friction rises from 0 to its limit, above 0.

    Returns
    -------
    The friction after it [N], of the sign of the motion once it slides.

    Notes
    -----
    It is rate-independent, so a guide at rest keeps the friction with which it stopped.

    References
    ----------
    Dahl's model with exponent 0: Dahl 1968, Aerospace Corp. TOR-0158(3107-18)-1.

    Examples
    --------
    >>> friction_force_n(0.0, 1e-6, 0.05, 1e-5)
    0.005
    >>> friction_force_n(0.005, -1.0, 0.05, 1e-5)
    -0.05
    """
    if limit_n <= 0.0:
        return 0.0
    moved = previous_friction_n + limit_n / presliding_m * displacement_change_m
    return min(max(moved, -limit_n), limit_n)
