"""The hysteresis gaps of one recorded loop: strain, force and displacement (Eqs. 2 and 9)."""

from __future__ import annotations

from dataclasses import dataclass

from musclewire.errors import RecordingError
from musclewire.identify.recordings import reference_quantity, required_quantity, resistance_reading, without_loop
from musclewire.sensing.gaps import hysteresis_gap
from musclewire.sensing.segments import LoopSegments, find_segments
from musclewire.signals.recording import Recording

__all__ = ["LoopGaps", "loop_gaps"]


@dataclass(frozen=True)
class LoopGaps:
    """Gaps of one loop as fractions of the largest value of the quantity (Eqs. 2 and 9).

    Parameters
    ----------
    segments
        Points A, B and C of the loop.
    strain_gap
        Gap of strain.
    force_gap
        Gap of force; None if the recording has no load cell.
    displacement_gap
        Gap of displacement; None if the recording has no displacement.
    """

    segments: LoopSegments
    strain_gap: float
    force_gap: float | None
    displacement_gap: float | None


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
    The gaps as fractions, None for a quantity without its instrument.

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
    heating = slice(segments.heating_b, segments.heating_c + 1)
    cooling = slice(segments.cooling_c, segments.cooling_b + 1)
    resistance, valid = reading.resistance_ohm, reading.valid

    def gap_of(quantity: str) -> float | None:
        values = reference_quantity(recording, quantity)
        if values is None:
            return None
        branches = [(resistance[part][valid[part]], values[part][valid[part]]) for part in (heating, cooling)]
        return hysteresis_gap(branches[0], branches[1])

    return LoopGaps(
        segments=segments,
        strain_gap=hysteresis_gap(segments.heating, segments.cooling),
        force_gap=gap_of("force"),
        displacement_gap=gap_of("displacement"),
    )
