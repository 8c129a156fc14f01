"""Everything that a finished run warns of: a wire that pulled too hard, and a wire that friction held."""

from __future__ import annotations

from musclewire.experiment.force_limit import force_warnings
from musclewire.signals.recording import Recording

__all__ = ["friction_warnings", "run_warnings"]

# Friction counts as holding the wire from this fraction of a leg's length on: 0.01 points of strain.
HELD_FRACTION = 1e-4


def run_warnings(recording: Recording) -> tuple[str, ...]:
    """Return the warnings of a run, the most dangerous first; none for a run without any."""
    return (*force_warnings(recording), *friction_warnings(recording))


def friction_warnings(recording: Recording) -> tuple[str, ...]:
    """Return a warning if friction held the connector while the wire became slack; none otherwise.

    Only a simulated rig knows: the recording's ``friction_held_m`` states by how much the wire was longer than the
    connector's position allows. A recording that does not state it gets no warning.
    """
    held_m = recording.facts.number_or_none("friction_held_m")
    leg_m = recording.facts.leg_length_or_none_m
    if held_m is None or leg_m is None or held_m <= HELD_FRACTION * leg_m:
        return ()
    return (
        f"friction holds the wire: cooling, it became up to {1e3 * held_m:.2f} mm longer than the connector let it, "
        "since the load cannot pull guide and wire back; displacement, strain and force then show the friction: more "
        "pretension, a stiffer spring, or a guide with less friction",
    )
