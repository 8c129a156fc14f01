"""Direction-gated branches: strain moves towards the branch of the direction in which the wire is being driven.

Ambient temperature and moving air do not enter the relation of resistance and strain; the direction does, and with it
the wire's history. Resistance alone does not say the direction: after a turn the strain stands still while resistance
follows the temperature, so that it is not monotone there. Electrical power does: above its own slow mean the wire
heats, below it cools. Heating, the strain only rises, towards the heating branch, and only while the resistance falls;
cooling, it only falls, towards the cooling branch, while the resistance rises. Without motion it approaches that branch
slowly while power supports the direction, and the mean of both, more slowly, once it does not, so that a wrong
direction is forgotten. It never leaves the two branches by more than a small margin.

In front is a Kalman filter of one number, the resistance. The noise that it assumes is measured, from the second
differences of the readings, and referred to the shunt's voltage, because a small current makes a noisy resistance. The
motion that it assumes grows with the distance of power from its mean: a wire that is held is averaged for long.

All gains follow from time constants and the time between two samples, as dt / (dt + time constant), which holds for
any of them. The arithmetic is repeated in ``gated_tick`` and in the C library (``mw_gated.c``), operation by operation.
"""

from __future__ import annotations

from typing import NamedTuple

from musclewire.sensing._curve import MARGIN, ResistanceCurve

__all__ = ["NUMBERS", "BranchState", "BranchUpdate", "GatedBranches", "TimeStep", "time_step"]

# Chosen on the tuning seeds 1 to 10 of benchmarks/gated_branches.py. Resistance counts in units of R_max - R_min, the
# quantity in units of the model's range, times in seconds.
NUMBERS = {
    # Direction: time constant of the mean power, and by how much power must differ from it.
    "mean_power_s": 3.0,
    "turning_fraction": 0.1,
    # Filter: variance that a still wire gains per second, one whose power differs from the mean by all of the mean, and
    # the part of an unexpected change; time over which noise is learnt.
    "still_per_s": 2.5e-7,
    "driven_per_s": 0.16,
    "surprise_per_s": 0.15,
    "noise_s": 10.0,
    # Motion: resistance moves if it differs from its value a time constant ago by more than noise and a least change.
    "lagging_s": 0.25,
    "motion_deviations": 1.7,
    "min_motion_variance": 1e-4,
    # Without motion: approach of the branch while power is beyond its mean in that direction by a fraction (below 0: a
    # little less than the mean will do), and of the mean of both branches otherwise. Back to the branch from beyond.
    "supporting_fraction": -0.01,
    "approach_s": 1.0,
    "middle_s": 8.0,
    "return_s": 1.0,
    # How far beyond the branches the quantity may be.
    "beyond": 0.015,
    # Standard deviation: part of the distance of the branches, and of the range (squared).
    "gap_fraction": 0.2,
    "range_variance": 1.0e-5,
}
# Nearer to R_min than this a wire cannot be before B, as for the paper's estimator.
AMBIGUOUS_ABOVE = 0.8
# Readings have at least the noise of a good converter, so that a gain never divides by nothing; in the same unit.
MIN_NOISE = 1e-10
# A power beyond it is none of a wire; it keeps the mean finite whatever the channels say. The same for the others.
MAX_POWER_W = 1e6
MAX_POWER_RATIO = 10.0
MAX_NOISE_V2 = 1.0


class BranchState(NamedTuple):
    """State of direction-gated branches between two samples.

    Parameters
    ----------
    value
        The quantity.
    resistance, lagging, variance
        Filtered resistance, its value about ``lagging_s`` ago, and the variance of the first; normalised.
    before, before_last
        The last two readings of the normalised resistance.
    noise_v2, learnt_s
        Variance of a reading, referred to the shunt's voltage [V2], and the time from which it is known [s]; -1 if only
        one reading is.
    mean_power_w
        Slow mean of the electrical power [W].
    heating
        1 if the wire was last heating, 0 if it was cooling.
    sensing
        1 between B and C, 0 before B, where resistance does not determine the quantity.
    """

    value: float
    resistance: float
    lagging: float
    variance: float
    before: float
    before_last: float
    noise_v2: float
    learnt_s: float
    mean_power_w: float
    heating: float
    sensing: float


class BranchUpdate(NamedTuple):
    """What one sample gives: the variance of the quantity, whether the reading is on the curve, and the next state."""

    variance: float
    on_curve: bool
    state: BranchState


class TimeStep(NamedTuple):
    """The time between two samples, and the gains that follow from it.

    Parameters
    ----------
    dt_s
        The time [s].
    mean_power_gain, lagging_gain, approach_gain, middle_gain, return_gain
        The part of a difference that is gone after it, for each time constant of ``NUMBERS``.
    """

    dt_s: float
    mean_power_gain: float
    lagging_gain: float
    approach_gain: float
    middle_gain: float
    return_gain: float


def time_step(dt_s: float) -> TimeStep:
    """Return a time between two samples with its gains.

    Parameters
    ----------
    dt_s
        The time [s].

    Returns
    -------
    The time and its gains.
    """
    times_s = (NUMBERS[f"{name}_s"] for name in ("mean_power", "lagging", "approach", "middle", "return"))
    return TimeStep(dt_s, *(dt_s / (dt_s + time_s) for time_s in times_s))


class GatedBranches:
    """Follows a quantity between the branches of a curve; state in, state out.

    Parameters
    ----------
    curve
        The wire's resistance curve.
    """

    def __init__(self, curve: ResistanceCurve) -> None:
        """Take the curve's numbers."""
        self._low, self._high = curve.normalised_min, curve.normalised_max
        self._minimum_ohm, self._per_ohm = curve.resistance_min_ohm, curve.tick_constants()["per_ohm"]
        self._both = curve.falling_coefficients
        span = curve.quantity_max - curve.quantity_min
        self._beyond = NUMBERS["beyond"] * span
        self._min_variance = curve.tick_constants()["residual_variance"] + NUMBERS["range_variance"] * span * span
        noise = curve.resistance_noise_ohm * self._per_ohm
        self._first_variance = noise * noise

    def tick_constants(self, step: TimeStep) -> dict[str, float]:
        """Return the numbers that ``step`` reads, by their names in ``gated_tick.CONSTANTS``."""
        own = ("turning_fraction", "supporting_fraction", "still_per_s", "driven_per_s", "surprise_per_s", "noise_s")
        gates = ("motion_deviations", "min_motion_variance", "gap_fraction")
        return {
            **{name: NUMBERS[name] for name in (*own, *gates)},
            **step._asdict(),
            "beyond": self._beyond,
            "min_variance": self._min_variance,
            "first_variance": self._first_variance,
            "min_noise": MIN_NOISE,
            "max_power_w": MAX_POWER_W,
            "max_ratio": MAX_POWER_RATIO,
            "max_noise_v2": MAX_NOISE_V2,
            "ambiguous_above": AMBIGUOUS_ABOVE,
            "resistance_min_ohm": self._minimum_ohm,
            "per_ohm": self._per_ohm,
            "normalised_min": self._low,
            "normalised_max": self._high,
            "normalised_margin": MARGIN,
        }

    def start(self, resistance_ohm: float, power_w: float) -> BranchUpdate:
        """Return the first sample: the mean of the branches, heating.

        Parameters
        ----------
        resistance_ohm
            Resistance [ohm].
        power_w
            Electrical power [W].

        Returns
        -------
        The sample; half the distance of the branches counts as its deviation.
        """
        read = (resistance_ohm - self._minimum_ohm) * self._per_ohm
        inside = min(max(read, self._low), self._high)
        heating, cooling, slope = self._branches(inside)
        power_w = min(power_w, MAX_POWER_W)
        value, half = (heating + cooling) / 2.0, (heating - cooling) / 2.0
        away = slope / 2.0 * (read - inside)
        variance = half * half + away * away + self._min_variance
        state = BranchState(
            value,
            read,
            read,
            self._first_variance,
            read,
            read,
            0.0,
            -1.0,
            power_w,
            1.0,
            0.0 if read >= AMBIGUOUS_ABOVE else 1.0,
        )
        return BranchUpdate(variance, self._low - MARGIN <= read <= self._high + MARGIN, state)

    def step(
        self,
        state: BranchState,
        resistance_ohm: float,
        power_w: float,
        shunt_voltage_v: float,
        after: TimeStep,
    ) -> BranchUpdate:
        """Return the next sample.

        Parameters
        ----------
        state
            The state before.
        resistance_ohm
            Resistance [ohm].
        power_w
            Electrical power [W].
        shunt_voltage_v
            Voltage across the shunt [V], not 0.
        after
            The time since the sample before.

        Returns
        -------
        Variance, whether the reading is on the curve, and the state after.
        """
        value, resistance, lagging, variance, before, before_last, noise_v2, learnt_s, mean_w, heating, sensing = state
        read = (resistance_ohm - self._minimum_ohm) * self._per_ohm
        # What one volt of noise at the shunt is in normalised resistance.
        per_volt = resistance_ohm * self._per_ohm / shunt_voltage_v
        noise = noise_v2 * per_volt * per_volt + MIN_NOISE
        on_curve = self._on_curve(read, noise)
        power_w = min(power_w, MAX_POWER_W)
        mean_w += (power_w - mean_w) * after.mean_power_gain
        ratio = min(power_w / mean_w - 1.0, MAX_POWER_RATIO)
        # The filter.
        away = read - resistance
        surprise = max(away * away - noise - variance, 0.0)
        variance += after.dt_s * (
            NUMBERS["still_per_s"] + NUMBERS["driven_per_s"] * ratio * ratio + NUMBERS["surprise_per_s"] * surprise
        )
        weight = variance / (variance + noise)
        resistance += weight * away
        variance -= weight * variance
        lagging += (resistance - lagging) * after.lagging_gain
        noise_v2, learnt_s = self._noise_after(
            noise_v2, learnt_s, (read - before) - (before - before_last), per_volt, after.dt_s
        )
        # The gate.
        # By how much power is beyond its mean in the direction of the wire.
        support = ratio if heating != 0.0 else -ratio
        if support < -NUMBERS["turning_fraction"]:  # motion counts from the turn
            heating, support, lagging = 1.0 - heating, -support, resistance
        moved = resistance - lagging
        if not moved * moved > NUMBERS["motion_deviations"] * variance + NUMBERS["min_motion_variance"]:
            moved = 0.0
        sensing = self._sensing_after(sensing, resistance, variance, heating, moved)
        inside = min(max(resistance, self._low), self._high)
        hot, cold, slope = self._branches(inside)
        value = self._moved((value, hot, cold), heating, moved, support, after)
        gap = NUMBERS["gap_fraction"] * (hot - cold)
        slope = slope / 2.0
        off = slope * (resistance - inside)
        spread = gap * gap + slope * slope * variance + off * off + self._min_variance
        now = BranchState(
            value, resistance, lagging, variance, read, before, noise_v2, learnt_s, mean_w, heating, sensing
        )
        return BranchUpdate(spread, on_curve, now)

    def _moved(
        self, at: tuple[float, float, float], heating: float, moved: float, support: float, after: TimeStep
    ) -> float:
        """Return the quantity, moved from its value towards its branch and kept within both branches."""
        value, hot, cold = at
        branch, towards = (hot, -moved) if heating != 0.0 else (cold, moved)
        ahead = branch - value if heating != 0.0 else value - branch
        if ahead < 0.0:
            value += (branch - value) * after.return_gain
        elif towards > 0.0:
            value = branch
        elif support > NUMBERS["supporting_fraction"]:
            value += (branch - value) * after.approach_gain
        else:
            value += ((hot + cold) / 2.0 - value) * after.middle_gain
        return min(max(value, min(hot, cold) - self._beyond), max(hot, cold) + self._beyond)

    def _sensing_after(self, sensing: float, resistance: float, variance: float, heating: float, moved: float) -> float:
        """Return whether the wire is between B and C: lost at the cold end, found where heating lowers resistance.

        From A to B resistance rises while the wire heats, from B to C it falls.
        """
        if resistance > self._high:
            return 0.0
        below = AMBIGUOUS_ABOVE - resistance
        found = (heating != 0.0 and moved < 0.0) or (below > 0.0 and below * below > 9.0 * variance)
        return 1.0 if found else sensing

    def _on_curve(self, read: float, noise: float) -> bool:
        """Return whether a reading can be one of the valid range, within three deviations of its noise."""
        outside = max(self._low - MARGIN - read, read - self._high - MARGIN, 0.0)
        return outside * outside <= 9.0 * noise

    @staticmethod
    def _noise_after(
        noise_v2: float, learnt_s: float, bend: float, per_volt: float, dt_s: float
    ) -> tuple[float, float]:
        """Return the noise and the time over which it is known, after one more second difference of the readings."""
        if learnt_s < 0.0 or dt_s <= 0.0:
            return noise_v2, 0.0
        learnt_s = min(learnt_s + dt_s, NUMBERS["noise_s"])
        bend_v = bend / per_volt
        return noise_v2 + (min(bend_v * bend_v / 6.0, MAX_NOISE_V2) - noise_v2) * (dt_s / learnt_s), learnt_s

    def _branches(self, inside: float) -> tuple[float, float, float]:
        """Return both branches and the slope of their sum at a normalised resistance, by Horner's rule."""
        hot = cold = slope = 0.0 * inside
        for h, c in self._both:
            slope = slope * inside + hot + cold
            hot = hot * inside + h
            cold = cold * inside + c
        return hot, cold, slope
