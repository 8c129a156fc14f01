"""Resistance scaled by the height of B: what a first heating shows of a changed load or resistance is taken away.

A scale of the resistance moves B and every other point alike, and a load nearly so, as long as strain counts from where
the wire is cold today. Where it counts from the zero of the characterization, a load has moved that zero as well, and a
scale would do harm.
"""

from __future__ import annotations

from array import array

import numpy as np

from musclewire.judge._first_heating import NOISY, KnownB, SeenAtB, height_of_b
from musclewire.physics import wire_resistance
from musclewire.sensing import SensingModel
from musclewire.signals import QuantityEstimate, Reason, RunFacts, WireSample

# Where strain counts from: the cold wire of today, or that of the characterization.
TODAY, KEPT = ZEROS = "today", "kept"
# What scaling leaves of a load, in % of the stroke: so much, and so much for each % of the span by which B is away.
LEFT_PCT, LEFT_PER_PCT = 3.0, 0.8
# Beyond so many % of the span no scale serves.
REFUSED_PCT = 9.0
# A resistance that is nearer to its highest than this part of the span is not past B, and one that is read with little
# current is noise: nothing is searched in either, and of a wire that rests only so many readings are kept. So one that
# is held for hours costs nothing.
MIN_FALL, KEPT_AT_REST = 0.04, 40
# 95 % of normally distributed errors lie within so many standard deviations.
WITHIN_STD = 1.96


class ScaleByB:
    """Scales the readings of a run from the first heating through B on, if B is not at the model's height.

    Parameters
    ----------
    known
        What the model's slow loop showed of B; None if nothing, and then nothing is scaled.
    stroke
        The stroke, in the unit of the estimate.
    shunt_resistance_ohm
        R [ohm] of Eq. 1.
    """

    def __init__(self, known: KnownB | None, stroke: float, shunt_resistance_ohm: float) -> None:
        """Begin before the first sample."""
        self._known, self._stroke, self._shunt_resistance_ohm = known, stroke, shunt_resistance_ohm
        self._resistance_ohm, self._drive_voltage_v = array("d"), array("d")
        self._highest_ohm, self._at_rest = 0.0, 0
        self._away: SeenAtB | None = None
        self.factor = 1.0

    @classmethod
    def of_model(cls, model: SensingModel, sense_voltage_v: float, shunt_resistance_ohm: float) -> ScaleByB:
        """Return what scales the readings of a model's wire, on a rig of a sense voltage [V] and a shunt [ohm]."""
        stated = RunFacts({**height_of_b(model), "limit_sense_voltage_v": sense_voltage_v})
        return cls(KnownB.stated_in(stated), model.stroke, shunt_resistance_ohm)

    @property
    def has_moved(self) -> bool:
        """Whether B has been passed and was not at the model's height."""
        return self._away is not None

    def scaled(self, sample: WireSample) -> WireSample:
        """Return a sample as an estimator is to see it: its resistance times the factor."""
        return sample._replace(wire_voltage_v=self.factor * sample.wire_voltage_v)

    def judged(self, estimate: QuantityEstimate) -> QuantityEstimate:
        """Return an estimate with the interval that a scaled resistance leaves, or not valid if B is too far away."""
        if self._away is None:
            return estimate
        if is_refused(self._away):
            reason = Reason.UNEXPLAINED if estimate.valid else estimate.reason
            return estimate._replace(valid=False, reason=reason)
        least = 0.01 * left_pct(self._away) * self._stroke / WITHIN_STD
        return estimate._replace(std=max(estimate.std, least))

    def watch(self, sample: WireSample) -> None:
        """Look at a sample as it was read, until B has been passed."""
        if self._known is None:
            return
        reading = wire_resistance(sample.wire_voltage_v, sample.shunt_voltage_v, self._shunt_resistance_ohm)
        if not reading.valid:
            return
        rests = sample.drive_voltage_v <= NOISY * self._known.sense_voltage_v
        if rests and self._at_rest >= KEPT_AT_REST:
            self._resistance_ohm.pop()
            self._drive_voltage_v.pop()
        self._resistance_ohm.append(reading.resistance_ohm)
        self._drive_voltage_v.append(sample.drive_voltage_v)
        self._at_rest = self._at_rest + 1 if rests else 0
        if rests:
            return
        self._highest_ohm = max(self._highest_ohm, reading.resistance_ohm)
        if self._highest_ohm - reading.resistance_ohm < MIN_FALL * (self._known.b_ohm - self._known.c_ohm):
            return
        until_now = np.frombuffer(self._resistance_ohm), np.frombuffer(self._drive_voltage_v)
        if self._known.passed_in(*until_now) is None:
            return
        seen = self._known.seen_in(*until_now)
        if seen is not None and seen.is_away:
            self._away = seen
            self.factor = 1.0 if is_refused(seen) else factor_of(seen, self._known)
        self._known = None


def is_refused(seen: SeenAtB) -> bool:
    """Return whether B is so far away that no scale serves."""
    return abs(seen.away_pct) > REFUSED_PCT


def left_pct(seen: SeenAtB) -> float:
    """Return half the width of the interval that a scaled resistance leaves [% of the stroke]."""
    return LEFT_PCT + LEFT_PER_PCT * abs(seen.away_pct)


def factor_of(seen: SeenAtB, known: KnownB) -> float:
    """Return the factor that brings B back to the model's height."""
    return known.b_ohm / (known.b_ohm + 0.01 * seen.away_pct * (known.b_ohm - known.c_ohm))


def what_followed(seen: SeenAtB) -> str:
    """Return in words what a run from today's zero has made of another height of B."""
    if is_refused(seen):
        return f"beyond {REFUSED_PCT:g} % nothing is valid: characterize again"
    return f"the resistance is scaled by it, and the interval is at least +-{left_pct(seen):.1f} % of the stroke"
