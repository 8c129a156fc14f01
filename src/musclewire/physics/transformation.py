"""Which phase a grain prefers, by how much, and when it switches.

Symbols: A austenite, R R-phase, M martensite; T temperature, sigma stress; f advantage over austenite in
kelvin; h barrier in kelvin; C stress rate (Clausius-Clapeyron slope) in Pa/K.

A phase change happens once its advantage exceeds its barrier. That excess, positive once the change is due, is
the drive of the change; there are three drives on cooling (A to M, A to R, R to M) and three on heating.

A grain is one class of transformation temperatures. It is not a single switch but a short interval of them,
so its phase shares move continuously while a drive sweeps through the interval: the limit of very many
switches, in which the ensemble loses its steps. Within a grain the shares are ordered as they form on
cooling: martensite first, then R-phase, then austenite. Either function leaves a grain where applying it again
changes nothing, so that a grain needs a second look only when a drive has risen.
"""

from __future__ import annotations

from musclewire.compiled import compiled, compiled_inline

__all__ = ["advantage_k", "cooled_grain", "heated_grain", "share_beyond"]


@compiled
def advantage_k(
    temperature_k: float, stress_pa: float, transformation_temperature_k: float, stress_rate_pa_per_k: float
) -> float:
    """Return how far [K] a phase is favoured over austenite: T_0 + sigma/C - T (Clausius-Clapeyron)."""
    return transformation_temperature_k + stress_pa / stress_rate_pa_per_k - temperature_k


@compiled_inline
def share_beyond(drive_k: float, inverse_width_per_k: float) -> float:
    """Return the share of a grain for which a change is due, 0 to 1; ``drive_k`` is that of its middle."""
    return min(max(drive_k * inverse_width_per_k + 0.5, 0.0), 1.0)


@compiled_inline
def cooled_grain(
    martensite: float,
    r_phase: float,
    a_to_m_drive_k: float,
    a_to_r_drive_k: float,
    r_to_m_drive_k: float,
    martensite_inverse_width_per_k: float,
    r_phase_inverse_width_per_k: float,
    preference_inverse_width_per_k: float,
) -> tuple[float, float]:
    """Return a grain's martensite and R-phase shares after cooling or loading.

    What leaves austenite stops at R-phase where that holds, and goes on to martensite where it does not. So both
    shares only ever rise to a bound, whatever the state: order between states lasts, and with it return-point memory
    (Sethna et al. 1993, doi 10.1103/PhysRevLett.70.3347).
    """
    has_left_a = max(
        share_beyond(a_to_m_drive_k, martensite_inverse_width_per_k),
        share_beyond(a_to_r_drive_k, r_phase_inverse_width_per_k),
    )
    formed = max(martensite + r_phase, has_left_a)
    no_longer_r = share_beyond(r_to_m_drive_k, preference_inverse_width_per_k)
    new_martensite = max(martensite, min(no_longer_r, formed))
    return new_martensite, formed - new_martensite


@compiled_inline
def heated_grain(
    martensite: float,
    r_phase: float,
    m_to_a_drive_k: float,
    r_to_a_drive_k: float,
    m_to_r_drive_k: float,
    martensite_inverse_width_per_k: float,
    r_phase_inverse_width_per_k: float,
    preference_inverse_width_per_k: float,
) -> tuple[float, float]:
    """Return a grain's martensite and R-phase shares after heating or unloading: the mirror of cooling."""
    has_left_m = max(
        share_beyond(m_to_a_drive_k, martensite_inverse_width_per_k),
        share_beyond(m_to_r_drive_k, preference_inverse_width_per_k),
    )
    new_martensite = min(martensite, 1.0 - has_left_m)
    must_be_austenite = share_beyond(r_to_a_drive_k, r_phase_inverse_width_per_k)
    formed = min(martensite + r_phase, max(new_martensite, 1.0 - must_be_austenite))
    return new_martensite, formed - new_martensite
