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

    Where austenite could go to both other phases, the larger drive goes first.
    """
    formed = martensite + r_phase
    a_to_m = max(share_beyond(a_to_m_drive_k, martensite_inverse_width_per_k) - formed, 0.0)
    a_to_r = max(share_beyond(a_to_r_drive_k, r_phase_inverse_width_per_k) - formed, 0.0)
    martensite_first = 1.0 if a_to_m_drive_k > a_to_r_drive_k else 0.0
    a_to_m_left = max(a_to_m - (1.0 - martensite_first) * a_to_r, 0.0)
    a_to_r_left = max(a_to_r - martensite_first * a_to_m, 0.0)
    new_martensite = martensite + a_to_m_left
    new_r_phase = r_phase + a_to_r_left
    no_longer_r = share_beyond(r_to_m_drive_k, preference_inverse_width_per_k)
    r_to_m = max(min(no_longer_r, new_martensite + new_r_phase) - new_martensite, 0.0)
    return new_martensite + r_to_m, new_r_phase - r_to_m


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
    m_to_a = max(martensite - 1.0 + share_beyond(m_to_a_drive_k, martensite_inverse_width_per_k), 0.0)
    m_to_r = max(martensite - 1.0 + share_beyond(m_to_r_drive_k, preference_inverse_width_per_k), 0.0)
    austenite_first = 1.0 if m_to_a_drive_k > m_to_r_drive_k else 0.0
    m_to_a_left = max(m_to_a - (1.0 - austenite_first) * m_to_r, 0.0)
    m_to_r_left = max(m_to_r - austenite_first * m_to_a, 0.0)
    new_martensite = martensite - m_to_a_left - m_to_r_left
    new_r_phase = r_phase + m_to_r_left
    must_be_austenite = share_beyond(r_to_a_drive_k, r_phase_inverse_width_per_k)
    r_to_a = min(max(new_martensite + new_r_phase - 1.0 + must_be_austenite, 0.0), new_r_phase)
    return new_martensite, new_r_phase - r_to_a
