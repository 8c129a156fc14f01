"""Warnings of a run in which a wire pulled harder than its allowed force, as against a stiff load."""

from __future__ import annotations

import numpy as np

from musclewire.sensing import noise_level
from musclewire.signals import Recording

# A reading counts as above the limit if it exceeds it by this many standard deviations of the load cell's noise.
NOISES = 4.0


def force_limit_n(recording: Recording) -> float | None:
    """Return the force allowed in a recording's run [N], None if it states neither its own limit nor the wire's."""
    limit = recording.facts.number_or_none("force_limit_n")
    return recording.facts.number_or_none("maximum_force_n") if limit is None else limit


def force_warnings(recording: Recording) -> tuple[str, ...]:
    """Return a warning if the measured force, ``force_n``, exceeds the wire's limit; none otherwise.

    The limit is the recording's ``force_limit_n`` or, without it, the wire's ``maximum_force_n`` [N]. A recording
    without load cell or limit cannot be judged and gets no warning.
    """
    limit = force_limit_n(recording)
    if "force_n" not in recording or limit is None:
        return ()
    force, time = recording["force_n"], recording["time_s"]
    above = force > limit + NOISES * noise_level(force)
    if not above.any():
        return ()
    worst = int(np.argmax(force))
    step_s = float(np.median(np.diff(time))) if time.size > 1 else 0.0
    drive = f", drive {recording['drive_voltage_v'][worst]:.2f} V" if "drive_voltage_v" in recording else ""
    whose = f" of wire {wire}" if (wire := recording.facts.text_or_none("wire")) else ""
    together = "parallel wire" in recording.facts.load
    over_s = step_s * int(above.sum())
    return (
        f"{'the wires pull' if together else 'the wire pulls'} with up to {force[worst]:.2f} N at {time[worst]:.1f} s"
        f"{drive}, {force[worst] - limit:.2f} N above the {limit:g} N allowed (maximum_force_n{whose}), and above it "
        f"for {over_s:.1f} s in total: drive less, set less pretension, or take a softer load or a thicker wire",
    )
