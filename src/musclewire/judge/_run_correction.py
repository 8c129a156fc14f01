"""The correction of a run: what its first heating and a known strain say of the wire of today, from the next sample on.

A scale of the resistance moves B and every other point alike, and a load nearly so, as long as strain counts from where
the wire is cold today. Where it counts from the zero of the characterization, a load has moved that zero as well, and a
scale would do harm. A strain that is known corrects from either zero.
"""

from __future__ import annotations

from array import array
from collections import deque
from math import log, log1p, sqrt
from typing import NamedTuple

import numpy as np

from musclewire.errors import CallerError
from musclewire.judge._first_heating import LIMIT_STDS, NOISY, KnownB, SeenAtB
from musclewire.judge._known_strain import COMPARED_S, WITHIN_STD, KnownStrain, MissedBy, held_mean
from musclewire.physics import wire_resistance
from musclewire.sensing import SHOWN_AS, UNCORRECTED, Correction, SensingModel, by_scale_of
from musclewire.signals import QuantityEstimate, Reason, WireSample

# Where strain counts from: the cold wire of today, or that of the characterization.
TODAY, KEPT = ZEROS = "today", "kept"
# What a scale leaves of a load, as a standard deviation, in parts of what it has taken away: without it the 95 %
# intervals of half and of one and a half times the load hold in 43 % of the samples.
LEFT_FRACTION = 0.4
# And in strokes, where one strain has shown it: a load that has also moved the zero errs to either side of it, so that
# little may be missed where much is wrong elsewhere (studies/known_strain.py --quick: 72 % hold without it).
LEFT_BY_STRAIN = 0.02
# A wire's resistance changes by less than 6 % in its life: two deviations of its scale, before anything is seen.
SCALE_STD = 0.03
# [% of the span from B to C]: no scale explains a resistance that is farther away.
REFUSED_PCT = 9.0
# Nothing is searched before B has been passed, nor in readings at little current, which are noise:
MIN_FALL = 0.04  # of the span from B to C: a resistance that is nearer to its highest is not past B
KEPT_AT_REST = 40  # readings of a wire at rest that are kept, so that one held for hours costs nothing


class RunCorrection:
    """Corrects the model of a run as the run shows it to be necessary; without ``known_b`` its height is left out."""

    def __init__(
        self,
        model: SensingModel,
        shunt_resistance_ohm: float,
        known_b: KnownB | None = None,
        known_strain: KnownStrain | None = None,
        room: Correction | None = None,
    ) -> None:
        """Begin with what the room makes of the zero. Raises CallerError for a strain that the model does not reach."""
        if known_strain is not None and not model.quantity_min <= known_strain.value <= model.quantity_max:
            factor, unit = SHOWN_AS[model.quantity]
            raise CallerError(
                f"the known {model.quantity} of {factor * known_strain.value:g} {unit} at {known_strain.at_s:g} s: "
                f"this model senses {factor * model.quantity_min:.3g} to {factor * model.quantity_max:.3g} {unit}"
            )
        self.correction = room or UNCORRECTED
        self.is_refused = False
        self._of_characterization, self._by_scale = model, by_scale_of(model)
        self._shunt_resistance_ohm = shunt_resistance_ohm
        self._heating = None if known_b is None else FirstHeating(known_b)
        self._known, self._seen = known_strain, deque[StillRow]()

    @property
    def has_moved(self) -> bool:
        """Whether anything was seen that the model does not say."""
        return self.is_refused or not self.correction.is_believed

    @property
    def watches(self) -> bool:
        """Whether anything is still to come that may correct the model."""
        return self._heating is not None or self._known is not None

    @property
    def model(self) -> SensingModel:
        """The model of today, by which the next sample is estimated."""
        return self.correction.applied_to(self._of_characterization)

    @property
    def variance(self) -> float:
        """By how much the correction widens the variance of an estimate."""
        return self.correction.variance(self._by_scale)

    def shown(self, estimate: QuantityEstimate) -> QuantityEstimate:
        """Return an estimate by the model of today from today's zero; not valid where B is too far away."""
        valid = estimate.valid and not self.is_refused
        return estimate._replace(
            value=estimate.value - self.correction.zero,
            std=sqrt(estimate.std * estimate.std + self.variance),
            valid=valid,
            reason=Reason.UNEXPLAINED if valid != estimate.valid else estimate.reason,
        )

    def watch(self, sample: WireSample, estimate: QuantityEstimate, taken_s: float) -> bool:
        """Look at a sample with its own estimate, taken so long [s] after the start; whether it corrects now."""
        if not self.watches:
            return False
        reading = wire_resistance(sample.wire_voltage_v, sample.shunt_voltage_v, self._shunt_resistance_ohm)
        before = self.correction
        if self._known is not None:
            self._look_at_strain(reading.resistance_ohm, estimate, taken_s)
        if self._heating is not None and reading.valid:
            self._look_at_b(self._heating, reading.resistance_ohm, sample.drive_voltage_v)
        return self.correction != before

    def _look_at_b(self, heating: FirstHeating, resistance_ohm: float, drive_voltage_v: float) -> None:
        """Follow the first heating, and correct by the height of B once it has been passed."""
        if not heating.has_passed(resistance_ohm, drive_voltage_v):
            return
        self._heating, seen, known = None, heating.seen, heating.known
        if seen is None or not seen.is_away:
            return
        self.is_refused = is_refused(seen)
        if self.is_refused:
            return
        std = 0.01 * seen.limit_pct / LIMIT_STDS * (known.b_ohm - known.c_ohm) / known.b_ohm
        too_large = log(self.correction.scale / factor_of(seen, known))
        found = self._doubted.updated(too_large, 1.0, 0.0, std * std)
        left = LEFT_FRACTION * 0.01 * seen.away_pct * self._of_characterization.stroke
        self.correction = found.with_zero_less_certain(left * left)

    def _look_at_strain(self, resistance_ohm: float, own: QuantityEstimate, taken_s: float) -> None:
        """Keep what was estimated of late, and correct by it once the moment of the known strain has come."""
        known, shown = self._known, self.shown(own)
        assert known is not None
        if shown.valid:
            self._seen.append(StillRow(taken_s, resistance_ohm, shown.value))
        while self._seen and self._seen[0].taken_s < taken_s - COMPARED_S:
            self._seen.popleft()
        if taken_s < known.at_s:
            return
        self._known = None
        if not shown.valid:
            return
        _, here_ohm, value = (float(one) for one in held_mean(np.array(self._seen), shown.std))
        missed = MissedBy(0, value - known.value, shown.std)
        # Along the mean curve, whichever branch the wire is on: both have about the same slope.
        model, zero = self.model, self.correction.zero
        seen, is_at = (min(max(zero + one, model.quantity_min), model.quantity_max) for one in (value, known.value))
        off_ohm = float(model.resistance_ohm(is_at) - model.resistance_ohm(seen))
        if off_ohm == 0.0:
            return
        by_scale = (is_at - seen) / log1p(off_ohm / here_ohm)
        # What agrees puts nothing in doubt: it narrows what was not certain, as the room's zero.
        prior = self._doubted if missed.is_away else self.correction
        found = prior.updated(seen - is_at, by_scale, -1.0, own.std * own.std)
        if missed.is_away:
            left = LEFT_BY_STRAIN * model.stroke, LEFT_FRACTION * missed.above
            found = found.with_zero_less_certain(left[0] * left[0] + left[1] * left[1])
        self.correction = found

    @property
    def _doubted(self) -> Correction:
        """The correction, with the scale that a wire may have before anything is seen of it."""
        now = self.correction
        return now if now.scale_variance else now._replace(scale_variance=SCALE_STD * SCALE_STD)


class StillRow(NamedTuple):
    """What is compared with a known strain: when it was taken [s], the resistance [ohm], the estimate."""

    taken_s: float
    resistance_ohm: float
    estimate: float


class FirstHeating:
    """Follows resistance and drive until the first heating has passed B."""

    def __init__(self, known: KnownB) -> None:
        """Begin before the first sample."""
        self.known = known
        self.seen: SeenAtB | None = None
        self._resistance_ohm, self._drive_voltage_v = array("d"), array("d")
        self._highest_ohm, self._at_rest = 0.0, 0

    def has_passed(self, resistance_ohm: float, drive_voltage_v: float) -> bool:
        """Look at a reading; whether B has been passed by now, and ``seen`` says how high it was, if that is known."""
        rests = drive_voltage_v <= NOISY * self.known.sense_voltage_v
        if rests and self._at_rest >= KEPT_AT_REST:
            self._resistance_ohm.pop()
            self._drive_voltage_v.pop()
        self._resistance_ohm.append(resistance_ohm)
        self._drive_voltage_v.append(drive_voltage_v)
        self._at_rest = self._at_rest + 1 if rests else 0
        if rests:
            return False
        self._highest_ohm = max(self._highest_ohm, resistance_ohm)
        if self._highest_ohm - resistance_ohm < MIN_FALL * (self.known.b_ohm - self.known.c_ohm):
            return False
        until_now = np.frombuffer(self._resistance_ohm), np.frombuffer(self._drive_voltage_v)
        if self.known.passed_in(*until_now) is None:
            return False
        self.seen = self.known.seen_in(*until_now)
        return True


def is_refused(seen: SeenAtB) -> bool:
    """Return whether B is so far away that no scale serves."""
    return abs(seen.away_pct) > REFUSED_PCT


def factor_of(seen: SeenAtB, known: KnownB) -> float:
    """Return the factor that brings B back to the model's height."""
    return known.b_ohm / (known.b_ohm + 0.01 * seen.away_pct * (known.b_ohm - known.c_ohm))


def what_followed(seen: SeenAtB) -> str:
    """Return in words what a run from today's zero has made of another height of B."""
    if is_refused(seen):
        return f"beyond {REFUSED_PCT:g} % nothing is valid: characterize again"
    left_pct = WITHIN_STD * LEFT_FRACTION * abs(seen.away_pct)
    return f"the resistance is scaled by it, and the interval is at least +-{left_pct:.1f} % of the stroke"
