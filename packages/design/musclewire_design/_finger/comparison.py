"""Distributed against concentrated actuation (Fig. 13a of Lan and Fan 2010): range over length, on the same beam.

Distributed: the tendon is guided by all columns. Concentrated is not drawn closely enough in the paper to be one thing;
two readings of it: the tendon is fastened to the last column and runs there in one straight chord, or it is fastened to
the first column and bends the first segment alone.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import NumericsError
from musclewire_design._finger.chain import finger_chain
from musclewire_design._finger.curve import beam_stress_pa
from musclewire_design._finger.geometry import FingerGeometry
from musclewire_design._finger.statics import FingerEquilibrium, equilibrium

STEPS = 120


class PullingScheme(NamedTuple):
    """One way to pull a finger, driven until the travel or the allowed stress of the beam is exhausted.

    ``guided`` are the columns the tendon is guided by or fastened to, ``range_over_length`` is the endpoint's
    displacement over the overall length, ``limit`` what was exhausted: "travel", "stress" or "curl" (the endpoint moves
    no further).
    """

    name: str
    guided: tuple[int, ...]
    endpoint_m: float
    range_over_length: float
    travel_m: float
    tendon_force_n: float
    stress_pa: float
    limit: str
    angles_rad: FloatArray


def compare_schemes(geometry: FingerGeometry, travel_m: float, stress_pa: float) -> list[PullingScheme]:
    """Return several ways to pull one finger, each to the end of a travel or to a stress in its beam (Fig. 13a).

    Parameters
    ----------
    geometry
        Dimensions of the finger.
    travel_m
        Largest travel of the tendon [m].
    stress_pa
        Stress in the beam at which a scheme ends [Pa].

    Returns
    -------
    The schemes: the tendon guided by all columns, in one chord to the last column, and fastened to the first one (not
    for a finger of one column).

    References
    ----------
    Lan and Fan 2010, Fig. 13(a).
    """
    last = geometry.columns - 1
    guides = {"distributed": tuple(range(geometry.columns)), "one chord to the last column": (last,)}
    if last:
        guides["first segment only"] = (0,)
    return [driven(geometry, name, guided, travel_m, stress_pa) for name, guided in guides.items()]


def driven(
    geometry: FingerGeometry, name: str, guided: tuple[int, ...], travel_m: float, stress_pa: float
) -> PullingScheme:
    """Return a scheme at its limit, to a hundred and twentieth of the travel."""
    chain = finger_chain(geometry, guided=guided)
    at, limit = equilibrium(chain, geometry.stiffness_n_m2, 0.0), "travel"
    for travel in np.linspace(0.0, travel_m, STEPS + 1)[1:]:
        try:
            further = equilibrium(chain, geometry.stiffness_n_m2, float(travel), start=at)
        except NumericsError:
            limit = "curl"
            break
        if float(beam_stress_pa(geometry, further).max()) > stress_pa:
            limit = "stress"
            break
        if further.endpoint_displacement_m <= at.endpoint_displacement_m:
            limit = "curl"
            break
        at = further
    return scheme_of(geometry, name, guided, at, limit)


def scheme_of(
    geometry: FingerGeometry, name: str, guided: tuple[int, ...], at: FingerEquilibrium, limit: str
) -> PullingScheme:
    """Return an equilibrium as a scheme's row."""
    endpoint = at.endpoint_displacement_m
    return PullingScheme(
        name,
        guided,
        endpoint,
        endpoint / geometry.overall_length_m,
        at.travel_m,
        at.tendon_force_n,
        float(beam_stress_pa(geometry, at).max()),
        limit,
        at.angles_rad,
    )
