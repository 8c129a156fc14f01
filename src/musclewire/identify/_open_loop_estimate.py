"""What a user's wire does under the current of a recording, simulated open loop: an estimate without resistance.

It reads no resistance, so what air and load have done since the calibration is not seen: the stated deviation says what
a calibration leaves open of them.
"""

from __future__ import annotations

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.judge import JudgedRecording
from musclewire.sensing import SensingModel
from musclewire.signals import Recording, asked_once
from musclewire.wire import WireConstants, drive_path, resting_state

# The simulated clock: the recording's own, and no slower than this, so that a sample a minute still has a course.
MAX_SAMPLE_S = 0.05
# What a calibration leaves open, as the particle filter takes it: of convection, load and stiffness a fraction, of the
# air a difference [K]; and the deviation of the wire's strain at its own temperature, over the model's range.
LEFT_OPEN = {"convection_factor": 0.05, "pretension_n": 0.03, "spring_stiffness_n_per_m": 0.05}
AIR_LEFT_OPEN_K = 1.5
STRUCTURAL = 0.003


def open_loop_estimate(
    model: SensingModel, recording: Recording, wire: WireConstants, air_k: float | None
) -> tuple[FloatArray, FloatArray]:
    """Return the model's quantity and its standard deviation, both (n_times,), by the current alone.

    The wire is at rest and cold before the recording; ``wire`` is on its load. Without ``air_k`` the wire file's
    counts. Raises RecordingError if the current is not known in some rows.
    """
    unknown = ~asked_once(recording, JudgedRecording).measured[0]
    if unknown.any():
        raise RecordingError(f"the current, and so what heated the wire, is not known in {int(unknown.sum())} rows")
    wire = wire if air_k is None else wire.replace(ambient_temperature_k=air_k)
    changed = [
        *({name: float(getattr(wire, name)) * (1.0 + part)} for name, part in LEFT_OPEN.items()),
        {"ambient_temperature_k": float(wire.ambient_temperature_k) + AIR_LEFT_OPEN_K},
    ]
    value = simulated(model.quantity, recording, wire, wire)
    variance = np.full(value.shape, (STRUCTURAL * (model.quantity_max - model.quantity_min)) ** 2)
    for one in changed:
        variance += (simulated(model.quantity, recording, wire.replace(**one), wire) - value) ** 2
    return value, np.sqrt(variance)


def simulated(quantity: str, recording: Recording, wire: WireConstants, cold: WireConstants) -> FloatArray:
    """Return a quantity of a wire under the recorded current, (n_times,), from the rest of the wire that was cold."""
    time_s, read = recording["time_s"], asked_once(recording, JudgedRecording).circuit
    sample_s = min(float(np.median(np.diff(time_s))), MAX_SAMPLE_S)
    clock_s = np.arange(time_s[0], time_s[-1] + sample_s, sample_s)
    current_a = np.interp(clock_s, time_s, np.abs(read.shunt_v) / read.shunt_ohm)
    path, _ = drive_path(wire, current_a, sample_s=sample_s, state=resting_state(cold), regulated_current=True)
    found = {
        "strain": path.displacement_m / wire.leg_length_m,
        "displacement": path.displacement_m,
        "force": path.force_n - cold.pretension_n,
    }
    return np.asarray(np.interp(time_s, clock_s, found[quantity]))
