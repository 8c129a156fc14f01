"""Steps that take the wire well beyond their target and back: what its controller's gains do not know of it.

A gap that takes less heat to cross than the slow loop says, or a wire that follows later than it did there, shows in
nothing else of a run: at the end of each step the target is reached.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from musclewire.judge._scale_by_b import WITHIN_STD
from musclewire.judge._sensed import since_first_sensed
from musclewire.signals import Recording

# Beyond the target by more than this part of all that the wire moves, and than the interval of the estimate, in at
# least so many steps: once or twice is chance, or the first step from cold.
MAX_BEYOND, MIN_STEPS = 0.1, 3
# A step is a target that holds for so long [s]; one that never stops changing has none.
HELD_S = 1.0


class Overshoot:
    """How far the estimate of a closed loop went beyond the target in each of its steps.

    Parameters
    ----------
    recording
        A closed loop with target and estimate.
    suffix
        The ending of the columns of its quantity.

    Attributes
    ----------
    rows
        The samples that are too far beyond, (n_times,); none if the steps with such samples are too few.
    n_steps
        How many targets held long enough to be looked at.
    beyond_pct
        By how much each step that went too far did so [% of the motion], (n_steps_beyond,).
    """

    def __init__(self, recording: Recording, suffix: str) -> None:
        """Look at every step."""
        target, value, time_s = recording[f"target_{suffix}"], recording[f"estimated_{suffix}"], recording["time_s"]
        judged = since_first_sensed(recording) & np.isfinite(value)
        if "valid" in recording:
            judged &= recording["valid"] > 0.0
        moved = float(np.ptp(value[judged])) if judged.any() else 0.0
        std = recording["estimate_std"] if "estimate_std" in recording else np.zeros(target.size)
        starts = np.flatnonzero(np.append(True, np.diff(target) != 0.0))
        ends = np.append(starts[1:], target.size)
        period_s = float(np.median(np.diff(time_s))) if time_s.size > 1 else 0.0
        self.rows: npt.NDArray[np.bool_] = np.zeros(target.size, dtype=np.bool_)
        self.n_steps, beyond = 0, []
        for start, end in zip(starts, ends, strict=True):
            if time_s[end - 1] - time_s[start] + period_s < HELD_S:
                continue
            self.n_steps += 1
            step = slice(int(start), int(end))
            side = np.sign(target[start] - value[start])
            past = side * (value[step] - target[start])
            # A wire that is on the far side still when the target comes has not gone there.
            counts = judged[step] & np.logical_or.accumulate(past < 0.0)
            too_far = counts & (past > MAX_BEYOND * moved) & (past > WITHIN_STD * std[step])
            if too_far.any():
                beyond.append(float(past[too_far].max()) / moved)
                self.rows[step] = too_far
        self.beyond_pct = 100.0 * np.array(beyond)
        if len(beyond) < MIN_STEPS:
            self.rows[:] = False

    def __str__(self) -> str:
        """Return it in words."""
        return (
            f"at {self.beyond_pct.size} of {self.n_steps} steps, by up to {self.beyond_pct.max():.0f} % of the motion"
        )
