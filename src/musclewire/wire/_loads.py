"""The load at a wire's connector as the equilibrium takes it: a linear spring, and a table of everything nonlinear.

Loads at one connector add up: each part has a force at the connector's displacement.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError

NOTHING = np.zeros(2)


class ElasticObject(NamedTuple):
    """An object in the way: it is touched after ``clearance_m`` of free motion and then pushes back like a spring.

    It is in the way of a finger's endpoint, of two endpoints that approach each other, or of the connector.

    Parameters
    ----------
    stiffness_n_per_m
        Its stiffness [N/m].
    clearance_m
        Motion until contact [m]; of two fingers, that of both endpoints together.
    """

    stiffness_n_per_m: float
    clearance_m: float


class ConnectorLoad(NamedTuple):
    """A load over the connector's displacement, beyond the pretension: a spring, and a table of what adds to it."""

    stiffness_n_per_m: float
    step_m: float  # from point to point of both tables, whose first is at 0
    force_n: FloatArray  # adds to the spring's, (n_points,); beyond the last point it continues with the last slope
    friction_n: FloatArray  # adds to the guide's, (n_points,); beyond the last point it stays


def spring_load(stiffness_n_per_m: float) -> ConnectorLoad:
    """Return a plain spring."""
    return ConnectorLoad(stiffness_n_per_m, 1.0, NOTHING, NOTHING)


def with_table(
    stiffness_n_per_m: float,
    force_n: Callable[[FloatArray], FloatArray],
    friction_n: Callable[[FloatArray], FloatArray],
    *,
    reach_m: float,
    points: int = 2001,
) -> ConnectorLoad:
    """Return a spring with two tabulated functions of displacement [m], linear between points up to ``reach_m``.

    Raises CallerError if a function does not stay finite, or the reach is not positive.
    """
    if not reach_m > 0.0:
        raise CallerError(f"a load's table reaches {reach_m} m: it must reach further than 0")
    displacement = np.linspace(0.0, reach_m, points)
    force, friction = force_n(displacement), friction_n(displacement)
    if not (np.isfinite(force).all() and np.isfinite(friction).all()):
        raise CallerError(f"a load is not finite somewhere between 0 and {1e3 * reach_m:g} mm: check its curve")
    return ConnectorLoad(
        stiffness_n_per_m, float(displacement[1]), np.ascontiguousarray(force), np.ascontiguousarray(friction)
    )
