"""Whether a slow loop shows C, the end of the transformation, or merely where its drive turned."""

from __future__ import annotations

import numpy as np

from musclewire.errors import RecordingError
from musclewire.identify._home.seen_points import seen_points
from musclewire.identify._home.warming import HeatCourse
from musclewire.identify._recordings import resistance_reading
from musclewire.signals import Recording


def shows_c(recording: Recording) -> bool | None:
    """Return whether the last cycle of a slow loop shows C.

    Parameters
    ----------
    recording
        The loop, with the column ``cycle`` and both voltages, as ``characterize`` records it.

    Returns
    -------
    True if the resistance rises again or has levelled off where the wire is hottest; False if it still falls there, so
    that C is only the turning point of the drive; None if the recording shows no transformation or no power.
    """
    if "cycle" not in recording or "wire_voltage_v" not in recording:
        return None
    try:
        reading = resistance_reading(recording)
        last = reading.valid & (recording["cycle"] == recording["cycle"].max())
        resistance = reading.resistance_ohm[last]
        power = recording["wire_voltage_v"][last] ** 2 / resistance
        if not np.isfinite(power).all() or power.size == 0:
            return None
        return seen_points(HeatCourse(recording["time_s"][last], power, resistance)).c_ohm is not None
    except RecordingError:
        return None
