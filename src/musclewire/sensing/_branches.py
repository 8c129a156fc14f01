"""A heating or cooling branch, and the single-valued curve that follows from its samples."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.sensing._smoothing import noise_level, smooth, smoothing_window

# Maximum smoothing window as a fraction of the branch, so that the bends of a loop are kept.
MAX_WINDOW_FRACTION = 0.03
# Below this rank correlation of position and resistance the samples are not in the order of the branch.
IN_ORDER = 0.5


class Branch(NamedTuple):
    """One branch of a loop, in the order in which the wire passed it, in either direction."""

    resistance_ohm: FloatArray  # shape (n,)
    quantity: FloatArray  # shape (n,): strain as a fraction, displacement [m] or force [N]


def checked_branch(branch: tuple[npt.ArrayLike, npt.ArrayLike], name: str) -> Branch:
    """Return the branch as float arrays; RecordingError on NaN, unequal lengths or fewer than two points."""
    resistance = np.asarray(branch[0], dtype=np.float64)
    quantity = np.asarray(branch[1], dtype=np.float64)
    if resistance.ndim != 1 or resistance.shape != quantity.shape:
        raise RecordingError(
            f"{name} branch: resistance has shape {resistance.shape} and the quantity {quantity.shape}: "
            "give two columns of equal length"
        )
    if resistance.size < 2:
        raise RecordingError(f"{name} branch has {resistance.size} points, at least 2 are needed")
    bad = ~(np.isfinite(resistance) & np.isfinite(quantity))
    if bad.any():
        raise RecordingError(
            f"{name} branch: {int(bad.sum())} of {bad.size} points are not finite, the first at index "
            f"{int(np.argmax(bad))}: leave out samples without current"
        )
    return Branch(resistance, quantity)


def single_valued(branch: tuple[npt.ArrayLike, npt.ArrayLike], name: str = "this") -> Branch:
    """Turn the samples of one branch into a curve: strictly rising resistance, one quantity at each.

    Noise in resistance is averaged along the branch, since sorting samples into resistance bins would flatten bends. A
    bias remains at both ends, where noise shifts the curve outwards by about twice what smoothing leaves of it. Clean
    data come back unchanged, however densely, evenly and in whichever direction they were sampled. Raises
    RecordingError for unusable columns, or if all resistances are equal.
    """
    from scipy.optimize import isotonic_regression

    resistance, quantity = _in_order(_without_repeats(checked_branch(branch, name)))
    if np.ptp(resistance) <= 0.0:
        raise RecordingError(
            f"{name} branch: every resistance is {resistance[0]:.6g} ohm, nothing to compare; check the column"
        )
    max_window = int(MAX_WINDOW_FRACTION * resistance.size)
    window = max(
        smoothing_window(noise_level(column), float(np.ptp(column)), max_window) for column in (resistance, quantity)
    )
    pooled = isotonic_regression(smooth(resistance, window))
    starts = np.asarray(pooled.blocks[:-1])
    counts = np.diff(np.asarray(pooled.blocks))
    means = np.add.reduceat(smooth(quantity, window), starts) / counts
    return Branch(np.asarray(pooled.x, dtype=np.float64)[starts], means)


def _without_repeats(branch: Branch) -> Branch:
    """Drop samples equal to their predecessor: a dwell, or a file written faster than it was measured."""
    changed = (np.diff(branch.resistance_ohm) != 0.0) | (np.diff(branch.quantity) != 0.0)
    keep = np.concatenate(([True], changed))
    return Branch(branch.resistance_ohm[keep], branch.quantity[keep])


def _in_order(branch: Branch) -> Branch:
    """Orient the branch towards rising resistance; samples in no order at all are sorted by resistance."""
    position = np.arange(branch.resistance_ohm.size) - (branch.resistance_ohm.size - 1) / 2
    rank = np.argsort(np.argsort(branch.resistance_ohm, kind="stable"), kind="stable") - position.max()
    scale = float(position @ position)
    agreement = float(position @ rank) / scale if scale > 0.0 else 1.0
    if abs(agreement) < IN_ORDER:
        order = np.argsort(branch.resistance_ohm, kind="stable")
        return Branch(branch.resistance_ohm[order], branch.quantity[order])
    step = 1 if agreement > 0.0 else -1
    return Branch(branch.resistance_ohm[::step], branch.quantity[::step])
