"""Heat loss of a thin wire to still air: properties of air and two published correlations.

Symbols: Ra Rayleigh number, Nu Nusselt number, Pr Prandtl number, d wire diameter.
"""

from __future__ import annotations

import math

STANDARD_GRAVITY_M_PER_S2 = 9.80665
STANDARD_PRESSURE_PA = 101325.0
AIR_GAS_CONSTANT_J_PER_KG_K = 287.05
AIR_SPECIFIC_HEAT_J_PER_KG_K = 1006.0

# Below it the correlation has no data; Morgan's goes down to 1e-10.
CHURCHILL_CHU_MIN_RAYLEIGH = 1e-5
# Within this of the air's temperature a wire loses less than a hundredth of the heat that it loses when hot.
NEGLIGIBLE_EXCESS_K = 1.0
# No wire is heated further above the air than this; one that is outside the range even there never reaches it.
MAX_EXCESS_K = 600.0


def air_dynamic_viscosity_pa_s(temperature_k: float) -> float:
    """Return the viscosity of air [Pa s] by Sutherland's law.

    Parameters
    ----------
    temperature_k
        T, temperature of the air [K], 100 to 1900 K.

    Returns
    -------
    mu, the dynamic viscosity [Pa s].

    References
    ----------
    U.S. Standard Atmosphere 1976 (NASA-TM-X-74335), Eq. 51: mu = beta T^(3/2) / (T + S) with beta = 1.458e-6 and
    S = 110.4 K. It does not depend on pressure.

    Examples
    --------
    >>> round(air_dynamic_viscosity_pa_s(288.15) * 1e5, 4)  # its table: 1.7894e-5 at sea level
    1.7894
    """
    return 1.458e-6 * temperature_k * math.sqrt(temperature_k) / (temperature_k + 110.4)


def air_thermal_conductivity_w_per_m_k(temperature_k: float) -> float:
    """Return the thermal conductivity of air [W/(m K)].

    Parameters
    ----------
    temperature_k
        T, temperature of the air [K].

    Returns
    -------
    k, the thermal conductivity [W/(m K)].

    References
    ----------
    U.S. Standard Atmosphere 1976 (NASA-TM-X-74335), Eq. 53:
    k = 2.64638e-3 T^(3/2) / (T + 245.4 * 10^(-12/T)).

    Examples
    --------
    >>> round(air_thermal_conductivity_w_per_m_k(288.15), 5)  # its table: 0.025326 at sea level
    0.02533
    """
    return (
        2.64638e-3
        * temperature_k
        * math.sqrt(temperature_k)
        / (temperature_k + 245.4 * 10.0 ** (-12.0 / temperature_k))
    )


def air_prandtl(temperature_k: float) -> float:
    """Return the Prandtl number of air, Pr = c_p mu / k.

    Parameters
    ----------
    temperature_k
        Temperature of the air [K], up to 450 K, to which the constant specific heat holds within 1 %.

    Returns
    -------
    Pr, dimensionless.

    References
    ----------
    mu and k from the U.S. Standard Atmosphere 1976 (NASA-TM-X-74335), Eqs. 51 and 53; c_p = 1006 J/(kg K).

    Examples
    --------
    >>> round(air_prandtl(300.0), 3)  # Incropera and DeWitt's table of air at 300 K: 0.707
    0.707
    """
    return (
        AIR_SPECIFIC_HEAT_J_PER_KG_K
        * air_dynamic_viscosity_pa_s(temperature_k)
        / air_thermal_conductivity_w_per_m_k(temperature_k)
    )


def rayleigh_of_wire(wall_temperature_k: float, ambient_temperature_k: float, diameter_m: float) -> float:
    """Return the Rayleigh number of a wire in air on its diameter, Ra = g beta abs(T_w - T_a) d^3 Pr / nu^2.

    Parameters
    ----------
    wall_temperature_k
        T_w, temperature of the wire's surface [K].
    ambient_temperature_k
        T_a, temperature of the air [K].
    diameter_m
        d, diameter of the wire [m].

    Returns
    -------
    Ra, dimensionless. Properties of air are those at the mean of both temperatures, beta = 1 / T (ideal gas), the
    pressure is 101325 Pa.

    References
    ----------
    The definition is that of Churchill and Chu 1975, doi 10.1016/0017-9310(75)90222-7.

    Examples
    --------
    >>> round(rayleigh_of_wire(363.15, 295.15, 100e-6), 6)
    0.004154
    """
    film_k = 0.5 * (wall_temperature_k + ambient_temperature_k)
    density = STANDARD_PRESSURE_PA / (AIR_GAS_CONSTANT_J_PER_KG_K * film_k)
    kinematic_viscosity = air_dynamic_viscosity_pa_s(film_k) / density
    buoyancy = STANDARD_GRAVITY_M_PER_S2 * abs(wall_temperature_k - ambient_temperature_k) / film_k
    return buoyancy * diameter_m**3 * air_prandtl(film_k) / kinematic_viscosity**2


def nusselt_churchill_chu(rayleigh: float, prandtl: float) -> float:
    """Return the mean Nusselt number of a horizontal cylinder in free convection.

    Parameters
    ----------
    rayleigh
        Ra on the diameter, 1e-5 to 1e12; :func:`convection_range_note` checks the lower end for a wire.
    prandtl
        Pr of the fluid.

    Returns
    -------
    Nu, dimensionless, mean over the circumference.

    References
    ----------
    Churchill and Chu 1975, Int. J. Heat Mass Transfer 18, 1049, doi 10.1016/0017-9310(75)90222-7:
    Nu = (0.60 + 0.387 Ra^(1/6) / [1 + (0.559/Pr)^(9/16)]^(8/27))^2.

    Examples
    --------
    The example is the one in the documentation of the library ht (Pr = 0.69, Gr = 2.63e9, Ra = Gr Pr). Incropera and
    DeWitt's Example 9.4 (Ra = 5.003e6, Pr = 0.703) prints 23.3, from intermediate results rounded to three digits; the
    formula gives 23.0 there.

    >>> round(nusselt_churchill_chu(2.63e9 * 0.69, 0.69), 9)
    139.134939701
    """
    prandtl_term = (1.0 + (0.559 / prandtl) ** (9.0 / 16.0)) ** (8.0 / 27.0)
    return (0.60 + 0.387 * rayleigh ** (1.0 / 6.0) / prandtl_term) ** 2


def nusselt_morgan(rayleigh: float) -> float:
    """Return the mean Nusselt number of a horizontal cylinder in free convection, for small Rayleigh numbers.

    Parameters
    ----------
    rayleigh
        Ra on the diameter, 1e-10 to 1e2.

    Returns
    -------
    Nu, dimensionless. The two pieces differ by 2 % at their common limit.

    References
    ----------
    Morgan 1975, Adv. Heat Transfer 11, 199, doi 10.1016/S0065-2717(08)70075-3:
    Nu = 0.675 Ra^0.058 below 1e-2, 1.02 Ra^0.148 above.

    Examples
    --------
    >>> nusselt_morgan(1.0)
    1.02
    >>> round(nusselt_morgan(1e-4), 4)
    0.3956
    """
    if rayleigh < 1e-2:
        return 0.675 * rayleigh**0.058
    return 1.02 * rayleigh**0.148


def convection_coefficient_w_per_m2_k(
    wall_temperature_k: float, ambient_temperature_k: float, diameter_m: float
) -> float:
    """Return the mean heat transfer coefficient of a thin horizontal wire in still air (Churchill and Chu).

    Parameters
    ----------
    wall_temperature_k
        Temperature of the wire's surface [K].
    ambient_temperature_k
        Temperature of the air [K].
    diameter_m
        d, diameter of the wire [m]; thin wires are outside the published range near the air's temperature, see
        :func:`convection_range_note`.

    Returns
    -------
    h = Nu k / d, the coefficient [W/(m2 K)], with k at the mean of both temperatures. Radiation is not included.

    Notes
    -----
    For 0.1 mm at 90 C in air of 22 C Morgan's correlation gives 7 % less: the spread of the published
    correlations, and the reason why a wire file carries a fitted factor on it.

    References
    ----------
    Churchill and Chu 1975, doi 10.1016/0017-9310(75)90222-7.

    Examples
    --------
    >>> round(convection_coefficient_w_per_m2_k(363.15, 295.15, 100e-6))
    151
    """
    film_k = 0.5 * (wall_temperature_k + ambient_temperature_k)
    rayleigh = rayleigh_of_wire(wall_temperature_k, ambient_temperature_k, diameter_m)
    nusselt = nusselt_churchill_chu(rayleigh, air_prandtl(film_k))
    return nusselt * air_thermal_conductivity_w_per_m_k(film_k) / diameter_m


def churchill_chu_from_k(diameter_m: float, ambient_temperature_k: float) -> float:
    """Return the excess over the air's temperature [K] at which Churchill and Chu's range, Ra >= 1e-5, begins.

    Parameters
    ----------
    diameter_m
        Diameter of the wire [m].
    ambient_temperature_k
        Temperature of the air [K].

    Returns
    -------
    The temperature difference [K]; infinity if 600 K are not enough.

    References
    ----------
    The limit is that of Churchill and Chu 1975, doi 10.1016/0017-9310(75)90222-7.

    Examples
    --------
    >>> 5.0 < churchill_chu_from_k(25e-6, 295.15) < 8.0  # the catalogue's thinnest wire
    True
    >>> churchill_chu_from_k(100e-6, 295.15) < 0.2
    True
    """
    low_k, high_k = 0.0, MAX_EXCESS_K
    if rayleigh_of_wire(ambient_temperature_k + high_k, ambient_temperature_k, diameter_m) < CHURCHILL_CHU_MIN_RAYLEIGH:
        return math.inf
    while high_k - low_k > 1e-6:
        middle_k = 0.5 * (low_k + high_k)
        wall_k = ambient_temperature_k + middle_k
        if rayleigh_of_wire(wall_k, ambient_temperature_k, diameter_m) < CHURCHILL_CHU_MIN_RAYLEIGH:
            low_k = middle_k
        else:
            high_k = middle_k
    return high_k


def convection_range_note(diameter_m: float, ambient_temperature_k: float) -> str:
    """Return a note on a wire whose convection is outside Churchill and Chu's published range; "" within it.

    Free convection of a thin wire near the air's temperature is so weak that the Rayleigh number falls below the range
    of the correlation. Within 1 K of the air that is negligible and true of most wires. Beyond, the note states up to
    which temperature difference it is so, and how much Morgan's correlation, valid down to Ra = 1e-10, differs there.

    Parameters
    ----------
    diameter_m
        Diameter of the wire [m].
    ambient_temperature_k
        Temperature of the air [K].

    Returns
    -------
    One sentence, or "".

    References
    ----------
    Churchill and Chu 1975, doi 10.1016/0017-9310(75)90222-7; Morgan 1975, doi 10.1016/S0065-2717(08)70075-3.

    Examples
    --------
    >>> convection_range_note(100e-6, 295.15)
    ''
    """
    begins_k = churchill_chu_from_k(diameter_m, ambient_temperature_k)
    if begins_k <= NEGLIGIBLE_EXCESS_K:
        return ""
    wall_k = ambient_temperature_k + min(begins_k, MAX_EXCESS_K)
    rayleigh = rayleigh_of_wire(wall_k, ambient_temperature_k, diameter_m)
    used = nusselt_churchill_chu(rayleigh, air_prandtl(0.5 * (wall_k + ambient_temperature_k)))
    less = 1.0 - nusselt_morgan(rayleigh) / used
    return (
        f"within {wall_k - ambient_temperature_k:.1f} K of the air, convection of a wire of {1e6 * diameter_m:.0f} um "
        f"is below the published range of Churchill and Chu's correlation (Ra >= {CHURCHILL_CHU_MIN_RAYLEIGH:g}); "
        f"Morgan's gives {100.0 * less:.0f} % less there"
    )
