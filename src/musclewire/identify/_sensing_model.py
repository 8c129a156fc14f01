"""Fit a self-sensing model to a recording, and use one on a recording, where the wire is between B and C."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, FitRejectedError, RecordingError, an_object, argument, joined
from musclewire.identify._extrapolation import hot_end
from musclewire.identify._loop_gaps import guide_friction_n
from musclewire.identify._open_loop_estimate import open_loop_estimate
from musclewire.identify._recordings import (
    DIVIDED_BY,
    has_power,
    heating_power_w,
    measured_quantity,
    over_cold_resistance,
    required_quantity,
    why_no_reference,
    without_loop,
)
from musclewire.identify._tuning import stated_heat_balance, with_gains
from musclewire.identify._use_of_model import OF_A_WIRE_FILE, check_wire_file, users_wire
from musclewire.identify._zero_of_room import NOTE, ROOM, cold_contraction_per_k
from musclewire.judge import (
    ErrorGroup,
    JudgedEstimate,
    JudgedRecording,
    coarse_readings,
    measured_rows,
    recording_defects,
    resistance_reading,
)
from musclewire.physics import ArrayReading
from musclewire.sensing import (
    AMBIGUOUS_ABOVE,
    ESTIMATORS,
    PAPER_ESTIMATOR,
    Estimator,
    EstimatorFactory,
    EstimatorSetup,
    Rows,
    SensingModel,
    WireMotion,
    centred_mean,
    default_estimator,
    estimates,
    find_loops,
    find_segments,
    fit_branches,
    fit_loop,
    other_wires,
    segment_course,
    with_wire_model,
)
from musclewire.signals import COLUMN_SUFFIX, Reason, Recording, WireSample, asked_once
from musclewire.wire import WireConstants

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Samples that are averaged: at the sense voltage the noise of one is as large as the change of resistance that counts,
# and that of a mean a fifth of it. A loop has to do without, since half of them lie in the future.
MEAN_SAMPLES = 33


def in_sensing_segment(model: SensingModel, recording: Recording, reading: ArrayReading) -> NDArray[np.bool_]:
    """Return where the wire is between B and C, (n_times,); without power, where no cold wire has this resistance."""
    if not has_power(recording):
        span = model.resistance_max_ohm - model.resistance_min_ohm
        return reading.resistance_ohm < model.resistance_min_ohm + AMBIGUOUS_ABOVE * span
    some_ohm = np.where(reading.valid, reading.resistance_ohm, 1.0)
    power_w = heating_power_w(recording, some_ohm)
    return sensed_since_extremes(model, reading.resistance_ohm, power_w, reading.valid)


def sensed_since_extremes(
    model: SensingModel, resistance_ohm: FloatArray, power_w: FloatArray, valid: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return where the wire is sensed, with each change of segment dated back to the extreme it is counted from.

    A loop learns that B is behind it only when the resistance has moved by 2 % of its span, which takes a slowly
    cooling wire a quarter of a minute. In a whole recording it is known when the resistance turned.
    """
    sensing = np.zeros(resistance_ohm.shape, dtype=np.bool_)
    rows = np.flatnonzero(valid)
    if rows.size == 0:
        return sensing
    calm_ohm, calm_w = (centred_mean(values[rows], MEAN_SAMPLES) for values in (resistance_ohm, power_w))
    found, anchor_ohm = segment_course(model.resistance_min_ohm, model.resistance_max_ohm, calm_ohm, calm_w)
    turns = np.append(0, 1 + np.flatnonzero(np.diff(anchor_ohm)))
    dated = found.copy()
    for row in 1 + np.flatnonzero(np.diff(found)):
        turned_at = turns[turns < row][-1]
        dated[turned_at + 1 : row] = found[row]
    sensing[rows] = dated
    return sensing


PAPER_ORDER = 6
WRONG_FRACTION = 0.05  # of the stroke: a sample with a larger error is wrong
MAX_WRONG = 0.005  # of the samples: with more wrong ones a model does not hold
WIRE_NOTES = (
    "wire",
    "wire_diameter_m",
    "wire_length_m",
    "leg_length_m",
    "pretension_n",
    "finger",
    "spring_stiffness_n_per_m",
    DIVIDED_BY,
)
# Bounds of the resistance of any wire over the cold one: readings within them are such ratios, not ohms.
MIN_RATIO = 0.8
MAX_RATIO = 1.5
# Rows of the loop that a model keeps for its home moves.
LOOP_ROWS = 300
MOTION_ROWS = 2000  # rows to which the motion of a recording is averaged before it shows how fast its wire is
MAX_CYCLES = 5  # cycles, the last ones, whose scatter shows how well the numbers of one repeat
WITHOUT_INSTRUMENT = "without an instrument name the wire: 'musclewire fit RECORDING --wire WIRE', or fit_resistance"
# What is said of a wrong average where it is not known which branch the wire is on.
UNTRIED = (
    "the recording has no current, by whose change a loop's estimator knows heating from cooling, so that only the "
    "average of both branches could be tried; record the wire's voltage or current with its resistance"
)
ALWAYS_COLD = "the wire was never warmer than where the model begins"
# A recording is warned of from this fraction of readings outside the range on: fewer are noise at its ends.
MIN_OUTSIDE = 0.01
# Why a model of resistance over the cold wire's has no gains, and how its numbers are to be read.
NO_OHMS = "the model is of resistance over the cold wire's, and no rig takes it"
OVER_COLD = "all resistances of this model, in ohm here, are parts of"
# What gives an estimate where the particle filter has no valid sample.
OPEN_LOOP = "open-loop simulation"


def fit(
    recording: Recording | npt.ArrayLike,
    measured: npt.ArrayLike | None = None,
    *,
    order: int | str = PAPER_ORDER,
    quantity: str = "strain",
    cycle: int | str = "last",
    relative_resistance: bool = False,
) -> SensingModel:
    """Fit the self-sensing model (Eqs. 3 to 5) to a slow loop, a recording or arrays, or to a printed table.

    Where the loop shows the plant, the model keeps the gains for it, as ``tune`` finds them; ``control`` takes them.
    Where the recording has the current, it goes through the estimator of a closed loop with this model, as by
    :func:`estimate`; if more than 0.5 % of the samples that count are more than 5 % of the stroke wrong, the model says
    that it does not hold. Of a recording that was interpolated by straight lines the measured rows count, and the model
    says so.

    Parameters
    ----------
    recording
        A slow loop, as ``characterize`` records it: resistance (or both voltages and the shunt) and the quantity to be
        sensed. Or a printed table: strain on both branches over resistance. Or an array of the wire's resistance [ohm],
        (n_times,), with ``measured``.
    measured
        Only with an array of resistance: strain as a fraction, displacement [m] or force [N] at the same moments,
        (n_times,), contraction positive; by ``quantity`` which. Without voltages the model has no gains.
    order
        Order of the polynomials: a number, the paper's is 6, or "auto" for the one that cross-validation chooses.
    quantity
        The quantity that the model senses: "strain", "displacement" or "force".
    cycle
        "last", "first" or "largest" complete cycle, or its number. By default the last, which is nearest to the loop
        that the wire repeats.
    relative_resistance
        Whether the model is of resistance over that of the cold wire, with which each recording must begin: then it
        estimates recordings of other wires or coils of the kind, too. No rig takes it.

    Returns
    -------
    The model, with residuals and warnings, with the gains of its loop, or why it has none (``no_gains``), and with why
    it does not hold (``does_not_hold``).

    Raises
    ------
    CallerError
        If one of both arrays is missing, or they are not of one length.
    RecordingError
        For a recording without a usable loop, or without a fact that the fit requires (shunt, length).
    FitRejectedError
        For a fit that cannot be inverted.

    References
    ----------
    Lan and Fan 2010, Eqs. 3 to 5.

    Examples
    --------
    >>> import musclewire as mw
    >>> with mw.open_rig("simulated") as rig:
    ...     model = mw.fit(mw.characterize(rig))
    >>> f"{1e2 * model.strain(16.0):.1f} % strain at 16 ohm"
    '2.5 % strain at 16 ohm'
    """
    if relative_resistance and (not isinstance(recording, Recording) or recording.is_branch_table):
        raise CallerError(
            argument("relative_resistance", True) + " is for a recording that begins with the cold wire: divide arrays"
        )
    if not isinstance(recording, Recording):
        return fit_arrays(recording, measured, order, cycle, quantity)
    if measured is not None:
        raise CallerError("a recording holds what was measured: give fit the recording alone, or two arrays")
    if recording.is_branch_table:
        return fit_table(recording, order)
    interpolated = measured_rows(recording)
    recording = given = interpolated.kept
    cold_ohm = 1.0
    if relative_resistance:
        recording, cold_ohm = over_cold_resistance(given)
    # What is said of readings, heat and limits is of those that were recorded; only the curve is of divided ones.
    reading, measured = reading_and_quantity(given, quantity)
    reading = reading._replace(resistance_ohm=reading.resistance_ohm / cold_ohm)
    notes = loop_notes(given, None if quantity == "force" else measured) | wire_notes(recording)
    source = given.facts.text_or_none("source") or ""
    against = (*recording_defects(given, quantity), *not_done(given), *interpolated.said)
    unusable = asked_once(given, JudgedRecording).measured[1]
    try:
        model = fit_loop(
            reading.resistance_ohm,
            measured,
            reading.valid,
            order,
            cycle,
            quantity,
            wire=notes,
            source=source,
            hot_end=hot_end(given),
        )
    except (RecordingError, FitRejectedError) as error:
        why = without_loop(error, recording) if isinstance(error, RecordingError) else error
        against = (*unusable, *against)
        if coarse_readings(given, quantity):  # whether the drive is too low is not known then
            raise RecordingError(f"no loop can be read: {'; '.join(against)}") from None
        raise (type(why)(f"{why} ({'; '.join(against)})") if against else why) from None
    model = replace(model, slow_loop=power_loop(recording, reading, measured, cycle, quantity))
    stated = None
    if relative_resistance:
        model = replace(model, no_gains=NO_OHMS)
        against = (*against, f"{OVER_COLD} the {cold_ohm:.4g} ohm of the cold wire")
    else:
        stated = stated_heat_balance(model, recording.facts)
    loops, motion = cycles_and_motion(recording, reading, measured, model)
    model = with_wire_model(model, loops, motion, minor_loop_motion(given, cold_ohm, model), stated)
    if not relative_resistance:
        model = with_gains(model, recording.facts)
    said = (*model.warnings, *unusable, *against)
    return replace(model, warnings=said, does_not_hold=why_loop_is_wrong(model, given))


def why_loop_is_wrong(model: SensingModel, recording: Recording) -> str:
    """Return why a loop by a model is wrong by its own recording, "" if it is not; without a current by the average."""
    try:
        wrong = estimate(model, recording).does_not_hold
    except RecordingError as error:  # nothing of its own loop can be estimated
        return str(error)
    return f"{wrong}: {UNTRIED}" if wrong and not asked_once(recording, JudgedRecording).has_current else wrong


def fit_arrays(
    resistance_ohm: npt.ArrayLike, measured: npt.ArrayLike | None, order: int | str, cycle: int | str, quantity: str
) -> SensingModel:
    """Return the model of a loop in arrays; samples that are not finite are left out. Raises as :func:`fit` does."""
    if measured is None:
        read = ": read_recording opens a file" if isinstance(resistance_ohm, str | Path) else ""
        raise CallerError(
            f"fit takes a recording, or the resistance and the measured {quantity} as two arrays, not "
            f"{an_object(resistance_ohm)} alone{read}"
        )
    resistance, values = np.asarray(resistance_ohm, dtype=float), np.asarray(measured, dtype=float)
    if resistance.ndim != 1 or resistance.shape != values.shape:
        raise CallerError(
            f"resistance has the shape {resistance.shape} and the measured {quantity} {values.shape}: both are "
            "(n_times,)"
        )
    finite = np.isfinite(resistance) & np.isfinite(values)
    model = fit_loop(resistance, values, finite, order, cycle, quantity, source="arrays")
    return replace(model, no_gains="two arrays show no power; a recording with voltages does")


def power_loop(
    recording: Recording, reading: ArrayReading, measured: FloatArray, cycle: int | str, quantity: str
) -> tuple[tuple[float, float, float], ...]:
    """Return time [s], power [W] and resistance [ohm] of the fitted loop and a fifth around it; none without power."""
    if not has_power(recording):
        return ()
    loop = find_segments(reading.resistance_ohm, measured, reading.valid, cycle, quantity)
    first, last = sorted((loop.heating_a, loop.cooling_a))
    around = (last - first) // 5
    there = np.flatnonzero(reading.valid)
    there = there[(there >= first - around) & (there <= last + around)]
    resistance = reading.resistance_ohm[there]
    power_w = heating_power_w(recording, resistance, there)
    rows = np.stack([recording["time_s"][there], power_w, resistance])
    means = [part.mean(axis=1) for part in np.array_split(rows, min(LOOP_ROWS, there.size), axis=1)]
    return tuple((float(f"{t:.7g}"), float(f"{p:.7g}"), float(f"{r:.7g}")) for t, p, r in means)


def cycles_and_motion(
    recording: Recording, reading: ArrayReading, measured: FloatArray, model: SensingModel
) -> tuple[list[Rows], WireMotion | None]:
    """Return the loop of each of the last cycles, and the motion in all of the recording; none without power."""
    if not model.slow_loop:
        return [], None
    cycles = len(find_loops(reading.resistance_ohm, measured, reading.valid))
    loops = [
        power_loop(recording, reading, measured, number, model.quantity)
        for number in range(max(cycles - MAX_CYCLES, 0), cycles)
    ]
    return loops, motion_in(recording, reading, measured, model)


def minor_loop_motion(recording: Recording, cold_ohm: float, model: SensingModel) -> WireMotion | None:
    """Return the motion in the minor loop of a recording; None without one, without power or without the quantity."""
    if recording.minor_loop is None or not model.slow_loop:
        return None
    try:
        reading, measured = reading_and_quantity(recording.minor_loop, model.quantity)
    except RecordingError:  # the run was cut off too soon
        return None
    reading = reading._replace(resistance_ohm=reading.resistance_ohm / cold_ohm)
    return motion_in(recording.minor_loop, reading, measured, model)


def motion_in(recording: Recording, reading: ArrayReading, measured: FloatArray, model: SensingModel) -> WireMotion:
    """Return the motion of a wire in a recording, as means over a bounded number of rows."""
    there = np.flatnonzero(reading.valid)
    time_s, resistance_ohm = recording["time_s"][there], reading.resistance_ohm[there]
    power_w = heating_power_w(recording, resistance_ohm, there)
    span_ohm = model.resistance_max_ohm - model.resistance_min_ohm
    rows = np.stack(
        [
            time_s,
            power_w,
            measured[there] / model.quantity_max,
            (resistance_ohm - model.resistance_min_ohm) / span_ohm,
        ]
    )
    means = [part.mean(axis=1) for part in np.array_split(rows, min(MOTION_ROWS, there.size), axis=1)]
    return WireMotion(*np.ascontiguousarray(np.array(means).T))


def reading_and_quantity(recording: Recording, quantity: str) -> tuple[ArrayReading, FloatArray]:
    """Return resistance and measured quantity of a recording; RecordingError names at once all that both lack."""
    missing = []
    for found in (resistance_reading, lambda given: quantity_to_fit(given, quantity)):
        try:
            found(recording)
        except RecordingError as error:
            missing.append(str(error))
    if missing:
        raise RecordingError(joined("; besides, ", missing))
    return resistance_reading(recording), quantity_to_fit(recording, quantity)


def quantity_to_fit(recording: Recording, quantity: str) -> FloatArray:
    """Return the measured quantity, (n_times,). Raises RecordingError that says how to do without an instrument."""
    try:
        return required_quantity(recording, quantity)
    except RecordingError as error:
        if quantity == "force" or "displacement_m" in recording:
            raise
        raise RecordingError(f"{error}; {WITHOUT_INSTRUMENT}") from None


def not_done(recording: Recording) -> tuple[str, ...]:
    """Return a warning if the run of a recording did not reach its end; in its minor loop all cycles are over."""
    return (recording.facts.cut_off,) if recording.facts.cut_off and recording.minor_loop is None else ()


def fit_table(recording: Recording, order: int | str) -> SensingModel:
    """Fit a printed loop, such as the paper's Table 2: strain on both branches at given resistances."""
    resistance = recording["resistance_ohm"]
    return fit_branches(
        (resistance, recording["strain_heating"]),
        (resistance, recording["strain_cooling"]),
        order,
        resistance_min_ohm=recording.facts.number_or_none("resistance_min_ohm"),
        resistance_max_ohm=recording.facts.number_or_none("resistance_max_ohm"),
        wire=wire_notes(recording),
        source=recording.facts.text_or_none("source") or "",
    )


def wire_notes(recording: Recording) -> dict[str, str | float]:
    """Return the metadata of the wire that a model keeps."""
    found = {name: recording.metadata.get(name) for name in WIRE_NOTES}
    return {name: value for name, value in found.items() if isinstance(value, (str, int, float))}


def loop_notes(recording: Recording, moved: FloatArray | None = None) -> dict[str, str | float]:
    """Return the notes of a loop, with what it shows of guide, air and, if the motion was measured, its cold end."""
    found = {
        "guide_friction_n": guide_friction_n(recording),
        "ambient_temperature_k": air_temperature_k(recording),
        ROOM: recording.facts.number_or_none("limit_ambient_temperature_k"),
        NOTE: None if moved is None else cold_contraction_per_k(recording, moved),
    }
    return wire_notes(recording) | {name: value for name, value in found.items() if value is not None}


def air_temperature_k(recording: Recording) -> float | None:
    """Return the air's temperature [K]: of the rig's thermometer, or as its rig file states it; None if neither."""
    column = recording.columns.get("ambient_temperature_k")
    if column is not None and np.isfinite(column).any():
        return float(np.nanmean(column))
    return recording.facts.number_or_none("limit_ambient_temperature_k")


@dataclass(frozen=True)
class EstimateReport:
    """An estimate over a recording, and its errors if the recording has a reference.

    Errors are in percent of the stroke that was measured in the model's loop (of the model's range for a model without
    a measured motion). They count the samples that the estimator says are valid, but for those at which the wire is
    colder than the model begins: no loop can be asked to go there. Those of a simulation count all samples.

    Parameters
    ----------
    recording
        The recording with the estimate's columns added; its metadata ``unusable_readings`` says which rows are no
        measurements, if there are any.
    valid_share
        Fraction of the samples that count.
    rms_pct
        Root mean square error [%] of the stroke; None without a reference.
    max_pct
        Largest error [%] of the stroke; None without a reference.
    wrong_pct
        How many of the samples that count are more than 5 % of the stroke wrong [%]; None without a reference.
    estimator
        Name of the estimator.
    no_reference
        Why there is no reference to compare with, and what would give one; "" with a reference.
    warnings
        That rows are no measurements, that readings lie outside the model's range, and what spoils the loop, each with
        its number.
    not_counted
        Why samples do not count: the fraction of all samples for each reason, the largest first.
    error_groups
        The samples that count by the cause of their error, with the largest error of each; none without a reference.
    quantity
        What was estimated: "strain", "displacement" or "force".
    of_stroke
        What errors are a percentage of, in words.
    fell_back
        Why the estimate is not by the estimator that was asked for, and what it is instead; "" if it is. The
        recording's metadata have it, too.
    """

    recording: Recording
    valid_share: float
    rms_pct: float | None
    max_pct: float | None
    wrong_pct: float | None
    estimator: str
    no_reference: str = ""
    warnings: tuple[str, ...] = ()
    not_counted: Mapping[str, float] = field(default_factory=dict)
    error_groups: tuple[ErrorGroup, ...] = ()
    quantity: str = "strain"
    of_stroke: str = "the measured stroke"
    fell_back: str = ""

    @property
    def columns(self) -> Mapping[str, FloatArray]:
        """The columns of the recording, the estimate's among them, as those of any recording."""
        return self.recording.columns

    def plot(self, kind: str | None = None, *, style: str = "screen") -> Figure:
        """Draw the estimate with its standard deviation and the reference, over time and over resistance.

        Parameters
        ----------
        kind
            Another plot, as in ``Recording.plot``; None is this one.
        style
            Size and fonts of the figure, as in ``Recording.plot``.

        Returns
        -------
        A matplotlib figure.

        Raises
        ------
        CallerError
            For an unknown kind or style.
        RecordingError
            If the recording lacks the columns for this kind.
        """
        return self.recording.plot(kind or "estimate", style=style)

    @property
    def does_not_hold(self) -> str:
        """Why a closed loop by this model and estimator is wrong; "" if the recording shows nothing of the kind."""
        if self.wrong_pct is None or self.wrong_pct <= 100.0 * MAX_WRONG:
            return ""
        return (
            f"by the estimator {self.estimator}, {self.wrong_pct:.2f} % of the samples that count in its own loop are "
            f"more than {100 * WRONG_FRACTION:g} % of {self.of_stroke} wrong ({100 * MAX_WRONG:g} % are allowed)"
        )

    def summary(self) -> str:
        """Return how many samples count and why others do not, where errors are and why, and last the errors."""
        errors = (
            "nothing to compare with: " + self.no_reference
            if self.rms_pct is None
            else f"error {self.rms_pct:.3f} % rms, {self.max_pct:.3f} % largest, of {self.of_stroke}; "
            f"{self.wrong_pct:.2f} % of the samples that count are more than {100 * WRONG_FRACTION:g} % wrong"
        )
        counted = f"{100 * self.valid_share:.1f} % in range and between B and C"
        if self.not_counted:
            counted += (
                f" (not: {', '.join(f'{100 * fraction:.1f} % {why}' for why, fraction in self.not_counted.items())})"
            )
        first = self.fell_back or f"{len(self.recording)} samples, {counted}"
        largest = sorted(self.error_groups, key=lambda group: -abs(group.largest_pct))[:1]
        # The group of most squares, and that of the largest error.
        where = [one.in_words(self.quantity) for one in dict.fromkeys([*self.error_groups[:1], *largest])]
        return joined("\n", [first, *where, f"estimator {self.estimator}: " + errors])


def outside_range(model: SensingModel, reading: ArrayReading) -> RecordingError:
    """Return the error that no resistance of a recording is one that the model senses at."""
    low, high = model.valid_resistance_ohm
    asked = "is it the same wire?"
    ends_ohm = sorted((float(reading.resistance_ohm.max()), high))
    if MIN_RATIO < ends_ohm[0] < MAX_RATIO < ends_ohm[1]:
        asked += " Or one of both is over the cold resistance: fit with " + argument("relative_resistance", True)
    return RecordingError(
        f"no sample lies in the model's range of {low:.3f} to {high:.3f} ohm: this recording goes from "
        f"{reading.resistance_ohm[reading.valid].min():.3f} to {reading.resistance_ohm.max():.3f} ohm; " + asked
    )


def nothing_valid(
    model: SensingModel, recording: Recording, reading: ArrayReading, reasons: list[int]
) -> RecordingError:
    """Return the error that no estimate of a recording is valid: by its resistance, or why else, with its defects."""
    low, high = model.valid_resistance_ohm
    there = reading.resistance_ohm[reading.valid]
    if not ((there >= low) & (there <= high)).any():
        return outside_range(model, reading)
    against = recording_defects(recording, model.quantity, model.stroke)
    return RecordingError("; ".join([f"no estimate is valid: {why_not_counted(recording, reasons)}", *against]))


def why_not_counted(recording: Recording, reasons: list[int]) -> str:
    """Return in words why none of a recording's samples counts."""
    every = np.ones(len(recording), dtype=np.bool_)
    fractions = asked_once(recording, JudgedRecording).not_counted(reasons, ~every, ~every)
    return ", ".join(f"{100 * fraction:.1f} % {reason}" for reason, fraction in fractions.items())


def range_warnings(model: SensingModel, reading: ArrayReading) -> tuple[str, ...]:
    """Return a warning if readings of a recording lie outside the range that its model senses; none otherwise."""
    there = reading.resistance_ohm[reading.valid]
    outside = there[other_wires(model, there)]
    if outside.size < MIN_OUTSIDE * there.size:
        return ()
    low, high = model.valid_resistance_ohm
    return (
        f"{100 * outside.size / there.size:.1f} % of the readings, {outside.min():.4g} to {outside.max():.4g} ohm, are "
        f"outside the {low:.4g} to {high:.4g} ohm that this model senses and read as its nearest end: check that it is "
        "the same wire, or fit a loop that reaches further",
    )


def estimate(
    model: SensingModel,
    recording: Recording,
    *,
    estimator: str | EstimatorFactory | None = None,
    wire_file: str | Path | None = None,
) -> EstimateReport:
    """Estimate strain (or the model's quantity) from a recording's resistance, sample by sample.

    Valid are samples with current, a resistance in the model's range, and the wire between B and C, which shows in how
    power and resistance move together. A recording that was interpolated by straight lines is estimated at its measured
    rows, and on lines between them.

    Parameters
    ----------
    model
        The model of this wire.
    recording
        Resistance, or both voltages and the shunt; drive and both voltages for another estimator than the default.
    estimator
        Name or factory of an estimator. The default is that of a closed loop with this model, the filter, sample by
        sample; the paper's for a model that shows no slow loop, and for a recording without current. The paper's,
        "polynomial", processes the whole recording at once, and knows from what follows where the wire passed B.
    wire_file
        The wire's own file, as ``calibrate`` writes it, for the estimator "particle-filter"; None without one. Where it
        has no valid sample, the estimate is the open-loop simulation of this wire by the recorded
        current, and says so (``fell_back``).

    Returns
    -------
    The recording with the estimate's columns, and the errors if the recording has the reference instrument.

    Raises
    ------
    CallerError
        If no estimator has this name, and for a wire file that the estimator does not read.
    RecordingError
        If no resistance follows from the columns, or none lies in the model's range.

    Examples
    --------
    >>> import musclewire as mw
    >>> with mw.open_rig("simulated") as rig:
    ...     loop = mw.characterize(rig)
    >>> report = mw.estimate(mw.fit(loop), loop)
    >>> report.recording["estimated_strain"].shape == loop["time_s"].shape
    True
    """
    if not isinstance(recording, Recording):
        raise CallerError(f"estimate takes a model and a recording, in this order, not {an_object(recording)} second")
    interpolated = measured_rows(recording)
    given, cold_ohm, recording = recording, None, interpolated.kept
    if DIVIDED_BY in model.wire:
        if wire_file is not None:
            raise CallerError("a wire file has ohms, and this model resistance over the cold wire's: leave one out")
        recording, cold_ohm = over_cold_resistance(recording)
    without_filter = ""
    if estimator is None:
        by_current = asked_once(recording, JudgedRecording).has_current
        estimator, without_filter = default_estimator(model) if by_current else (PAPER_ESTIMATOR, "")
    check_wire_file(wire_file, estimator)
    whole = estimator == PAPER_ESTIMATOR
    wire = None if wire_file is None else users_wire(wire_file, recording.metadata)
    columns, reasons = by_arrays(model, recording) if whole else by_samples(estimator, model, recording, wire)
    suffix = COLUMN_SUFFIX[model.quantity]
    fell_back = ""
    if wire is not None and estimator == OF_A_WIRE_FILE and not columns["valid"].any():
        columns, reasons, fell_back = open_loop_instead(model, recording, wire, reasons)
        estimator, given = OPEN_LOOP, given.with_metadata(estimate_fell_back=fell_back)
    valid, value = columns["valid"] > 0.0, columns[f"estimated_{suffix}"]
    reading = resistance_reading(recording)
    if not valid.any():
        raise nothing_valid(model, recording, reading, reasons)
    measured = measured_quantity(recording, model.quantity)
    # A simulation begins nowhere: it is judged from the cold wire on.
    least = -np.inf if fell_back else model.quantity_min
    counts = valid if measured is None else valid & (measured >= least)
    errors: FloatArray | None = None
    groups: tuple[ErrorGroup, ...] = ()
    if measured is not None and counts.any():
        errors = (value - measured)[counts] / model.stroke * 100.0
        if not fell_back:  # what errors are put down to are properties of a curve
            groups = JudgedEstimate(model, recording, reading.resistance_ohm, value, measured, counts).groups
    judged = asked_once(recording, JudgedRecording)
    _, found = judged.measured
    kept = given.with_metadata(unusable_readings="; ".join(found)) if found else given
    if cold_ohm is not None:
        kept = kept.with_metadata(estimate_divided_by_ohm=cold_ohm)
        columns["wire_resistance_ohm"] = cold_ohm * columns["wire_resistance_ohm"]
    return EstimateReport(
        recording=kept.with_columns(interpolated.spread(given["time_s"], columns)),
        valid_share=float(counts.mean()),
        rms_pct=None if errors is None else float(np.sqrt(np.mean(errors**2))),
        max_pct=None if errors is None else float(np.abs(errors).max()),
        wrong_pct=None if errors is None else float(100.0 * np.mean(np.abs(errors) > 100.0 * WRONG_FRACTION)),
        estimator=estimator if isinstance(estimator, str) else getattr(estimator, "__name__", type(estimator).__name__),
        no_reference=why_no_reference(recording, model.quantity) if counts.any() else ALWAYS_COLD,
        warnings=(
            *found,
            *filter(None, [without_filter]),
            *interpolated.said,
            *range_warnings(model, reading),
            *recording_defects(recording, model.quantity, model.stroke),
            *not_done(given),
        ),
        not_counted=judged.not_counted(reasons, valid, counts),
        error_groups=groups,
        quantity=model.quantity,
        of_stroke="the measured stroke" if model.measured_stroke else "the model's range",
        fell_back=fell_back,
    )


def open_loop_instead(
    model: SensingModel, recording: Recording, wire: WireConstants, reasons: list[int]
) -> tuple[dict[str, FloatArray], list[int], str]:
    """Return columns and reasons of the open-loop simulation, and in words why it takes the filter's place."""
    every = np.ones(len(recording), dtype=np.bool_)
    try:
        value, std = open_loop_estimate(model, recording, wire, air_temperature_k(recording))
    except RecordingError as error:
        never = outside_range(model, resistance_reading(recording))
        raise RecordingError(f"{never}; nor by simulation: {error}") from None
    mean_pct, max_pct = (100.0 * float(part) / model.stroke for part in (std.mean(), std.max()))
    why = why_not_counted(recording, reasons)
    said = (
        f"no sample of the particle filter is valid ({why}): the estimate is the open-loop simulation of the wire file "
        "by the recorded current, from a cold wire, which reads no resistance; its standard deviation is "
        f"{mean_pct:.2g} % of the stroke in the mean, {max_pct:.2g} % at most"
    )
    return estimate_columns(model.quantity, value, std, every), [Reason.OK] * len(recording), said


def by_arrays(model: SensingModel, recording: Recording) -> tuple[dict[str, FloatArray], list[int]]:
    """Return the columns of the paper's estimate of a whole recording, and each sample's ``Reason``."""
    reading = resistance_reading(recording)
    result = model.estimate(reading.resistance_ohm)
    sensed = in_sensing_segment(model, recording, reading)
    conditions = [~reading.valid, other_wires(model, reading.resistance_ohm), ~result.valid, ~sensed]
    reasons = np.select(
        conditions, [Reason.NO_CURRENT, Reason.MISMATCH, Reason.OUT_OF_RANGE, Reason.COLD], default=Reason.OK
    )
    columns = estimate_columns(model.quantity, result.value, result.std, reasons == Reason.OK)
    return columns | {"wire_resistance_ohm": reading.resistance_ohm}, reasons.tolist()


def by_samples(
    estimator: str | EstimatorFactory, model: SensingModel, recording: Recording, wire: WireConstants | None = None
) -> tuple[dict[str, FloatArray], list[int]]:
    """Return the columns of an estimator that runs sample by sample, and each sample's ``Reason``."""
    times = recording["time_s"]
    if times.size < 2:
        raise RecordingError(
            f"{recording.facts.whose} has fewer than two rows: an estimator takes two, a sample period apart"
        )
    period_s = float(np.median(np.diff(times)))
    read = asked_once(recording, JudgedRecording).circuit
    setup = EstimatorSetup(model, read.shunt_ohm, period_s, wire=wire)
    made: Estimator = ESTIMATORS.make(estimator, setup)
    air = recording.columns.get("ambient_temperature_k")
    air_k = [None] * times.size if air is None else air.tolist()
    rows = zip(*(column.tolist() for column in (times, read.drive_v, read.wire_v, read.shunt_v)), air_k, strict=True)
    found, recorded = zip(*estimates(made, (WireSample(*row) for row in rows)), strict=True)
    own = dict(zip(made.columns, np.array(recorded, dtype=np.float64).T, strict=True))
    value, std = (np.array([getattr(one, name) for one in found]) for name in ("value", "std"))
    columns = estimate_columns(made.quantity, value, std, np.array([one.valid for one in found]))
    return own | columns, [one.reason for one in found]


def estimate_columns(
    quantity: str, value: FloatArray, std: FloatArray, valid: NDArray[np.bool_]
) -> dict[str, FloatArray]:
    """Return an estimate, its standard deviation in the same unit and whether it is valid, as a recording's columns."""
    return {f"estimated_{COLUMN_SUFFIX[quantity]}": value, "estimate_std": std, "valid": valid.astype(np.float64)}
