"""The cooling after a loop: how high the resistance turns, against the slow loop that the model was fitted to.

As B does on the first heating, it moves with the load and with the resistance itself, and hardly with the air. So what
has changed in mid-run, while the wire was hot, is seen as soon as it has cooled; not which of the two it was, nor when.
"""

from __future__ import annotations

from math import hypot

import numpy as np

from musclewire.errors import RecordingError
from musclewire.judge._first_heating import LIMIT_STDS, KnownB, SeenAtB
from musclewire.judge._loop import JudgedLoop
from musclewire.judge._readings import resistance_reading
from musclewire.sensing import noise_level

# Readings whose mean is the highest resistance: at the sense voltage one is noisy, and nothing moves fast.
MEAN_SAMPLES = 10
HIGHEST = "cooling after the loop, the highest resistance"


def seen_cooling(loop: JudgedLoop) -> SeenAtB | None:
    """Return how high the resistance was in the cooling after a loop; None if nobody looked, or it is not known."""
    known, cooling_ohm = KnownB.stated_in(loop.facts), loop.facts.number_or_none("model_cooling_ohm")
    cooling = loop.recording.cooling
    if known is None or cooling_ohm is None or cooling is None or "wire_resistance_ohm" not in loop.recording:
        return None
    try:
        reading = resistance_reading(cooling)
    except RecordingError:  # no current, or readings that are none: other findings say so
        return None
    resistance_ohm = reading.resistance_ohm[reading.valid]
    begins_ohm = float(np.median(loop.recording["wire_resistance_ohm"][-MEAN_SAMPLES:]))
    if resistance_ohm.size < 3 * MEAN_SAMPLES:
        return None
    means_ohm = np.convolve(resistance_ohm, np.full(MEAN_SAMPLES, 1.0 / MEAN_SAMPLES), "valid")
    std_ohm = hypot(known.std_ohm, noise_level(resistance_ohm) / MEAN_SAMPLES**0.5)
    highest_ohm = float(means_ohm.max())
    if not highest_ohm > begins_ohm + LIMIT_STDS * std_ohm:  # it had turned before the loop's end
        return None
    away_ohm = highest_ohm - cooling_ohm
    if away_ohm < 0.0:  # one that still rises may rise by as much again as in the last half of the time
        away_ohm = min(away_ohm + max(float(means_ohm[-1] - means_ohm[means_ohm.size // 2]), 0.0), 0.0)
    percent = 100.0 / (known.b_ohm - known.c_ohm)
    return SeenAtB(len(loop.recording) - 1, percent * away_ohm, percent * LIMIT_STDS * std_ohm, HIGHEST)
