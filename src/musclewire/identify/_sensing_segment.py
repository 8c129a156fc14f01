"""Which samples of a whole recording lie between B and C, where resistance tells strain."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.physics import ArrayReading
from musclewire.sensing import AMBIGUOUS_ABOVE, SensingModel, segment_course
from musclewire.signals import Recording

# At the sense voltage the noise of one sample is as large as the change of resistance that counts: means over so many
# samples are a fifth of it. A loop has to do without, since half of them lie in the future.
MEAN_SAMPLES = 33


def in_sensing_segment(model: SensingModel, recording: Recording, reading: ArrayReading) -> NDArray[np.bool_]:
    """Return the samples in which the wire is between B and C, (n_times,).

    Without a voltage there is no power to locate B by; then only resistances that no cold wire has count.
    """
    if "wire_voltage_v" not in recording:
        span = model.resistance_max_ohm - model.resistance_min_ohm
        return reading.resistance_ohm < model.resistance_min_ohm + AMBIGUOUS_ABOVE * span
    some_ohm = np.where(reading.valid, reading.resistance_ohm, 1.0)
    power_w = recording["wire_voltage_v"] ** 2 / some_ohm
    return dated_back(model, reading.resistance_ohm, power_w, reading.valid)


def dated_back(
    model: SensingModel, resistance_ohm: FloatArray, power_w: FloatArray, valid: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return where the wire is sensed, with each change of segment dated back to the extreme it is counted from.

    A loop learns that B is behind it only when the resistance has moved away from there by 2 % of its span, which takes
    a slowly cooling wire a quarter of a minute. In a whole recording it is known when the resistance turned.
    """
    sensing = np.zeros(resistance_ohm.shape, dtype=np.bool_)
    rows = np.flatnonzero(valid)
    if rows.size == 0:
        return sensing
    calm_ohm, calm_w = (centred_mean(values[rows]) for values in (resistance_ohm, power_w))
    found, anchor_ohm = segment_course(model.resistance_min_ohm, model.resistance_max_ohm, calm_ohm, calm_w)
    turns = np.append(0, 1 + np.flatnonzero(np.diff(anchor_ohm)))
    dated = found.copy()
    for row in 1 + np.flatnonzero(np.diff(found)):
        turned_at = turns[turns < row][-1]
        dated[turned_at + 1 : row] = found[row]
    sensing[rows] = dated
    return sensing


def centred_mean(values: FloatArray) -> FloatArray:
    """Return the mean over ``MEAN_SAMPLES`` around each value, over fewer near the ends, both (n,)."""
    reach = MEAN_SAMPLES // 2
    total = np.concatenate([[0.0], np.cumsum(values)])
    place = np.arange(values.size)
    first, after = np.maximum(place - reach, 0), np.minimum(place + reach + 1, values.size)
    return np.asarray((total[after] - total[first]) / (after - first))
