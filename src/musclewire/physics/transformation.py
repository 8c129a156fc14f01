"""Which phase a grain prefers, by how much, and when it switches.

Symbols: A austenite, R R-phase, M martensite; T temperature, sigma stress; f advantage over austenite in
kelvin; h barrier in kelvin; C stress rate (Clausius-Clapeyron slope) in Pa/K.

A phase change happens once its advantage exceeds its barrier. That excess, positive once the change is due, is
the thermodynamic driving force of the change; there are three on cooling (A to M, A to R, R to M) and three on heating.

A grain is one class of transformation temperatures. It is not a single switch but a short interval of them,
so its phase shares move continuously while a driving force sweeps through the interval: the limit of very many
switches, in which the ensemble loses its steps. Within a grain the shares are ordered as they form on
cooling: martensite first, then R-phase, then austenite. Either function leaves a grain where applying it again
changes nothing, so that a grain needs a second look only when a driving force has risen.
"""

from __future__ import annotations

from musclewire.compiled import compiled, compiled_inline

__all__ = ["advantage_k", "cooled_grain", "heated_grain", "fraction_beyond"]


@compiled
def advantage_k(
    temperature_k: float, stress_pa: float, transformation_temperature_k: float, stress_rate_pa_per_k: float
) -> float:
    """Return how far [K] a phase is favoured over austenite (Clausius-Clapeyron).

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


@compiled_inline
def fraction_beyond(force_k: float, inverse_width_per_k: float) -> float:
    """Return the fraction of a grain for which a change is due, 0 to 1.

    Parameters
    ----------
    force_k
        Thermodynamic driving force of the change at the grain's middle [K], less its barrier.
    inverse_width_per_k
        1 / width of the grain's interval of transformation temperatures [1/K].

    Returns
    -------
    The fraction: 0.5 at a driving force of 0, and linear over the interval.

    References
    ----------
    Source: our own limit of very many switches, decision 3 (grains as intervals).

    Examples
    --------
    >>> fraction_beyond(0.25, 1.0)
    0.75
    """
    return min(max(force_k * inverse_width_per_k + 0.5, 0.0), 1.0)


@compiled_inline
def cooled_grain(
    martensite: float,
    r_phase: float,
    a_to_m_force_k: float,
    a_to_r_force_k: float,
    r_to_m_force_k: float,
    martensite_inverse_width_per_k: float,
    r_phase_inverse_width_per_k: float,
    preference_inverse_width_per_k: float,
) -> tuple[float, float]:
    """Return a grain's fractions of martensite and R-phase after cooling or loading.

    Parameters
    ----------
    martensite
        Fraction before, 0 to 1.
    r_phase
        Fraction before, 0 to 1 - ``martensite``.
    a_to_m_force_k
        Thermodynamic driving force of austenite to martensite at the grain's middle, less its barrier [K].
    a_to_r_force_k
        That of austenite to R-phase [K].
    r_to_m_force_k
        That of R-phase to martensite [K].
    martensite_inverse_width_per_k
        1 / width of the grain's interval for martensite [1/K].
    r_phase_inverse_width_per_k
        The same for R-phase [1/K].
    preference_inverse_width_per_k
        The same for the change between R-phase and martensite [1/K].

    Returns
    -------
    The fractions of martensite and of R-phase.

    Notes
    -----
    What leaves austenite stops at R-phase if that is stable, and goes on to martensite if not. So both fractions only
    ever rise to a bound, whatever the state: the order between states lasts, and with it return-point memory.

    References
    ----------
    Sethna et al. 1993, doi 10.1103/PhysRevLett.70.3347, for the memory that order between states implies.

    Examples
    --------
    >>> cooled_grain(0.0, 0.0, 0.0, -9.0, 9.0, 1.0, 1.0, 1.0)  # at its middle, and R-phase is not stable
    (0.5, 0.0)
    """
    has_left_a = max(
        fraction_beyond(a_to_m_force_k, martensite_inverse_width_per_k),
        fraction_beyond(a_to_r_force_k, r_phase_inverse_width_per_k),
    )
    formed = max(martensite + r_phase, has_left_a)
    no_longer_r = fraction_beyond(r_to_m_force_k, preference_inverse_width_per_k)
    new_martensite = max(martensite, min(no_longer_r, formed))
    return new_martensite, formed - new_martensite


@compiled_inline
def heated_grain(
    martensite: float,
    r_phase: float,
    m_to_a_force_k: float,
    r_to_a_force_k: float,
    m_to_r_force_k: float,
    martensite_inverse_width_per_k: float,
    r_phase_inverse_width_per_k: float,
    preference_inverse_width_per_k: float,
) -> tuple[float, float]:
    """Return a grain's fractions of martensite and R-phase after heating or unloading: the mirror of cooling.

    Parameters
    ----------
    martensite
        Fraction before, 0 to 1.
    r_phase
        Fraction before, 0 to 1 - ``martensite``.
    m_to_a_force_k
        Thermodynamic driving force of martensite to austenite at the grain's middle, less its barrier [K].
    r_to_a_force_k
        That of R-phase to austenite [K].
    m_to_r_force_k
        That of martensite to R-phase [K].
    martensite_inverse_width_per_k
        1 / width of the grain's interval for martensite [1/K].
    r_phase_inverse_width_per_k
        The same for R-phase [1/K].
    preference_inverse_width_per_k
        The same for the change between R-phase and martensite [1/K].

    Returns
    -------
    The fractions of martensite and of R-phase.

    References
    ----------
    As :func:`cooled_grain`: Sethna et al. 1993, doi 10.1103/PhysRevLett.70.3347.

    Examples
    --------
    >>> heated_grain(1.0, 0.0, 0.0, 9.0, -9.0, 1.0, 1.0, 1.0)  # at its middle, and R-phase is not stable
    (0.5, 0.0)
    """
    has_left_m = max(
        fraction_beyond(m_to_a_force_k, martensite_inverse_width_per_k),
        fraction_beyond(m_to_r_force_k, preference_inverse_width_per_k),
    )
    new_martensite = min(martensite, 1.0 - has_left_m)
    must_be_austenite = fraction_beyond(r_to_a_force_k, r_phase_inverse_width_per_k)
    formed = min(martensite + r_phase, max(new_martensite, 1.0 - must_be_austenite))
    return new_martensite, formed - new_martensite
