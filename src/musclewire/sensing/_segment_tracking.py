"""In which segment of the loop a wire is, by how its power and its resistance change together; compiled.

One resistance near its maximum has two meanings: a cold wire on its way from A to B, which hardly strains, or a
wire between B and C, which does (Lan and Fan 2010, Fig. 3b). They differ in sign: from A to B
resistance rises as the wire is heated, from B to C it falls. The direction of the last change of electrical power is
therefore compared with the direction in which the resistance changes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inner, row_in
from musclewire.sensing._curve import Row, row_type

# Nearer to R_min than this, as normalised resistance, a wire cannot be in segment A-B: from A to B resistance rises
# by a few percent, from B to C it falls by more than ten (Lan and Fan 2010, Fig. 3b).
AMBIGUOUS_ABOVE = 0.8
# A change of the smoothed resistance counts from this fraction of the span. At the sense voltage the current is small
# and the noise of one sample is one to two hundredths of it; a mean over eight samples reduces it to well below.
MIN_CHANGE = 0.02
SMOOTHING_SAMPLES = 8.0
# A change of power counts from this fraction.
MIN_POWER_CHANGE = 0.02

NUMBERS_ROW = row_type(("ambiguous_above_ohm", "min_change_ohm"))
STATE = ("sensing", "heating", "power_extreme_w", "resistance_anchor_ohm", "smoothed_ohm")
STATE_ROW = row_type(STATE)


class SegmentCourse(NamedTuple):
    """Where a wire is in each sample of a recording, each of shape (n_times,)."""

    sensing: npt.NDArray[np.bool_]  # whether strain can be sensed: the wire is between B and C
    anchor_ohm: FloatArray  # resistance from which a change in the opposite direction is counted


def segment_numbers(resistance_min_ohm: float, resistance_max_ohm: float) -> dict[str, float]:
    """Return the numbers that ``track`` reads, by name, of a wire with these resistances at C and B [ohm]."""
    span = resistance_max_ohm - resistance_min_ohm
    return {
        "ambiguous_above_ohm": resistance_min_ohm + AMBIGUOUS_ABOVE * span,
        "min_change_ohm": MIN_CHANGE * span,
    }


@compiled_inner
def begin_segment(numbers: Row, state: Row, resistance_ohm: float, power_w: float) -> None:
    """Take a first sample: near R_max a wire counts as cold until a change shows otherwise."""
    state.sensing = 0.0 if resistance_ohm >= numbers.ambiguous_above_ohm else 1.0
    state.heating = 1.0
    state.power_extreme_w = power_w
    state.resistance_anchor_ohm = state.smoothed_ohm = resistance_ohm


@compiled_inner
def track(numbers: Row, state: Row, resistance_ohm: float, power_w: float) -> None:
    """Follow the segment by one more sample with current."""
    state.smoothed_ohm += (resistance_ohm - state.smoothed_ohm) / SMOOTHING_SAMPLES
    if state.heating != 0.0:
        state.power_extreme_w = max(state.power_extreme_w, power_w)
        turned = power_w < state.power_extreme_w * (1.0 - MIN_POWER_CHANGE)
    else:
        state.power_extreme_w = min(state.power_extreme_w, power_w)
        turned = power_w > state.power_extreme_w * (1.0 + MIN_POWER_CHANGE)
    if turned:
        state.heating, state.power_extreme_w = 1.0 - state.heating, power_w
        state.resistance_anchor_ohm = state.smoothed_ohm
    # The anchor follows changes in the direction of this segment; a change in the opposite one is of the other
    # segment.
    if state.sensing == state.heating:
        state.resistance_anchor_ohm = min(state.resistance_anchor_ohm, state.smoothed_ohm)
        opposite_ohm = state.smoothed_ohm - state.resistance_anchor_ohm
    else:
        state.resistance_anchor_ohm = max(state.resistance_anchor_ohm, state.smoothed_ohm)
        opposite_ohm = state.resistance_anchor_ohm - state.smoothed_ohm
    if opposite_ohm > numbers.min_change_ohm:
        state.sensing, state.resistance_anchor_ohm = 1.0 - state.sensing, state.smoothed_ohm
    if state.smoothed_ohm < numbers.ambiguous_above_ohm:
        state.sensing = 1.0


@compiled
def track_all(
    constants: FloatArray,
    state_array: FloatArray,
    resistance_ohm: FloatArray,
    power_w: FloatArray,
    sensing: npt.NDArray[np.bool_],
    anchor_ohm: FloatArray,
) -> None:
    """Follow the segment through all samples of a recording."""
    numbers, state = row_in(constants, NUMBERS_ROW), row_in(state_array, STATE_ROW)
    for sample in range(resistance_ohm.shape[0]):
        if sample == 0:
            begin_segment(numbers, state, resistance_ohm[sample], power_w[sample])
        else:
            track(numbers, state, resistance_ohm[sample], power_w[sample])
        sensing[sample] = state.sensing != 0.0
        anchor_ohm[sample] = state.resistance_anchor_ohm


def segment_course(
    resistance_min_ohm: float, resistance_max_ohm: float, resistance_ohm: FloatArray, power_w: FloatArray
) -> SegmentCourse:
    """Follow a wire through A-B and B-C by its samples with current."""
    constants = np.array(list(segment_numbers(resistance_min_ohm, resistance_max_ohm).values()))
    course = SegmentCourse(np.zeros(resistance_ohm.shape, dtype=np.bool_), np.zeros(resistance_ohm.shape))
    resistance_ohm, power_w = np.array(resistance_ohm), np.array(power_w)
    track_all(constants, np.zeros(len(STATE)), resistance_ohm, power_w, *course)
    return course
