"""Where a wire's cold end moves with the room: in a warmer one it keeps part of its contraction.

A wire that has cooled to a room 15 K warmer is 5 % of its stroke shorter, and an estimate is larger by most of that
than strain that counts from there. Not by all of it on a spring that was set to its pretension again: at the same
resistance it pulls with less force then, which lets the wire be shorter.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.identify._home.overlay import LATENT_K
from musclewire.identify._home.warming import course_of
from musclewire.sensing import SHOWN_AS, UNCORRECTED, Correction, SensingModel
from musclewire.signals import MetadataValue, Recording, RunFacts
from musclewire.wire import HeatBalance

# The note of a model: contraction that is left for each kelvin of warmer air, in the quantity's unit.
NOTE = "cold_contraction_per_k"
# And the note of the air that its rig file stated: what a thermometer reads is not compared with what is stated.
ROOM = "stated_ambient_k"
COLD_END_K = 8.0  # [K above the air]: cooling below is its cold end
MIN_COLD_K = 4.0  # [K above the air], to which the wire must have cooled
MIN_POINTS = 8
# The zero moves by a fraction of the contraction that is left: by all of it under a weight, otherwise by
SPRINGS_FRACTION = 0.7  # on the springs of the benches (studies/zero_of_room.py prints both), and by
FRACTION = 0.85  # under a load that is not stated: between both.
FRACTION_STD = 0.15  # standard deviation of either
FRACTION = 0.85  # under a load that is not stated: between both
FRACTION_STD = 0.15  # standard deviation of either
# Rooms that differ by less are one, measured twice.
SAME_ROOM_K = 1.0


class ZeroOfRoom(NamedTuple):
    """What a room makes of the zero, and that in words."""

    correction: Correction
    said: str


def cold_contraction_per_k(recording: Recording, moved: FloatArray) -> float | None:
    """Return the contraction, in the unit of ``moved``, that cooling leaves for each kelvin by which it ends warmer.

    The slope is over the cold end of the last cooling; None if the recording does not state the heat balance, does not
    cool that far, or shows nothing that is left.
    """
    finite = np.isfinite(moved)
    if not finite.any():
        return None
    try:
        heat, course = HeatBalance.stated_in(recording.facts), course_of(recording)
    except RecordingError:
        return None
    span_ohm = float(np.ptp(course.resistance_ohm))
    at = np.interp(course.time_s, recording["time_s"][finite], moved[finite])
    if span_ohm == 0.0:
        return None
    warming_k = course.warming_k(heat, LATENT_K / span_ohm)
    last_hot = int(np.flatnonzero(at >= 0.5 * (at.min() + at.max()))[-1])
    cold = last_hot + np.flatnonzero(warming_k[last_hot:] <= COLD_END_K)
    if cold.size < MIN_POINTS or warming_k[cold].min() > MIN_COLD_K:
        return None
    slope = float(np.polyfit(warming_k[cold], at[cold], 1)[0])
    return slope if slope > 0.0 else None


def zero_of_room(model: SensingModel, known: Mapping[str, MetadataValue]) -> ZeroOfRoom | None:
    """Return the strain between today's zero and the model's by the room's temperature; None if the same or unknown."""
    fitted = RunFacts(model.wire, "this model")
    then_k, slope = fitted.number_or_none(ROOM), fitted.number_or_none(NOTE)
    today_k = RunFacts(known, "this rig").number_or_none("limit_ambient_temperature_k")
    if then_k is None or today_k is None or model.quantity == "force":
        return None
    warmer_k = today_k - then_k
    if abs(warmer_k) < SAME_ROOM_K:
        return None
    room = f"the room is {abs(warmer_k):.0f} K {'warmer' if warmer_k > 0.0 else 'colder'} than at the characterization"
    if slope is None:
        return ZeroOfRoom(UNCORRECTED, f"{room}, and the model does not state how far that moves the zero: fit again")
    has_spring = (fitted.number_or_none("spring_stiffness_n_per_m") or 0.0) > 0.0
    value = (SPRINGS_FRACTION if has_spring else FRACTION) * slope * warmer_k
    std = FRACTION_STD * slope * abs(warmer_k)
    factor, unit = SHOWN_AS[model.quantity]
    return ZeroOfRoom(
        Correction(zero=value, zero_variance=std * std),
        f"{room}, where the cold wire is {'shorter' if warmer_k > 0.0 else 'longer'}: from today's zero every estimate "
        f"is {factor * abs(value):.2g} +- {factor * std:.1g} {unit} {'less' if warmer_k > 0.0 else 'more'}",
    )
