"""The first cycles of a new wire: training until its loop repeats.

A new wire changes in its first cycles: it keeps some strain, its resistance drifts, its hysteresis narrows
(Churchill and Shaw, SMASIS2009-48968; Hartwich et al. 2021, doi 10.3390/s21206804). A model fitted before that is over
does not stay valid. What a settled wire still drifts, a home move finds (``experiment/_home.py``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from musclewire.errors import CallerError
from musclewire.experiment._open_loop import SlowSine, characterize
from musclewire.experiment._run import OnSample, file_in
from musclewire.experiment._run_warnings import run_warnings
from musclewire.identify import required_quantity
from musclewire.judge import resistance_reading
from musclewire.rigs import Rig
from musclewire.sensing import find_segments
from musclewire.signals import Recording

TRAINING_PERIOD_S = 30.0
# A loop has settled if it has moved by less than this fraction of resistance span and of stroke over some cycles.
SETTLED_FRACTION = 0.003
CYCLES_COMPARED = 5  # cycles over which that motion is taken


@dataclass(frozen=True)
class TrainingCycle:
    """One cycle of a training.

    Parameters
    ----------
    number
        Which cycle, from 1.
    resistance_min_ohm
        Resistance at point C [ohm].
    resistance_max_ohm
        Resistance at point B [ohm].
    strain_cold
        Strain of the cold wire.
    stroke
        Strain from cold to hot.
    change
        Change over the last five cycles, as a fraction of resistance span and stroke; None before there are so many.
    """

    number: int
    resistance_min_ohm: float
    resistance_max_ohm: float
    strain_cold: float
    stroke: float
    change: float | None


@dataclass(frozen=True)
class Training:
    """A finished training.

    Parameters
    ----------
    cycles
        Every cycle, in order.
    settled
        Whether the loop repeats; False if the largest number of cycles came first.
    warnings
        The first cycle in which the wire pulled harder than it may, in a sentence for each reason; empty if none did.
    """

    cycles: tuple[TrainingCycle, ...]
    settled: bool
    warnings: tuple[str, ...] = ()


def train(
    rig: Rig,
    *,
    amplitude_v: float | None = None,
    period_s: float = TRAINING_PERIOD_S,
    max_cycles: int = 60,
    settled_fraction: float = SETTLED_FRACTION,
    folder: str | Path | None = None,
    on_cycle: Callable[[TrainingCycle], None] | None = None,
    on_sample: OnSample | None = None,
) -> Training:
    """Cycle a wire until its loop repeats: five cycles that together move it by less than 0.3 %.

    Parameters
    ----------
    rig
        The rig, open; it is driven.
    amplitude_v
        Greatest drive voltage [V]; the rig's own if None.
    period_s
        Time of a cycle [s]; 30 s are a third of the paper's slow sine.
    max_cycles
        Number of cycles after which it stops if it does not settle.
    settled_fraction
        Change over five cycles, as a fraction of resistance span and stroke, below which it is settled.
    folder
        Folder into which each cycle is recorded as it runs; nothing is written if None.
    on_cycle
        Called with each cycle once it is judged.
    on_sample
        Called with every recorded row, numbers by column name; it may raise to stop the run.

    Returns
    -------
    The cycles, whether they settled, and warnings.

    Raises
    ------
    CallerError
        For fewer than two cycles.
    RecordingError
        If the wire does not transform at all.
    """
    if max_cycles < 2:
        raise CallerError(f"max_cycles is {max_cycles}: a change needs at least 2 cycles")
    sine = SlowSine(amplitude_v=amplitude_v, period_s=period_s, cycles=1)
    cycles: list[TrainingCycle] = []
    warnings: tuple[str, ...] = ()
    for number in range(1, max_cycles + 1):
        path = None if folder is None else file_in(folder, f"cycle-{number:03d}.h5")
        recording = characterize(rig, path=path, overwrite=True, on_sample=on_sample, minor_loop=False, **sine)
        warnings = warnings or tuple(f"cycle {number}: {text}" for text in run_warnings(recording))
        cycle = cycle_of(recording, number, cycles)
        cycles.append(cycle)
        if on_cycle is not None:
            on_cycle(cycle)
        if cycle.change is not None and cycle.change < settled_fraction:
            return Training(tuple(cycles), settled=True, warnings=warnings)
    return Training(tuple(cycles), settled=False, warnings=warnings)


def cycle_of(recording: Recording, number: int, before: Sequence[TrainingCycle]) -> TrainingCycle:
    """Return the loop of one cycle with its change since earlier ones. Raises RecordingError if it is no loop."""
    reading = resistance_reading(recording)
    segments = find_segments(reading.resistance_ohm, required_quantity(recording), reading.valid)
    cycle = TrainingCycle(
        number=number,
        resistance_min_ohm=segments.resistance_min_ohm,
        resistance_max_ohm=segments.resistance_max_ohm,
        strain_cold=segments.strain_cold,
        stroke=segments.strain_max - segments.strain_cold,
        change=None,
    )
    if len(before) < CYCLES_COMPARED:
        return cycle
    return replace(cycle, change=change_between(before[-CYCLES_COMPARED], cycle))


def change_between(before: TrainingCycle, after: TrainingCycle) -> float:
    """Return the largest change of R_min, R_max, cold strain or stroke, over the span of each."""
    span = before.resistance_max_ohm - before.resistance_min_ohm
    return max(
        abs(after.resistance_min_ohm - before.resistance_min_ohm) / span,
        abs(after.resistance_max_ohm - before.resistance_max_ohm) / span,
        abs(after.strain_cold - before.strain_cold) / before.stroke,
        abs(after.stroke - before.stroke) / before.stroke,
    )
