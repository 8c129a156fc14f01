"""The hot end of a slow loop: whether it is C, and whether more drive would show more."""

from __future__ import annotations

from musclewire.identify._extrapolation import reached_in
from musclewire.parameters import ValidityLimits, exceeds
from musclewire.sensing import HotEnd
from musclewire.signals import Recording

# Nearer than this [K] to the temperature up to which the alloy was measured there is no room for more drive.
ROOM_K = 5.0
ZERO_CELSIUS_K = 273.15


def hot_end(recording: Recording) -> HotEnd:
    """Return what a slow loop says of its hottest point besides resistance and strain: is it C, and is more to be had.

    A recording of another program states neither; then the person who drives the wire has to know.
    """
    limits, reached = ValidityLimits.stated_in(recording.metadata), reached_in(recording)
    levelled = recording.metadata.get("shows_c") is True
    highest_k, reached_k = limits.covered_temperature_high_k, reached.temperature_k
    if exceeds(reached.largest_stress_pa, limits.working_stress_pa):
        return HotEnd(levelled, "more drive would pull harder still, and the wire is above its vendor's stress already")
    if highest_k is None or reached_k is None:
        return HotEnd(levelled)
    at = f"by its power the wire reached {reached_k - ZERO_CELSIUS_K:.0f} C"
    measured = f"the {highest_k - ZERO_CELSIUS_K:.0f} C up to which the alloy was measured"
    if reached_k > highest_k - ROOM_K:
        return HotEnd(levelled, f"more drive is no way on, {at} of {measured}")
    return HotEnd(levelled, f"a higher amplitude shows more: {at}, below {measured}")
