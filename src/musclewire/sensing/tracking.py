"""Tell segment A-B from segment B-C while a wire runs, from its voltages alone.

One resistance near its maximum has two meanings: a cold wire on its way from A to B, which hardly strains, or a
wire between B and C, which does (Lan and Fan 2010, Fig. 3b). What tells them apart is the sign: from A to B resistance
rises as the wire is heated, from B to C it falls. So the direction of the last change of electrical power is held
against the direction in which the resistance moves.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["SegmentState", "SegmentTracker"]

FloatArray = npt.NDArray[np.float64]

# Nearer to R_min than this, as normalised resistance, a wire cannot be in segment A-B.
AMBIGUOUS_ABOVE = 0.6
# A move of resistance counts from this share of the span, above the noise of a usual acquisition card.
LEAST_MOVE = 0.01
# A change of power counts from this share.
LEAST_POWER_CHANGE = 0.02


class SegmentState(NamedTuple):
    """What the tracker remembers: whether strain can be sensed, and the last turns of power and resistance."""

    sensing: bool
    heating: bool
    power_extreme_w: float
    resistance_anchor_ohm: float


class SegmentTracker:
    """Follows a wire through A-B and B-C; state in, state out."""

    def __init__(self, resistance_min_ohm: float, resistance_max_ohm: float) -> None:
        """Take R_min and R_max of the wire's model."""
        span = resistance_max_ohm - resistance_min_ohm
        self._ambiguous_above_ohm = resistance_min_ohm + AMBIGUOUS_ABOVE * span
        self._least_move_ohm = LEAST_MOVE * span

    def start(self, resistance_ohm: float, power_w: float) -> SegmentState:
        """Return the state for a first sample: near R_max a wire is taken for cold until it shows otherwise."""
        return SegmentState(resistance_ohm < self._ambiguous_above_ohm, True, power_w, resistance_ohm)

    def step(self, state: SegmentState, resistance_ohm: float, power_w: float) -> SegmentState:
        """Return the state after one more sample with current."""
        sensing, heating, extreme, anchor = state
        if heating:
            extreme = max(extreme, power_w)
            turned = power_w < extreme * (1.0 - LEAST_POWER_CHANGE)
        else:
            extreme = min(extreme, power_w)
            turned = power_w > extreme * (1.0 + LEAST_POWER_CHANGE)
        if turned:
            heating, extreme, anchor = not heating, power_w, resistance_ohm
        moved = resistance_ohm - anchor
        if abs(moved) > self._least_move_ohm:
            sensing = (moved < 0.0) == heating
            anchor = resistance_ohm
        return SegmentState(sensing or resistance_ohm < self._ambiguous_above_ohm, heating, extreme, anchor)

    def track(
        self, resistance_ohm: FloatArray, power_w: FloatArray, valid: npt.NDArray[np.bool_]
    ) -> npt.NDArray[np.bool_]:
        """Return for each sample whether strain can be sensed, (n_times,); samples without current are skipped."""
        sensing = np.zeros(resistance_ohm.shape, dtype=np.bool_)
        state: SegmentState | None = None
        for row in np.flatnonzero(valid):
            resistance, power = float(resistance_ohm[row]), float(power_w[row])
            state = self.start(resistance, power) if state is None else self.step(state, resistance, power)
            sensing[row] = state.sensing
        return sensing
