"""When a loop is sensed, and how much of the time in which it should be it is."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.signals import Recording

# Eq. 7 counts "sequentially after one second of each step (till the end of each step)".
SETTLE_S = 1.0
# A wire is sensed once its estimates were valid for so long.
SENSED_S = 0.5


def after_approach(elapsed_s: FloatArray, approach_s: float) -> npt.NDArray[np.bool_]:
    """Return the samples after the approach, or after the first second if there was none, (n_times,)."""
    return np.asarray(elapsed_s > (1e-9 if approach_s > 0.0 or elapsed_s[-1] <= SETTLE_S else SETTLE_S))


def judged_for_sensing(recording: Recording) -> npt.NDArray[np.bool_]:
    """Return the samples at which a loop should have been sensed, (n_times,)."""
    # Of a recording of another program, too, which need not state them.
    approach_s, period_s = (recording.facts.number_or_none(name) or 0.0 for name in ("approach_s", "sample_period_s"))
    elapsed_s = recording["time_s"] - recording["time_s"][0] + period_s - approach_s
    return after_approach(elapsed_s, approach_s) & since_first_sensed(recording)


def valid_share(recording: Recording) -> float:
    """Return the fraction of valid samples among those at which a loop should have been sensed."""
    return float(np.mean(recording["valid"][judged_for_sensing(recording)]))


def since_first_sensed(recording: Recording) -> npt.NDArray[np.bool_]:
    """Return the samples from which on the wire is sensed, (n_times,); all of them if it never is, or it is not known.

    Below B the resistance of a cold wire does not determine its strain: that it is not sensed there is no fault. It is
    sensed from the first sample on that begins ``SENSED_S`` of valid ones; a shorter while may be a cold wire's, too.
    """
    everywhere = np.ones(len(recording), dtype=np.bool_)
    if "valid" not in recording:
        return everywhere
    length = max(round(SENSED_S / recording.facts.sample_period_s), 1)
    valid = np.concatenate([[0], np.cumsum(recording["valid"] > 0.0)])
    begins = np.flatnonzero(valid[length:] - valid[:-length] == length)
    return everywhere if begins.size == 0 else np.arange(len(recording)) >= begins[0]
