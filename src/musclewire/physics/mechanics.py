"""Strain of a wire from its stress, phases and temperature."""

from __future__ import annotations

import math

from musclewire.compiled import compiled

__all__ = [
    "maximum_transformation_strain",
    "maximum_transformation_strain_slope_per_pa",
    "reuss_modulus_pa",
    "friction_force_n",
]


@compiled
def maximum_transformation_strain(
    stress_pa: float, strain_at_no_stress: float, strain_saturated: float, stress_scale_pa: float
) -> float:
    """Return the strain that fully oriented martensite reaches at this stress.

    H(sigma) = H_0 + (H_sat - H_0)(1 - exp(-sigma/sigma_k)):
    Lagoudas, Hartl, Chemisky, Machado and Popov 2012, Int. J. Plasticity 32-33, 155,
    doi 10.1016/j.ijplas.2011.10.009.
    """
    return strain_saturated - (strain_saturated - strain_at_no_stress) * math.exp(-stress_pa / stress_scale_pa)


@compiled
def maximum_transformation_strain_slope_per_pa(
    stress_pa: float, strain_at_no_stress: float, strain_saturated: float, stress_scale_pa: float
) -> float:
    """Return dH/dsigma [1/Pa] of :func:`maximum_transformation_strain`."""
    return (strain_saturated - strain_at_no_stress) / stress_scale_pa * math.exp(-stress_pa / stress_scale_pa)


@compiled
def reuss_modulus_pa(martensite_fraction: float, austenite_modulus_pa: float, martensite_modulus_pa: float) -> float:
    """Return the modulus [Pa] of phases in series under one stress (Reuss); the R-phase counts as austenite."""
    return 1.0 / ((1.0 - martensite_fraction) / austenite_modulus_pa + martensite_fraction / martensite_modulus_pa)


@compiled
def friction_force_n(
    previous_friction_n: float, displacement_change_m: float, limit_n: float, presliding_m: float
) -> float:
    """Return the friction of a guide after a small motion: elastic up to ``presliding_m``, then Coulomb.

    Dahl's model with exponent 0 (Dahl 1968, Aerospace Corp. TOR-0158(3107-18)-1): rate-independent, so a guide
    at rest keeps the friction with which it stopped.
    """
    if limit_n <= 0.0:
        return 0.0
    moved = previous_friction_n + limit_n / presliding_m * displacement_change_m
    return min(max(moved, -limit_n), limit_n)
