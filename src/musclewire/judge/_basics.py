"""What every loop is sensed by first: is its drive at a limit, is the wire sensed, does the instrument agree."""

from __future__ import annotations

import numpy as np

from musclewire.judge._known_strain import WITHIN_STD
from musclewire.judge._loop import DetectedRows, JudgedLoop, Mask

HEATING_S = 1.0  # [s] that a drive may be at its limit while the wire heats; chosen: a shorter time warns of any step
COOLING_S = 4.0  # [s] that it may be while the wire cools: cooling takes longer, and no drive shortens it
# The least fraction by which the resistance of a wire that heats at the upper limit changes within HEATING_S.
FOLLOWS = 0.005
# An instrument contradicts an estimate if more than this part of the valid samples are beyond the interval: errors last
# for a step, and of the paper's eleven steps two are beyond by chance in one run of ten, three in 1.5 %.
MAX_BEYOND = 0.25
# A closed loop with a smaller part of valid samples was not closed.
MIN_VALID_FRACTION = 0.8


def saturation(loop: JudgedLoop) -> DetectedRows:
    """Return the samples from which on the drive has been at a limit for too long without reaching the target."""
    above, below = loop.off_target > 0.0, loop.off_target < 0.0
    # A drive at its lower limit though the wire is to heat is what the protection gave instead.
    heating = (loop.at_upper_limit | loop.at_lower_limit | loop.power_limited) & below
    cooling = loop.at_lower_limit & above
    rows = lasting(heating, round(HEATING_S / loop.period_s)) | lasting(cooling, round(COOLING_S / loop.period_s))
    return DetectedRows(rows & ~loop.once(stalled).rows)


def stalled(loop: JudgedLoop) -> DetectedRows:
    """Return the samples at which the drive is at its upper limit and the resistance has not followed for a while."""
    length = max(round(HEATING_S / loop.period_s), 1)
    ohm = loop.recording.columns.get("wire_resistance_ohm", np.zeros(0))
    if ohm.size <= 2 * length:
        return DetectedRows(loop.since(None))
    moved = np.full(ohm.size, np.inf)
    moved[length:] = np.abs(ohm[length:] - ohm[:-length]) / np.maximum(ohm[length:], 1e-9)
    return DetectedRows(lasting(loop.at_upper_limit & (loop.off_target < 0.0) & (moved < FOLLOWS), 2 * length))


def lasting(marked: Mask, length: int) -> Mask:
    """Return the marked samples before which at least ``length`` have been marked without a gap."""
    place = np.arange(marked.size)
    since = place - np.maximum.accumulate(np.where(marked, -1, place))
    return np.asarray(marked & (since >= length))


def contradicted(loop: JudgedLoop) -> DetectedRows:
    """Return the samples at which the instrument is beyond the estimate's interval, if they are too many; else none."""
    error, sensed = loop.error, loop.valid & loop.sensed
    if error is None:
        return DetectedRows(loop.since(None))
    beyond = sensed & (np.abs(error) > WITHIN_STD * loop.std)
    if beyond.sum() <= MAX_BEYOND * sensed.sum():
        return DetectedRows(loop.since(None))
    stroke = max(float(np.ptp(loop.estimate - error)), float(np.ptp(loop.estimate)))
    said = f"{100.0 * beyond.mean():.0f} % of the samples"
    if stroke > 0.0:
        rms_pct = 100.0 * float(np.sqrt(np.mean(error[beyond] ** 2))) / stroke
        said += f", by {rms_pct:.1f} % rms of the stroke"
    return DetectedRows(beyond, lambda: said)


def hardly_sensed(loop: JudgedLoop) -> DetectedRows:
    """Return the samples that could not be sensed, if they are too many; else none."""
    if loop.valid.all() or loop.valid_share >= MIN_VALID_FRACTION:
        return DetectedRows(loop.since(None))
    said = f"{100.0 * loop.valid_share:.0f} % of the samples could be sensed"
    return DetectedRows(loop.counted & loop.sensed & ~loop.valid, lambda: said)
