"""Force between fingers and an object from resistance, once contact has been found.

With the object's stiffness k known, force follows from travel: free fingers would have closed by D(l) at this
resistance, they had closed by D(l_c) at contact, and the difference is the deformation of the object, the fingers and
the stretched wires in series:

    f = [D(l) - D(l_c)] / [1/k + n (c_f + c_w e'(l)^2)]

with n fingers, c_f the compliance of a finger at its endpoint, c_w that of a wire at its tendon, and e' the endpoint's
travel per travel of the tendon, which is also the tendon's force per endpoint force. Air disturbances do not enter, as
strain follows from resistance in any air. Without k there is a bound (a rigid object), and an estimate from the power
that contact takes, which air disturbances do affect: the mean over all contacts and stiffnesses by their likelihood.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.extras.grip._contact_detection import ContactState
from musclewire.sensing import evaluate

MAX_STIFFNESS_N_PER_M = 1e6  # [N/m] from which on an object counts as rigid
MIN_STIFFNESS_N_PER_M = 1.0  # [N/m]: no object is softer
# Stiffnesses of unknown objects: from that of a sponge to one that the fingers can hardly distinguish from a stone's.
UNKNOWN_STIFFNESSES_N_PER_M = np.geomspace(20.0, 2000.0, 33)
# In thermal time constants of the wire, from when its drive is reduced:
AT_REST_AFTER = 1.0 / 3.0  # the fingers are at rest
COOLED_AFTER = 2.0  # their wires have cooled
# Number of samples over which noise is averaged.
AVERAGED_SAMPLES = 3


@dataclass(frozen=True)
class GripCurve:
    """Travel and compliance of fingers over normalised resistance; coefficients are of ascending powers.

    Parameters
    ----------
    fingers
        Number of fingers.
    endpoint_m
        One free finger's endpoint on heating [m].
    leverage
        Its e': travel of the endpoint over travel of the tendon.
    finger_compliance_m_per_n
        Compliance of a finger at its endpoint [m/N].
    wire_compliance_m_per_n
        Compliance of a wire at its tendon [m/N].
    power_per_newton_w
        Holding power per newton at one tendon, of all wires of the circuit together [W].
    normalised_min
        Least normalised resistance at which it holds.
    normalised_max
        Greatest normalised resistance at which it holds.

    Raises
    ------
    CallerError
        For compliances below 0, no finger, or no power per newton.
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
        """Check the numbers that divide later."""
        if self.fingers < 1 or min(self.finger_compliance_m_per_n, self.wire_compliance_m_per_n) < 0.0:
            raise CallerError(f"a grip needs at least one finger, not {self.fingers}, and compliances of at least 0")
        for place in (self.normalised_min, self.normalised_max):
            if not float(evaluate(self.power_per_newton_w, place)) > 0.0:
                raise CallerError(
                    f"force takes no power at a normalised resistance of {place:g}: record grips of stiffer blocks"
                )

    def closed_m(self, normalised: float) -> float:
        """Return the travel by which the free fingers have closed in total at a normalised resistance."""
        return self.fingers * float(evaluate(self.endpoint_m, self._within(normalised)))

    def compliance_m_per_n(self, normalised: float) -> float:
        """Return the compliance of the fingers and their wires between the endpoints at a normalised resistance."""
        lever = self._lever(normalised)
        return self.fingers * (self.finger_compliance_m_per_n + self.wire_compliance_m_per_n * lever * lever)

    def force_n(self, normalised: float, contact: float, stiffness_n_per_m: float) -> float:
        """Return the grip force on an object of known stiffness at a normalised resistance; 0 before contact."""
        return float(self._forces_n(normalised, np.array([contact]), np.array([stiffness_n_per_m]))[0, 0])

    def max_force_n(self, normalised: float, contact: float) -> float:
        """Return the grip force on a rigid object, an upper bound for any other."""
        return self.force_n(normalised, contact, MAX_STIFFNESS_N_PER_M)

    def met_by_power(self, state: ContactState) -> tuple[float, float]:
        """Return the place of contact as normalised resistance and the object's stiffness [N/m], both from power.

        Neither is known, and in the most likely pair a draught would count as force. Every pair is therefore weighted
        by its likelihood, with a prior that is uniform in the logarithm over ``UNKNOWN_STIFFNESSES_N_PER_M``. The force
        is the mean over all pairs, which remains unbiased although the closing ends by it.
        """
        tried = self._likelihoods(state, UNKNOWN_STIFFNESSES_N_PER_M)
        if tried is None:
            return state.place, MIN_STIFFNESS_N_PER_M
        here, places, forces_n, likelihood = tried
        probability = np.exp(likelihood - likelihood.max())
        probability /= probability.sum()
        force_n = float((probability * forces_n).sum())
        contact = float((probability.sum(axis=0) * places).sum())
        travel_m = self.closed_m(here) - self.closed_m(contact)
        if force_n <= 0.0 or travel_m <= 0.0:
            return contact, MIN_STIFFNESS_N_PER_M
        object_m_per_n = travel_m / force_n - self.compliance_m_per_n(here)
        if object_m_per_n <= 0.0:
            return contact, MAX_STIFFNESS_N_PER_M
        return contact, min(max(1.0 / object_m_per_n, MIN_STIFFNESS_N_PER_M), MAX_STIFFNESS_N_PER_M)

    def contact_place(self, state: ContactState, stiffness_n_per_m: float) -> float:
        """Return the most likely place of contact with an object of known stiffness, as normalised resistance.

        The stiffness determines how power grows from each place, which leaves less to air disturbances than a free
        slope: log-likelihoods s (overlap) - s^2 (weight) / 2 of the detector's candidates, at the slope s each should
        have.
        """
        tried = self._likelihoods(state, np.array([stiffness_n_per_m]))
        if tried is None:
            return state.place
        _, places, _, likelihood = tried
        best = int(np.argmax(likelihood[0]))
        return float(places[best]) if likelihood[0, best] > 0.0 else state.place

    def _likelihoods(
        self, state: ContactState, stiffness_n_per_m: FloatArray
    ) -> tuple[float, FloatArray, FloatArray, FloatArray] | None:
        """Return the present place, those passed, and by stiffness and place passed force [N] and log-likelihood.

        None if there is no place at which contact may have begun. The likelihood is that of the slope with which power
        would have grown from there.
        """
        here = state.normalised
        if here is None or not (passed := state.places > here).any():
            return None
        places, overlaps, weights = state.places[passed], state.overlaps[passed], state.weights[passed]
        forces_n = self._forces_n(here, places, stiffness_n_per_m)
        cost_w = float(evaluate(self.power_per_newton_w, self._within(here))) * self._lever(here)
        slopes_w = cost_w * forces_n / (places - here)
        return here, places, forces_n, slopes_w * overlaps - 0.5 * slopes_w * slopes_w * weights

    def _forces_n(self, here: float, places: FloatArray, stiffness_n_per_m: FloatArray) -> FloatArray:
        """Return the force for many contacts and stiffnesses [N], (n_stiffnesses, n_places)."""
        met = np.clip(places, self.normalised_min, self.normalised_max)
        met_m = self.fingers * evaluate(self.endpoint_m, met)
        travel_m = np.maximum(self.closed_m(here) - met_m, 0.0)
        forces: FloatArray = travel_m / (1.0 / stiffness_n_per_m[:, None] + self.compliance_m_per_n(here))
        return forces

    def _within(self, normalised: float) -> float:
        """Return a normalised resistance clipped to the range of the curve."""
        return min(max(normalised, self.normalised_min), self.normalised_max)

    def _lever(self, normalised: float) -> float:
        """Return the tendon's force per endpoint force."""
        return float(evaluate(self.leverage, self._within(normalised)))


def fall_by_cooling(places: Sequence[float], sample_period_s: float, thermal_time_s: float) -> float:
    """Return the fall of normalised resistance in a hold that is due to cooling and not to contraction.

    ``places`` are normalised resistances since the drive was reduced below the one that closes further. Cooling metal
    loses resistance, while the fingers are held at rest by hysteresis. A fall between the moment they are at rest and
    the wire's new temperature is therefore no motion; a later one may be, and is not counted.
    """
    first = round(AT_REST_AFTER * thermal_time_s / sample_period_s)
    cooling = places[first : round(COOLED_AFTER * thermal_time_s / sample_period_s)]
    if len(cooling) <= AVERAGED_SAMPLES:
        return 0.0
    return max(float(np.mean(cooling[:AVERAGED_SAMPLES]) - np.mean(cooling[-AVERAGED_SAMPLES:])), 0.0)
