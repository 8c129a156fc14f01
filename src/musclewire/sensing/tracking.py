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

from musclewire.arrays import FloatArray

__all__ = ["AMBIGUOUS_ABOVE", "SegmentState", "SegmentTracker"]


# Nearer to R_min than this, as normalised resistance, a wire cannot be in segment A-B: from A to B resistance rises
# by a few percent, from B to C it falls by more than ten (Lan and Fan 2010, Fig. 3b).
AMBIGUOUS_ABOVE = 0.8
# A move of the smoothed resistance counts from this share of the span. At the sense voltage the current is small and
# one sample's noise is a share of one to two hundredths; a mean over eight samples brings it well below.
LEAST_MOVE = 0.02
SMOOTHING_SAMPLES = 8.0
# A change of power counts from this share.
LEAST_POWER_CHANGE = 0.02


class SegmentState(NamedTuple):
    """What a tracker remembers of a wire.

    Parameters
    ----------
    sensing
        Whether strain can be sensed: the wire is between B and C.
    heating
        Whether power last turned upward.
    power_extreme_w
        Extreme of the power since it turned [W].
    resistance_anchor_ohm
        Resistance from which a move the other way is counted [ohm].
    smoothed_ohm
        Resistance, smoothed over eight samples [ohm].
    """

    sensing: bool
    heating: bool
    power_extreme_w: float
    resistance_anchor_ohm: float
    smoothed_ohm: float


class SegmentTracker:
    """Follows a wire through A-B and B-C; state in, state out.

    Parameters
    ----------
    resistance_min_ohm
        R_min of the wire's model [ohm].
    resistance_max_ohm
        R_max of the wire's model [ohm].
    """

    def __init__(self, resistance_min_ohm: float, resistance_max_ohm: float) -> None:
        """Take R_min and R_max of the wire's model."""
        span = resistance_max_ohm - resistance_min_ohm
        self._ambiguous_above_ohm = resistance_min_ohm + AMBIGUOUS_ABOVE * span
        self._least_move_ohm = LEAST_MOVE * span

    def start(self, resistance_ohm: float, power_w: float) -> SegmentState:
        """Return the state for a first sample: near R_max a wire is taken for cold until it shows otherwise.

        Parameters
        ----------
        resistance_ohm
            Resistance [ohm].
        power_w
            Electrical power [W].

        Returns
        -------
        The state.
        """
        cold = resistance_ohm >= self._ambiguous_above_ohm
        return SegmentState(not cold, True, power_w, resistance_ohm, resistance_ohm)

    def step(self, state: SegmentState, resistance_ohm: float, power_w: float) -> SegmentState:
        """Return the state after one more sample with current.

        Parameters
        ----------
        state
            The state before.
        resistance_ohm
            Resistance [ohm].
        power_w
            Electrical power [W].

        Returns
        -------
        The state after.
        """
        sensing, heating, extreme, anchor, smoothed = state
        smoothed += (resistance_ohm - smoothed) / SMOOTHING_SAMPLES
        if heating:
            extreme = max(extreme, power_w)
            turned = power_w < extreme * (1.0 - LEAST_POWER_CHANGE)
        else:
            extreme = min(extreme, power_w)
            turned = power_w > extreme * (1.0 + LEAST_POWER_CHANGE)
        if turned:
            heating, extreme, anchor = not heating, power_w, smoothed
        # The anchor goes along in the direction this segment explains; a move the other way is the other segment's.
        if sensing == heating:
            anchor = min(anchor, smoothed)
            other_way = smoothed - anchor
        else:
            anchor = max(anchor, smoothed)
            other_way = anchor - smoothed
        if other_way > self._least_move_ohm:
            sensing, anchor = not sensing, smoothed
        return SegmentState(sensing or smoothed < self._ambiguous_above_ohm, heating, extreme, anchor, smoothed)

    def track(
        self, resistance_ohm: FloatArray, power_w: FloatArray, valid: npt.NDArray[np.bool_]
    ) -> npt.NDArray[np.bool_]:
        """Return for each sample of a recording whether strain can be sensed.

        Parameters
        ----------
        resistance_ohm
            Resistances [ohm], shape (n_times,).
        power_w
            Electrical power [W], shape (n_times,).
        valid
            Which samples have current, shape (n_times,); the others are skipped and not sensed.

        Returns
        -------
        Whether strain can be sensed, shape (n_times,).
        """
        sensing = np.zeros(resistance_ohm.shape, dtype=np.bool_)
        state: SegmentState | None = None
        for row in np.flatnonzero(valid):
            resistance, power = float(resistance_ohm[row]), float(power_w[row])
            state = self.start(resistance, power) if state is None else self.step(state, resistance, power)
            sensing[row] = state.sensing
        return sensing
