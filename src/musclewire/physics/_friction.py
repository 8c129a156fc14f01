"""The friction of a guide. What a wire's metal does, phases, strain and resistance, is in ``wire``."""

from __future__ import annotations

from musclewire.compiled import compiled


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
