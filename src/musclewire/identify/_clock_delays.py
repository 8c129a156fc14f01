"""The delay between the clocks of two recordings, by the correlation of what both recorded, with its deviation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError, argument
from musclewire.signals import Recording

# Below this correlation the two columns do not show the same thing.
MIN_CORRELATION = 0.7
# Correlations elsewhere must be lower by this, or the delay could as well be there.
MIN_MARGIN = 0.05
# Delays are tried that leave this fraction of the shorter recording in common, and of each column's variance in it.
MIN_OVERLAP = 0.3
MIN_VARIANCE = 0.2
# Both recordings on one grid: more points take memory and show no more.
MAX_POINTS = 1 << 21
# A half of a recording shows a delay only with both of these:
MIN_SAMPLES = 8
MIN_CHANGE = 0.3  # of the column's change in the whole recording
# Clocks of instruments that differ by more have another cause.
MAX_RATE = 0.03
# Standard deviations by which the delays of both halves may differ without a drift.
DRIFT_STDS = 4.0


class Delay(NamedTuple):
    """A delay [s], its standard deviation [s], the correlation there, the best elsewhere, and the delay of that [s]."""

    delay_s: float
    std_s: float
    correlation: float
    next_correlation: float
    next_delay_s: float

    @property
    def is_determined(self) -> bool:
        """Whether there is one delay at which the columns correlate, and no other."""
        return self.correlation >= MIN_CORRELATION and self.next_correlation <= self.correlation - MIN_MARGIN


def delay_of(
    first: Recording, second: Recording, pair: tuple[str, str], around_s: float = 0.0, within_s: float = np.inf
) -> Delay:
    """Return where two recordings correlate best, as a delay of the second clock; only some delays are tried."""
    periods_s = np.array([sample_period_s(first), sample_period_s(second)])
    step_s = float(max(periods_s.min() / 2.0, (first.duration_s + second.duration_s) / MAX_POINTS))
    one, other = _on_grid(first, pair[0], step_s), _on_grid(second, pair[1], step_s)
    coefficients, lags, counts = _correlations(one, other)
    # Two different columns may have opposite signs; the same one has not.
    strength = coefficients if pair[0] == pair[1] else np.abs(coefficients)
    start_s = float(second["time_s"][0] - first["time_s"][0])
    strength = np.where(np.abs(start_s + step_s * lags - around_s) <= within_s, strength, 0.0)
    best = int(np.argmax(strength))
    top, width = float(strength[best]), max(1, round(float(periods_s.max()) / step_s))
    samples = float(counts[best]) / width
    noise = max(1.0 - top**2, 1e-12)
    # The peak is a parabola over the longer sample period to both sides; its curvature shows where it falls by more
    # than noise does.
    before, after = _beside(strength, best, width)
    vertex = float(np.clip(0.5 * width * (after - before) / max(2.0 * top - before - after, 1e-12), -width, width))
    wide = width
    while 2.0 * top - sum(_beside(strength, best, wide)) < 8.0 * noise / np.sqrt(samples) and wide < counts[best] / 8.0:
        wide *= 2
    bend = max(2.0 * top - sum(_beside(strength, best, wide)), 1e-12) / (wide * step_s) ** 2
    fit_std_s = float(np.sqrt(noise / (samples * max(top, MIN_MARGIN) * bend)))
    # An event is somewhere between two samples of each recording; several events by chance at different places.
    sampling_std_s = float(np.hypot(*periods_s)) / np.sqrt(12.0 * _events(one, other, round(float(lags[best])), width))
    # The main peak reaches as far as correlations are nearly as good.
    low = np.flatnonzero(strength[:best] <= top - 2.0 * MIN_MARGIN)
    high = np.flatnonzero(strength[best:] <= top - 2.0 * MIN_MARGIN)
    elsewhere = strength.copy()
    elsewhere[low[-1] if low.size else 0 : best + high[0] + 1 if high.size else None] = 0.0
    next_best = int(np.argmax(elsewhere))
    delay_s, next_delay_s = (start_s + step_s * lag for lag in (float(lags[best]) + vertex, float(lags[next_best])))
    return Delay(delay_s, float(np.hypot(fit_std_s, sampling_std_s)), top, float(elsewhere[next_best]), next_delay_s)


def _beside(strength: FloatArray, best: int, width: int) -> tuple[float, float]:
    """Return the correlations before and after the best one."""
    return float(strength[max(best - width, 0)]), float(strength[min(best + width, strength.size - 1)])


def _events(one: FloatArray, other: FloatArray, lag: int, width: int) -> float:
    """Return how many events two series have in common, from the products of their changes over a sample period."""
    start, stop = max(0, -lag), min(one.size, other.size - lag)
    changes = np.diff(one[start:stop:width]) * np.diff(other[start + lag : stop + lag : width])
    return max(1.0, float(changes.sum() ** 2 / max(float(changes @ changes), 1e-300)))


def _on_grid(recording: Recording, name: str, step_s: float) -> FloatArray:
    """Return a column at equal steps."""
    time_s, values = recording["time_s"], recording[name]
    if np.ptp(values) <= 1e-12 * max(1.0, float(np.abs(values).max())):
        raise RecordingError(f"{name} does not change, and shows no delay of the clocks; name another column")
    return np.interp(np.arange(time_s[0], time_s[-1], step_s), time_s, values)


def _correlations(one: FloatArray, other: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return Pearson's coefficient over the common part for each lag of the other series, the lags, and its length."""
    from scipy import signal

    one, other = one - one.mean(), other - other.mean()
    ones, others = np.ones_like(one), np.ones_like(other)
    lags = signal.correlation_lags(other.size, one.size, mode="full").astype(np.float64)

    def products(left: FloatArray, right: FloatArray) -> FloatArray:
        return np.asarray(signal.correlate(left, right, mode="full", method="fft"), dtype=np.float64)

    counts = np.maximum(np.rint(products(others, ones)), 1.0)
    sum_one, sum_other = products(others, one), products(other, ones)
    covariance = products(other, one) - sum_one * sum_other / counts
    spread_one = products(others, one**2) - sum_one**2 / counts
    spread_other = products(other**2, ones) - sum_other**2 / counts
    # A common part in which a column hardly changes shows nothing, and its coefficient is noise.
    enough = counts >= MIN_OVERLAP * min(one.size, other.size)
    enough &= spread_one > MIN_VARIANCE * counts / one.size * float(one @ one)
    enough &= spread_other > MIN_VARIANCE * counts / other.size * float(other @ other)
    safe = np.where(enough, spread_one * spread_other, 1.0)
    return np.where(enough, covariance / np.sqrt(safe), 0.0), lags, counts


def steady_deviations(
    first: Recording, second: Recording, pair: tuple[str, str], found: Delay
) -> tuple[float, float, str]:
    """Return deviations of delay and rate by both halves, also in words. Raises RecordingError for a drift."""
    low_s = max(first["time_s"][0], second["time_s"][0] - found.delay_s)
    half_s = 0.5 * (min(first["time_s"][-1], second["time_s"][-1] - found.delay_s) - low_s)
    halves = [
        half for start_s in (low_s, low_s + half_s) if (half := _delay_in(first, second, pair, start_s, half_s, found))
    ]
    drift_s = halves[1].delay_s - halves[0].delay_s if len(halves) == 2 else np.inf
    if abs(drift_s) > MAX_RATE * half_s:
        return found.std_s, 0.0, "not both halves show a delay: whether the clocks drift is not known"
    rate, rate_std = drift_s / half_s, float(np.hypot(halves[0].std_s, halves[1].std_s)) / half_s
    words = f"the delay is {halves[0].delay_s:.6g} s in the first half and {halves[1].delay_s:.6g} s in the second"
    if abs(rate) < DRIFT_STDS * rate_std:
        return found.std_s, rate_std, f"{words}: no drift beyond {1e6 * DRIFT_STDS * rate_std:.2g} ppm"
    corrected = delay_of(first, second.with_columns(time_s=second["time_s"] / (1.0 + rate)), pair)
    if (
        abs(drift_s) > 0.5 * max(sample_period_s(first), sample_period_s(second))
        and corrected.correlation > found.correlation
    ):
        size = f"{60.0 * rate:.3g} s a minute ({1e6 * rate:.0f} +- {1e6 * rate_std:.0f} ppm)"
        raise RecordingError(f"the clocks drift apart by {size}: {words}; correct one clock, or join shorter parts")
    return float(np.hypot(found.std_s, drift_s / np.sqrt(3.0))), rate_std, f"{words}: within a sample period"


def _delay_in(
    first: Recording, second: Recording, pair: tuple[str, str], start_s: float, long_s: float, found: Delay
) -> Delay | None:
    """Return the delay that a part of the recordings shows by itself, None if it shows none."""
    within_s = 2.0 * MAX_RATE * long_s
    one, begin_s = _cut(first, start_s, start_s + long_s), start_s + found.delay_s
    other = _cut(second, begin_s - within_s, begin_s + long_s + within_s)
    if min(len(one), len(other)) < MIN_SAMPLES or np.ptp(one[pair[0]]) < MIN_CHANGE * np.ptp(first[pair[0]]):
        return None
    part = delay_of(one, other, pair, found.delay_s, within_s) if np.ptp(other[pair[1]]) > 0.0 else None
    return part if part and part.is_determined else None


def require_determined(found: Delay, pair: tuple[str, str]) -> None:
    """Raise RecordingError unless the delay is determined."""
    names = " and ".join(dict.fromkeys(pair))
    if found.correlation < MIN_CORRELATION:
        raise RecordingError(
            f"the recordings cannot be joined by {names}: their correlation is {found.correlation:.2f} at best, at "
            f"least {MIN_CORRELATION} is needed; name columns that follow each other"
        )
    if not found.is_determined:
        raise RecordingError(
            f"the recordings cannot be joined by {names}: they correlate by {found.correlation:.2f} at a delay of "
            f"{found.delay_s:.6g} s and by {found.next_correlation:.2f} at {found.next_delay_s:.6g} s; record a single "
            "step or pulse that both loggers see, or state the delay (" + argument("delay_s") + ")"
        )


def sample_period_s(recording: Recording) -> float:
    return float(np.median(np.diff(recording["time_s"])))


def _cut(recording: Recording, low_s: float, high_s: float) -> Recording:
    start, stop = np.searchsorted(recording["time_s"], (low_s, high_s))
    return recording.between(int(start), int(stop))
