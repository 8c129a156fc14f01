"""How well a run followed its target: Eq. 7 for each step of a staircase, in two readings.

A run holds the first target for an approach before its first step, since a wire at rest is too cold for its resistance
to determine strain. The paper does not say how its wire came to the first step, so each step has both errors:

- *From the first target on*: the clock of the first step starts when its target is first asked for, however the wire
  was before. Of the approach and the first step, only what lies within one step's time after that counts.
- *Approached*: that clock starts after the approach.

In both the first second of each step is left out, as the paper does. All steps but the first have the same samples in
both, and without an approach the first has, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from markupsafe import Markup

from musclewire.arrays import FloatArray
from musclewire.controllers import Reference, Staircase, Step
from musclewire.errors import RecordingError
from musclewire.judge import SETTLE_S, JudgedLoop
from musclewire.parameters import read_published
from musclewire.sensing import SHOWN_AS
from musclewire.signals import COLUMN_SUFFIX, Recording, reference_quantity, with_answers_of

# The two readings of Eq. 7 in words, as they stand next to a number.
FROM_FIRST_TARGET, APPROACHED = "from the first target on", "after the approach"


class StepErrors(NamedTuple):
    """Mean absolute errors over one stretch of a run, in percent of its target; None for what is not determined."""

    mae_pct: float | None
    estimate_mae_pct: float | None
    tracking_mae_pct: float | None


UNDETERMINED = StepErrors(None, None, None)


@dataclass(frozen=True)
class StepMetrics:
    """Errors of one step in percent of its target, from the first target on and after the approach.

    The two differ in the first step only. An error is None without the instrument for it, without samples after the
    first second, and for a target of 0.

    Parameters
    ----------
    target
        Target of the step, in the unit of the run's quantity.
    direction
        "rise" or "return".
    mae_pct
        Mean absolute error of the reference instrument against the target [%] (Eq. 7), from the first target on.
    estimate_mae_pct
        That of the estimate against the reference instrument [%].
    tracking_mae_pct
        That of the estimate against the target [%]: what the loop itself can see.
    mae_approached_pct
        As ``mae_pct``, after the approach [%].
    estimate_mae_approached_pct
        As ``estimate_mae_pct``, after the approach [%].
    tracking_mae_approached_pct
        As ``tracking_mae_pct``, after the approach [%].
    """

    target: float
    direction: str
    mae_pct: float | None
    estimate_mae_pct: float | None
    tracking_mae_pct: float | None
    mae_approached_pct: float | None
    estimate_mae_approached_pct: float | None
    tracking_mae_approached_pct: float | None


@dataclass(frozen=True)
class ControlMetrics:
    """All steps of a run and their summary.

    The ``rms`` are over the whole run after the approach, or after its first second if there was none, in percent of
    the largest target.

    Parameters
    ----------
    quantity
        What was controlled: "strain", "displacement" or "force".
    steps
        Errors of each step; none if the target was not a staircase.
    mae_max_pct
        Largest of the steps' errors against the reference instrument [%], from the first target on; None without one.
    mae_mean_pct
        Mean of the same [%].
    mae_max_approached_pct
        Largest of the steps' errors after the approach [%].
    mae_mean_approached_pct
        Mean of the same [%].
    approach_s
        Time [s] for which the first target was held before the first step.
    start
        What the reference instrument read first, in the quantity's unit: where the wire came from; None without one.
    valid_share
        Fraction of the samples with a valid estimate, from where the wire is first sensed on: cold of B it cannot be.
    rms_pct
        Reference instrument against target [%]; None without an instrument.
    estimate_rms_pct
        Estimate against reference instrument [%]; None without an instrument.
    tracking_rms_pct
        Estimate against target [%].
    """

    quantity: str
    steps: tuple[StepMetrics, ...] = ()
    mae_max_pct: float | None = None
    mae_mean_pct: float | None = None
    mae_max_approached_pct: float | None = None
    mae_mean_approached_pct: float | None = None
    approach_s: float = 0.0
    start: float | None = None
    valid_share: float = 1.0
    rms_pct: float | None = None
    estimate_rms_pct: float | None = None
    tracking_rms_pct: float = 0.0

    @property
    def approach(self) -> str:
        """How the wire came to the first step, in words."""
        factor, unit = SHOWN_AS[self.quantity]
        # Adding zero turns a rounded -0.0 to 0.0.
        where = "" if self.start is None else f", the wire being at {round(factor * self.start, 2) + 0.0:.2f} {unit}"
        if self.approach_s == 0.0:
            return f"no approach: the first step began when its target was first asked for{where}"
        return f"the first target was asked for{where}, and the first step began {self.approach_s:g} s later"

    @property
    def counted(self) -> str:
        """What of the run the ``rms`` count, in words."""
        return APPROACHED if self.approach_s > 0.0 else f"after the first {SETTLE_S:g} s"

    def _repr_html_(self) -> str:
        """Return the table of errors for a notebook, as ``print`` shows them."""
        return Markup("<pre>{}</pre>").format(str(self))

    def __str__(self) -> str:
        """Return mean and largest error, then a table; the first step has a row for each reading if they differ.

        Without an instrument for the quantity only the error that the loop sees is known: that of the estimate.
        """
        if self.valid_share == 0.0:
            return f"no estimate was ever valid: the {self.quantity} was never sensed, and the loop never closed"
        if self.mae_mean_pct is None and self.rms_pct is None:
            return "\n".join(self._without_instrument())
        if not self.steps:
            return (
                f"rms error {percent(self.rms_pct)} %, of the estimate {percent(self.estimate_rms_pct)} %, "
                f"of tracking {percent(self.tracking_rms_pct)} % (of the largest target, {self.counted})"
            )
        lines = [
            *summary_lines(self),
            "errors in % of the target, the first second of each step left out (Eq. 7)",
            "estimate: against the reference instrument, tracking: against the target",
            self.approach,
            f"{'target':>10} {'':7} {'MAE %':>8} {'estimate %':>11} {'tracking %':>11}",
        ]
        factor, unit = SHOWN_AS[self.quantity]
        for step in self.steps:
            label = f"{step.target * factor:>7.3g} {unit:2} {step.direction:7}"
            lines += [f"{label} {errors}" for errors in step_lines(step, self.approach_s)]
        return "\n".join(lines)

    def _without_instrument(self) -> list[str]:
        """Return the lines of a run whose rig has no instrument for the quantity."""
        largest, mean = largest_and_mean([step.tracking_mae_pct for step in self.steps])
        lines = [f"no instrument measured the {self.quantity}: how far its estimate is from the target, in % of it"]
        if not self.steps:
            return [*lines, f"rms {percent(self.tracking_rms_pct)} %, of the largest target, {self.counted}"]
        lines += [f"mean {percent(mean)} %, largest {percent(largest)} % (Eq. 7)", self.approach]
        factor, unit = SHOWN_AS[self.quantity]
        return lines + [
            f"{step.target * factor:>7.3g} {unit:2} {step.direction:7} {percent(step.tracking_mae_pct):>8} %"
            for step in self.steps
        ]


def summary_lines(metrics: ControlMetrics) -> list[str]:
    """Return mean and largest error of the steps in words, of both readings after an approach, and the paper's."""
    first = percent(metrics.steps[0].mae_pct)
    counted = f"mean {percent(metrics.mae_mean_pct)} %, largest {percent(metrics.mae_max_pct)} %, first step {first} %"
    factor, unit = SHOWN_AS[metrics.quantity]
    begun = "" if metrics.start is None else f", begun at {round(factor * metrics.start, 2) + 0.0:.2f} {unit}"
    lines = [f"{counted}{begun}"]
    if metrics.approach_s != 0.0:
        largest, mean = percent(metrics.mae_max_approached_pct), percent(metrics.mae_mean_approached_pct)
        lines = [f"{counted} {FROM_FIRST_TARGET}", f"mean {mean} %, largest {largest} % {APPROACHED}"]
    table = read_published("lan_fan_2010")["table2"]
    rising, returning = table["desired_strain_pct"], table["desired_strain_pct"][-2::-1]
    if metrics.quantity == "strain" and [round(100.0 * step.target, 9) for step in metrics.steps] == rising + returning:
        printed = [*table["mae_rise_pct"], *table["mae_return_pct"]]
        mean, largest = f"{np.mean(printed):.2f}", f"{max(printed):.2f}"
        lines.append(
            f"the paper's wire: mean {mean} %, largest {largest} %, after an approach that it does not describe"
        )
    return lines


def step_lines(step: StepMetrics, approach_s: float) -> list[str]:
    """Return the errors of a step as lines of a table: two for the first step after an approach."""
    counted = StepErrors(step.mae_pct, step.estimate_mae_pct, step.tracking_mae_pct)
    approached = StepErrors(step.mae_approached_pct, step.estimate_mae_approached_pct, step.tracking_mae_approached_pct)
    if counted == approached:
        return [error_columns(counted)]
    return [
        f"{error_columns(counted)}  {FROM_FIRST_TARGET}",
        f"{error_columns(approached)}  {APPROACHED} of {approach_s:g} s",
    ]


def error_columns(errors: StepErrors) -> str:
    """Return three errors as columns of a table."""
    return f"{percent(errors.mae_pct):>8} {percent(errors.estimate_mae_pct):>11} {percent(errors.tracking_mae_pct):>11}"


def percent(value: float | None) -> str:
    """Return a percentage for a table; a dash for None."""
    return "-" if value is None else f"{value:.3f}"


@dataclass(frozen=True, eq=False, repr=False)
class ControlRun(Recording):
    """A recording of a closed loop with its metrics.

    Parameters
    ----------
    metrics
        Errors of each step and of the whole run.
    """

    metrics: ControlMetrics = field(default_factory=lambda: ControlMetrics("strain"))


def determined(error_pct: float | None, what: str) -> float:
    """Return an error of a run. Raises RecordingError if instrument or samples are missing for it."""
    if error_pct is None:
        raise RecordingError(
            f"{what} cannot be determined: the run has no reference instrument for it, or a step no sample after its "
            "first second; record it with the instrument, and hold each step for more than 1 s"
        )
    return error_pct


def mean_absolute_error(values: FloatArray, wanted: FloatArray | float, per: float) -> float:
    """Return 100 mean(|values - wanted|) / |per| [%], the mean of the absolute error (Eq. 7).

    References
    ----------
    Lan and Fan 2010, Eq. 7.
    """
    return float(100.0 * np.mean(np.abs(values - wanted)) / abs(per))


def root_mean_square(errors: FloatArray, per: float) -> float:
    """Return the root mean square of errors over ``per``, in percent."""
    return float(100.0 * np.sqrt(np.mean(errors**2)) / per)


def control_metrics(recording: Recording, quantity: str, reference: Reference) -> ControlMetrics:
    """Return how well a closed-loop recording followed its target, of a staircase each step by itself (Eq. 7).

    Errors against the reference instrument are None if the recording lacks it.

    References
    ----------
    Lan and Fan 2010, Eq. 7.
    """
    suffix = COLUMN_SUFFIX[quantity]
    estimated = recording[f"estimated_{suffix}"]
    measured = reference_quantity(recording, quantity)
    elapsed_s = elapsed(recording)
    steps: Sequence[Step] = reference.steps if isinstance(reference, Staircase) else ()
    approach_s = recording.facts.approach_s
    rows = tuple(step_metrics(step, elapsed_s, estimated, measured, approach_s) for step in steps)
    largest, mean = largest_and_mean([row.mae_pct for row in rows])
    largest_approached, mean_approached = largest_and_mean([row.mae_approached_pct for row in rows])
    loop = JudgedLoop(recording)
    counted = loop.counted
    target = recording[f"target_{suffix}"][counted]
    per = float(np.abs(target).max()) or 1.0
    true = None if measured is None else measured[counted]
    return ControlMetrics(
        quantity=quantity,
        rms_pct=None if true is None else root_mean_square(true - target, per),
        estimate_rms_pct=None if true is None else root_mean_square(estimated[counted] - true, per),
        tracking_rms_pct=root_mean_square(estimated[counted] - target, per),
        steps=rows,
        mae_max_pct=largest,
        mae_mean_pct=mean,
        mae_max_approached_pct=largest_approached,
        mae_mean_approached_pct=mean_approached,
        approach_s=approach_s,
        start=None if measured is None or not np.isfinite(measured[0]) else float(measured[0]),
        valid_share=loop.valid_share,
    )


def with_metrics(recording: Recording, quantity: str, reference: Reference) -> ControlRun:
    """Return a closed loop's recording with its metrics, and with what has been found in it."""
    metrics = control_metrics(recording, quantity, reference)
    return with_answers_of(ControlRun(recording.whole_columns, recording.metadata, metrics), recording)


def largest_and_mean(errors_pct: Sequence[float | None]) -> tuple[float | None, float | None]:
    """Return the largest and the mean of the errors that are determined; None twice if none is."""
    known = [error for error in errors_pct if error is not None]
    return (max(known), float(np.mean(known))) if known else (None, None)


def elapsed(recording: Recording) -> FloatArray:
    """Return the time since the reference began, negative during the approach, (n_times,)."""
    time_s = recording["time_s"]
    return np.asarray(time_s - time_s[0] + recording.facts.sample_period_s - recording.facts.approach_s)


def step_metrics(
    step: Step,
    elapsed_s: FloatArray,
    estimated: FloatArray,
    measured: FloatArray | None,
    approach_s: float = 0.0,
) -> StepMetrics:
    """Return the errors of one step, from one second after its start to its end (Eq. 7), in both readings.

    From the first target on, the first step counts earlier by the approach; the others do not change.

    References
    ----------
    Lan and Fan 2010, Eq. 7: "sequentially after one second of each step (till the end of each step)". How the wire came
    to the first step is not said there.
    """
    early_s = approach_s if step.index == 0 else 0.0
    counted = step_errors(step, elapsed_s + early_s, estimated, measured)
    approached = counted if early_s == 0.0 else step_errors(step, elapsed_s, estimated, measured)
    return StepMetrics(step.target, step.direction, *counted, *approached)


def step_errors(step: Step, elapsed_s: FloatArray, estimated: FloatArray, measured: FloatArray | None) -> StepErrors:
    """Return the errors of one step by one clock, that of ``elapsed_s``."""
    part = (elapsed_s > step.start_s + SETTLE_S + 1e-9) & (elapsed_s <= step.stop_s + 1e-9)
    if not part.any() or step.target == 0.0:  # nothing after the first second, or nothing to be relative to
        return UNDETERMINED
    seen = estimated[part]
    true = None if measured is None else measured[part]
    return StepErrors(
        mae_pct=None if true is None else mean_absolute_error(true, step.target, step.target),
        estimate_mae_pct=None if true is None else mean_absolute_error(seen, true, step.target),
        tracking_mae_pct=mean_absolute_error(seen, step.target, step.target),
    )
