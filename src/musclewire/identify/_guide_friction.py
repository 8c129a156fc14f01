"""The friction between wire and spring, from one slow loop with a load cell and a displacement sensor."""

from __future__ import annotations

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.signals import Recording

# The middle of the stroke is compared: near its ends the friction has not reversed yet.
MIDDLE = (0.25, 0.75)
PLACES = 101
MIN_SAMPLES = 20


def guide_friction_n(recording: Recording) -> float | None:
    """Return the Coulomb friction at the connector [N]; None if a recording does not identify it.

    At equal displacement the spring's force is the same on both branches, so half the difference of the load cell's
    readings is friction: it opposes the wire in contraction and assists it on return. The last rise and fall of the
    displacement are compared. It requires ``force_n`` and ``displacement_m``.
    """
    if "force_n" not in recording or "displacement_m" not in recording:
        return None
    displacement, force = recording["displacement_m"], recording["force_n"]
    if "cycle" in recording:
        last = recording["cycle"] == recording["cycle"].max()
        displacement, force = displacement[last], force[last]
    top = int(np.argmax(displacement))
    low, high = (float(displacement.max()) * fraction for fraction in MIDDLE)
    rise = between(displacement[: top + 1], force[: top + 1], low, high)
    fall = between(displacement[top:], force[top:], low, high)
    if min(rise[0].size, fall[0].size) < MIN_SAMPLES:
        return None
    places = np.linspace(low, high, PLACES)
    apart_n = line_through(*rise, places) - line_through(*fall, places)
    return max(0.5 * float(apart_n.mean()), 0.0)


def between(
    displacement_m: FloatArray, force_n: FloatArray, low_m: float, high_m: float
) -> tuple[FloatArray, FloatArray]:
    """Return the samples of a branch between two displacements."""
    inside = (displacement_m >= low_m) & (displacement_m <= high_m)
    return displacement_m[inside], force_n[inside]


def line_through(displacement_m: FloatArray, force_n: FloatArray, places_m: FloatArray) -> FloatArray:
    """Return force over displacement by a parabola fitted to noisy samples, since a load may be slightly nonlinear."""
    centre, half = places_m.mean(), 0.5 * float(np.ptp(places_m))
    fitted = np.polyfit((displacement_m - centre) / half, force_n, 2)
    return np.asarray(np.polyval(fitted, (places_m - centre) / half))
