"""Readings that are no measurements: marks, lone readings, ends of a range, pulses that are off, contradictions.

They are judged before the wire is, and by this table only: whatever computes a resistance from a recording, the import
of a file and the doctor ask ``judge_readings``. What stays at the end of a range looks like a wire that has stopped
moving.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.files import NOTED_BY_IMPORT, is_overload
from musclewire.judge._lone_readings import MEASURED, MOTION, OFF_FRACTION, PASSED, lone_readings
from musclewire.signals import COLUMNS, MetadataValue

Rows = NDArray[np.bool_]
Columns = Mapping[str, FloatArray]
Metadata = Mapping[str, MetadataValue]

# What an import says of a file with too many rows for it.
TOO_MANY = "more than {rows} rows: the command that uses the recording judges whether its readings are measurements"
# Equal rows in succession: fewer are no plateau.
PLATEAU_ROWS = 5
# Steps of the column's resolution by which it must move in the rows before a plateau, as many as that has. The top of
# a smooth curve of w rows on either side, rounded to a step q, has risen by q ((2 + 1)^2 - 1) = 8 q in its own length.
CUT_STEPS = 12.0
# Of that rise, a fifth of the rows makes at most this part: more is a jump to a level, or a decaying approach to it.
MAX_PART = 0.45
# Steps of the column's resolution: noise that is larger on both sides of a plateau would not leave five rows equal.
NOISE_STEPS = 1.5
NEIGHBOURS = 20  # rows on either side of a plateau, from which its noise is known
REPEATED = 0.1  # of the neighbours at most may repeat the row before, or the column is not noisy
CALM = 0.3  # scatter, or change, of a channel in a plateau over that next to it: with less the channel was held
MIN_STEPS = 2.0  # steps, or noises, of another channel: a larger motion before a plateau shows what the drive did
HOLD_ROWS = 4  # a motion counts over a plateau's length divided by this: the stretches at both ends do not overlap
# What moves on while a column stays at the end of its range. Past a resistance it moves by this part of its own range;
# from A to B a wire does by 15 %, at one value of a meter with few steps.
_ELECTRICAL = ("wire_current_a", "shunt_voltage_v")
PARTNERS = {
    "wire_voltage_v": _ELECTRICAL,
    "shunt_voltage_v": ("wire_voltage_v",),
    "wire_current_a": ("wire_voltage_v",),
    "wire_resistance_ohm": ("drive_voltage_v", "wire_voltage_v", *_ELECTRICAL, "displacement_m", "reference_strain"),
}
KEPT = ("time_s", *MEASURED, *MOTION, "drive_voltage_v")
# More lone readings than this part of a column are no accidents: which of its readings are right is not known.
MANY_ALONE = 0.1
# An import judges files of up to this many rows, which take 100 MB; what uses a recording judges it in any case.
MAX_ROWS = 2_000_000
MOVED = 0.25  # of its range, by which another column moves in a plateau that the end of a range has cut off
FINE = 0.01  # step over range of a resistance: with larger ones a wire that passes B leaves equal rows, too
# In noise a resistance is cut off in at least this part of all rows.
OFTEN = 0.03
# The part of all its distinct neighbouring values that lies at a column's own step.
STEP_QUANTILE = 0.1
# Ends of range [V] of a chip's shunt voltage, by its data sheet, and the shunt on its usual board [ohm].
CHIPS = {"ina219": (0.04, 0.08, 0.16, 0.32), "ina226": (0.08192,)}
BOARD_SHUNT_OHM = 0.1
# A reading within this part of a stated range's end is at it: one step of 12 bits less.
AT_END = 1.0 - 1.0 / 4096.0
# Pulses are off where voltage and current are next to nothing, and their quotient is none of the wire by this factor.
WIRE_RATIO = 2.0
CURRENT_FRACTION = 0.1  # difference of two sources of the current, over it: shunts and ranges differ by less
RESISTANCE_FRACTION = 0.2  # the same of two sources of the resistance, which includes leads
NOT_COUNTED = 0.05  # of the largest current: in rows with less a quotient is noise
# Voltage of wire and shunt over that of the drive: outside these a unit or a channel is wrong.
DRIVE_LOW = 1.0 / 3.0
DRIVE_HIGH = 1.2
# A drive is late by some rows if it is explained by voltage and current only when shifted by these:
MIN_LATE_MISFIT = 0.01  # of the drive, unexplained without a shift: with less there is nothing to explain
LEFT_BY_SHIFT = 1.0 / 3.0  # of that, left by the shift: late by three quarters of a row, a whole one leaves a quarter
MAX_LEFT = 0.1  # of the drive, left by the shift: more is no delay but another drive
MIN_LATE_ROWS = 20  # rows: fewer show no delay
MAX_LATE_ROWS = 50_000  # rows, evenly apart, in which a delay is searched: more take longer and show no more


class UnusableRows(NamedTuple):
    """Rows of a column that are no measurements."""

    column: str
    rows: Rows  # (n_times,)
    why: str  # what they are and what to do about it
    is_real: bool = False  # the numbers are right all the same, and only no resistance follows from them


@dataclass(frozen=True)
class JudgedReadings:
    """Which rows of a recording are measurements."""

    usable: Rows  # (n_times,)
    found: tuple[UnusableRows, ...] = ()  # those that cannot be used, by column and reason
    contradiction: str = ""  # of two sources of one quantity, so that no row can be trusted
    notes: tuple[str, ...] = ()  # what else is to be known: rows that importing left out, a drive that is none

    @property
    def findings(self) -> tuple[str, ...]:
        """What cannot be used in words, with the number of rows."""
        counted = (
            f"{int(item.rows.sum())} of {item.rows.size} rows are no measurements: {item.why}" for item in self.found
        )
        return (*self.notes, *counted)


def judge_readings(
    columns: Columns, metadata: Metadata, used: tuple[str, ...] = (*MEASURED, *MOTION)
) -> JudgedReadings:
    """Return which rows are measurements in all of the columns ``used``.

    The metadata may state ``shunt_resistance_ohm``, ends of range as ``wire_current_range_a``, the ``chip`` as INA219,
    and ``held_columns``, the names of those that were held on purpose.
    """
    n_times = next(iter(columns.values())).size
    named = {name: np.zeros(n_times, dtype=np.bool_) for name in used}
    found, contradiction = list[UnusableRows](), ""
    mended = {name: bridged(values, np.isnan(values)) for name, values in columns.items()}
    for rule in (*FALSE_NUMBERS, *RULES):
        for item in list(rule(mended, metadata)):
            if rule in FALSE_NUMBERS:
                mended[item.column] = bridged(mended[item.column], item.rows)
            if item.column in used and (item.rows & ~named[item.column]).any():
                named[item.column] |= item.rows
                found.append(item)
                if rule is lone and item.rows.sum() > MANY_ALONE * n_times:
                    contradiction = f"{int(item.rows.sum())} of {n_times} rows, too many to leave them out: {item.why}"
    bad = np.any(list(named.values()), axis=0)
    good = {name: values[~bad] for name, values in mended.items()}
    for said in () if contradiction or bad.all() else contradictions(good, metadata):
        contradiction = contradiction or f"two columns contradict each other: {said}"
    notes = [str(metadata[said]) for said in NOTED_BY_IMPORT if said in metadata]
    notes += [] if bad.all() else drive_doubts(mended, ~bad)
    return JudgedReadings(~bad, tuple(found), contradiction, tuple(notes))


def bridged(values: FloatArray, rows: Rows) -> FloatArray:
    """Return a column in which some rows lie on lines between those next to them; 0 if they are all."""
    there = np.flatnonzero(~rows)
    if there.size == values.size:
        return values
    return np.interp(np.arange(values.size), there, values[there]) if there.size else np.zeros(values.shape)


def overload_marks(columns: Columns, _: Metadata) -> Iterator[UnusableRows]:
    """Yield the rows in which an instrument says that its range was exceeded."""
    for name in (*MEASURED, *MOTION):
        if name in columns and (rows := is_overload(columns[name])).any():
            yield UnusableRows(
                name, rows, f"{name} holds {columns[name][np.argmax(rows)]:.3g}, an instrument's mark of an overload"
            )


def lone(columns: Columns, metadata: Metadata) -> Iterator[UnusableRows]:
    """Yield the rows in which a column stands alone, but for those that are said to be held."""
    for name, rows in lone_readings(columns).items():
        if name in _held(metadata):
            continue
        at = between(columns[name][rows], name)
        yield UnusableRows(
            name, rows, f"{name} stands alone there at {at}, far from the rest: spikes, or an instrument's mark"
        )


def other_sign(columns: Columns, metadata: Metadata) -> Iterator[UnusableRows]:
    """Yield the rows in which a current jumps by a whole range to a sign that it has not with this voltage."""
    for name, current_a in _currents(columns, metadata):
        if "wire_voltage_v" not in columns:
            continue
        power, size = columns["wire_voltage_v"] * current_a, np.abs(current_a)
        there = size > NOT_COUNTED * size.max()
        rows = there & (power * np.sign(np.median(power[there] if there.any() else power)) < 0.0)
        jumps = np.abs(np.diff(columns[name]))[np.diff(rows)]
        if 0 < 2 * rows.sum() < there.sum() and np.median(jumps) > np.abs(columns[name]).max():
            at, by = between(columns[name][rows], name), _shown(float(np.median(jumps)), name)
            why = f"{name} has the other sign there, {at}, where wire_voltage_v goes on, with jumps by {by}: a number "
            yield UnusableRows(name, rows, f"{why}that wrapped at an end of its range; {_LARGER}")


def ends_of_range(columns: Columns, metadata: Metadata) -> Iterator[UnusableRows]:
    """Yield the rows at an end of range that file, mapping or chip states."""
    for name in MEASURED:
        if name not in columns:
            continue
        size = np.abs(columns[name])
        for end, whose in _stated_ends(name, metadata):
            rows = size >= AT_END * end
            if rows.any() and (whose == "stated" or size[rows].max() <= end / AT_END):
                yield UnusableRows(name, rows, f"{name} stays at {_shown(end, name)}, {_END_OF[whose]}; {_LARGER}")


_END_OF = {"stated": "the end of the range that is stated", "chip": "the end of a range of this chip"}
_LARGER = "choose a larger range or a smaller shunt"


def _stated_ends(name: str, metadata: Metadata) -> Iterator[tuple[float, str]]:
    """Yield the ends of range of a column, in SI, and who states each."""
    quantity, unit = name.rsplit("_", 1)
    if (stated := _positive(metadata.get(f"{quantity}_range_{unit}"))) is not None:
        yield stated, "stated"
    scale = {"shunt_voltage_v": 1.0, "wire_current_a": _positive(metadata.get("chip_shunt_ohm")) or BOARD_SHUNT_OHM}
    if name in scale:
        for end_v in CHIPS.get(str(metadata.get("chip", "")).strip().lower(), ()):
            yield end_v / scale[name], "chip"


def plateaus(columns: Columns, metadata: Metadata) -> Iterator[UnusableRows]:
    """Yield the rows in which a column stands still at its largest size, for five rows or more, while others move."""
    for name in MEASURED:
        if name not in columns or name in _held(metadata):
            continue
        size = np.abs(columns[name])
        at_top = size == size.max()
        runs = [run for run in _runs(at_top) if run[1] - run[0] >= PLATEAU_ROWS]
        # A column that never moves was held, as by a source of current: of an end of range only the metadata know.
        if not runs or at_top.all() or size.max() == 0.0:
            continue
        step = _step_of(size)
        ends = _ends_resistance if name == "wire_resistance_ohm" else _ends_drive
        if any(ends(_Plateau(size, *run, step), columns, PARTNERS[name]) for run in runs):
            top = _shown(float(size.max()), name)
            yield UnusableRows(name, at_top, f"{name} stays at {top}, the end of a range; {_LARGER}")


def _held(metadata: Metadata) -> set[str]:
    return {name.strip() for name in str(metadata.get("held_columns", "")).split(",")}


class _Plateau(NamedTuple):
    """Equal rows at the largest size of a column: from ``first`` to before ``last``; ``step`` is the column's own."""

    size: FloatArray
    first: int
    last: int
    step: float

    @property
    def sides(self) -> list[FloatArray]:
        """The rows on both sides towards the plateau, one of it included, where there are enough."""
        both = self.size[: self.first + 1], self.size[self.last - 1 :][::-1]
        return [side for side in both if side.size > PLATEAU_ROWS]

    def neighbours(self, values: FloatArray) -> list[FloatArray]:
        """Return what another column does next to the plateau, on each side."""
        before = values[max(self.first - NEIGHBOURS, 0) : self.first]
        after = values[self.last : self.last + NEIGHBOURS]
        return [side for side in (before, after) if side.size >= PLATEAU_ROWS]

    @property
    def cut_rows(self) -> int:
        """Over how many rows the column runs evenly into the equal ones, and out of them, as if cut off; else 0."""
        found = [_rows_into(side, self.last - self.first, self.step) for side in self.sides]
        return max(found) if found and all(found) else 0

    @property
    def is_in_noise(self) -> bool:
        """Whether the rows around scatter so much that these would not be equal."""
        around = [side[-1 - NEIGHBOURS :] for side in self.sides]
        around = [rows[rows < rows[-1]] for rows in around]
        around = [rows for rows in around if rows.size >= PLATEAU_ROWS + 2]
        return bool(around) and all(_is_noisy(rows, self.step) for rows in around)


def _ends_drive(plateau: _Plateau, columns: Columns, partners: tuple[str, ...]) -> bool:
    """Return whether a voltage or current is at the end of its range: the others go on, with the drive or its noise."""
    others = [columns[name] for name in ("drive_voltage_v", *partners) if name in columns]
    if any(_outgrows(plateau, values) for values in others):
        return True
    if plateau.cut_rows:
        found = [goes_on for values in others for goes_on in _goes_on(plateau, values)]
        if (found and all(found)) or not others:
            return True
    return plateau.is_in_noise and any(_stays_noisy(plateau, values) for values in others)


def _outgrows(plateau: _Plateau, values: FloatArray) -> bool:
    """Return whether another column changes so much that this one would have changed too, by more than its step."""
    inside = np.abs(values[plateau.first : plateau.last])
    low, high = float(inside.min()), float(inside.max())
    # In proportion to it the equal rows would have begun lower, by this part of their value.
    missing = (high - low) / high if high - low > _min_change(values) else 0.0
    return missing > 1.0 - 1.0 / PASSED and missing * float(plateau.size[plateau.first]) > plateau.step


def _min_change(values: FloatArray) -> float:
    """Return how much a column has to change to show it, for its steps and noise."""
    return MIN_STEPS * max(_step_of(np.abs(values)), _scatter(values))


def _goes_on(plateau: _Plateau, values: FloatArray) -> list[bool]:
    """Return whether another column continues, for each side of the plateau on which it moved enough to show it."""
    rows = min(plateau.cut_rows, max((plateau.last - plateau.first) // HOLD_ROWS, 1))
    least, found = _min_change(values), []
    for edge, inwards in ((plateau.first, 1), (plateau.last - 1, -1)):
        outside, then = edge - inwards * rows, edge + inwards * (rows // 2 + 1)
        if 0 <= outside < values.size:
            before, after = values[edge] - values[outside], values[then + inwards * rows] - values[then]
            if abs(before) > least:
                found.append(bool(after * np.sign(before) > CALM * abs(before)))
    return found


def _stays_noisy(plateau: _Plateau, values: FloatArray) -> bool:
    """Return whether another column scatters in the plateau as it does next to it, by more than its step."""
    around = [_scatter(side) for side in plateau.neighbours(values)]
    inside = _scatter(values[plateau.first : plateau.last])
    return bool(around) and inside >= max(NOISE_STEPS * _step_of(np.abs(values)), CALM * max(around))


def _ends_resistance(plateau: _Plateau, columns: Columns, partners: tuple[str, ...]) -> bool:
    """Return whether a resistance is at the end of its range: it is not if the wire rests, or passes B."""
    inside = slice(plateau.first, plateau.last)
    ranges = {name: float(np.ptp(columns[name])) for name in partners if name in columns}
    moved = {name for name, span in ranges.items() if np.ptp(columns[name][inside]) > MOVED * span > 0.0}
    instruments = {"displacement_m", "reference_strain"} & ranges.keys()
    inner = plateau.first > 0 and plateau.last < plateau.size.size
    fine = plateau.step <= FINE * float(np.ptp(plateau.size))
    if (fine and moved & instruments) or (plateau.cut_rows and (inner or (moved and not instruments))):
        return True
    at_top = int((plateau.size == plateau.size[plateau.first]).sum())
    return plateau.is_in_noise and at_top >= OFTEN * plateau.size.size


def _rows_into(side: FloatArray, length: int, step: float) -> int:
    """Return over how many rows the values of a side, the oldest first, rise evenly into the last one; 0 for none."""
    rows, least = 1, CUT_STEPS * max(step, _scatter(side[-1 - NEIGHBOURS :]))
    while PLATEAU_ROWS * rows <= min(max(length, PLATEAU_ROWS), side.size - 1):
        points = side[-1 - PLATEAU_ROWS * rows :: rows]
        gains, rise = np.diff(points), float(points[-1] - points[0])
        if rise >= least and gains.min() >= -MAX_PART * rise / 2.0 and gains.max() <= MAX_PART * rise:
            return PLATEAU_ROWS * rows
        rows *= 2
    return 0


def _is_noisy(rows: FloatArray, step: float) -> bool:
    """Return whether rows scatter by more than their step, and hardly ever repeat a value."""
    return bool(np.mean(np.diff(rows) == 0.0) <= REPEATED and _scatter(rows) >= NOISE_STEPS * step)


def _scatter(values: FloatArray) -> float:
    """Return the standard deviation of noise on a short, almost straight piece of a curve."""
    return float(np.median(np.abs(np.diff(values, n=2)))) / 0.6745 / np.sqrt(6.0) if values.size > 2 else 0.0


def _step_of(size: FloatArray) -> float:
    """Return the step in which a column was recorded; that of a column without steps is small."""
    steps = np.diff(np.unique(size))
    steps = steps[steps > 1e-12 * size.max()]
    return float(np.quantile(steps, STEP_QUANTILE)) if steps.size else 0.0


def off_pulses(columns: Columns, metadata: Metadata) -> Iterator[UnusableRows]:
    """Yield the rows in which a pulsed drive is off: next to no current, so no resistance."""
    for name, current_a in _currents(columns, metadata):
        if "wire_voltage_v" not in columns:
            continue
        volts, amperes = np.abs(columns["wire_voltage_v"]), np.abs(current_a)
        low = (volts <= OFF_FRACTION * volts.max()) & (amperes <= OFF_FRACTION * amperes.max())
        if not low.any() or low.all() or not amperes[~low].min() > 0.0:
            continue
        on_ohm = float(np.median(volts[~low] / amperes[~low]))
        ohm = volts[low] / np.maximum(amperes[low], 1e-30)
        signs = np.sign(columns["wire_voltage_v"][low]) == np.sign(current_a[low])
        others = ~(signs & (ohm > on_ohm / WIRE_RATIO) & (ohm < on_ohm * WIRE_RATIO))
        if 2 * int(others.sum()) > int(low.sum()):
            most = _shown(float(amperes[low].max()), "wire_current_a")
            why = f"the drive is off, {most} at most, and without current there is no resistance; read in the pulses"
            yield UnusableRows(name, low, why, is_real=True)


def _currents(columns: Columns, metadata: Metadata) -> Iterator[tuple[str, FloatArray]]:
    """Yield the sources of the current, each by the name of its column, as [A]."""
    shunt_ohm = _positive(metadata.get("shunt_resistance_ohm"))
    if "shunt_voltage_v" in columns and shunt_ohm is not None:
        yield "shunt_voltage_v", columns["shunt_voltage_v"] / shunt_ohm
    if "wire_current_a" in columns:
        yield "wire_current_a", columns["wire_current_a"]


def other_current(columns: Columns, metadata: Metadata) -> Iterator[UnusableRows]:
    """Yield the rows in which two sources of the current differ that agree elsewhere."""
    currents = dict(_currents(columns, metadata))
    if len(currents) < 2 or _ratio_of_currents(currents) is not None:
        return
    shunt_a, current_a = currents.values()
    off = np.abs(shunt_a - current_a) > CURRENT_FRACTION * np.abs(current_a) + NOT_COUNTED * np.abs(current_a).max()
    # Where one of the two is at the end of its range, the other is right.
    for item in (item for rule in (ends_of_range, plateaus) for item in rule(columns, metadata)):
        off &= ~item.rows
    if off.any():
        why = "shunt_voltage_v over the shunt differs from wire_current_a there; leave out the column that is wrong"
        yield UnusableRows("shunt_voltage_v", off, why)
        yield UnusableRows("wire_current_a", off, why)


def _ratio_of_currents(currents: Mapping[str, FloatArray]) -> float | None:
    """Return the current by the shunt over that which was measured, None if the two agree."""
    shunt_a, current_a = currents["shunt_voltage_v"], currents["wire_current_a"]
    counted = np.abs(current_a) > NOT_COUNTED * np.abs(current_a).max()
    if not counted.any():
        return None
    ratio = float(np.median(shunt_a[counted] / current_a[counted]))
    return None if abs(ratio - 1.0) <= CURRENT_FRACTION else ratio


def contradictions(good: Columns, metadata: Metadata) -> Iterator[str]:
    """Yield in which quantities two sources disagree throughout, and what to do; of columns without unusable rows."""
    currents = dict(_currents(good, metadata))
    if len(currents) == 2 and (ratio := _ratio_of_currents(currents)) is not None:
        shunt_ohm = _positive(metadata.get("shunt_resistance_ohm")) or 0.0
        yield (
            f"shunt_voltage_v over the shunt of {shunt_ohm:g} ohm is {ratio:.3g} times wire_current_a: by the current "
            f"the shunt has {shunt_ohm * abs(ratio):.3g} ohm; correct its resistance or a unit, or leave one column out"
        )
    if not {"wire_voltage_v", "wire_resistance_ohm"} <= good.keys():
        return
    volts, resistance = good["wire_voltage_v"], good["wire_resistance_ohm"]
    for name, current_a in currents.items():
        there = (np.abs(current_a) > NOT_COUNTED * np.abs(current_a).max()) & (resistance > 0.0)
        ratio = float(np.median(volts[there] / (current_a * resistance)[there])) if there.any() else 1.0
        if abs(ratio - 1.0) > RESISTANCE_FRACTION:
            yield (
                f"wire_voltage_v over the current of {name} is {ratio:.3g} times wire_resistance_ohm: correct a unit, "
                "or leave out the columns that are wrong"
            )


def drive_doubts(columns: Columns, usable: Rows) -> list[str]:
    """Return that the drive is not what wire and shunt have together, or not when; that spoils no reading."""
    if not {"wire_voltage_v", "drive_voltage_v"} <= columns.keys() or not columns["drive_voltage_v"].max() > 0.0:
        return []
    drive_v, doubts = columns["drive_voltage_v"], list[str]()
    inner_v = columns["wire_voltage_v"] + columns.get("shunt_voltage_v", 0.0 * drive_v)
    high = usable & (drive_v > 0.5 * drive_v[usable].max())
    ratio = float(np.median(inner_v[high] / drive_v[high])) if high.any() else 1.0
    if not DRIVE_LOW <= ratio <= DRIVE_HIGH:
        doubts.append(f"wire and shunt together have {ratio:.3g} times drive_voltage_v: check units and channels")
    through = [columns[name] for name in _ELECTRICAL if name in columns]
    if through and (late := rows_late(drive_v, np.stack([columns["wire_voltage_v"], *through], axis=1))):
        period_s = float(np.median(np.diff(columns["time_s"]))) if "time_s" in columns else 0.0
        by = f"{abs(late)} samples" + (f" ({abs(late) * period_s:.3g} s)" if period_s else "")
        doubts.append(
            f"drive_voltage_v is recorded {by} {'later' if late > 0 else 'earlier'} than the voltages that follow from "
            "it: shift the column by its delay, or record both with one clock"
        )
    return doubts


def rows_late(drive_v: FloatArray, readings: FloatArray) -> int:
    """Return by how many rows a drive is later than voltage and current, 0 if that is not plain; half a row is none."""
    every = -(-drive_v.size // MAX_LATE_ROWS)
    drive_v, readings = drive_v[::every], readings[::every]
    count, off = drive_v.size, misfit(drive_v, readings, 0)
    if count < MIN_LATE_ROWS or off < MIN_LATE_MISFIT:
        return 0
    # By NumPy: SciPy's correlation loads for longer than a board waits for its next command.
    spectra = np.fft.rfft([drive_v - drive_v.mean(), readings[:, 0] - readings[:, 0].mean()], 2 * count)
    found, most = np.fft.irfft(spectra[0] * spectra[1].conj()), count // 4
    late, step = int(np.argmax(found[np.arange(-most, most + 1)])) - most, most // 4
    # The products of slow courses favour a long overlap: from their largest on the course itself decides.
    while step:
        nearest = min((late, late - step, late + step), key=lambda rows: misfit(drive_v, readings, rows))
        late, step = nearest, step if nearest != late else step // 2
    left = misfit(drive_v, readings, late)
    return every * late if left < min(LEFT_BY_SHIFT * off, MAX_LEFT) else 0


def misfit(drive_v: FloatArray, readings: FloatArray, late: int) -> float:
    """Return which part of a drive voltage and current, so many rows earlier, do not explain; 1 if half is cut off."""
    count = drive_v.size - abs(late)
    one, others = (drive_v[late:], readings[:count]) if late >= 0 else (drive_v[:count], readings[-late:])
    if 2 * count < drive_v.size or one.var() * count <= 0.5 * drive_v.var() * drive_v.size:
        return 1.0
    centred, others = one - one.mean(), others - others.mean(axis=0)
    rest = centred - others @ np.linalg.lstsq(others, centred, rcond=None)[0]
    return float(np.sqrt(rest @ rest / (centred @ centred)))


def pulls_as_a_wire(columns: Columns, metadata: Metadata) -> bool:
    """Return whether the resistance is lower where most was moved, by either sign; True if one of them is unknown."""
    ohm = columns.get("wire_resistance_ohm")
    current_a = next((values for _, values in _currents(columns, metadata)), None)
    if ohm is None and current_a is not None and "wire_voltage_v" in columns:
        with np.errstate(divide="ignore", invalid="ignore"):
            ohm = np.abs(columns["wire_voltage_v"] / current_a)
    moved = next((columns[name] for name in ("displacement_m", "reference_strain") if name in columns), None)
    usable = judge_readings(columns, metadata).usable
    if ohm is None or moved is None or usable.sum() < 2 * PLATEAU_ROWS:
        return True
    ohm, moved = ohm[usable], np.abs(moved[usable] - moved[usable][0])
    most, least = moved >= np.quantile(moved, 0.9), moved <= np.quantile(moved, 0.1)
    return bool(np.median(ohm[most]) < np.median(ohm[least]))


class ReadingsOfBlocks:
    """The readings of a table that comes block after block, up to a number of rows, to be judged at its end."""

    def __init__(self) -> None:
        """Begin without rows."""
        self._blocks: list[dict[str, FloatArray]] = []
        self._rows = 0

    def add(self, columns: Columns) -> None:
        """Keep a block's readings, and what shows that the rest moves."""
        self._rows += next(iter(columns.values())).size
        if self._rows <= MAX_ROWS:
            self._blocks.append({name: columns[name] for name in KEPT if name in columns})
        else:
            self._blocks.clear()

    @property
    def notes(self) -> tuple[str, ...]:
        """That nothing was judged here, if there are too many rows."""
        return (TOO_MANY.format(rows=MAX_ROWS),) if self._rows > MAX_ROWS else ()

    def is_of_a_wire(self, metadata: Metadata) -> bool:
        """Return whether resistance and motion are those of a wire, as far as they are known."""
        return not self._blocks or not self._blocks[0] or pulls_as_a_wire(self._columns(), metadata)

    def judge(self, metadata: Metadata) -> JudgedReadings | None:
        """Return which rows are measurements; None if there are none to judge, or too many."""
        if not self._blocks or not set(MEASURED) & self._blocks[0].keys():
            return None
        return judge_readings(self._columns(), metadata)

    def _columns(self) -> dict[str, FloatArray]:
        return {name: np.concatenate([block[name] for block in self._blocks]) for name in self._blocks[0]}


Rule = Callable[[Columns, Metadata], Iterator[UnusableRows]]
# What makes a reading unusable, in the order in which it is named: numbers that were never measured, by which nothing
# else is judged, and what other rows show.
FALSE_NUMBERS: tuple[Rule, ...] = (overload_marks, lone, other_sign)
RULES: tuple[Rule, ...] = (
    ends_of_range,
    plateaus,
    off_pulses,
    other_current,
)


def _runs(there: Rows) -> list[tuple[int, int]]:
    """Return first row and row after the last of each run of rows."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], there, [False])).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _positive(value: MetadataValue) -> float | None:
    number = isinstance(value, int | float) and not isinstance(value, bool) and 0.0 < value < float("inf")
    return float(value) if number else None  # type: ignore[arg-type]


def _shown(value: float, name: str) -> str:
    return f"{value:.4g} {COLUMNS[name].unit}"


def between(values: FloatArray, name: str) -> str:
    """Return the range of some readings of a column with its unit."""
    low, high = f"{values.min():.4g}", _shown(float(values.max()), name)
    return high if values.min() == values.max() else f"{low} to {high}"
