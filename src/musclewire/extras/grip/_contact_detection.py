"""Contact of a closing finger, found from the voltages of its wire alone.

Principle. The strain of a wire at a resistance hardly depends on its load (Lan and Fan 2010, Fig. 7), so that
resistance against strain cannot show that a finger has touched an object. Power against resistance does: the object's
reaction raises the wire's stress, stress raises its transformation temperatures, and a hotter wire takes more power at
the same resistance. A draught or warmer air also changes that power, but not together with the resistance. Written as a
heat balance over normalised resistance l, which falls as the wire contracts:

    P = theta(l) - m(l) dl/dt + a + s [(l_c - l) - tau dl/dt]  once l < l_c

theta is the power that holds the free finger at l, m the heat per unit of l (latent heat and further heating of the
wire), both from closings without an object; a the disturbance by the air; tau the wire's thermal time constant; l_c
the normalised resistance at which contact began; s [W] the slope with which power grows from there. The term in dl/dt
shows contact at once and not only after force has grown: from one sample to the next the wire must warm faster for the
same motion.

Detection. Integrated over time the balance holds without differentiating the noisy resistance:

    E = int (P - theta) dt + int m dl = E_0 + int a dt + s [int (l_c - l) dt + tau (l_c - l)]

The disturbance a is a first-order random process of given strength and duration; a Kalman filter on (E, a) whitens E,
and a generalised likelihood ratio compares "free" with "contact at l_c" for every recent l_c and the s that fits it
best (Willsky and Jones 1976, IEEE Trans. Autom. Control 21, 108, doi 10.1109/TAC.1976.1101146). The score is that ratio
in standard deviations.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, isfinite
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.sensing import check_resistance_range, evaluate, normalised_resistance

# In standard deviations. Of a Gaussian score 4.5 is passed by chance once in 300,000; a closing has some 40 samples.
THRESHOLD = 4.5
# In a fast closing one sample may cover half a millimetre: contact may have begun at as many places within it.
PLACES_PER_SAMPLE = 4
# Contacts that began longer ago than this many samples are no longer tried.
CANDIDATES = 40 * PLACES_PER_SAMPLE
# The wire has begun to contract once its resistance has fallen by this fraction of the range from its maximum.
MIN_FALL_FRACTION = 0.04
# Before that it must take this fraction of the power that holds it at the beginning of contraction.
MIN_POWER_FRACTION = 0.5
# Error of theta and m in a free closing: a fraction of the power, independent from sample to sample.
MODEL_POWER_FRACTION = 0.01
NO_FLOATS = np.empty(0)


@dataclass(frozen=True)
class FreeClosing:
    """Power and energy of a closing without an object over normalised resistance; coefficients are of ascending powers.

    Parameters
    ----------
    resistance_min_ohm
        Resistance at C, normalised 0 [ohm].
    resistance_max_ohm
        Resistance at B, normalised 1 [ohm].
    holding_power_w
        Theta: power that holds all wires of the circuit at a place [W].
    closing_energy_j
        m: their energy over normalised resistance [J].
    normalised_min
        Least normalised resistance at which both hold.
    normalised_max
        Greatest normalised resistance at which both hold.
    normalised_noise
        Standard deviation of one sample's normalised resistance, with what theta and m leave unexplained.
    thermal_time_s
        Time constant of the wires in air [s].

    Raises
    ------
    CallerError
        For numbers that cannot be.
    """

    resistance_min_ohm: float
    resistance_max_ohm: float
    holding_power_w: tuple[float, ...]
    closing_energy_j: tuple[float, ...]
    normalised_min: float
    normalised_max: float
    normalised_noise: float
    thermal_time_s: float

    def __post_init__(self) -> None:
        """Check the numbers that divide or are integrated later."""
        check_resistance_range(self.resistance_min_ohm, self.resistance_max_ohm)
        numbers = (*self.holding_power_w, *self.closing_energy_j, self.normalised_min, self.normalised_max)
        if not (self.holding_power_w and self.closing_energy_j and all(map(isfinite, numbers))):
            raise CallerError(
                f"a free closing needs finite coefficients of power and energy, not {numbers}: train the gripper again"
            )
        if not (self.normalised_min < self.normalised_max and 0.0 < self.normalised_noise < 1.0):
            raise CallerError(
                f"a free closing needs a range of normalised resistance that rises, not {self.normalised_min:g} to "
                f"{self.normalised_max:g}, and noise between 0 and 1, not {self.normalised_noise:g}: train again"
            )
        if not 0.0 < self.thermal_time_s < float("inf"):
            raise CallerError(f"the thermal time is {self.thermal_time_s:g} s and must be above 0")

    def normalised(self, resistance_ohm: float) -> float:
        """Return normalised resistance (Eq. 3), 0 at C and 1 at B."""
        return normalised_resistance(resistance_ohm, self.resistance_min_ohm, self.resistance_max_ohm)


class AirDisturbance(NamedTuple):
    """How much the air is expected to change convection, as standard deviations in fractions of the holding power."""

    draught_fraction: float = 0.10
    draught_time_s: float = 3.0  # correlation time
    air_temperature_fraction: float = 0.06  # constant over one closing: 3 K of some 60 K between wire and air


class ContactState(NamedTuple):
    """State of the detector; ``score`` and the fields after it are its result."""

    highest: float
    normalised: float | None
    power_w: float
    following: bool
    energy_j: float
    level: FloatArray
    covariance: FloatArray
    places: FloatArray
    signatures: FloatArray
    responses: FloatArray
    overlaps: FloatArray
    weights: FloatArray
    score: float
    place: float  # normalised resistance at which contact most likely began
    slope_w: float  # growth of power per unit of normalised resistance since
    touched: bool  # stays True once the score has passed the threshold
    # Deviation of the last energy from the prediction of the free closing in standard deviations of noise and air
    # disturbance; None until the wire contracts.
    innovation: float | None


class SampleInterval(NamedTuple):
    """The interval between two samples: normalised resistances, energy and its noise [J], powers [W], time [s]."""

    before: float
    here: float
    energy_j: float
    holding_w: float
    taken_w: float
    noise_j: float
    dt_s: float


class ContactDetector:
    """Distinguishes contact from air disturbances while a finger closes; state in, state out."""

    def __init__(self, free: FreeClosing, air: AirDisturbance | None = None, threshold: float = THRESHOLD) -> None:
        """Take the free closing, the air disturbance expected and the score that counts as contact, both above 0."""
        self.free, self.air, self.threshold = free, air or AirDisturbance(), threshold
        if not (min(self.air) > 0.0 and threshold > 0.0):
            raise CallerError(
                f"the expected air disturbance {tuple(self.air)} and the threshold {threshold} must be above 0"
            )

    def start(self) -> ContactState:
        """Return the state before a closing, the wire cold or just warm."""
        nothing = np.zeros((2, 2))
        return ContactState(
            -np.inf, None, 0.0, False, 0.0, np.zeros(2), nothing,
            NO_FLOATS, NO_FLOATS, np.empty((2, 0)), NO_FLOATS, NO_FLOATS, 0.0, 1.0, 0.0, False, None,
        )  # fmt: skip

    def step(self, state: ContactState, resistance_ohm: float, power_w: float, dt_s: float) -> ContactState:
        """Return the state after one more sample of a closing, whose resistance and power are means of all wires."""
        free = self.free
        here, before = free.normalised(resistance_ohm), state.normalised
        seen = state._replace(normalised=here, power_w=power_w)
        if not state.following:
            # At low current the resistance is mostly noise, and a wire that contracts takes more power.
            powered = power_w > MIN_POWER_FRACTION * float(evaluate(free.holding_power_w, free.normalised_max))
            seen = seen._replace(highest=max(state.highest, here) if powered else state.highest)
            if not (powered and here < min(free.normalised_max, seen.highest - MIN_FALL_FRACTION)):
                return seen
        if before is None or here < free.normalised_min:
            return seen
        middle = min(0.5 * (here + before), free.normalised_max)
        holding_w = float(evaluate(free.holding_power_w, middle))
        noise_j = free.normalised_noise * float(evaluate(free.closing_energy_j, middle))
        if not state.following:
            level = (self.air.draught_fraction**2 + self.air.air_temperature_fraction**2) * holding_w**2
            seen = seen._replace(following=True, covariance=np.diag([noise_j**2, level]))
        taken_w = 0.5 * (power_w + state.power_w)
        energy = state.energy_j + (taken_w - holding_w) * dt_s + noise_j / free.normalised_noise * (here - before)
        return self._weigh(seen, SampleInterval(before, here, energy, holding_w, taken_w, noise_j, dt_s))

    def _weigh(self, state: ContactState, interval: SampleInterval) -> ContactState:
        """Return the state after one more energy: filter, candidates, score."""
        places, signatures = self._candidates(state, interval)
        level, covariance, responses = self._predicted(state, interval)
        variance = covariance[0, 0] + interval.noise_j**2
        gain = covariance[:, 0] / variance
        innovation = interval.energy_j - level[0]
        shown = signatures - responses[0]
        state = state._replace(
            energy_j=interval.energy_j,
            level=level + gain * innovation,
            covariance=covariance - np.outer(gain, covariance[0]),
            places=places,
            signatures=signatures,
            responses=responses + gain[:, None] * shown,
            overlaps=shifted_candidates(state.overlaps) + innovation * shown / variance,
            weights=shifted_candidates(state.weights) + shown * shown / variance,
            innovation=float(innovation / np.sqrt(variance)),
        )
        return self._scored(state)

    def _candidates(self, state: ContactState, interval: SampleInterval) -> tuple[FloatArray, FloatArray]:
        """Return the places at which contact may have begun, and the energy signature of each until now [J per W]."""
        before, here, dt_s = interval.before, interval.here, interval.dt_s
        # Contact may also have begun since the sample before, at several places; the oldest candidates are dropped.
        fractions = np.arange(PLACES_PER_SAMPLE) / PLACES_PER_SAMPLE
        since = fractions * (before - here)
        places = np.append(state.places, before - since)[-CANDIDATES:]
        old = (
            state.signatures
            + (state.places - 0.5 * (here + before)) * dt_s
            + (before - here) * self.free.thermal_time_s
        )
        # For these only the rest of the sample, and of its motion, is after contact.
        left = (before - here) - since
        new = 0.5 * left * (1.0 - fractions) * dt_s + left * self.free.thermal_time_s
        return places, np.append(old, new)[-CANDIDATES:]

    def _predicted(self, state: ContactState, interval: SampleInterval) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return level, covariance and the candidates' responses as predicted for the sample."""
        dt_s = interval.dt_s
        kept = exp(-dt_s / self.air.draught_time_s)
        forward = np.array([[1.0, dt_s], [0.0, 1.0]])
        draught_w2 = (self.air.draught_fraction * interval.holding_w) ** 2 * (1.0 - kept * kept)
        drift = np.diag([(MODEL_POWER_FRACTION * interval.taken_w * dt_s) ** 2, draught_w2])
        responses = forward @ np.hstack([state.responses, np.zeros((2, PLACES_PER_SAMPLE))])[:, -CANDIDATES:]
        return forward @ state.level, forward @ state.covariance @ forward.T + drift, responses

    def _scored(self, state: ContactState) -> ContactState:
        """Return the state with its best candidate, and whether the score of that counts as contact."""
        distinguishable = state.weights > np.finfo(float).tiny
        scores = np.where(distinguishable, state.overlaps, 0.0) / np.sqrt(np.where(distinguishable, state.weights, 1.0))
        best = int(np.argmax(scores))
        score = float(scores[best])
        slope_w = max(score / float(np.sqrt(state.weights[best])), 0.0) if distinguishable[best] else 0.0
        return state._replace(
            score=score,
            place=float(state.places[best]),
            slope_w=slope_w,
            touched=state.touched or score > self.threshold,
        )


def shifted_candidates(values: FloatArray) -> FloatArray:
    """Return one number per candidate, with zeros for the new ones and without the oldest."""
    return np.append(values, np.zeros(PLACES_PER_SAMPLE))[-CANDIDATES:]
