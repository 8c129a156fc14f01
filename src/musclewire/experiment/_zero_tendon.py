"""Setting the finger's stage so that the tendon is straight and carries nothing (Lan and Fan 2010, section 4.2).

"The finger sits on Linear Stage 2, which can set the finger tendon force to zero regardless of the pretension force."
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError
from musclewire.rigs import HasTendonStage, Rig, ability

# The stage's range about its start [m]; chosen: a wider one finds a worse start, and pulls the finger more.
FARTHEST_SLACK_M = 100e-6
FARTHEST_PULL_M = 100e-6
POSITIONS = 21
SAMPLES_EACH = 10
# The rise over the whole pull must exceed the load cell's noise by this factor, or the tendon was never taut.
MIN_RISE_NOISES = 10.0


@dataclass(frozen=True, eq=False)
class TendonZero:
    """Where the tendon of a finger begins to pull, with the readings that show it."""

    slack_m: float  # setting of the finger's stage at which it begins, in the stage's own reading
    tendon_stiffness_n_per_m: float  # slope of the force beyond it
    positions_m: FloatArray  # settings that were tried, (n_positions,)
    force_n: FloatArray  # readings of the load cell there, (n_positions,)


def zero_tendon(rig: Rig, *, start_slack_m: float = 0.0) -> TendonZero:
    """Draw the finger's stage from slack to taut while the wire is cold, find the kink in force, and stop there.

    Only the load cell is read. Positions go from 0.1 mm slack to 0.1 mm taut; the kink is where a level line and
    a rising line fit best.

    Parameters
    ----------
    rig
        The rig, open, with a stage below the finger that software can move, and a load cell.
    start_slack_m
        Setting of the stage that is believed to be zero [m], about which the search runs.

    Returns
    -------
    The point at which the tendon begins to pull, with the measurements.

    Raises
    ------
    CallerError
        For a rig without such a stage or without a load cell.
    RecordingError
        If the force does not rise.

    References
    ----------
    Lan and Fan 2010, section 4.2.
    """
    stage = ability(rig, HasTendonStage)
    if stage is None:
        raise CallerError("the finger's stage of this rig is moved by hand: turn it until the force begins to rise")
    positions = start_slack_m + np.linspace(FARTHEST_SLACK_M, -FARTHEST_PULL_M, POSITIONS)
    forces, spread = np.empty(POSITIONS), 0.0
    for index, slack_m in enumerate(positions):
        stage.set_tendon_slack(float(slack_m))
        readings = [rig.exchange(rig.sense_voltage_v).force_n for _ in range(SAMPLES_EACH)]
        if None in readings:
            raise CallerError("this rig has no load cell: the tendon's zero cannot be found by force, set it by hand")
        forces[index] = np.mean(np.array(readings, dtype=np.float64))
        spread = max(spread, float(np.std(np.array(readings, dtype=np.float64))))
    if forces[-1] - forces[0] < MIN_RISE_NOISES * spread / np.sqrt(SAMPLES_EACH):
        raise RecordingError(
            f"the force rises by {forces[-1] - forces[0]:.4f} N only while the tendon is drawn by "
            f"{1e3 * (positions[0] - positions[-1]):.2f} mm: is the tendon attached, and the stage near its zero?"
        )
    kink_m, slope = kink_and_slope(-positions, forces)
    stage.set_tendon_slack(-kink_m)
    return TendonZero(-kink_m, slope, positions, forces)


def kink_and_slope(place: FloatArray, value: FloatArray) -> tuple[float, float]:
    """Return the kink between a level and a rising line, and the slope, by least squares; both arrays (n,), rising."""
    kinks = np.linspace(place[1], place[-2], 401)
    ramps = np.maximum(place[None, :] - kinks[:, None], 0.0)
    centred = ramps - ramps.mean(axis=1, keepdims=True)
    slopes = centred @ (value - value.mean()) / np.sum(centred**2, axis=1)
    left = np.sum((value - value.mean()) ** 2) - slopes**2 * np.sum(centred**2, axis=1)
    best = int(np.argmin(left))
    return float(kinks[best]), float(slopes[best])
