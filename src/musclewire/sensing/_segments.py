"""Points A, B and C on both branches of a strain-resistance loop (Fig. 3b), found automatically."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError
from musclewire.sensing._branches import Branch
from musclewire.sensing._curve import SHOWN_AS
from musclewire.sensing._loop_points import LoopPoints, points_of
from musclewire.sensing._resistance_extremes import readings_first
from musclewire.sensing._smoothing import noise_level
from musclewire.sensing._turning_points import (
    MIN_SWING,
    HalfCycle,
    SmoothedRecording,
    half_cycles,
    smoothed,
    turning_points,
)

MIN_SAMPLES = 20
MIN_BRANCH_SAMPLES = 8
# A cycle is complete if it ends within this fraction of its stroke from its start.
CLOSURE = 0.15
# The stroke must be this many times the noise of strain (white noise alone spans 8), and the fall of resistance this
# many times its noise.
MIN_STROKE_NOISES = 20.0
MIN_SIGNAL = 10.0
# From B to C the strain must rise by at least this fraction of the stroke, otherwise the two are unrelated.
MIN_STRAIN_FRACTION = 0.3
# Correlation of strain and resistance over the middle of the stroke above which its sign is certain.
CERTAIN_SIGN = 0.5
# Heating without transformation raises the resistance by less than this; an inverted loop changes it by more.
THERMAL_FRACTION = 0.05
# Instrument of each quantity, and the word for its range.
INSTRUMENTS = {"strain": "strain sensor", "displacement": "displacement sensor", "force": "load cell"}
SPANS = {"strain": "a stroke", "displacement": "a stroke", "force": "a change"}


@dataclass(frozen=True, eq=False)
class LoopSegments:
    """Points A, B, C of one loop, as indices into the recording, and its branches from B to C.

    A is coldest, B has the most resistance and C the least; heating passes A, B, C and cooling C, B, A.
    """

    heating_a: int  # that of B if the loop does not return to cold; B is then where it turns
    heating_b: int  # sample next to B
    heating_c: int  # the turning point if the transformation was not completed
    cooling_c: int
    cooling_b: int
    cooling_a: int
    heating: Branch  # measured samples in the order of the recording
    cooling: Branch
    resistance_min_ohm: float  # at C on heating, after smoothing
    resistance_max_ohm: float  # at B on heating, of the polynomial through the samples around it
    strain_cold: float  # smoothed strain (or displacement [m], force [N]) at A
    strain_max: float  # on heating, smoothed
    # Of the stroke from A to C, what lies from B to C on heating; about 0.85 in the paper.
    transformation_fraction: float
    cooling_transformation_fraction: float
    returns_cold: bool
    complete: bool  # whether the transformation was completed
    resistance_noise_ohm: float  # standard deviation of one reading
    strain_noise: float  # in the unit of strain
    cycle: int  # number among the complete ones, from 0
    cycles_found: int


def find_segments(
    resistance_ohm: npt.ArrayLike,
    strain: npt.ArrayLike,
    valid: npt.ArrayLike | None = None,
    cycle: str | int = "last",
    quantity: str = "strain",
) -> LoopSegments:
    """Find A, B and C on one loop of a recording, whose columns have shape (n_times,) and contraction positive.

    ``cycle`` is "last", "first" or "largest" complete cycle, or its number (0 the first, -1 the last); the last by
    default, as it is the most stable one. Raises RecordingError if there is no transformation, the strain has the wrong
    sign, points are too few or no cycle is complete. Raises CallerError for an unknown ``cycle``.

    References
    ----------
    Lan and Fan 2010, Fig. 3(b) and its text.
    """
    signals = _UsableSamples.read(resistance_ohm, strain, valid, quantity)
    pairs = signals.cycles()
    return signals.segments(pairs, _chosen(cycle, pairs, signals.curves))


def find_loops(
    resistance_ohm: npt.ArrayLike, strain: npt.ArrayLike, valid: npt.ArrayLike | None = None
) -> list[LoopSegments]:
    """Find A, B and C on every complete cycle of a recording, as :func:`find_segments`, and raise as it does."""
    signals = _UsableSamples.read(resistance_ohm, strain, valid)
    pairs = signals.cycles()
    return [signals.segments(pairs, number) for number in range(len(pairs))]


@dataclass(frozen=True, eq=False)
class _UsableSamples:
    """The usable samples of a recording, raw and smoothed, with their indices in it."""

    place: npt.NDArray[np.intp]
    resistance_ohm: FloatArray
    strain: FloatArray
    curves: SmoothedRecording
    turns: list[int]
    starts_low: bool
    quantity: str
    left_out: str

    @classmethod
    def read(
        cls,
        resistance_ohm: npt.ArrayLike,
        strain: npt.ArrayLike,
        valid: npt.ArrayLike | None,
        quantity: str = "strain",
    ) -> _UsableSamples:
        """Return the usable samples of a recording; RecordingError if there is no transformation in them."""
        place, resistance, contraction = _usable(resistance_ohm, strain, valid, quantity)
        left_out = readings_first(place.size, np.size(resistance_ohm))
        _check_stroke(contraction, quantity, left_out)
        swing = max(MIN_SWING * float(np.ptp(contraction)), MIN_SIGNAL * noise_level(contraction))
        turns, starts_low = turning_points(contraction, swing)
        curves = smoothed(resistance, contraction, len(turns) - 1)
        _check_fall(curves, quantity, left_out)
        return cls(place, resistance, contraction, curves, turns, starts_low, quantity, left_out)

    def cycles(self) -> list[tuple[HalfCycle, HalfCycle]]:
        """Return the complete cycles as (heating, cooling); cooling may come first if no cycle starts cold."""
        halves = half_cycles(self.curves, self.turns, self.starts_low)
        neighbours = list(pairwise(halves))
        closed = [pair for pair in neighbours if _is_closed(pair, self.curves.strain)]
        from_cold = [pair for pair in closed if pair[0].rising]
        if from_cold:
            return from_cold
        if closed:
            return [(after, before) for before, after in closed]
        raise RecordingError(_no_cycle(halves, self.curves.strain, self.quantity))

    def segments(self, pairs: list[tuple[HalfCycle, HalfCycle]], number: int) -> LoopSegments:
        """Return the points and branches of a cycle."""
        heating, cooling = pairs[number]
        curves, place = self.curves, self.place
        up, down = (points_of(half, self.resistance_ohm, curves) for half in (heating, cooling))
        for half, points in ((heating, up), (cooling, down)):
            _check_branch(half, points, curves, self.quantity, self.left_out)
        return LoopSegments(
            heating_a=int(place[up.a]),
            heating_b=int(place[up.b]),
            heating_c=int(place[up.c]),
            cooling_c=int(place[down.c]),
            cooling_b=int(place[down.b]),
            cooling_a=int(place[down.a]),
            heating=self._branch(up.b, up.c),
            cooling=self._branch(down.c, down.b),
            resistance_min_ohm=float(curves.resistance_ohm[up.c]),
            resistance_max_ohm=up.at_b.resistance_ohm,
            strain_cold=float(curves.strain[up.a]),
            strain_max=float(curves.strain[heating.first : heating.last + 1].max()),
            transformation_fraction=_fraction_from_b(up, curves.strain),
            cooling_transformation_fraction=_fraction_from_b(down, curves.strain),
            returns_cold=up.returns_cold,
            complete=up.complete or down.complete,
            resistance_noise_ohm=noise_level(self.resistance_ohm),
            strain_noise=noise_level(self.strain),
            cycle=number,
            cycles_found=len(pairs),
        )

    def _branch(self, first: int, last: int) -> Branch:
        """Return the measured samples of a branch."""
        inside = slice(first, last + 1)
        return Branch(self.resistance_ohm[inside], self.strain[inside])


def _usable(
    resistance_ohm: npt.ArrayLike, strain: npt.ArrayLike, valid: npt.ArrayLike | None, quantity: str
) -> tuple[npt.NDArray[np.intp], FloatArray, FloatArray]:
    """Return indices, resistance and strain of the samples with a resistance, after a check of the columns."""
    resistance = np.asarray(resistance_ohm, dtype=np.float64)
    contraction = np.asarray(strain, dtype=np.float64)
    mask = np.ones(resistance.shape, dtype=np.bool_) if valid is None else np.asarray(valid, dtype=np.bool_)
    if resistance.ndim != 1 or not resistance.shape == contraction.shape == mask.shape:
        raise RecordingError(
            f"resistance has shape {resistance.shape}, {quantity} {contraction.shape}, valid {mask.shape}: "
            "give one wire, columns of equal length"
        )
    place = np.flatnonzero(mask)
    if place.size < MIN_SAMPLES:
        raise RecordingError(
            f"{place.size} usable samples of {mask.size}: a loop needs at least {MIN_SAMPLES}, better 200"
        )
    resistance, contraction = resistance[place], contraction[place]
    bad = ~(np.isfinite(resistance) & np.isfinite(contraction) & (resistance > 0.0))
    if bad.any():
        raise RecordingError(
            f"{int(bad.sum())} of {bad.size} samples have no finite positive resistance and finite {quantity}, "
            f"the first at index {int(place[np.argmax(bad)])}: mark them in `valid` or drop them"
        )
    return place, resistance, contraction


def _shown(value: float, quantity: str) -> str:
    """Return a value with its unit."""
    factor, unit = SHOWN_AS[quantity]
    return f"{factor * value:.3g} {unit}"


def _check_stroke(strain: FloatArray, quantity: str, left_out: str) -> None:
    """Raise RecordingError for a stroke that is not well above its noise."""
    stroke, noise = float(np.ptp(strain)), noise_level(strain)
    if stroke <= 0.0 or stroke < MIN_STROKE_NOISES * noise:
        raise RecordingError(
            f"no transformation: the {quantity} moves by {_shown(stroke, quantity)}, its noise is "
            f"{_shown(noise, quantity)}, and at least {MIN_STROKE_NOISES:g} times that are needed: "
            f"{left_out or f'raise the drive or check the {INSTRUMENTS[quantity]}'}"
        )


def _check_fall(curves: SmoothedRecording, quantity: str, left_out: str) -> None:
    """Raise RecordingError unless resistance falls with rising strain over the middle of the stroke."""
    strain, resistance = curves.strain, curves.resistance_ohm
    sign, change = _middle_trend(strain, resistance)
    if sign < -CERTAIN_SIGN:
        return
    span = f"{SPANS[quantity]} of {_shown(float(np.ptp(strain)), quantity)}"
    if sign > CERTAIN_SIGN and change >= THERMAL_FRACTION:
        backwards = "pulling must read" if quantity == "force" else "contraction must be"
        option = "" if quantity == "force" else " ('musclewire import ... --invert --zero')"
        raise RecordingError(
            f"{quantity} of the wrong sign: over {span} the resistance rises with it by {100 * change:.1f} %: "
            f"{backwards} positive, negate the {quantity}{option}"
        )
    # A wire held at both ends pulls without contracting: stress prevents most of the transformation, and its resistance
    # follows its temperature.
    wanted = "pulling" if quantity == "force" else "contraction"
    held = "a wire that can hardly contract has no such loop; if it can, " if quantity == "force" else ""
    raise RecordingError(
        f"no transformation: the resistance does not fall as the {quantity} rises over {span} "
        f"(correlation {sign:+.2f}, fall needed {-CERTAIN_SIGN:+.1f}; change {100 * change:.1f} %): "
        f"{held}{left_out or 'raise the drive voltage'}, and check that {wanted} is positive"
    )


def _middle_trend(strain: FloatArray, resistance: FloatArray) -> tuple[float, float]:
    """Return correlation of strain and resistance, and resistance's change, by means over 15 to 85 % of the stroke."""
    fraction = (strain - strain.min()) / np.ptp(strain)
    slices = np.floor((fraction - 0.15) / 0.7 * 20).astype(np.intp)
    inside = (slices >= 0) & (slices < 20)
    counts = np.bincount(slices[inside], minlength=20)
    filled = counts > 0
    if filled.sum() < 3:
        return 0.0, 0.0
    mean = np.bincount(slices[inside], weights=resistance[inside], minlength=20)[filled] / counts[filled]
    change = float(np.ptp(mean) / mean.mean())
    if np.ptp(mean) <= 1e-12 * abs(mean.mean()):
        return 0.0, change
    return float(np.corrcoef(np.flatnonzero(filled), mean)[0, 1]), change


def _is_closed(pair: tuple[HalfCycle, HalfCycle], strain: FloatArray) -> bool:
    """Return whether the second half cycle ends at the start of the first, relative to the larger stroke of the two."""
    before, after = pair
    begin, turn, end = strain[before.first], strain[before.last], strain[after.last]
    stroke = max(abs(turn - begin), abs(turn - end))
    return bool(stroke > 0.0 and abs(begin - end) <= CLOSURE * stroke)


def _no_cycle(halves: list[HalfCycle], strain: FloatArray, quantity: str) -> str:
    """Return the message on a recording without a complete cycle."""
    factor, unit = SHOWN_AS[quantity]
    story = ", ".join(
        f"{'heating' if half.rising else 'cooling'} from {factor * strain[half.first]:.3g} to "
        f"{factor * strain[half.last]:.3g} {unit}"
        for half in halves
    )
    return (
        f"no complete cycle: the recording holds only {story or 'one turning point'} ({quantity}), as if cut off: "
        f"record heating and cooling back to the {quantity} at the start"
    )


def _chosen(cycle: str | int, pairs: list[tuple[HalfCycle, HalfCycle]], curves: SmoothedRecording) -> int:
    """Return the number of the requested cycle."""
    if cycle == "last":
        return len(pairs) - 1
    if cycle == "first":
        return 0
    if cycle == "largest":
        return int(np.argmax([curves.strain[up.first : up.last + 1].max() for up, _ in pairs]))
    if not isinstance(cycle, int):
        raise CallerError(f"cycle is {cycle!r}: use 'last', 'first', 'largest' or a number")
    if not -len(pairs) <= cycle < len(pairs):
        raise CallerError(
            f"there is no cycle {cycle}: the recording holds {len(pairs)}, choose from 0 to {len(pairs) - 1}"
        )
    return cycle % len(pairs)


def _fraction_from_b(points: LoopPoints, strain: FloatArray) -> float:
    """Return the fraction of the strain from A to C that lies from B to C."""
    cold, warm = float(strain[points.a]), float(strain[points.c])
    at_b = float(np.interp(points.at_b.place, np.arange(strain.size), strain))
    return (warm - at_b) / (warm - cold)


def _check_branch(half: HalfCycle, points: LoopPoints, curves: SmoothedRecording, quantity: str, left_out: str) -> None:
    """Raise RecordingError unless resistance falls well above its noise, with enough strain, over enough samples."""
    resistance, strain = curves.resistance_ohm, curves.strain
    name = "heating" if half.rising else "cooling"
    fall = float(resistance[points.b] - resistance[points.c])
    gain = float((strain[points.c] - strain[points.b]) / np.ptp(strain[half.first : half.last + 1]))
    if fall < MIN_SIGNAL * curves.resistance_noise_ohm or gain < MIN_STRAIN_FRACTION:
        raise RecordingError(
            f"no transformation: on the {name} branch the resistance falls by {fall:.3g} ohm (its noise is "
            f"{curves.resistance_noise_ohm:.2g} ohm after smoothing) while the {quantity} gains "
            f"{100 * gain:.0f} % of its range: {left_out or 'raise the drive voltage or average more samples'}"
        )
    if strain[points.c] <= 0.0:
        raise RecordingError(
            f"no transformation: on the {name} branch the {quantity} is {_shown(float(strain[points.c]), quantity)} at "
            "minimum resistance: contraction must be positive and zero when cold, check "
            f"{left_out or 'drive voltage'}, sign and zero"
        )
    samples = abs(points.c - points.b) + 1
    if samples < MIN_BRANCH_SAMPLES:
        raise RecordingError(
            f"{samples} samples between B and C on the {name} branch, at least {MIN_BRANCH_SAMPLES} are "
            f"needed: {left_out or 'sample faster or drive more slowly'}"
        )
