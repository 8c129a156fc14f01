"""Two recordings of one experiment by loggers with different clocks: their delay by correlation, and one recording.

Both recorded something in common: a command, a step, or two columns that follow each other.
"""

from __future__ import annotations

import itertools
from datetime import datetime
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError, argument
from musclewire.signals._columns import known_column
from musclewire.signals._metadata import MetadataValue
from musclewire.signals._recording import Recording, follows_from

# Below this correlation the two columns do not show the same thing.
MIN_CORRELATION = 0.7
# Correlations elsewhere must be lower by this, or the delay could as well be there.
MIN_MARGIN = 0.05
# Delays are tried that leave this fraction of the shorter recording in common.
MIN_OVERLAP = 0.3
# Both recordings on one grid: more points take memory and show no more.
MAX_POINTS = 1 << 21
# Parts of the recordings of which each shows the delay by itself: a clock that drifts shows another one in each.
PARTS = 4
# A gap of so many sample periods is no place for a straight line.
MAX_GAP_PERIODS = 3.0
# Clocks of instruments that differ by more have another cause. At so many points a rate between two of these moves no
# event by more than a point or two.
RATES = np.linspace(0.97, 1.03, 121)
COARSE_POINTS = 1 << 13


class JoinedRecordings(NamedTuple):
    """Two recordings on the clock of the first.

    Parameters
    ----------
    recording
        Columns of both, at the times of the first recording that both have.
    delay_s
        Time by which the second clock is ahead [s]: what happens at t on the first is at t + delay on the second.
    delay_std_s
        Its standard deviation [s]; None for a delay that was given or is that of the clocks.
    correlation
        Coefficient of correlation of the shared columns at this delay; None if no column was compared.
    columns
        The shared column of the first recording and that of the second.
    notes
        How it was done, a sentence each.
    rate
        Seconds of the second clock in one of the first; 1 by default, for clocks that do not drift apart. What happens
        at t on the first is at rate t + delay on the second.
    rate_std
        Its standard deviation; 0 by default, for a rate of 1.
    how
        In words, where no column was compared; "" by default.
    """

    recording: Recording
    delay_s: float
    delay_std_s: float | None
    correlation: float | None
    columns: tuple[str, ...]
    notes: tuple[str, ...]
    rate: float = 1.0
    rate_std: float = 0.0
    how: str = ""


class _Delay(NamedTuple):
    """The peak of the correlation, its delay's standard deviation [s], and notes on the parts."""

    peak: _CorrelationPeak
    std_s: float
    notes: tuple[str, ...]


class _CorrelationPeak(NamedTuple):
    """The best delay [s] of two series, its correlation, the best elsewhere, and the delay of that [s]."""

    delay_s: float
    correlation: float
    next_correlation: float
    next_delay_s: float


class _DelayOfPart(NamedTuple):
    """The middle of a part on the first clock, its delay, and the standard deviation of that [s]."""

    middle_s: float
    delay_s: float
    std_s: float


def join_recordings(
    first: Recording, second: Recording, on: str | tuple[str, str] | None = None, delay_s: float | None = None
) -> JoinedRecordings:
    """Join two recordings of one experiment: by one clock, by a delay that is given, or by a column of both.

    Recordings of one clock, ``on="time_s"``, have no delay but that of their beginnings, as ``start_time`` or
    ``clock_start_s`` in their metadata state them. Otherwise the delay is that at which the coefficient of correlation
    of what both recorded is largest; its standard deviation is the largest of three: that of the fit, that over parts
    of the recordings, and that of the sample periods. Clocks that drift apart, by up to 3 %, are joined by their rate.
    Columns of the second recording come to the times of the first by means over the first's sample period where the
    second was sampled faster, and by straight lines where it was slower.

    Parameters
    ----------
    first
        The recording whose clock and rows are kept.
    second
        The other one; columns that the first has, too, are left out.
    on
        The shared column, or the first's and the second's, such as ``("drive_voltage_v", "wire_voltage_v")``, or
        "time_s" for one clock. None, the default, takes the only column that both have, or else clocks that count from
        one moment.
    delay_s
        The delay [s] where nothing in the recordings shows it; None by default.

    Returns
    -------
    The joined recording, with the delay and its uncertainty.

    Raises
    ------
    CallerError
        If ``on`` has to be given, or names a column that a recording lacks.
    RecordingError
        If the correlation does not determine the delay, or the clocks drift apart.
    """
    if delay_s is not None:
        return _by_delay(first, second, delay_s, "as given")
    if on in {"time_s", ("time_s", "time_s")}:
        return _by_delay(first, second, _clock_delay_s(first, second) or 0.0, "by one clock")
    both = [name for name in first.names if name in second and name != "time_s"]
    if on is None and len(both) != 1 and (clock_s := _clock_delay_s(first, second)) is not None:
        return _by_delay(first, second, clock_s, "by their clocks, which count from one moment")
    pair = _shared(first, second, on)
    step_s = max(_period_s(first), _period_s(second), (first.duration_s + second.duration_s) / MAX_POINTS) / 2.0
    rate, rate_std = 1.0, 0.0
    try:
        found = _delay_of(first, second, pair, step_s)
    except RecordingError as problem:
        rates = _rate_of(first, second, pair, step_s)
        if rates is None:
            raise problem from None
        rate, rate_std = rates
        second = second.with_columns(time_s=second["time_s"] / rate)
        found = _delay_of(first, second, pair, step_s)
    delay_s, std_s = rate * found.peak.delay_s, rate * found.std_s
    recording, notes = _resampled(first, second, found.peak.delay_s)
    metadata: dict[str, MetadataValue] = {
        "join_delay_s": delay_s,
        "join_delay_std_s": std_s,
        "join_correlation": found.peak.correlation,
        "join_columns": f"{pair[0]}, {pair[1]}",
        **({"join_rate": rate, "join_rate_std": rate_std} if rate != 1.0 else {}),
    }
    joined, all_notes = recording.with_metadata(metadata), (*notes, *found.notes)
    return JoinedRecordings(joined, delay_s, std_s, found.peak.correlation, pair, all_notes, rate, rate_std)


def _by_delay(first: Recording, second: Recording, delay_s: float, how: str) -> JoinedRecordings:
    """Return recordings joined by a delay that is known and not found."""
    recording, notes = _resampled(first, second, delay_s)
    metadata: dict[str, MetadataValue] = {"join_delay_s": delay_s, "join_how": how}
    return JoinedRecordings(recording.with_metadata(metadata), delay_s, None, None, (), notes, how=how)


def _clock_delay_s(first: Recording, second: Recording) -> float | None:
    """Return the delay [s] of recordings whose clocks count from one moment; None if their metadata do not say so."""
    one, other = (recording.metadata.get("clock_start_s") for recording in (first, second))
    if isinstance(one, float) and isinstance(other, float):
        return one - other
    dates = [recording.metadata.get("start_time") for recording in (first, second)]
    try:
        began = [datetime.fromisoformat(str(date)) for date in dates]
        return (began[0] - began[1]).total_seconds()
    except (ValueError, TypeError):
        return None


def _delay_of(first: Recording, second: Recording, pair: tuple[str, str], step_s: float) -> _Delay:
    """Return the delay by correlation. Raises RecordingError if it is not determined, or the clocks drift apart."""
    peak = _peak(first, second, pair, step_s)
    _require_determined(peak, pair)
    return _Delay(peak, *_uncertainty_s(first, second, pair, peak, step_s))


def _rate_of(first: Recording, second: Recording, pair: tuple[str, str], step_s: float) -> tuple[float, float] | None:
    """Return the rate of the second clock and its standard deviation, None if the parts do not show one."""
    from scipy.optimize import least_squares

    def at_rate(rate: float) -> Recording:
        return second.with_columns(time_s=second["time_s"] / rate)

    coarse_s = max(step_s, (first.duration_s + second.duration_s) / COARSE_POINTS)
    tried = [_peak(first, at_rate(rate), pair, coarse_s) for rate in RATES]
    best = int(np.argmax([peak.correlation for peak in tried]))
    if tried[best].correlation < MIN_CORRELATION:
        return None
    rate = float(RATES[best])
    delay_s = rate * _peak(first, at_rate(rate), pair, step_s).delay_s
    time_s, one = first["time_s"], first[pair[0]]

    def apart(line: FloatArray) -> FloatArray:
        """Return what is left of the first column after the second one, whose clock is such a line, scaled to it."""
        other = np.interp(line[0] * time_s + line[1], second["time_s"], second[pair[1]])
        inside = (line[0] * time_s + line[1] >= second["time_s"][0]) & (
            line[0] * time_s + line[1] <= second["time_s"][-1]
        )
        gain, offset = np.polyfit(other[inside], one[inside], 1)
        return np.where(inside, one - gain * other - offset, 0.0)

    duration_s = min(first.duration_s, second.duration_s)
    found = least_squares(apart, (rate, delay_s), x_scale=(coarse_s / duration_s, coarse_s), diff_step=(1e-5, 1e-5))
    # An event is somewhere between two samples of each recording, at both ends.
    resolution_s = float(np.hypot(_period_s(first), _period_s(second)) / np.sqrt(3.0))
    return float(found.x[0]), resolution_s / duration_s


def _shared(first: Recording, second: Recording, on: str | tuple[str, str] | None) -> tuple[str, str]:
    """Return the shared columns. CallerError if they are not there or not the only ones."""
    if on is not None:
        pair = (on, on) if isinstance(on, str) else on
        for name, recording, which in zip(pair, (first, second), ("first", "second"), strict=True):
            known_column(name)
            if name not in recording:
                raise CallerError(f"the {which} recording has no {name}; it has {', '.join(recording.names)}")
        return pair
    both = [name for name in first.names if name in second and name != "time_s"]
    if len(both) == 1:
        return both[0], both[0]
    what = f"both have {', '.join(both)}" if both else "they have no column in common"
    raise CallerError(
        f"{what}: name the columns by which to join, as drive_voltage_v, or drive_voltage_v=wire_voltage_v for two "
        "that follow each other (" + argument("on") + ")"
    )


def _period_s(recording: Recording) -> float:
    return float(np.median(np.diff(recording["time_s"])))


def _on_grid(recording: Recording, name: str, step_s: float) -> FloatArray:
    """Return a column at equal steps, each the nearest sample."""
    # Straight lines would smooth the noise between samples, and the best delay would be one that smooths most of it.
    time_s = recording["time_s"]
    count = int((time_s[-1] - time_s[0]) / step_s) + 1
    edges = (time_s[1:] + time_s[:-1]) / 2
    return np.asarray(recording[name][np.searchsorted(edges, time_s[0] + step_s * np.arange(count))], dtype=np.float64)


def _peak(first: Recording, second: Recording, pair: tuple[str, str], step_s: float) -> _CorrelationPeak:
    """Return where two recordings correlate best, as a delay of the second clock."""
    one, other = _on_grid(first, pair[0], step_s), _on_grid(second, pair[1], step_s)
    for series, name in zip((one, other), pair, strict=True):
        if np.ptp(series) <= 1e-12 * max(1.0, float(np.abs(series).max())):
            raise RecordingError(f"{name} does not change, and shows no delay of the clocks; name another column")
    coefficients, lags = _correlations(one, other)
    # Two different columns may have opposite signs; the same one has not.
    strength = coefficients if pair[0] == pair[1] else np.abs(coefficients)
    best = int(np.argmax(strength))
    start_s = float(second["time_s"][0] - first["time_s"][0])
    delay_s = start_s + step_s * (float(lags[best]) + _vertex(strength, best))
    elsewhere = _outside_main_peak(strength, best)
    after = int(np.argmax(elsewhere))
    return _CorrelationPeak(
        delay_s, float(strength[best]), float(elsewhere[after]), start_s + step_s * float(lags[after])
    )


def _correlations(one: FloatArray, other: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return Pearson's coefficient over the common part for each lag of the other series behind the first."""
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
    enough &= spread_one > 0.2 * counts / one.size * float(one @ one)
    enough &= spread_other > 0.2 * counts / other.size * float(other @ other)
    safe = np.where(enough, spread_one * spread_other, 1.0)
    return np.where(enough, covariance / np.sqrt(safe), 0.0), lags


def _vertex(values: FloatArray, index: int) -> float:
    """Return the offset of a parabola's vertex through three points around a maximum, within half a step."""
    if not 0 < index < values.size - 1:
        return 0.0
    before, top, after = (float(values[index + step]) for step in (-1, 0, 1))
    bend = before - 2.0 * top + after
    return 0.0 if bend >= 0.0 else float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5))


def _outside_main_peak(strength: FloatArray, best: int) -> FloatArray:
    """Return the correlations without the main peak, which reaches as far as they are nearly as good."""
    good = strength > strength[best] - 2.0 * MIN_MARGIN
    low = best - int(np.argmin(good[best::-1])) if not good[: best + 1].all() else 0
    high = best + int(np.argmin(good[best:])) if not good[best:].all() else strength.size - 1
    outside = strength.copy()
    outside[low : high + 1] = 0.0
    return outside


def _require_determined(peak: _CorrelationPeak, pair: tuple[str, str]) -> None:
    """Raise RecordingError unless there is one delay at which the columns correlate, and no other."""
    names = " and ".join(dict.fromkeys(pair))
    if peak.correlation < MIN_CORRELATION:
        raise RecordingError(
            f"the recordings cannot be joined by {names}: their correlation is {peak.correlation:.2f} at best, at "
            f"least {MIN_CORRELATION} is needed; name columns that follow each other"
        )
    if peak.next_correlation > peak.correlation - MIN_MARGIN:
        raise RecordingError(
            f"the recordings cannot be joined by {names}: they correlate by {peak.correlation:.2f} at a delay of "
            f"{peak.delay_s:.6g} s and by {peak.next_correlation:.2f} at {peak.next_delay_s:.6g} s; record a single "
            "step or pulse that both loggers see, or state the delay (" + argument("delay_s") + ")"
        )


def _uncertainty_s(
    first: Recording, second: Recording, pair: tuple[str, str], peak: _CorrelationPeak, step_s: float
) -> tuple[float, tuple[str, ...]]:
    """Return the delay's standard deviation [s], and a note on the parts. Raises RecordingError if the clocks drift."""
    # An event is somewhere between two samples of each recording: uniform distributions of one sample period each way.
    resolution_s = float(np.hypot(_period_s(first), _period_s(second)) / np.sqrt(3.0))
    std_s = max(resolution_s, _fit_std_s(first, second, pair, peak, step_s))
    parts = _delays_of_parts_s(first, second, pair, peak, step_s)
    if len(parts) < 2:
        return std_s, ("the recordings have one event in common: whether the clocks drift is not known",)
    delays_s = [part.delay_s for part in parts]
    drift_s, drift_std_s = delays_s[-1] - delays_s[0], float(np.hypot(parts[0].std_s, parts[-1].std_s))
    if abs(drift_s) > 4.0 * drift_std_s + 2.0 * resolution_s:
        raise RecordingError(
            f"the clocks drift apart: the delay is {delays_s[0]:.6g} s at the beginning and {delays_s[-1]:.6g} s at "
            "the end; cut both recordings into shorter parts and join these"
        )
    std_s = max(std_s, float(np.std(delays_s, ddof=1) / np.sqrt(len(delays_s))))
    return std_s, (f"{len(parts)} parts by themselves have delays from {min(delays_s):.6g} to {max(delays_s):.6g} s",)


def _fit_std_s(
    first: Recording, second: Recording, pair: tuple[str, str], peak: _CorrelationPeak, step_s: float
) -> float:
    """Return the delay's standard deviation [s] by least squares: noise over slope; noise may last over samples."""
    time_s = first["time_s"]
    shifted = np.interp(time_s + peak.delay_s, second["time_s"], second[pair[1]], left=np.nan, right=np.nan)
    common = np.isfinite(shifted)
    one, other = first[pair[0]][common], shifted[common]
    gain, offset = np.polyfit(other, one, 1)
    residual = one - gain * other - offset
    # The product of both slopes: noise, which only one of them has, adds nothing to it.
    slopes = np.gradient(one, time_s[common]), np.gradient(gain * other, time_s[common])
    power = float(slopes[0] @ slopes[1])
    lasting = float(residual[1:] @ residual[:-1] / max(float(residual @ residual), 1e-300))
    inflation = (1.0 + abs(lasting)) / max(1.0 - abs(lasting), 1e-3)
    return float(np.sqrt(inflation * residual.var() / power)) if power > 0.0 else step_s


def _delays_of_parts_s(
    first: Recording, second: Recording, pair: tuple[str, str], peak: _CorrelationPeak, step_s: float
) -> list[_DelayOfPart]:
    """Return delay and standard deviation [s] of each part of the recordings that determines a delay by itself."""
    time_s = first["time_s"]
    begin = max(time_s[0], second["time_s"][0] - peak.delay_s)
    end = min(time_s[-1], second["time_s"][-1] - peak.delay_s)
    edges = np.linspace(begin, end, PARTS + 1)
    found: list[_DelayOfPart] = []
    for low, high in itertools.pairwise(edges):
        margin = 0.5 * (high - low)
        one = _cut(first, low, high)
        other = _cut(second, low + peak.delay_s - margin, high + peak.delay_s + margin)
        if len(one) < 8 or len(other) < 8 or np.ptp(one[pair[0]]) < 0.3 * np.ptp(first[pair[0]]):
            continue
        part = _peak(one, other, pair, step_s)
        if part.correlation >= MIN_CORRELATION and part.next_correlation <= part.correlation - MIN_MARGIN:
            std_s = _fit_std_s(one, other, pair, part, step_s)
            found.append(_DelayOfPart(0.5 * (low + high), part.delay_s, std_s))
    return found


def _cut(recording: Recording, low_s: float, high_s: float) -> Recording:
    start, stop = np.searchsorted(recording["time_s"], (low_s, high_s))
    return recording.between(int(start), int(stop))


def _resampled(first: Recording, second: Recording, delay_s: float) -> tuple[Recording, tuple[str, ...]]:
    """Return both recordings on the first one's rows, and how that was done."""
    metadata = {**second.with_minor_loop.metadata, **first.metadata}
    begins = follows_from(second.metadata)
    from_s = second.metadata.get(begins)
    if not follows_from(metadata) and len(second.with_minor_loop) > len(second) and isinstance(from_s, (int, float)):
        metadata[begins] = from_s - delay_s
    first, second = first.with_minor_loop, second.with_minor_loop
    time_s, other_s = first["time_s"], second["time_s"] - delay_s
    period_s, other_period_s = _period_s(first), _period_s(second)
    names = [name for name in second.names if name != "time_s" and name not in first]
    if not names:
        raise CallerError(
            f"the second recording adds no column: both have {', '.join(second.names)}; use one of them alone"
        )
    keep = (time_s >= other_s[0]) & (time_s <= other_s[-1])
    after = np.clip(np.searchsorted(other_s, time_s), 1, other_s.size - 1)
    keep &= other_s[after] - other_s[after - 1] <= MAX_GAP_PERIODS * max(other_period_s, period_s)
    if keep.sum() < 2:
        raise RecordingError(f"the recordings have no time in common at a delay of {delay_s:.6g} s; check the files")
    faster = other_period_s < 0.7 * period_s
    edges = np.concatenate(([time_s[0] - period_s / 2], (time_s[1:] + time_s[:-1]) / 2, [time_s[-1] + period_s / 2]))
    columns = {name: first[name][keep] for name in first.names}
    for name in names:
        straight = np.interp(time_s, other_s, second[name])
        columns[name] = (_means(edges, other_s, second[name], straight) if faster else straight)[keep]
    how = "means over the first file's sample period" if faster else "straight lines between its samples"
    same = [name for name in second.names if name != "time_s" and name in first]
    notes = (
        f"{', '.join(names)} of the second file, sampled every {other_period_s:.6g} s, by {how} ({period_s:.6g} s)",
        f"{int(keep.sum())} of {keep.size} rows kept: those within the second file and not in a gap of it",
        *((f"{', '.join(same)} taken from the first file",) if same else ()),
    )
    return Recording(columns, metadata), notes


def _means(edges: FloatArray, time_s: FloatArray, values: FloatArray, otherwise: FloatArray) -> FloatArray:
    """Return the mean of a series' samples between each two edges, or another value if there is no sample."""
    counts = np.diff(np.searchsorted(time_s, edges))
    sums = np.diff(np.concatenate(([0.0], np.cumsum(values)))[np.searchsorted(time_s, edges)])
    return np.where(counts > 0, sums / np.maximum(counts, 1), otherwise)
