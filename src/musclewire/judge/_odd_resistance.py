"""Resistance that no wire of the model has once it is sensed: one that jumps, or is above all of the slow loop.

A contact that comes loose raises the resistance within one sample. A wire that cools takes many for as much, and one
that is heated lowers it. Above B no wire comes back, unless leads, load or the resistance itself have changed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view

from musclewire.arrays import FloatArray
from musclewire.judge._cooling import seen_cooling
from musclewire.judge._first_heating import LIMIT_STDS, MEAN_SAMPLES, NOISY, KnownB, seen_at_b
from musclewire.judge._loop import DetectedRows, JudgedLoop, in_windows
from musclewire.judge._run_correction import TODAY, what_followed

# A rise is a jump if it is larger than both of these, beyond what the wire moves before and after it:
JUMP_PART = 0.04  # of the span from B to C
JUMP_NOISES = 9.0  # standard deviations of a reading at its drive
# Two rows of what the wire moves, and as much again, as one that moves fast does not move evenly.
MOVES = 4.0
# A reading is a mean over its sample, so a contact that opens within one raises two. What lasts for one is a spike.
# A jump needs two rows before it, the one in which it may fall, and two after it.
BEFORE = 4  # rows before a jump: more than two, as a wire that is switched turns
STEADY_SAMPLES = 8  # rows about a jump, before and after it, none of them missing
STEADY_PART = 0.8  # lowest over highest drive in these rows: a reading at another current may have another error
# The median size of the second differences of readings with normal noise, in standard deviations of a reading.
BEND_PER_STD = 0.6745 * 6.0**0.5
NO_ROWS = np.zeros(0, dtype=np.intp)


class OddResistance(NamedTuple):
    """Where a run's resistance is none of the model's wire; percentages are of the span from B to C."""

    jumps: npt.NDArray[np.intp] = NO_ROWS  # the rows at which it jumped
    largest_jump_pct: float = 0.0
    above: npt.NDArray[np.intp] = NO_ROWS  # the rows at which it is above all that the slow loop showed
    above_pct: float = 0.0  # by how much at most


def odd_resistance(loop: JudgedLoop) -> OddResistance:
    """Return where a run's resistance is none of the model's wire, once it is sensed; nowhere if it knows no B."""
    known = KnownB.stated_in(loop.facts)
    if known is None or "wire_resistance_ohm" not in loop.recording or not known.b_ohm > known.c_ohm:
        return OddResistance()
    resistance_ohm, drive_v = loop.recording["wire_resistance_ohm"], loop.drive_voltage_v
    read = np.isfinite(resistance_ohm) & (resistance_ohm > 0.0) & loop.sensed
    resistance_ohm = np.where(read, resistance_ohm, np.nan)
    noise_ohm = reading_noise_ohm(resistance_ohm, drive_v)
    percent = 100.0 / (known.b_ohm - known.c_ohm)
    limit_ohm = np.maximum(JUMP_PART * (known.b_ohm - known.c_ohm), JUMP_NOISES * noise_ohm)
    jumps, by_ohm = jumps_in(resistance_ohm, steady_rows(loop.time_s, drive_v), limit_ohm)
    above, above_ohm = above_the_loop(known, resistance_ohm, drive_v, noise_ohm)
    return OddResistance(
        jumps, percent * float(by_ohm.max(initial=0.0)), above, percent * float(above_ohm.max(initial=0.0))
    )


def bad_contact(loop: JudgedLoop) -> DetectedRows:
    """Return the samples from the first jump of the resistance at a steady drive on."""
    odd = loop.once(odd_resistance)
    often = "once" if odd.jumps.size == 1 else f"{odd.jumps.size} times"
    said = f"{often}, by up to {odd.largest_jump_pct:.0f} % of the span from B to C"
    return DetectedRows(loop.since_first(odd.jumps), lambda: said)


def other_height_of_b(loop: JudgedLoop) -> DetectedRows:
    """Return the samples from another B than the model's on, or from a resistance above all of the slow loop's on.

    What the cooling after the loop alone shows has come at a time that is not known, once the wire was sensed.
    """
    seen, odd = loop.once(seen_at_b), loop.once(odd_resistance)
    above = loop.since_first(odd.above)
    if seen is None or not seen.is_away:
        after = loop.once(seen_cooling)
        if not above.any() and after is not None and after.is_away:
            return DetectedRows(loop.sensed if seen is None else loop.since(seen.row), lambda: str(after))
        said = f"up to {odd.above_pct:.0f} % of the span from B to C above all that the model's slow loop showed"
        return DetectedRows(above, lambda: said)
    from_today = loop.facts.text_or_none("zero_from") == TODAY
    return DetectedRows(
        above | loop.since(seen.row), lambda: f"{seen}; {what_followed(seen)}" if from_today else str(seen)
    )


def reading_noise_ohm(resistance_ohm: FloatArray, drive_voltage_v: FloatArray) -> FloatArray:
    """Return the noise of each reading [ohm], (n_times,): what a voltage's noise is in resistance falls with the drive.

    Not by ``noise_level``, for which a converter that repeats itself has no noise.
    """
    bends_v = np.abs(np.diff(resistance_ohm, 2)) * drive_voltage_v[1:-1]
    bends_v = bends_v[np.isfinite(bends_v) & (bends_v > 0.0)]
    noise_v = float(np.median(bends_v)) / BEND_PER_STD if bends_v.size else 0.0
    return np.asarray(noise_v / np.maximum(drive_voltage_v, 1e-9))


def steady_rows(time_s: FloatArray, drive_voltage_v: FloatArray) -> npt.NDArray[np.intp]:
    """Return the rows about which the drive is steady and no row is missing: ``BEFORE`` before, the rest from it on."""
    if time_s.size < STEADY_SAMPLES:
        return NO_ROWS
    lowest_v, highest_v = (in_windows(one, drive_voltage_v, STEADY_SAMPLES) for one in (np.minimum, np.maximum))
    steps_s = np.diff(time_s)
    whole = in_windows(np.maximum, steps_s, STEADY_SAMPLES - 1) <= 1.5 * float(np.median(steps_s))
    return np.flatnonzero(whole & (lowest_v >= STEADY_PART * highest_v)) + BEFORE


def jumps_in(
    resistance_ohm: FloatArray, rows: npt.NDArray[np.intp], limit_ohm: FloatArray
) -> tuple[npt.NDArray[np.intp], FloatArray]:
    """Return where resistance has jumped up to stay, in two readings on each side, and by how much, (n_jumps,) each."""
    before = [resistance_ohm[rows - back] for back in (2, 1)]
    after = [resistance_ohm[rows + on] for on in (1, 2)]
    moving_ohm = np.maximum(np.maximum(before[1] - before[0], after[1] - after[0]), 0.0)
    by_ohm = np.minimum(*after) - np.maximum(*before) - MOVES * moving_ohm
    found = by_ohm > limit_ohm[rows]
    if not found.any():
        return NO_ROWS, np.zeros(0)
    # A jump between two rows is seen at both.
    first = found & ~np.isin(rows - 1, rows[found])
    return rows[first], by_ohm[first]


def above_the_loop(
    known: KnownB, resistance_ohm: FloatArray, drive_voltage_v: FloatArray, noise_ohm: FloatArray
) -> tuple[npt.NDArray[np.intp], FloatArray]:
    """Return the rows up to which the mean of some well-read readings is above the slow loop, and by how much [ohm]."""
    if resistance_ohm.size < MEAN_SAMPLES:
        return NO_ROWS, np.zeros(0)
    read_well = np.where(drive_voltage_v > NOISY * known.sense_voltage_v, resistance_ohm, np.nan)
    above_ohm = sliding_window_view(read_well, MEAN_SAMPLES).mean(axis=1) - known.highest_ohm
    std_ohm = np.hypot(known.std_ohm, noise_ohm[MEAN_SAMPLES - 1 :] / MEAN_SAMPLES**0.5)
    found = np.flatnonzero(above_ohm > LIMIT_STDS * std_ohm)
    return found + MEAN_SAMPLES - 1, above_ohm[found]
