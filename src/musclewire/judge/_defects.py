"""What spoils a loop though each of its readings is one: noise, steps, jumps, flat stretches, short cooling, clocks.

And rows that somebody put between the measured ones by straight lines. Everything is judged from the recording alone,
before a model and for a recording without a complete loop too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.judge._findings import remedies
from musclewire.judge._lone_readings import MOTION
from musclewire.judge._readings import JudgedRecording, resistance_reading
from musclewire.judge._unusable_readings import judge_readings
from musclewire.sensing import SHOWN_AS, hysteresis_gap, noise_level, turning_points
from musclewire.signals import (
    COLUMN_SUFFIX,
    COLUMNS,
    Recording,
    RunFacts,
    asked_once,
    reference_quantity,
)

Rows = NDArray[np.intp]
# The numbers of a defect by their names in its sentence, with their units and words; None without one.
Numbers = Mapping[str, float | str] | None

MIN_ROWS = 12  # rows of a loop: fewer show no defect
MOVED_NOISES = 20.0  # standard deviations of the noise: a smaller range of the instrument is no motion
# Standard deviations: 95 % of normal noise lies within an interval of this length; if that is the swing of the
# resistance, a reading determines no strain.
SCATTER_STDS = 4.0
# A step of a column over its value: resistance changes by some 10 % from B to C, so larger steps resolve it coarsely.
COARSE_PART = 0.05
FOLLOWED = 0.5  # least relative change of resistance over that of the column: a step of the drive would change both
LOW_CURRENT_PART = 0.2  # of all rows, those with the least current, whose scatter is that of low current
LOW_CURRENT_ROWS = 8  # rows that are taken at least: fewer determine no scatter
# A wire stands still within this part of the stroke from its cold end; motion moves its resistance by as much.
STILL = 0.02
JUMP_PART = 0.1  # of the swing of the resistance: a smaller jump at a change of range spoils no loop
# The probability that noise has as clear a jump anywhere. The jump must also explain half of what a line leaves:
# readings of another wire between those of this one leave more.
JUMP_CHANCE = 1e-4
# Where more of a jump than this could as well be a line over the power, nothing is known.
MIN_APART = 0.05
# Where 1 % of the resistance, the change by some 10 K in martensite, is more than a quarter of the stroke, it is flat.
FLAT_CHANGE = 0.04
MIN_FLAT = 0.3  # of the stroke: a shorter flat stretch is no defect
FLAT_PARTS = 40  # equal parts of the stroke over which readings are averaged before a flat stretch is searched
SHORT = 0.05  # of the stroke, by which cooling ends short: an error from which on a sample counts as wrong
BACK = 1.2  # current at the end over the least one before: at more the wire is still heated, and has not cooled
DELAY_STDS = 2.0  # standard deviations of the delay between two joined clocks, by which it may be wrong
UNSTATED_DELAY_S = 0.05  # [s] by which it may be wrong if the recording states no standard deviation; chosen
GAP_CHANGE = 0.1  # of the hysteresis gap: a delay that changes it by less does no harm
# A cycle passes at least this part of the stroke.
CYCLE_PART = 0.5
# A row is on the line between its neighbours within this part of its column's range: a file of seven digits or more
# shows it, and a converter's step is larger by far.
STRAIGHT_PART = 1e-6
MIN_SPACING = 5  # rows from one measured row to the next: smaller spacings are not taken for interpolation
REGULAR_PART = 0.9  # of the spacings must be near their median: interpolation puts in about as many rows each time
UNEVEN_PART = 0.25  # of the median spacing: how far a spacing may differ from it and still be near, or one row
# The largest spacing over the median one: in a larger gap measured rows would be left out.
MAX_SPACING_PART = 3.0
OUTER_PERCENT = 10.0  # of the bends of a curve at either end, left out so that no single reading decides
# The largest bend over the smallest. Lines between measured readings bend by anything; a converter bends a steady
# slope by one of its steps, or by two.
MIN_DIFFERENT = 4.0
ELECTRICAL = ("wire_resistance_ohm", "wire_voltage_v", "shunt_voltage_v", "wire_current_a")
# Fewer measured rows than this show no rule.
MIN_MEASURED = 12


@dataclass(frozen=True)
class MeasuredLoop:
    """The rows of a recording that are measurements; all arrays are (n_times,)."""

    time_s: FloatArray
    resistance_ohm: FloatArray
    moved: FloatArray  # strain as a fraction, displacement [m] or force [N]
    current_a: FloatArray | None
    source: tuple[str, ...]  # the columns from which resistance follows
    quantity: str
    facts: RunFacts

    @cached_property
    def stroke(self) -> float:
        """The range of the motion."""
        return float(np.ptp(self.moved))

    @cached_property
    def swing_ohm(self) -> float:
        """Difference of the mean resistances [ohm] of the cold and of the hot fifth of the stroke."""
        part = (self.moved - self.moved.min()) / self.stroke
        return abs(float(self.resistance_ohm[part < 0.2].mean() - self.resistance_ohm[part > 0.8].mean()))

    @cached_property
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


def measured_loop(recording: Recording, quantity: str) -> MeasuredLoop | None:
    """Return the rows that are measurements; None if they are few, or without a motion beyond its noise."""
    moved = reference_quantity(recording, quantity)
    # A wire that is held at both ends has no loop that could be spoilt.
    if moved is None or "blocked" in recording.facts.load:
        return None
    judged = asked_once(recording, JudgedRecording)
    reading = judged.reading
    there = reading.valid & np.isfinite(moved)
    if there.sum() < MIN_ROWS or np.ptp(moved[there]) <= MOVED_NOISES * noise_level(moved[there]):
        return None
    current_a = None
    if judged.has_current:
        current_a = np.abs(judged.circuit.shunt_v[there] / judged.circuit.shunt_ohm)
    columns = recording["time_s"][there], reading.resistance_ohm[there], moved[there]
    return MeasuredLoop(*columns, current_a, judged.source, quantity, recording.facts)


def drowning_noise(loop: MeasuredLoop) -> Numbers:
    """Return how the readings at the least current scatter over the swing of the resistance."""
    if loop.current_a is None:
        return None
    order = np.argsort(loop.current_a, kind="stable")
    rows = max(LOW_CURRENT_ROWS, round(LOW_CURRENT_PART * order.size))
    low_ohm, high_ohm = (scatter_ohm(loop.resistance_ohm, part) for part in (order[:rows], order[-rows:]))
    if SCATTER_STDS * low_ohm <= loop.swing_ohm:
        return None
    min_ma, max_ma = (1e3 * loop.current_a[order[place]] for place in (0, rows - 1))
    return {"min_ma": min_ma, "max_ma": max_ma, "low": low_ohm, "high": high_ohm, "swing": loop.swing_ohm}


def coarse_steps(loop: MeasuredLoop) -> Numbers:
    """Return the step of a column that is recorded so coarsely that its steps are those of the resistance."""
    columns = {loop.source[-1]: loop.resistance_ohm}
    if len(loop.source) > 1 and loop.current_a is not None:
        columns = {loop.source[-1]: loop.current_a, loop.source[0]: loop.current_a * loop.resistance_ohm}
    for name, values in columns.items():
        digits = np.unique(np.round(values / (1e-9 * np.abs(values).max())))
        if digits.size < 2:
            continue
        step = 1e-9 * float(np.abs(values).max() * np.quantile(np.diff(digits), 0.1))
        part = step / float(np.median(np.abs(values)))
        change, size = np.abs(np.diff(values)), np.abs(values[1:])
        stepped = (change > 0.5 * step) & (size > 0.0)
        change_ohm = np.abs(np.diff(loop.resistance_ohm)) / loop.resistance_ohm[1:]
        if part > COARSE_PART and np.median(change_ohm[stepped] / (change / size)[stepped]) > FOLLOWED:
            return {
                "name": name,
                "step": step,
                "unit": COLUMNS[name].unit,
                "count": np.ptp(values) / step,
                "pct": 100 * part,
            }
    return None


def scatter_ohm(resistance_ohm: FloatArray, rows: Rows) -> float:
    """Return the standard deviation of single readings in some rows [ohm], by how each leaves its two neighbours."""
    inner = rows[(rows > 0) & (rows < resistance_ohm.size - 1)]
    off = resistance_ohm[inner - 1] - 2.0 * resistance_ohm[inner] + resistance_ohm[inner + 1]
    return float(np.median(np.abs(off))) / 0.6745 / np.sqrt(6.0) if inner.size else 0.0


def jump_with_current(loop: MeasuredLoop) -> Numbers:
    """Return by how much the cold wire's resistance jumps at a current, beyond its even rise with the power."""
    if loop.current_a is None:
        return None
    still = loop.moved <= loop.moved.min() + STILL * loop.stroke
    order = np.flatnonzero(still)[np.argsort(loop.current_a[still], kind="stable")]
    if order.size < 6:
        return None
    current_a, resistance_ohm = loop.current_a[order], loop.resistance_ohm[order]
    place, jump_ohm, std_ohm = largest_jump(current_a**2, resistance_ohm)
    free = order.size - 3
    errors = max(float(stdtrit(free, 1.0 - 0.5 * JUMP_CHANCE / order.size)), float(np.sqrt(free)))
    if abs(jump_ohm) <= max(JUMP_PART * loop.swing_ohm, errors * std_ohm):
        return None
    at_ma = 1e3 * 0.5 * (current_a[place - 1] + current_a[place])
    by_pct, swing_pct = (100.0 * one / resistance_ohm.mean() for one in (jump_ohm, loop.swing_ohm))
    return {"by_pct": by_pct, "swing_pct": swing_pct, "at_ma": at_ma}


def largest_jump(power: FloatArray, values: FloatArray) -> tuple[int, float, float]:
    """Return where values jump most off their line over a rising power, by how much, and that jump's standard error."""
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


def flat_stretch(loop: MeasuredLoop) -> Numbers:
    """Return over which stretch of the stroke, beyond the maximum, the resistance hardly changes on a branch."""
    start, peak, end = loop.cycle
    low, stroke = float(loop.moved.min()), loop.stroke
    found = []
    for rows in (slice(start, peak + 1), slice(peak, end + 1)):
        part, ohm = course_of((loop.moved[rows] - low) / stroke, loop.resistance_ohm[rows])
        found.append(longest_flat(part, ohm))
    first, last, change = max(found, key=lambda one: one[1] - one[0])
    if last - first < MIN_FLAT:
        return None
    factor, unit = SHOWN_AS[loop.quantity]
    ends = {name: factor * (low + place * stroke) for name, place in (("first", first), ("last", last))}
    return {**ends, "unit": unit, "change_pct": 100 * change, "part_pct": 100 * (last - first)}


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


def short_cooling(loop: MeasuredLoop) -> Numbers:
    """Return by how much cooling ends short of where heating began, though the current is back."""
    start, peak, end = loop.cycle
    if not start < peak < end:
        return None
    current_a = loop.current_a
    if current_a is not None and current_a[end] > BACK * current_a[: peak + 1].min():
        return None
    short = float(loop.moved[end] - loop.moved[start])
    if short < SHORT * loop.stroke:
        return None
    factor, unit = SHOWN_AS[loop.quantity]
    return {"short": factor * short, "unit": unit, "short_pct": 100 * short / loop.stroke}


def joined_clocks(loop: MeasuredLoop) -> Numbers:
    """Return by how much the gap changes within what is known of the delay between two clocks that were joined."""
    if loop.facts.number_or_none("join_delay_s") is None:
        return None
    std_s = loop.facts.number_or_none("join_delay_std_s")
    off_s = UNSTATED_DELAY_S if std_s is None else DELAY_STDS * std_s
    try:
        gap, *others = (gap_with_delay(loop, delay_s) for delay_s in (0.0, -off_s, off_s))
    except RecordingError:  # no two branches, and so no gap
        return None
    if max(abs(other - gap) for other in others) <= GAP_CHANGE * gap:
        return None
    known = "of no stated deviation" if std_s is None else f"known to {1e3 * std_s:.3g} ms"
    return {"known": known, "off_ms": 1e3 * off_s, "least_pct": 100 * min(others), "most_pct": 100 * max(others)}


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


class Defect(NamedTuple):
    """What may spoil a loop: its key, what finds its numbers, and whether it shows where noise drowns the loop, too."""

    key: str
    detect: Callable[[MeasuredLoop], Numbers]
    shows_in_noise: bool


DEFECTS = (
    Defect("coarse_steps", coarse_steps, True),
    Defect("drowning_noise", drowning_noise, True),
    Defect("jump_with_current", jump_with_current, False),
    Defect("flat_stretch", flat_stretch, False),
    Defect("joined_clocks", joined_clocks, False),
    Defect("short_cooling", short_cooling, True),
)


def defects_in(recording: Recording, quantity: str) -> tuple[float, dict[str, str]]:
    """Return the stroke of a recording and what it shows against itself, in one pass over the table."""
    loop, found = measured_loop(recording, quantity), dict[str, str]()
    if loop is None:
        return 0.0, found
    for defect in DEFECTS:
        # All else that a coarse column shows is its steps.
        hidden = "coarse_steps" in found or ("drowning_noise" in found and not defect.shows_in_noise)
        numbers = None if hidden else defect.detect(loop)
        if numbers is not None:
            found[defect.key] = remedies("recording")[defect.key].format(**numbers)
    return loop.stroke, found


# What is asked once of a recording, by the quantity that moved.
BY_QUANTITY = {quantity: partial(defects_in, quantity=quantity) for quantity in COLUMN_SUFFIX}


def recording_defects(recording: Recording, quantity: str, model_stroke: float = 0.0) -> tuple[str, ...]:
    """Return what a recording shows against itself; nothing without motion, or a cycle by the stroke of a model."""
    stroke, found = asked_once(recording, BY_QUANTITY[quantity])
    return tuple(found.values()) if stroke >= CYCLE_PART * model_stroke else ()


def coarse_readings(recording: Recording, quantity: str) -> str:
    """Return that a column is recorded too coarsely for a loop; "" if none is."""
    return asked_once(recording, BY_QUANTITY[quantity])[1].get("coarse_steps", "")


class MeasuredRows(NamedTuple):
    """The rows of a recording that were measured, None for all of them; the recording of these; what is said of it."""

    rows: NDArray[np.intp] | None
    kept: Recording
    said: tuple[str, ...] = ()

    def spread(self, time_s: FloatArray, columns: dict[str, FloatArray]) -> dict[str, FloatArray]:
        """Return columns of these rows for all times, on lines; valid is what lies between valid ones."""
        if self.rows is None:
            return columns
        spread = {name: np.interp(time_s, time_s[self.rows], values) for name, values in columns.items()}
        return spread | {"valid": np.floor(spread["valid"])}


def measured_rows(recording: Recording) -> MeasuredRows:
    """Return which rows have measured motion, not interpolated. Raises RecordingError if those are the lesser part."""
    rows, n_times = asked_once(recording, rows_between_lines), len(recording)
    moved, said = asked_once(recording, judged_motion)
    if rows is None and moved.all():
        return MeasuredRows(None, recording)
    if rows is not None:
        lines = f"{n_times - rows.size} of {n_times} rows lie on straight lines between the {rows.size} that were "
        said = (*said, lines + "measured, and say nothing of their own: all is judged at those that were measured")
    rows = np.flatnonzero(moved) if rows is None else rows[moved[rows]]
    kept = Recording({name: values[rows] for name, values in recording.columns.items()}, recording.metadata)
    return MeasuredRows(rows, kept, said)


def judged_motion(recording: Recording) -> tuple[NDArray[np.bool_], tuple[str, ...]]:
    """Return where the instruments of motion measured, and what is said of the rest; RecordingError if it is much."""
    judged = judge_readings(recording.columns, recording.facts.stated, MOTION)
    if judged.contradiction:
        raise RecordingError(judged.contradiction)
    return judged.usable, judged.findings[len(judged.notes) :]


def rows_between_lines(recording: Recording) -> NDArray[np.intp] | None:
    """Return the rows, (n_measured,), between which electrical readings lie on straight lines; None if none show."""
    time_s = recording["time_s"]
    if time_s.size < MIN_SPACING * MIN_MEASURED:
        return None
    recorded = [bends_of(time_s, recording[name]) for name in ELECTRICAL if name in recording]
    bends = list(recorded)
    if "wire_resistance_ohm" not in recording:
        try:
            reading = resistance_reading(recording)
        except RecordingError:  # what is missing is said where it is needed, with all else that is missing
            return None
        bends.append(bends_of(time_s, np.where(reading.valid, reading.resistance_ohm, np.nan)))
    # Two of voltage, current and resistance may be on lines; the third is then their product or quotient.
    between = np.sum([bend <= STRAIGHT_PART for bend in bends], axis=0) >= min(2, len(bends))
    # A line whose bend lies between two rows bends at both: the first of them stands for the measured one.
    bent = ~between
    bent[1:] &= between[:-1]
    rows = np.union1d(np.flatnonzero(bent), time_s.size - 1)
    spacing = np.diff(rows)
    # Where measured rows follow each other, only a part was interpolated: all of it is taken as it is.
    if rows.size < MIN_MEASURED or np.median(spacing) < MIN_SPACING or np.sum(~between) > 2 * rows.size:
        return None
    if spacing.max() > MAX_SPACING_PART * np.median(spacing):
        return None
    uneven = max(1.0, UNEVEN_PART * float(np.median(spacing)))
    regular = np.mean(np.abs(spacing - np.median(spacing)) <= uneven) >= REGULAR_PART
    return rows if regular and any(bends_by_anything(bend, rows[1:-1]) for bend in recorded) else None


def bends_of(time_s: FloatArray, values: FloatArray) -> FloatArray:
    """Return how far each row lies off the line through its neighbours, as a part of the column's range, (n_times,)."""
    # Infinite at the ends, and where readings stand still, as those of a converter with coarse steps: on no drawn line.
    bends = np.full(values.size, np.inf)
    finite = values[np.isfinite(values)]
    span = float(np.ptp(finite)) if finite.size else 0.0
    if not span > 0.0:
        return bends
    step, after = np.diff(time_s)[:-1], np.diff(time_s)[1:]
    with np.errstate(invalid="ignore", divide="ignore"):
        line = (values[:-2] * after + values[2:] * step) / (step + after)
    moves = np.abs(values[2:] - values[:-2]) > 2.0 * STRAIGHT_PART * span
    bends[1:-1] = np.where(moves & np.isfinite(line), np.abs(values[1:-1] - line) / span, np.inf)
    return np.where(np.isnan(bends), np.inf, bends)


def bends_by_anything(bends: FloatArray, rows: NDArray[np.intp]) -> bool:
    """Return whether a curve that is straight at most rows bends at the others by this and that."""
    there = bends[rows][np.isfinite(bends[rows])]
    if np.mean(bends <= STRAIGHT_PART) < 0.5 or there.size < MIN_MEASURED:
        return False
    small, large = np.percentile(there, [OUTER_PERCENT, 100.0 - OUTER_PERCENT])
    return bool(large > MIN_DIFFERENT * small and large > MIN_DIFFERENT * STRAIGHT_PART)
