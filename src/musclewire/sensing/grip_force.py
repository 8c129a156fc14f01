"""Force between fingers and an object from resistance, once contact has been found.

With the object's stiffness k known, force follows from travel: the fingers would have closed by D(l) at this
resistance, they had closed by D(l_c) at contact, and what lies between was taken up by the object, the fingers and the
stretched wires in series:

    f = [D(l) - D(l_c)] / [1/k + n (c_f + c_w e'(l)^2)]

with n fingers, c_f the compliance of a finger at its endpoint, c_w that of a wire at its tendon, and e' the endpoint's
travel per travel of the tendon, which is also the tendon's force per endpoint force. Weather does not enter: resistance
tells strain whatever the air does. Without k there is a bound (a rigid object), and an estimate from the power that
contact has cost, in which weather does enter: the mean over all contacts and stiffnesses that power leaves likely.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.sensing.branch_equations import evaluate
from musclewire.sensing.contact_detection import ContactState

__all__ = ["GripCurve", "fall_by_cooling"]


# An object is taken for rigid from this stiffness, and never softer than this.
STIFFEST_N_PER_M, SOFTEST_N_PER_M = 1e6, 1.0
# What objects there are, where nothing is known: from a sponge's 20 N/m to 2000 N/m, on which fingers hardly tell it
# from a stone's.
THINKABLE_N_PER_M = np.geomspace(20.0, 2000.0, 33)
# In thermal times of the wire, once its drive has been taken back: the fingers stand after the first, and their wires
# have cooled after the second.
STANDS_AFTER, COOLED_AFTER = 1.0 / 3.0, 2.0
# Noise is averaged over so many samples.
AVERAGED = 3


@dataclass(frozen=True)
class GripCurve:
    """How fingers close and give, over normalised resistance; coefficients are ascending powers.

    ``endpoint_m`` is one free finger's endpoint on heating, ``leverage`` its e'. ``power_per_newton_w`` is what a
    newton at one tendon costs in holding power, all wires of the circuit together. Raises CallerError for compliances
    below 0, no finger, or a newton that costs nothing.
    """

    fingers: int
    endpoint_m: tuple[float, ...]
    leverage: tuple[float, ...]
    finger_compliance_m_per_n: float
    wire_compliance_m_per_n: float
    power_per_newton_w: tuple[float, ...]
    normalised_min: float
    normalised_max: float

    def __post_init__(self) -> None:
        """Check what later divides."""
        if self.fingers < 1 or min(self.finger_compliance_m_per_n, self.wire_compliance_m_per_n) < 0.0:
            raise CallerError("a grip needs at least one finger, and compliances of at least 0")
        for place in (self.normalised_min, self.normalised_max):
            if not float(evaluate(self.power_per_newton_w, place)) > 0.0:
                raise CallerError("force must cost power throughout: these grips of known blocks say it does not")

    def closed_m(self, normalised: float) -> float:
        """Return by how much the free fingers have closed, all together [m]."""
        return self.fingers * float(evaluate(self.endpoint_m, self._within(normalised)))

    def compliance_m_per_n(self, normalised: float) -> float:
        """Return what a newton between the fingers takes away from how far they close [m/N]."""
        lever = self._lever(normalised)
        return self.fingers * (self.finger_compliance_m_per_n + self.wire_compliance_m_per_n * lever * lever)

    def force_n(self, normalised: float, contact: float, stiffness_n_per_m: float) -> float:
        """Return the grip force [N] on an object of known stiffness that was met at ``contact``; 0 before it."""
        travel_m = self.closed_m(normalised) - self.closed_m(contact)
        return max(travel_m, 0.0) / (1.0 / stiffness_n_per_m + self.compliance_m_per_n(normalised))

    def max_force_n(self, normalised: float, contact: float) -> float:
        """Return the grip force on a rigid object [N]: no softer one can have more."""
        return self.force_n(normalised, contact, STIFFEST_N_PER_M)

    def slopes_w(self, here: float, places: FloatArray, stiffness_n_per_m: FloatArray) -> FloatArray:
        """Return how steeply power must have grown [W], (n_stiffnesses, n_places), from each place to ``here``."""
        cost_w = float(evaluate(self.power_per_newton_w, self._within(here))) * self._lever(here)
        return cost_w * self._forces_n(here, places, stiffness_n_per_m) / (places - here)

    def met_by_power(self, state: ContactState) -> tuple[float, float]:
        """Return where contact began, as normalised resistance, and the object's stiffness [N/m], both by power.

        Neither is known, and the pair that explains power best is one in which a draught is taken for force. So every
        pair is weighed by its likelihood and by what objects there are: stiffnesses of ``THINKABLE_N_PER_M``, in
        decades alike. The force of the answer is the mean over all pairs, and such a mean stays unbiased although
        the closing ends by it.
        """
        here = state.normalised
        if here is None or not (state.places > here).any():
            return state.place, SOFTEST_N_PER_M
        behind = state.places > here
        places, overlaps, weights = state.places[behind], state.overlaps[behind], state.weights[behind]
        slopes = self.slopes_w(here, places, THINKABLE_N_PER_M)
        likelihood = slopes * overlaps - 0.5 * slopes * slopes * weights
        share = np.exp(likelihood - likelihood.max())
        share /= share.sum()
        force_n = float((share * self._forces_n(here, places, THINKABLE_N_PER_M)).sum())
        contact = float((share.sum(axis=0) * places).sum())
        travel_m = self.closed_m(here) - self.closed_m(contact)
        if force_n <= 0.0 or travel_m <= 0.0:
            return contact, SOFTEST_N_PER_M
        give = travel_m / force_n - self.compliance_m_per_n(here)
        return contact, min(max(1.0 / give, SOFTEST_N_PER_M), STIFFEST_N_PER_M) if give > 0.0 else STIFFEST_N_PER_M

    def contact_place(self, state: ContactState, stiffness_n_per_m: float) -> float:
        """Return where contact most likely began with an object of known stiffness, as normalised resistance.

        The stiffness says how power grows from each place, which leaves less to weather than the best slope of all:
        log-likelihoods s (overlap) - s^2 (weight) / 2 of the detector's candidates, at the slope s each should have.
        """
        here = state.normalised
        if here is None or not state.places.size:
            return state.place
        behind = state.places > here
        if not behind.any():
            return state.place
        slopes = self.slopes_w(here, state.places[behind], np.array([stiffness_n_per_m]))[0]
        likelihood = slopes * state.overlaps[behind] - 0.5 * slopes * slopes * state.weights[behind]
        best = int(np.argmax(likelihood))
        return float(state.places[behind][best]) if likelihood[best] > 0.0 else state.place

    def _forces_n(self, here: float, places: FloatArray, stiffness_n_per_m: FloatArray) -> FloatArray:
        """Return ``force_n`` for many contacts and stiffnesses [N], (n_stiffnesses, n_places)."""
        met = np.clip(places, self.normalised_min, self.normalised_max)
        met_m = self.fingers * np.polynomial.polynomial.polyval(met, np.array(self.endpoint_m))
        travel_m = np.maximum(self.closed_m(here) - met_m, 0.0)
        forces: FloatArray = travel_m / (1.0 / stiffness_n_per_m[:, None] + self.compliance_m_per_n(here))
        return forces

    def _within(self, normalised: float) -> float:
        return min(max(normalised, self.normalised_min), self.normalised_max)

    def _lever(self, normalised: float) -> float:
        return float(evaluate(self.leverage, self._within(normalised)))


def fall_by_cooling(places: Sequence[float], sample_period_s: float, thermal_time_s: float) -> float:
    """Return by how much normalised resistance has fallen because the wire cools in a hold, not because it contracts.

    ``places`` are normalised resistances since the drive was taken back below what closes further. Metal that cools
    loses resistance; the fingers, by hysteresis, stand. So a fall between the moment they stand and the wire's new
    temperature is no motion; what comes later may be, and is left alone.
    """
    first = round(STANDS_AFTER * thermal_time_s / sample_period_s)
    cooling = places[first : round(COOLED_AFTER * thermal_time_s / sample_period_s)]
    if len(cooling) <= AVERAGED:
        return 0.0
    return max(float(np.mean(cooling[:AVERAGED]) - np.mean(cooling[-AVERAGED:])), 0.0)
