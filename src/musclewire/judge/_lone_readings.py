"""Readings that stand alone: away from their neighbours and back at once, or one value far from all others.

Marks of a lost sensor, full scales of a converter, spikes and wraps of a sign have this in common, whatever their
number. What a wire does shows in more than one channel: a pulse has the wire's resistance, a motion has a drive.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray

Rows = NDArray[np.bool_]
Columns = Mapping[str, FloatArray]

# What is judged: electrical readings, and those of instruments of motion. The drive is a command.
MEASURED = ("wire_voltage_v", "shunt_voltage_v", "wire_current_a", "wire_resistance_ohm")
MOTION = ("displacement_m", "reference_strain", "force_n", "endpoint_displacement_m", "endpoint_force_n")
NEAREST = 10  # rows on either side with which a row is compared
TRIMMED = 5  # readings left out at either end of these when sorted: what lasts for as many rows is no spike
# A row is a spike if it is off by more than its neighbours differ, and than each of these:
FAR = 0.2  # of the range of values at which the column stays for longer
NOISES = 12.0  # standard deviations of its neighbours: of an even noise 20 of them determine only half of it
STEPS = 3.0  # steps of the column's resolution
# The standard deviation of normal noise over the median size of its differences.
STD_OF_DIFFERENCES = 1.0 / (0.6745 * 2.0**0.5)
MAX_PART = 0.1  # of all rows: a value in more of them is a reading, not an instrument's mark
OTHERS = 5  # distinct other values: a column with fewer shows no mark, as any value may be one of its steps
PASSED = 1.5  # ratio of resistances: one wire's differ by less
OFF_FRACTION = 0.02  # of the usual voltage and current: without current both are below
# Rows that are looked at together.
CHUNK = 100_000


def lone_readings(columns: Columns) -> dict[str, Rows]:
    """Return for each measured column the rows that stand alone and that no other channel explains, (n_times,)."""
    names = (*MEASURED, *MOTION, "drive_voltage_v")
    found = {name: lone_rows(columns[name], name == "wire_resistance_ohm") for name in names if name in columns}
    events = found.pop("drive_voltage_v", np.zeros(next(iter(columns.values())).shape, dtype=np.bool_))
    moves = np.any([found[name] for name in MOTION if name in found] or [events], axis=0)
    for current in ("shunt_voltage_v", "wire_current_a"):
        if {"wire_voltage_v", current} <= found.keys():
            pair = found["wire_voltage_v"], found[current]
            real = of_one_wire(columns["wire_voltage_v"], columns[current], *pair)
            found["wire_voltage_v"], found[current] = (rows & ~real for rows in pair)
            events = events | (real & (pair[0] | pair[1]))
    if (rows := found.get("wire_resistance_ohm", events[:0])).any():
        ratio = columns["wire_resistance_ohm"] / np.median(columns["wire_resistance_ohm"][~rows])
        real = rows & (np.abs(np.log(np.maximum(ratio, 1e-300))) < np.log(PASSED)) & near(events | moves)
        found["wire_resistance_ohm"] = rows & ~real
        events = events | real
    # Where a drive is pulsed throughout, a pulse is near by chance.
    event = near(events)
    event &= 2 * event.sum() < event.size
    found |= {name: found[name] & ~event for name in MOTION if name in found}
    return {name: with_equals(columns[name], rows) for name, rows in found.items() if rows.any()}


def lone_rows(values: FloatArray, without_zero: bool = False) -> Rows:
    """Return the rows of a column that stand alone in it, (n_times,); each that is found uncovers others."""
    alone = np.zeros(values.shape, dtype=np.bool_)
    place = np.flatnonzero(np.isfinite(values) & ((values != 0.0) | (not without_zero)))
    while (found := marks_in(values[place]) | jumps_in(values[place])).any():
        alone[place[found]] = True
        place = place[~found]
    return alone


def marks_in(values: FloatArray) -> Rows:
    """Return the rows at an end of a column if few have it, farther from the rest than that is wide, or large."""
    for end in (values.max(initial=-np.inf), values.min(initial=np.inf)):
        marked = values == end
        rest = values[~marked]
        if rest.size and marked.sum() <= MAX_PART * values.size:
            gap, size = np.abs(rest - end).min(), np.abs(rest).max()
            if gap > np.ptp(rest) and (np.unique(rest).size > OTHERS or gap > size > 0.0):
                return np.asarray(marked)
    return np.zeros(values.shape, dtype=np.bool_)


def jumps_in(values: FloatArray) -> Rows:
    """Return the rows that leave their neighbours and come back within fewer rows than show what goes on."""
    count, width = values.size, 2 * NEAREST + 1
    alone = np.zeros(count, dtype=np.bool_)
    if count <= width:
        return alone
    blocks = np.sort(values[: count - count % width].reshape(-1, width), axis=1)
    span = float(blocks[:, -1 - TRIMMED].max() - blocks[:, TRIMMED].min())
    # Next to a column that stands still only what is more than all of it is far.
    far = FAR * span or abs(float(blocks[0, TRIMMED]))
    jumped = np.zeros(count, dtype=np.bool_)
    jumped[1:] |= np.abs(np.diff(values)) > far
    rows = np.flatnonzero(near(jumped))
    if far == 0.0 or rows.size == 0:
        return alone
    if span > 0.0:
        steps = np.diff(np.unique(values))
        far = max(far, STEPS * float(np.quantile(steps[steps > 1e-12 * np.abs(values).max()], 0.1)))
    for part in np.split(rows, range(CHUNK, rows.size, CHUNK)):
        around = values[np.clip(part - NEAREST, 0, count - width)[:, None] + np.arange(width)]
        std = STD_OF_DIFFERENCES * np.partition(np.abs(np.diff(around, axis=1)), NEAREST, axis=1)[:, NEAREST]
        around.partition((TRIMMED, width - 1 - TRIMMED), axis=1)
        low, high = around[:, TRIMMED], around[:, width - 1 - TRIMMED]
        off = np.maximum(low - values[part], values[part] - high)
        alone[part] = off > np.maximum(np.maximum(high - low, NOISES * std), far)
    while True:
        # What a neighbour leads to, or what lies between both sides or before the end, is a course, as a decay.
        sides = values[np.clip(sides_of(alone), 0, count - 1)]
        course = (values >= sides.min(axis=0) - far) & (values <= sides.max(axis=0) + far)
        leads = (np.abs(np.diff(values)) <= far) & (alone[1:] != alone[:-1])
        course[1:] |= leads
        course[:-1] |= leads
        course[[0, -1]] = True
        if not (course & alone).any():
            return alone
        alone &= ~course


def sides_of(rows: Rows) -> NDArray[np.intp]:
    """Return for each row the nearest before and after it that is none of some rows, (2, n_times); -1 or beyond."""
    place = np.arange(rows.size)
    before = np.maximum.accumulate(np.where(rows, -1, place))
    after = np.minimum.accumulate(np.where(rows, rows.size, place)[::-1])[::-1]
    return np.stack([before, after])


def near(rows: Rows) -> Rows:
    """Return the rows that are so near to some that they may belong to one event."""
    found = rows.copy()
    for shift in range(1, TRIMMED + 1):
        found[shift:] |= rows[:-shift]
        found[:-shift] |= rows[shift:]
    return found


def of_one_wire(voltage_v: FloatArray, current: FloatArray, lone_v: Rows, lone_a: Rows) -> Rows:
    """Return the rows in which voltage and current are those of the wire, or of a drive that is off for a moment."""
    either, both = lone_v | lone_a, lone_v & lone_a
    real = np.zeros(either.shape, dtype=np.bool_)
    if not either.any() or either.all():
        return real
    usual = [np.quantile(np.abs(values[~either]), 1.0 - MAX_PART) for values in (voltage_v, current)]
    real |= (np.abs(voltage_v) <= OFF_FRACTION * usual[0]) & (np.abs(current) <= OFF_FRACTION * usual[1])
    # Pulses between rows without a current agree with each other alone; an instrument's mark is one value throughout.
    pulses = both.any() and np.ptp(voltage_v[both]) + np.ptp(current[both]) > 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = voltage_v / current
        for rows in (~either, both) if pulses else (~either,):
            part = ratio / np.median(ratio[rows & (current != 0.0)])
            real |= (part > 1.0 / PASSED) & (part < PASSED)
    return real


def with_equals(values: FloatArray, rows: Rows) -> Rows:
    """Return rows with all others at a value that stands alone in a third of its rows, and in two at least."""
    known, which, counts = np.unique(values, return_inverse=True, return_counts=True)
    alone = np.bincount(which[rows], minlength=known.size)
    return np.asarray(rows | ((alone > 1) & (3 * alone >= counts))[which])
