"""Two recordings of one experiment by loggers with different clocks: their delay by correlation, and one recording.

Both recorded something in common: a command, a step, or two columns that follow each other.
"""

from __future__ import annotations

from datetime import datetime
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError, argument
from musclewire.identify._clock_delays import delay_of, require_determined, sample_period_s, steady_deviations
from musclewire.signals import MetadataValue, Recording, follows_from, known_column

# Sample periods: in a longer gap nothing shows that a straight line holds.
MAX_GAP_PERIODS = 3.0


class JoinedRecordings(NamedTuple):
    """Two recordings on the clock of the first."""

    recording: Recording  # columns of both, at the times of the first recording that both have
    # Time by which the second clock is ahead: what happens at t on the first is at t + delay on the second.
    delay_s: float
    delay_std_s: float | None  # None for a delay that was given or is that of the clocks
    correlation: float | None  # coefficient of the shared columns at this delay; None if no column was compared
    columns: tuple[str, ...]  # the shared column of the first recording and that of the second
    notes: tuple[str, ...]  # how it was done, a sentence each
    rate: float = 1.0  # seconds of the second clock in one of the first: 1, since clocks that drift apart are refused
    rate_std: float = 0.0  # by the delays of both halves; 0 where these are not known
    how: str = ""  # in words, where no column was compared


def join_recordings(
    first: Recording, second: Recording, on: str | tuple[str, str] | None = None, delay_s: float | None = None
) -> JoinedRecordings:
    """Join two recordings of one experiment: by one clock, by a delay that is given, or by a column of both.

    Recordings of one clock, ``on="time_s"``, have no delay but that of their beginnings, as their metadata state them.
    Otherwise the delay is that at which the correlation of a column of each, ``on``, by default the only shared one, is
    largest; its deviation follows from the peak's curvature, the noise left and the sample periods. Clocks that drift
    apart are refused. The second's columns come to the first's times by means where it was sampled faster, else by
    straight lines. Raises CallerError if ``on`` has to be given, or names a column that a recording lacks. Raises
    RecordingError if the correlation does not determine the delay, or the clocks drift apart.
    """
    if delay_s is not None:
        return _by_delay(first, second, delay_s, "as given")
    if on in {"time_s", ("time_s", "time_s")}:
        return _by_delay(first, second, _clock_delay_s(first, second) or 0.0, "by one clock")
    both = [name for name in first.names if name in second and name != "time_s"]
    if on is None and len(both) != 1 and (clock_s := _clock_delay_s(first, second)) is not None:
        return _by_delay(first, second, clock_s, "by their clocks, which count from one moment")
    pair = _shared(first, second, on)
    found = delay_of(first, second, pair)
    std_s, rate_std, note = steady_deviations(first, second, pair, found)
    require_determined(found, pair)
    recording, notes = _resampled(first, second, found.delay_s)
    metadata: dict[str, MetadataValue] = {
        "join_delay_s": found.delay_s,
        "join_delay_std_s": std_s,
        "join_correlation": found.correlation,
        "join_columns": f"{pair[0]}, {pair[1]}",
    }
    joined, all_notes = recording.with_metadata(metadata), (*notes, note)
    return JoinedRecordings(joined, found.delay_s, std_s, found.correlation, pair, all_notes, rate_std=rate_std)


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


def _resampled(first: Recording, second: Recording, delay_s: float) -> tuple[Recording, tuple[str, ...]]:
    """Return both recordings on the first one's rows, and how that was done."""
    metadata = {**second.with_minor_loop.metadata, **first.metadata}
    begins = follows_from(second.metadata)
    from_s = second.metadata.get(begins)
    if not follows_from(metadata) and len(second.with_minor_loop) > len(second) and isinstance(from_s, (int, float)):
        metadata[begins] = from_s - delay_s
    first, second = first.with_minor_loop, second.with_minor_loop
    time_s, other_s = first["time_s"], second["time_s"] - delay_s
    period_s, other_period_s = sample_period_s(first), sample_period_s(second)
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
