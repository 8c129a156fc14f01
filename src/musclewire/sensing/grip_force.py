"""Force between fingers and an object from resistance, once contact has been found.

With the object's stiffness k known, force follows from travel: the fingers would have closed by D(l) at this
resistance, they had closed by D(l_c) at contact, and what lies between was taken up by the object, the fingers and the
stretched wires in series:

    f = [D(l) - D(l_c)] / [1/k + n (c_f + c_w e'(l)^2)]

with n fingers, c_f the compliance of a finger at its endpoint, c_w that of a wire at its tendon, and e' the endpoint's
travel per travel of the tendon, which is also the tendon's force per endpoint force. Weather does not enter: resistance
tells strain whatever the air does. Without k there is a bound (a rigid object), and an estimate from the power that
contact has cost, in which weather does enter.
"""

from __future__ import annotations

from dataclasses import dataclass

from musclewire.errors import CallerError
from musclewire.sensing.contact import ContactState
from musclewire.sensing.polynomials import evaluate

__all__ = ["GripCurve"]

# An object is taken for rigid from this stiffness, and never softer than this.
STIFFEST_N_PER_M, SOFTEST_N_PER_M = 1e6, 1.0


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

    def most_force_n(self, normalised: float, contact: float) -> float:
        """Return the grip force on a rigid object [N]: no softer one can have more."""
        return self.force_n(normalised, contact, STIFFEST_N_PER_M)

    def force_by_power_n(self, normalised: float, contact: float, slope_w: float) -> float:
        """Return the grip force [N] that the power spent since contact speaks of, whatever the object's stiffness."""
        cost_w = float(evaluate(self.power_per_newton_w, self._within(normalised)))
        return max(contact - normalised, 0.0) * slope_w / (cost_w * self._lever(normalised))

    def stiffness_by_power_n_per_m(self, normalised: float, contact: float, slope_w: float) -> float:
        """Return the stiffness of an object [N/m] that would have cost this power; within what can be told."""
        force = self.force_by_power_n(normalised, contact, slope_w)
        travel_m = self.closed_m(normalised) - self.closed_m(contact)
        if force <= 0.0 or travel_m <= 0.0:
            return SOFTEST_N_PER_M
        give = travel_m / force - self.compliance_m_per_n(normalised)
        return min(max(1.0 / give, SOFTEST_N_PER_M), STIFFEST_N_PER_M) if give > 0.0 else STIFFEST_N_PER_M

    def contact_place(self, state: ContactState, stiffness_n_per_m: float) -> float:
        """Return where contact most likely began with an object of known stiffness, as normalised resistance.

        The stiffness says how power grows from each place, which leaves less to weather than the best slope of all:
        log-likelihoods s (overlap) - s^2 (weight) / 2 of the detector's candidates, at the slope s each should have.
        """
        here = state.normalised
        if here is None or not state.places.size:
            return state.place
        cost_w = float(evaluate(self.power_per_newton_w, self._within(here))) * self._lever(here)
        best, place = 0.0, state.place
        for at, overlap, weight in zip(state.places, state.overlaps, state.weights, strict=True):
            if at <= here:
                continue
            slope = cost_w * self.force_n(here, float(at), stiffness_n_per_m) / (at - here)
            likelihood = slope * overlap - 0.5 * slope * slope * weight
            if likelihood > best:
                best, place = likelihood, float(at)
        return place

    def _within(self, normalised: float) -> float:
        return min(max(normalised, self.normalised_min), self.normalised_max)

    def _lever(self, normalised: float) -> float:
        return float(evaluate(self.leverage, self._within(normalised)))
