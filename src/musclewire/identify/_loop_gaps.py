"""What a recorded loop shows: its hysteresis gaps (Eqs. 2 and 9), and the friction between wire and spring."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.identify._recordings import required_quantity, without_loop
from musclewire.judge import resistance_reading
from musclewire.physics import ArrayReading
from musclewire.sensing import LoopSegments, find_segments, hysteresis_gap, noise_level
from musclewire.signals import Recording, reference_quantity

# A force rises with the contraction if it rises by more than this many standard deviations of the load cell's noise,
NOISES = 4.0
# and by more than this part of the difference between the branches: under a weight a rubbing guide makes a loop, too.
MIN_SLOPE = 0.1
# Its slope is taken over this fraction of the motion to either side of its middle.
INNER = 0.3


@dataclass(frozen=True)
class LoopGaps:
    """Gaps of one loop as fractions of the largest value of the quantity (Eqs. 2 and 9)."""

    segments: LoopSegments  # points A, B and C of the loop
    strain_gap: float
    # Gap of force; None if the recording has no load cell, or the load no spring: then the contraction force is that of
    # friction and noise, and there is nothing to compare the gap with.
    force_gap: float | None
    displacement_gap: float | None  # gap of displacement; None if the recording has no displacement
    no_force_gap: str = ""  # why there is no gap of force; "" if there is one


def loop_gaps(recording: Recording, *, cycle: int | str = "last") -> LoopGaps:
    """Find A, B, C by strain, then compare heating with cooling at equal resistance from B to C.

    Parameters
    ----------
    recording
        A loop with strain.
    cycle
        Which one, as in ``find_segments``.

    Returns
    -------
    The gaps as fractions, None for a quantity without its instrument and for a force that does not rise with the
    contraction.

    Raises
    ------
    RecordingError
        If the recording has no strain or no usable loop.

    References
    ----------
    Lan and Fan 2010, Eqs. 2 and 9.
    """
    reading = resistance_reading(recording)
    strain = required_quantity(recording, "strain")
    try:
        segments = find_segments(reading.resistance_ohm, strain, reading.valid, cycle)
    except RecordingError as error:
        raise without_loop(error, recording) from None

    def gap_of(quantity: str) -> float | None:
        values = reference_quantity(recording, quantity)
        return None if values is None else gap_in(segments, reading, values)

    force = reference_quantity(recording, "force")
    no_force_gap = "no load cell" if force is None else force_is_level(force, strain, segments)
    return LoopGaps(
        segments=segments,
        strain_gap=hysteresis_gap(segments.heating, segments.cooling),
        force_gap=None if no_force_gap else gap_of("force"),
        displacement_gap=gap_of("displacement"),
        no_force_gap=no_force_gap,
    )


def force_is_level(force: FloatArray, strain: FloatArray, segments: LoopSegments) -> str:
    """Return in words that a force does not rise with the contraction, as without a spring; "" if it does."""
    heating, cooling = branches_of(segments)
    strains, forces = (np.concatenate([column[heating], column[cooling]]) for column in (strain, force))
    on_cooling = np.arange(strains.size) >= heating.stop - heating.start
    # Near the turns of the motion friction turns, too, which looks like a spring.
    inner = np.abs(strains - 0.5 * (strains.max() + strains.min())) <= INNER * np.ptp(strains)
    # One line for each branch, of the same slope: their distance is what friction of the guide adds to the loop.
    lines = np.column_stack([np.ones(strains.size), strains, on_cooling])[inner]
    slope, between_n = np.linalg.lstsq(lines, forces[inner], rcond=None)[0][1:]
    rise_n = float(slope * np.ptp(strains))
    if rise_n > max(NOISES * noise_level(force), MIN_SLOPE * abs(float(between_n))):
        return ""
    return f"the force does not rise with the contraction ({rise_n:+.3f} N over the loop), as under a weight"


def gap_in(segments: LoopSegments, reading: ArrayReading, values: FloatArray) -> float:
    """Return a quantity's gap over its largest value. Raises RecordingError if the branches share no resistance."""
    resistance, valid = reading.resistance_ohm, reading.valid
    branches = [(resistance[part][valid[part]], values[part][valid[part]]) for part in branches_of(segments)]
    return hysteresis_gap(branches[0], branches[1])


def branches_of(segments: LoopSegments) -> tuple[slice, slice]:
    """Return the samples from B to C of both branches."""
    return slice(segments.heating_b, segments.heating_c + 1), slice(segments.cooling_c, segments.cooling_b + 1)


# The middle of the stroke is compared: near its ends the friction has not reversed yet.
MIDDLE = (0.25, 0.75)
PLACES = 101
MIN_SAMPLES = 20


def guide_friction_n(recording: Recording) -> float | None:
    """Return the Coulomb friction at the connector [N]; None if a recording does not identify it.

    At equal displacement the spring's force is the same on both branches, so half the difference of the load cell's
    readings is friction: it opposes the wire in contraction and assists it on return. The last rise and fall of the
    displacement are compared. It requires ``force_n`` and ``displacement_m``.
    """
    if "force_n" not in recording or "displacement_m" not in recording:
        return None
    displacement, force = recording["displacement_m"], recording["force_n"]
    if "cycle" in recording:
        last = recording["cycle"] == recording["cycle"].max()
        displacement, force = displacement[last], force[last]
    top = int(np.argmax(displacement))
    low, high = (float(displacement.max()) * fraction for fraction in MIDDLE)
    rise = between(displacement[: top + 1], force[: top + 1], low, high)
    fall = between(displacement[top:], force[top:], low, high)
    if min(rise[0].size, fall[0].size) < MIN_SAMPLES:
        return None
    places = np.linspace(low, high, PLACES)
    apart_n = line_through(*rise, places) - line_through(*fall, places)
    return max(0.5 * float(apart_n.mean()), 0.0)


def between(
    displacement_m: FloatArray, force_n: FloatArray, low_m: float, high_m: float
) -> tuple[FloatArray, FloatArray]:
    """Return the samples of a branch between two displacements."""
    inside = (displacement_m >= low_m) & (displacement_m <= high_m)
    return displacement_m[inside], force_n[inside]


def line_through(displacement_m: FloatArray, force_n: FloatArray, places_m: FloatArray) -> FloatArray:
    """Return force over displacement by a parabola fitted to noisy samples, since a load may be slightly nonlinear."""
    centre, half = places_m.mean(), 0.5 * float(np.ptp(places_m))
    fitted = np.polyfit((displacement_m - centre) / half, force_n, 2)
    return np.asarray(np.polyval(fitted, (places_m - centre) / half))
