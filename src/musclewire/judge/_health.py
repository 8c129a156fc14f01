"""Health of a finished closed loop: each cause for which its result may not hold, with its time, from its recording."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.judge._cause import CAUSE_TEXT, Cause
from musclewire.judge._first_heating import SeenAtB, seen_at_b
from musclewire.judge._known_strain import MissedBy, missed_known_strain
from musclewire.judge._missed_target import MAX_MISSED, MissedTarget
from musclewire.judge._odd_resistance import odd_resistance
from musclewire.judge._oscillation import Oscillation
from musclewire.judge._overshoot import Overshoot
from musclewire.judge._scale_by_b import TODAY, WITHIN_STD, what_followed
from musclewire.judge._sensed import judged_for_sensing, since_first_sensed, valid_share
from musclewire.sensing import SHOWN_AS
from musclewire.signals import COLUMN_SUFFIX, Recording, reference_quantity

NAMES = {
    Cause.SATURATION: "saturation",
    Cause.CHANGED_LOAD: "changed load",
    Cause.CHANGED_AIR: "changed air",
    Cause.OTHER_WIRE: "wrong or aged wire",
    Cause.STALLED: "stalled or slack",
    Cause.OSCILLATION: "oscillation",
    Cause.CONTRADICTED: "contradicted",
    Cause.OTHER_HEIGHT_OF_B: "changed load or resistance",
    Cause.HARDLY_SENSED: "hardly sensed",
    Cause.MISSED_KNOWN_STRAIN: "known strain missed",
    Cause.BAD_CONTACT: "bad contact",
    Cause.OVERSHOOT: "overshoot",
    Cause.TARGET_MISSED: "target missed",
    Cause.WIDE_INTERVAL: "interval too wide",
}
# The drive is at a limit within this fraction of it; a target is missed by more than this part of the range of targets.
AT_LIMIT, NOT_REACHED = 0.01, 0.05
# How long [s] heating and cooling may be at their limit: cooling takes its time, and no drive shortens it.
HEATING_S, COOLING_S = 1.0, 4.0
# The resistance of a wire that heats at the upper limit follows by more than this fraction within that time.
FOLLOWS = 0.005
# What alone makes a result doubtful; changed air does not, if the estimator that has found it takes it into account.
GRAVE = (
    Cause.CHANGED_LOAD,
    Cause.OTHER_WIRE,
    Cause.STALLED,
    Cause.CONTRADICTED,
    Cause.OTHER_HEIGHT_OF_B,
    Cause.HARDLY_SENSED,
    Cause.MISSED_KNOWN_STRAIN,
    Cause.BAD_CONTACT,
    Cause.TARGET_MISSED,
    Cause.WIDE_INTERVAL,
)
# An instrument contradicts an estimate if more than this part of the valid samples are beyond the interval: errors last
# for a step, and of the paper's eleven steps two are beyond by chance in one run of ten, three in 1.5 %.
MAX_BEYOND = 0.25
# A closed loop with a smaller part of valid samples was not closed.
MIN_VALID_FRACTION = 0.8


class TimedFinding(NamedTuple):
    """A cause: when it was first found [s], for how long [s] in total, whether the run holds, its numbers in words."""

    cause: Cause
    from_s: float
    lasted_s: float
    grave: bool
    numbers: str = ""

    @property
    def answer(self) -> dict[str, object]:
        """The finding as a JSON object."""
        return {
            "cause": self.cause.name.lower(),
            "from_s": self.from_s,
            "lasted_s": self.lasted_s,
            "grave": self.grave,
            "numbers": self.numbers,
        }


def findings(recording: Recording) -> tuple[TimedFinding, ...]:
    """Return what is wrong in a closed loop, in the order of time; nothing for a recording without a target.

    Parameters
    ----------
    recording
        A closed loop with drive, target and estimate; with the column ``health``, what its estimator has found counts,
        too.

    Returns
    -------
    One finding for each cause.
    """
    period_s = period_of(recording)
    found = [
        TimedFinding(
            cause,
            float(recording["time_s"][np.argmax(where)]),
            float(where.sum()) * period_s,
            is_grave(cause, where, recording),
            numbers_of(cause, recording),
        )
        for cause, where in marks_of(recording).items()
        if where.any()
    ]
    return tuple(sorted(found, key=lambda finding: finding.from_s))


def marks_of(recording: Recording) -> dict[Cause, npt.NDArray[np.bool_]]:
    """Return the samples at which each cause was found, (n_times,) each; none for a recording without a target."""
    suffix = sensed_suffix(recording)
    if not suffix or not len(recording) or f"estimated_{suffix}" not in recording:
        return {}
    marked = {Cause.SATURATION: saturated(recording, suffix), Cause.STALLED: stalled(recording, suffix)}
    marked[Cause.SATURATION] &= ~marked[Cause.STALLED]
    marked[Cause.CONTRADICTED] = contradicted(recording, suffix)
    odd = odd_resistance(recording)
    marked[Cause.OTHER_HEIGHT_OF_B] = from_row_on(recording, seen_at_b(recording)) | since_first(recording, odd.above)
    marked[Cause.BAD_CONTACT] = since_first(recording, odd.jumps)
    marked[Cause.OVERSHOOT] = Overshoot(recording, suffix).rows
    marked[Cause.OSCILLATION] = Oscillation(recording, suffix).rows
    missed = MissedTarget(recording, suffix, with_target(recording))
    marked[Cause.TARGET_MISSED], marked[Cause.WIDE_INTERVAL] = missed.rows, missed.hidden
    marked[Cause.HARDLY_SENSED] = hardly_sensed(recording)
    marked[Cause.MISSED_KNOWN_STRAIN] = from_row_on(recording, missed_known_strain(recording))
    if "health" in recording:
        for cause in (Cause.CHANGED_LOAD, Cause.CHANGED_AIR, Cause.OTHER_WIRE):
            marked[cause] = recording["health"] == float(cause)
    return marked


def flagged(recording: Recording) -> npt.NDArray[np.bool_]:
    """Return the samples at which a cause was found for which a run does not hold, (n_times,)."""
    return any_of(recording, grave=True)


def noted(recording: Recording) -> npt.NDArray[np.bool_]:
    """Return the samples at which only causes were found with which a run holds, (n_times,)."""
    return any_of(recording, grave=False) & ~flagged(recording)


def any_of(recording: Recording, *, grave: bool) -> npt.NDArray[np.bool_]:
    """Return the samples at which a cause was found that is grave, or one that is not, (n_times,)."""
    none = np.zeros(len(recording), dtype=np.bool_)
    marks = marks_of(recording).items()
    return np.asarray(np.any([none, *(on for cause, on in marks if is_grave(cause, on, recording) is grave)], axis=0))


def is_grave(cause: Cause, where: npt.NDArray[np.bool_], recording: Recording) -> bool:
    """Return whether a run with a cause at some samples does not hold: saturation is grave if it takes long."""
    return cause in GRAVE or (cause is Cause.SATURATION and where.sum() > MAX_MISSED * with_target(recording).sum())


def numbers_of(cause: Cause, recording: Recording) -> str:
    """Return the numbers of a finding in words; "" for a cause that has none."""
    if cause is Cause.CONTRADICTED:
        return contradiction_in_words(recording, sensed_suffix(recording))
    if cause is Cause.OTHER_HEIGHT_OF_B:
        return in_words_at_b(recording)
    if cause is Cause.BAD_CONTACT:
        odd = odd_resistance(recording)
        often = "once" if odd.jumps.size == 1 else f"{odd.jumps.size} times"
        return f"{often}, by up to {odd.largest_jump_pct:.0f} % of the span from B to C"
    if cause is Cause.OVERSHOOT:
        return str(Overshoot(recording, sensed_suffix(recording)))
    if cause is Cause.OSCILLATION:
        return str(Oscillation(recording, sensed_suffix(recording)))
    if cause is Cause.TARGET_MISSED:
        return missed_in_words(recording)
    if cause is Cause.MISSED_KNOWN_STRAIN:
        return miss_in_words(recording)
    if cause is Cause.HARDLY_SENSED:
        return f"{100.0 * valid_share(recording):.0f} % of the samples could be sensed"
    return ""


def health_metadata(recording: Recording) -> dict[str, str]:
    """Return the findings of a closed loop for its own metadata, under ``health``; nothing if all is well."""
    found = findings(recording)
    said = [
        f"{NAMES[one.cause]} at {one.from_s:.2f} s for {one.lasted_s:.2f} s{in_brackets(one.numbers)}" for one in found
    ]
    return {"health": "; ".join(said)} if said else {}


def health_warnings(recording: Recording) -> tuple[str, ...]:
    """Return a warning for each finding: cause, time and what to do."""
    return tuple(
        f"{NAMES[one.cause]} from {one.from_s:.1f} s on, {one.lasted_s:.1f} s in total{in_brackets(one.numbers)}: "
        f"{CAUSE_TEXT[one.cause]}"
        for one in findings(recording)
    )


def in_brackets(numbers: str) -> str:
    """Return numbers as an insertion."""
    return f" ({numbers})" if numbers else ""


def does_not_hold(recording: Recording) -> str:
    """Return why a closed loop's result does not hold: model, load, grave causes, long at a limit; "" if it does."""
    stated = (recording.facts.text_or_none(name) for name in ("model_does_not_hold", "other_load"))
    grave = (NAMES[one.cause] for one in findings(recording) if one.grave)
    return "; ".join(one for one in (*stated, *grave) if one)


def with_target(recording: Recording) -> npt.NDArray[np.bool_]:
    """Return the samples after the approach, (n_times,)."""
    approach_s = recording.facts.number_or_none("approach_s") or 0.0
    return np.asarray(recording["time_s"] - recording["time_s"][0] > approach_s - 0.5 * period_of(recording))


def sensed_suffix(recording: Recording) -> str:
    """Return the ending of the columns of the quantity that a loop has controlled; "" of what is no closed loop."""
    return next((one for one in COLUMN_SUFFIX.values() if f"target_{one}" in recording), "")


def errors_of(recording: Recording, suffix: str) -> FloatArray | None:
    """Return the estimate's errors against the instrument; None without an instrument or a stated deviation."""
    quantity = next(name for name, one in COLUMN_SUFFIX.items() if one == suffix)
    measured = reference_quantity(recording, quantity)
    if measured is None or "estimate_std" not in recording:
        return None
    return np.asarray(recording[f"estimated_{suffix}"] - measured)


def contradicted(recording: Recording, suffix: str) -> npt.NDArray[np.bool_]:
    """Return the samples at which the instrument is beyond the estimate's interval, if they are too many; else none."""
    none = np.zeros(len(recording), dtype=np.bool_)
    error = errors_of(recording, suffix)
    if error is None:
        return none
    judged = (recording["valid"] > 0.0) & since_first_sensed(recording)
    beyond = judged & (np.abs(error) > WITHIN_STD * recording["estimate_std"])
    return beyond if beyond.sum() > MAX_BEYOND * judged.sum() else none


def contradiction_in_words(recording: Recording, suffix: str) -> str:
    """Return in words how far the instrument is from the estimate where it contradicts it."""
    error, beyond = errors_of(recording, suffix), contradicted(recording, suffix)
    if error is None:
        return ""
    estimated = recording[f"estimated_{suffix}"]
    stroke = max(float(np.ptp(estimated - error)), float(np.ptp(estimated)))
    said = f"{100.0 * beyond.mean():.0f} % of the samples"
    if stroke == 0.0:
        return said
    rms_pct = 100.0 * float(np.sqrt(np.mean(error[beyond] ** 2))) / stroke
    return f"{said}, by {rms_pct:.1f} % rms of the stroke"


def from_row_on(recording: Recording, found: SeenAtB | MissedBy | None) -> npt.NDArray[np.bool_]:
    """Return the samples from the row on at which something was found beyond its limit; none if it was not."""
    rows = [found.row] if found is not None and found.is_away else []
    return since_first(recording, np.array(rows, dtype=np.intp))


def since_first(recording: Recording, rows: npt.NDArray[np.intp]) -> npt.NDArray[np.bool_]:
    """Return the samples from the first of some rows on; none of no rows."""
    return np.arange(len(recording)) >= (rows[0] if rows.size else len(recording))


def in_words_at_b(recording: Recording) -> str:
    """Return in words where B of the first heating is, and what a run from today's zero has made of it.

    Of one at the model's height, or that was not seen, in words how far above the slow loop the resistance was.
    """
    seen = seen_at_b(recording)
    if seen is None or not seen.is_away:
        above_pct = odd_resistance(recording).above_pct
        return f"up to {above_pct:.0f} % of the span from B to C above all that the model's slow loop showed"
    from_today = recording.facts.text_or_none("zero_from") == TODAY
    return f"{seen}; {what_followed(seen)}" if from_today else str(seen)


def missed_in_words(recording: Recording) -> str:
    """Return in words for how much of the time and by how much a target was missed, and the cause, where it is known.

    Known is what was there at more than half of the samples that miss.
    """
    suffix = sensed_suffix(recording)
    missed = MissedTarget(recording, suffix, with_target(recording))
    rows, below, none = missed.rows, missed.away < 0.0, np.zeros(len(recording), dtype=np.bool_)
    known = {
        "the protection": below & at_lower_limit(recording),
        "no valid estimate": below & (recording["valid"] == 0.0) if "valid" in recording else none,
        "the supply": below & at_upper_limit(recording),
        "the power that holds the highest temperature": below & power_limited(recording),
        "cooling": ~below & at_lower_limit(recording),
        "the air": recording["health"] == float(Cause.CHANGED_AIR) if "health" in recording else none,
    }
    why = next((f": {name}" for name, there in known.items() if (there & rows).sum() > 0.5 * rows.sum()), "")
    quantity = next(name for name, one in COLUMN_SUFFIX.items() if one == suffix)
    factor, unit = SHOWN_AS[quantity]
    missed_pct = 100.0 * rows.sum() / with_target(recording).sum()
    return f"{missed_pct:.0f} % of the time, by up to {factor * np.abs(missed.away[rows]).max():.2g} {unit}{why}"


def miss_in_words(recording: Recording) -> str:
    """Return in words by how much the estimate missed a known strain, and what was done about it."""
    missed = missed_known_strain(recording)
    if missed is None:
        return ""
    quantity = next(name for name, one in COLUMN_SUFFIX.items() if one == sensed_suffix(recording))
    factor, unit = SHOWN_AS[quantity]
    side = "above" if missed.above > 0.0 else "below"
    return (
        f"by {factor * abs(missed.above):.2g} {unit} {side}, beyond +-{factor * WITHIN_STD * missed.std:.2g} {unit}; "
        f"the resistance is scaled by {recording['resistance_factor'][-1]:.4f}"
    )


def hardly_sensed(recording: Recording) -> npt.NDArray[np.bool_]:
    """Return the samples that could not be sensed, if they are too many; else none."""
    if "valid" not in recording or valid_share(recording) >= MIN_VALID_FRACTION:
        return np.zeros(len(recording), dtype=np.bool_)
    return judged_for_sensing(recording) & ~(recording["valid"] > 0.0)


def saturated(recording: Recording, suffix: str) -> npt.NDArray[np.bool_]:
    """Return the samples from which on the drive has been at a limit for too long without reaching the target."""
    above, below = beyond_target(recording, suffix)
    # A drive at its lower limit though the wire is to heat is what the protection gave instead.
    heating = (at_upper_limit(recording) | at_lower_limit(recording) | power_limited(recording)) & below
    cooling = above & at_lower_limit(recording)
    period_s = period_of(recording)
    return lasting(heating, round(HEATING_S / period_s)) | lasting(cooling, round(COOLING_S / period_s))


def stalled(recording: Recording, suffix: str) -> npt.NDArray[np.bool_]:
    """Return the samples at which the drive is at its upper limit and the resistance has not followed for a while."""
    _, below = beyond_target(recording, suffix)
    length = max(round(HEATING_S / period_of(recording)), 1)
    ohm = recording["wire_resistance_ohm"] if "wire_resistance_ohm" in recording else np.zeros(0)
    if ohm.size <= 2 * length:
        return np.zeros(len(recording), dtype=np.bool_)
    moved = np.full(ohm.size, np.inf)
    moved[length:] = np.abs(ohm[length:] - ohm[:-length]) / np.maximum(ohm[length:], 1e-9)
    return lasting(at_upper_limit(recording) & below & (moved < FOLLOWS), 2 * length)


def at_upper_limit(recording: Recording) -> npt.NDArray[np.bool_]:
    """Return the samples at which the drive is at its upper limit."""
    high_v = recording.facts.number_or_none("limit_maximum_voltage_v")
    return recording["drive_voltage_v"] >= (high_v or np.inf) * (1.0 - AT_LIMIT)


def at_lower_limit(recording: Recording) -> npt.NDArray[np.bool_]:
    """Return the samples at which the drive is at its lower limit."""
    low_v = recording.facts.number_or_none("limit_sense_voltage_v")
    return np.asarray(recording["drive_voltage_v"] <= (low_v or 0.0) * (1.0 + AT_LIMIT))


def power_limited(recording: Recording) -> npt.NDArray[np.bool_]:
    """Return the samples at which the controller gave no more, since that holds the highest temperature."""
    column = recording["power_limited"] if "power_limited" in recording else np.zeros(len(recording))
    return np.asarray(column > 0.0)


def beyond_target(recording: Recording, suffix: str) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Return the samples at which the estimate is well above and well below the target, after approach and first B."""
    target, value = recording[f"target_{suffix}"], recording[f"estimated_{suffix}"]
    enough = NOT_REACHED * max(float(np.ptp(target)), 0.1 * float(np.abs(target).max()))
    after = with_target(recording) & since_first_sensed(recording)
    return after & (value - target > enough), after & (target - value > enough)


def lasting(marked: npt.NDArray[np.bool_], length: int) -> npt.NDArray[np.bool_]:
    """Return the marked samples before which at least ``length`` have been marked without a gap."""
    place = np.arange(marked.size)
    since = place - np.maximum.accumulate(np.where(marked, -1, place))
    return np.asarray(marked & (since >= length))


def period_of(recording: Recording) -> float:
    """Return the time between two samples [s]."""
    time_s = recording["time_s"]
    return float(np.median(np.diff(time_s))) if time_s.size > 1 else 1.0
