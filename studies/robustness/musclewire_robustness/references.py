"""The four references of the benchmark, in strain, as functions of time from 0 on."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from musclewire import CallerError, FloatArray, staircase
from musclewire.errors import nearest_hint

# Where random targets lie, in full strokes: inside of the range that is judged.
LOW, HIGH = 0.18, 0.93
# The paper's staircase, in strain.
STEP_S = 6.0
STREAM = 15
Reference = Callable[[FloatArray, float, np.random.Generator], FloatArray]


def stairs(time_s: FloatArray, stroke: float, random: np.random.Generator) -> FloatArray:  # noqa: ARG001
    """Return the paper's staircase, over and over: 1.5 to 3.0 % strain and back, six seconds each."""
    levels = np.array(staircase().levels[:-1])
    place = (time_s // STEP_S).astype(np.int64) % levels.size
    return np.asarray(np.minimum(levels[place], HIGH * stroke))


def random_steps(time_s: FloatArray, stroke: float, random: np.random.Generator) -> FloatArray:
    """Return random levels held for 2 to 6 s."""
    count = int(time_s[-1] / 2.0) + 2
    starts = np.concatenate([[0.0], np.cumsum(random.uniform(2.0, 6.0, count))])
    levels = stroke * random.uniform(LOW, HIGH, count + 1)
    return np.asarray(levels[np.searchsorted(starts, time_s + 1e-9, side="right") - 1])


def sines(time_s: FloatArray, stroke: float, random: np.random.Generator) -> FloatArray:
    """Return two sines of 23 s and 7 s, with random phases."""
    phases = random.uniform(0.0, 2.0 * np.pi, 2)
    wave = 0.65 * np.sin(2.0 * np.pi * time_s / 23.0 + phases[0]) + 0.35 * np.sin(
        2.0 * np.pi * time_s / 7.0 + phases[1]
    )
    return np.asarray(stroke * (0.5 * (LOW + HIGH) + 0.5 * (HIGH - LOW) * wave))


def minor_loops(time_s: FloatArray, stroke: float, random: np.random.Generator) -> FloatArray:
    """Return ramps of 0.1 to 0.4 strokes a second between random turning points."""
    times, levels = [0.0], [0.5 * (LOW + HIGH) * stroke]
    while times[-1] < time_s[-1]:
        level = stroke * random.uniform(LOW, HIGH)
        rate = stroke * random.uniform(0.1, 0.4)
        times.append(times[-1] + max(abs(level - levels[-1]) / rate, 0.2))
        levels.append(level)
    return np.interp(time_s, times, levels)


REFERENCES: Mapping[str, Reference] = {
    "staircase": stairs,
    "random steps": random_steps,
    "sines": sines,
    "minor loops": minor_loops,
}


def require_reference(name: str) -> None:
    """Raise CallerError for an unknown reference, suggesting the nearest."""
    if name not in REFERENCES:
        raise CallerError(f"there is no reference '{name}'{nearest_hint(name, REFERENCES)}")


def reference_targets(name: str, time_s: FloatArray, stroke: float, seed: int) -> FloatArray:
    """Return the targets of a reference.

    Parameters
    ----------
    name
        One of ``REFERENCES``.
    time_s
        Times from 0 on [s], (n_samples,).
    stroke
        Full stroke of the wire, as its user knows it.
    seed
        Seed of the wire: each has random targets of its own.

    Returns
    -------
    The targets as strain, (n_samples,).

    Raises
    ------
    CallerError
        For an unknown reference.
    """
    require_reference(name)
    random = np.random.default_rng([STREAM, seed, list(REFERENCES).index(name)])
    return REFERENCES[name](np.asarray(time_s, dtype=np.float64), stroke, random)


def start_up(time_s: FloatArray, stroke: float, first: float, duration_s: float) -> FloatArray:
    """Return the loop before a reference: from cold nearly to the full stroke, low, and to the first target."""
    knots = (0.0, 0.45 * duration_s, 0.8 * duration_s, duration_s)
    return np.interp(time_s, knots, (0.0, 0.97 * stroke, 0.1 * stroke, first))
