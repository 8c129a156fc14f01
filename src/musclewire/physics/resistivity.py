"""Electrical resistance of a wire from its phases, its temperature and its change of shape."""

from __future__ import annotations

from musclewire.compiled import compiled

__all__ = ["phase_resistivity_ohm_m", "wire_resistance_ohm", "REFERENCE_TEMPERATURE_K"]

REFERENCE_TEMPERATURE_K = 293.15
ELASTIC_POISSON_RATIO = 0.33


@compiled
def phase_resistivity_ohm_m(
    resistivity_ohm_m: float, temperature_coefficient_per_k: float, temperature_k: float
) -> float:
    """Return the resistivity [ohm m] of one phase, linear in temperature from 20 C.

    Parameters
    ----------
    resistivity_ohm_m
        rho_20, resistivity at 20 C [ohm m].
    temperature_coefficient_per_k
        alpha [1/K].
    temperature_k
        T, temperature of the wire [K].

    Returns
    -------
    rho_20 (1 + alpha (T - 293.15 K)) [ohm m].

    References
    ----------
    Source of the linear law's coefficients: the alloy's file, number by number.

    Examples
    --------
    >>> round(phase_resistivity_ohm_m(8e-7, 5e-4, 313.15) * 1e9, 6)
    808.0
    """
    return resistivity_ohm_m * (1.0 + temperature_coefficient_per_k * (temperature_k - REFERENCE_TEMPERATURE_K))


@compiled
def wire_resistance_ohm(
    resistivity_ohm_m: float,
    austenite_length_m: float,
    austenite_area_m2: float,
    transformation_strain: float,
    elastic_strain: float,
    thermal_strain: float,
) -> float:
    """Return rho l / A [ohm] with the length and the cross-section that the strains leave.

    Parameters
    ----------
    resistivity_ohm_m
        rho, mean over the phases [ohm m].
    austenite_length_m
        Length of the wire as stress-free austenite [m].
    austenite_area_m2
        Cross-section of the wire as stress-free austenite [m2].
    transformation_strain
        As a fraction; it keeps the volume, so l/A grows as the square of the stretch.
    elastic_strain
        As a fraction; it thins the wire by Poisson's ratio of 0.33, the vendor's figure for NiTi.
    thermal_strain
        As a fraction; expansion widens the wire as it lengthens it, so l/A falls.

    Returns
    -------
    The resistance [ohm].

    References
    ----------
    R = rho l / A with each strain's own change of l and A. Source of Poisson's ratio: the vendor's data of NiTi.

    Examples
    --------
    >>> round(wire_resistance_ohm(1e-6, 0.14, 7.854e-9, 0.04, 0.0, 0.0) / (1e-6 * 0.14 / 7.854e-9), 4)
    1.0816
    """
    stretch = 1.0 + transformation_strain
    thinning = 1.0 - ELASTIC_POISSON_RATIO * elastic_strain
    return (
        resistivity_ohm_m
        * austenite_length_m
        / austenite_area_m2
        * stretch
        * stretch
        * (1.0 + elastic_strain)
        / (thinning * thinning * (1.0 + thermal_strain))
    )
