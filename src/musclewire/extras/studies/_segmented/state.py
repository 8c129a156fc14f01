"""Rows of numbers of a wire in segments in addition to those of a wire, which each segment is, and the whole, too.

Heat, enthalpy and conductances of a segment are stated as if the whole wire were in its state: a segment counts by its
fraction of the length.
"""

from __future__ import annotations

from musclewire.wire import Row, field


class SegmentPlace(Row):
    """Where a segment lies, and its numbers of the step in progress."""

    weight: float = field("1", "fraction of the wire's length")
    before_w_per_k: float = field("W/K", "conductance to the segment before, or to the clamp")
    after_w_per_k: float = field("W/K", "conductance to the segment after, or to the clamp")
    trial_k: float = field("K", "temperature at the moment that is looked at")
    trial_ohm: float = field("ohm", "resistance at that moment")
    net_w: float = field("W", "power less loss and conduction at that moment")
    started_w: float = field("W", "the same at the start of the step")
    within_w: float = field("W", "the same in the middle of the step")
    heat_j: float = field("J", "heat of the step")


class SegmentSums(Row):
    """Sums since the start that a wire does not have."""

    heat_to_clamps_j: float = field("J", "heat lost to the clamps since the start")
    hottest_k: float = field("K", "highest temperature of any segment since the start")
