"""What spoils a loop though each of its readings is one: noise, jumps, flat stretches, short cooling, joined clocks.

Everything is judged from the recording alone, before a model and for a recording without a complete loop too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.identify._recordings import circuit_readings, has_current, resistance_reading
from musclewire.sensing import SHOWN_AS, hysteresis_gap, noise_level, turning_points
from musclewire.signals import Recording, reference_quantity

Rows = NDArray[np.intp]

# Fewer rows show no defect of a loop, and a motion of fewer standard deviations of its noise is none.
MIN_ROWS, MOVED_NOISES = 12, 20.0
# Of normal noise, so many standard deviations hold 95 % of the readings: if they are the swing, a reading says nothing.
SCATTER_STDS = 4.0
# The least current is that of this part of the rows, and of so many at least.
LOW_CURRENT_PART, LOW_CURRENT_ROWS = 0.2, 8
# A wire stands still within this part of the stroke from its cold end; motion moves its resistance by as much.
STILL = 0.02
# A jump counts from this part of the swing on, if chance makes one as clear, anywhere, this rarely, and if it explains
# half of what the line leaves: readings of another wire between those of this one leave more.
JUMP_PART, JUMP_CHANCE = 0.1, 1e-4
# Where more of a jump than this could as well be a line over the power, nothing is known.
MIN_APART = 0.05
# Where 1 % of the resistance, the change by some 10 K in martensite, is more than a quarter of the stroke, it is flat.
FLAT_CHANGE = 0.04
# A flat stretch counts from this part of the stroke on; it is looked for in so many parts.
MIN_FLAT, FLAT_PARTS = 0.3, 40
# Cooling ends short from the error on at which a sample counts as wrong, with the current back within this factor.
SHORT, BACK = 0.05, 1.2
# Two clocks that were joined are known to so many standard deviations, and to this time [s] if it is not stated; it
# counts from the part of the gap on that it changes.
DELAY_STDS, UNSTATED_DELAY_S, GAP_CHANGE = 2.0, 0.05, 0.1
# A cycle passes at least this part of the stroke.
CYCLE_PART = 0.5


@dataclass(frozen=True)
class MeasuredLoop:
    """The rows of a recording that are measurements; all arrays are (n_times,).

    Parameters
    ----------
    time_s
        Time [s].
    resistance_ohm
        Resistance [ohm].
    moved
        Strain as a fraction, displacement [m] or force [N].
    current_a
        Current [A]; None if it was not recorded.
    quantity
        What moved.
    """

    time_s: FloatArray
    resistance_ohm: FloatArray
    moved: FloatArray
    current_a: FloatArray | None
    quantity: str

    @property
    def stroke(self) -> float:
        """The range of the motion."""
        return float(np.ptp(self.moved))

    @property
    def swing_ohm(self) -> float:
        """Difference of the mean resistances [ohm] of the cold and of the hot fifth of the stroke."""
        part = (self.moved - self.moved.min()) / self.stroke
        return abs(float(self.resistance_ohm[part < 0.2].mean() - self.resistance_ohm[part > 0.8].mean()))

    @property
    def cycle(self) -> tuple[int, int, int]:
        """Rows of start, hot end and end of the last cycle; without a cooling the last two are one."""
        turns, starts_low = turning_points(self.moved, CYCLE_PART * self.stroke)
        peaks = [place for place in range(len(turns)) if (place % 2 == 0) != starts_low]
        if not peaks:
            return 0, int(np.argmax(self.moved)), self.moved.size - 1
        last = peaks[-1]
        start = turns[last - 1] if last else 0
        end = turns[last + 1] if last + 1 < len(turns) else self.moved.size - 1
        return start, turns[last], end


def recording_defects(recording: Recording, quantity: str, min_stroke: float = 0.0) -> tuple[str, ...]:
    """Return what a recording shows against itself, each with its number; nothing without an instrument of motion.

    Parameters
    ----------
    recording
        A recording with resistance, and with what moved.
    quantity
        "strain", "displacement" or "force".
    min_stroke
        A recording that moves less is not judged: strain as a fraction, displacement [m] or force [N].

    Returns
    -------
    Warnings: that noise at low current drowns the swing of the resistance, that the resistance jumps with the current,
    that it hardly changes over a stretch of the stroke, that cooling ends short of where heating began, and of a
    recording that was joined from two clocks, that the gap is no better known than their delay.
    """
    loop = measured_loop(recording, quantity)
    if loop is None or loop.stroke < min_stroke:
        return ()
    drowned = list(drowning_noise(loop))
    # What noise drowns shows neither jumps nor stretches.
    shown = [] if drowned else [*jump_with_current(loop), *flat_stretch(loop), *joined_clocks(loop, recording)]
    return (*drowned, *shown, *short_cooling(loop))


def measured_loop(recording: Recording, quantity: str) -> MeasuredLoop | None:
    """Return the rows that are measurements; None if they are few, or without a motion beyond its noise."""
    moved = reference_quantity(recording, quantity)
    # A wire that is held at both ends has no loop that could be spoilt.
    if moved is None or "blocked" in recording.facts.load:
        return None
    reading = resistance_reading(recording)
    there = reading.valid & np.isfinite(moved)
    if there.sum() < MIN_ROWS or np.ptp(moved[there]) <= MOVED_NOISES * noise_level(moved[there]):
        return None
    current_a = None
    if has_current(recording):
        read = circuit_readings(recording)
        current_a = np.abs(read.shunt_v[there] / read.shunt_ohm)
    return MeasuredLoop(recording["time_s"][there], reading.resistance_ohm[there], moved[there], current_a, quantity)


def drowning_noise(loop: MeasuredLoop) -> Iterator[str]:
    """Yield that the readings at the least current scatter over the swing of the resistance."""
    if loop.current_a is None:
        return
    order = np.argsort(loop.current_a, kind="stable")
    rows = max(LOW_CURRENT_ROWS, round(LOW_CURRENT_PART * order.size))
    low_ohm, high_ohm = (scatter_ohm(loop.resistance_ohm, part) for part in (order[:rows], order[-rows:]))
    if SCATTER_STDS * low_ohm <= loop.swing_ohm:
        return
    min_ma, max_ma = (1e3 * loop.current_a[order[place]] for place in (0, rows - 1))
    yield (
        f"noise at low current drowns the swing of the resistance: readings at {min_ma:.3g} to {max_ma:.3g} mA "
        f"scatter by {low_ohm:.2g} ohm where it swings by {loop.swing_ohm:.2g} ohm, those at the largest "
        f"current by {high_ohm:.2g} ohm; raise the least current, or average longer"
    )


def scatter_ohm(resistance_ohm: FloatArray, rows: Rows) -> float:
    """Return the standard deviation of single readings in some rows [ohm], by how each leaves its two neighbours."""
    inner = rows[(rows > 0) & (rows < resistance_ohm.size - 1)]
    off = resistance_ohm[inner - 1] - 2.0 * resistance_ohm[inner] + resistance_ohm[inner + 1]
    return float(np.median(np.abs(off))) / 0.6745 / np.sqrt(6.0) if inner.size else 0.0


def jump_with_current(loop: MeasuredLoop) -> Iterator[str]:
    """Yield that the resistance of the cold wire, which stands still, jumps at a current.

    What heats the wire raises its resistance evenly with the power; a jump is what such a line leaves.
    """
    if loop.current_a is None:
        return
    still = loop.moved <= loop.moved.min() + STILL * loop.stroke
    order = np.flatnonzero(still)[np.argsort(loop.current_a[still], kind="stable")]
    if order.size < 6:
        return
    current_a, resistance_ohm = loop.current_a[order], loop.resistance_ohm[order]
    place, jump_ohm, std_ohm = largest_jump(current_a**2, resistance_ohm)
    free = order.size - 3
    errors = max(float(stdtrit(free, 1.0 - 0.5 * JUMP_CHANCE / order.size)), float(np.sqrt(free)))
    if abs(jump_ohm) <= max(JUMP_PART * loop.swing_ohm, errors * std_ohm):
        return
    at_ma = 1e3 * 0.5 * (current_a[place - 1] + current_a[place])
    by_pct, swing_pct = (100.0 * one / resistance_ohm.mean() for one in (jump_ohm, loop.swing_ohm))
    yield (
        f"the resistance jumps by {by_pct:+.1f} %, of a swing of {swing_pct:.1f} %, when the current passes "
        f"{at_ma:.3g} mA while nothing moves: measure at one current, or look for contacts or ranges that change there"
    )


def largest_jump(power: FloatArray, values: FloatArray) -> tuple[int, float, float]:
    """Return before which row of rising power values jump most clearly, by how much, and that jump's standard error.

    Least squares of a line and a jump, for each place of the jump at once.
    """
    count = values.size
    centred = power - power.mean()
    square = float(centred @ centred)
    rest = values - values.mean()
    if square > 0.0:
        rest = rest - centred * float(centred @ rest) / square
    places = np.arange(2, count - 1)
    after = (count - places).astype(np.float64)
    spread = after * (1.0 - after / count)
    line = np.cumsum(centred[::-1])[::-1][places] ** 2 / square if square > 0.0 else 0.0
    apart = spread - line
    known = apart > MIN_APART * spread
    jumps = np.where(known, np.cumsum(rest[::-1])[::-1][places] / np.where(known, apart, 1.0), 0.0)
    gained = jumps**2 * apart
    best = int(np.argmax(gained))
    left = max(float(rest @ rest) - float(gained[best]), 0.0) / (count - 3)
    return int(places[best]), float(jumps[best]), float(np.sqrt(left / max(float(apart[best]), 1e-300)))


def flat_stretch(loop: MeasuredLoop) -> Iterator[str]:
    """Yield over which stretch of the stroke, beyond the maximum, the resistance hardly changes on a branch."""
    start, peak, end = loop.cycle
    low, stroke = float(loop.moved.min()), loop.stroke
    found = []
    for rows in (slice(start, peak + 1), slice(peak, end + 1)):
        part, ohm = course_of((loop.moved[rows] - low) / stroke, loop.resistance_ohm[rows])
        found.append(longest_flat(part, ohm))
    first, last, change = max(found, key=lambda one: one[1] - one[0])
    if last - first < MIN_FLAT:
        return
    factor, unit = SHOWN_AS[loop.quantity]
    ends = " to ".join(f"{factor * (low + place * stroke):.3g}" for place in (first, last))
    yield (
        f"the resistance hardly changes, by {100 * change:.1f} %, over {100 * (last - first):.0f} % of the stroke, "
        f"{ends} {unit}: one reading stands for many positions there; sense outside of it, or use another wire or load"
    )


def course_of(part: FloatArray, resistance_ohm: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the mean part of the stroke and resistance [ohm] in each of the equal parts that have rows."""
    place = np.minimum((part * FLAT_PARTS).astype(int), FLAT_PARTS - 1)
    rows = np.bincount(place, minlength=FLAT_PARTS)
    there = rows > 0
    means = [np.bincount(place, values, FLAT_PARTS)[there] / rows[there] for values in (part, resistance_ohm)]
    return means[0], means[1]


def longest_flat(part: FloatArray, resistance_ohm: FloatArray) -> tuple[float, float, float]:
    """Return where the longest flat stretch begins and ends, and by which fraction the resistance changes in it."""
    best = (0.0, 0.0, 0.0)
    for first in range(int(np.argmax(resistance_ohm)), part.size - 1):
        inside = resistance_ohm[first:]
        change = (np.maximum.accumulate(inside) - np.minimum.accumulate(inside)) / inside[0]
        length = part[first:] - part[first]
        flat = np.flatnonzero(change <= FLAT_CHANGE * length)
        if flat.size and length[flat[-1]] > best[1] - best[0]:
            best = (float(part[first]), float(part[first + flat[-1]]), float(change[flat[-1]]))
    return best


def short_cooling(loop: MeasuredLoop) -> Iterator[str]:
    """Yield by how much cooling ends short of where heating began, though the current is back."""
    start, peak, end = loop.cycle
    if not start < peak < end:
        return
    current_a = loop.current_a
    if current_a is not None and current_a[end] > BACK * current_a[: peak + 1].min():
        return
    short = float(loop.moved[end] - loop.moved[start])
    if short < SHORT * loop.stroke:
        return
    factor, unit = SHOWN_AS[loop.quantity]
    yield (
        f"cooling ends {factor * short:.3g} {unit}, {100 * short / loop.stroke:.0f} % of the stroke, short of where "
        "heating began: let it cool longer; if it rests there, train the wire or look for friction"
    )


def joined_clocks(loop: MeasuredLoop, recording: Recording) -> Iterator[str]:
    """Yield by how much the gap changes within what is known of the delay between two clocks that were joined."""
    facts = recording.facts
    if facts.number_or_none("join_delay_s") is None:
        return
    std_s = facts.number_or_none("join_delay_std_s")
    off_s = UNSTATED_DELAY_S if std_s is None else DELAY_STDS * std_s
    try:
        gap, *others = (gap_with_delay(loop, delay_s) for delay_s in (0.0, -off_s, off_s))
    except RecordingError:  # no two branches, and so no gap
        return
    if max(abs(other - gap) for other in others) <= GAP_CHANGE * gap:
        return
    known = "of no stated deviation" if std_s is None else f"known to {1e3 * std_s:.3g} ms"
    yield (
        f"two clocks were joined by a delay {known}; with {1e3 * off_s:.3g} ms more or less the gap between heating "
        f"and cooling is {100 * min(others):.2g} to {100 * max(others):.2g} % of the stroke; sweep more slowly, or "
        "record both with one instrument"
    )


def gap_with_delay(loop: MeasuredLoop, delay_s: float) -> float:
    """Return the gap of the last cycle over the stroke as it were with the motion so much [s] later."""
    start, peak, end = loop.cycle
    moved = np.interp(loop.time_s - delay_s, loop.time_s, loop.moved)
    # From B to C: before the maximum of the resistance one reading stands for two positions.
    first = start + int(np.argmax(loop.resistance_ohm[start : peak + 1]))
    last = peak + int(np.argmax(loop.resistance_ohm[peak : end + 1]))
    warm, cool = slice(first, peak + 1), slice(peak, last + 1)
    heating, cooling = ((loop.resistance_ohm[rows], moved[rows]) for rows in (warm, cool))
    return hysteresis_gap(heating, cooling, maximum=loop.stroke)
