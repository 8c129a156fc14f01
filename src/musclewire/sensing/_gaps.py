"""The gap between heating and cooling branch (Eqs. 2 and 9)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError
from musclewire.sensing._branches import Branch, single_valued

AnyBranch = tuple[npt.ArrayLike, npt.ArrayLike]


def hysteresis_gap(heating: AnyBranch, cooling: AnyBranch, points: int = 400, maximum: float | None = None) -> float:
    """Return the mean distance of the branches at equal resistance: (1/k) sum |S_h - S_c| / S_max.

    A fraction, without the paper's 100 %, at k ``points`` evenly spaced over the range that both branches have;
    ``maximum`` is S_max if the loop reaches further than they. :func:`single_valued` has a small bias under noise.
    Raises RecordingError if the branches share no resistances, or the largest quantity is not positive.

    References
    ----------
    Lan and Fan 2010, Eq. 2 (gaps of strain and force) and Eq. 9 (gap of displacement).
    """
    differences, largest = _differences(heating, cooling, points, maximum)
    return float(np.mean(np.abs(differences))) / largest


def signed_hysteresis_gap(heating: AnyBranch, cooling: AnyBranch) -> float:
    """Return the mean of heating minus cooling, otherwise as :func:`hysteresis_gap`; if they differ, branches cross."""
    differences, largest = _differences(heating, cooling, 400, None)
    return float(np.mean(differences)) / largest


def shared_resistances(heating: Branch, cooling: Branch, points: int) -> FloatArray:
    """Return evenly spaced resistances over the range that both single-valued branches have [ohm], shape (points,)."""
    low = float(max(heating.resistance_ohm[0], cooling.resistance_ohm[0]))
    high = float(min(heating.resistance_ohm[-1], cooling.resistance_ohm[-1]))
    if not high > low:
        raise RecordingError(
            f"heating covers {heating.resistance_ohm[0]:.4f} to {heating.resistance_ohm[-1]:.4f} ohm and "
            f"cooling {cooling.resistance_ohm[0]:.4f} to {cooling.resistance_ohm[-1]:.4f} ohm: "
            "the branches share no resistance, check that both come from one loop"
        )
    # Centres of equal cells: the mean over them is the mean over the range, however few there are.
    centres: FloatArray = (np.arange(points) + 0.5) / points
    return low + (high - low) * centres


def _differences(
    heating: AnyBranch, cooling: AnyBranch, points: int, maximum: float | None
) -> tuple[FloatArray, float]:
    """Return heating minus cooling at common resistances, and the largest quantity."""
    if points < 1:
        raise CallerError(f"the gap needs at least 1 point to compare, got {points}")
    rising, falling = single_valued(heating, "heating"), single_valued(cooling, "cooling")
    resistances = shared_resistances(rising, falling, points)
    largest = max(float(rising.quantity.max()), float(falling.quantity.max())) if maximum is None else maximum
    if not largest > 0.0:
        raise RecordingError(
            f"the largest quantity of the loop is {largest:.4g}: contraction must be positive, negate the column"
        )
    on_heating = np.interp(resistances, rising.resistance_ohm, rising.quantity)
    on_cooling = np.interp(resistances, falling.resistance_ohm, falling.quantity)
    return on_heating - on_cooling, largest
