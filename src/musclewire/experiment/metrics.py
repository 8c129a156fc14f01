"""How well a run followed its target: Eq. 7 for each step of a staircase."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.controllers.references import Reference, Staircase, Step
from musclewire.errors import RecordingError
from musclewire.identify.recordings import COLUMN_SUFFIX, reference_quantity
from musclewire.sensing.curve import SHOWN_AS
from musclewire.signals.recording import Recording

__all__ = [
    "ControlMetrics",
    "ControlRun",
    "StepMetrics",
    "control_metrics",
    "determined",
    "elapsed",
    "mean_absolute_error",
]

# Eq. 7 counts "sequentially after one second of each step (till the end of each step)".
SETTLE_S = 1.0


@dataclass(frozen=True)
class StepMetrics:
    """Errors of one step in percent of its target.

    An error is None without the instrument for it, without samples after the first second, and for a target of 0.

    Parameters
    ----------
    target
        Target of the step, in the unit of the run's quantity.
    direction
        "rise" or "return".
    mae_pct
        Mean absolute error of the reference instrument against the target [%] (Eq. 7).
    estimate_mae_pct
        That of the estimate against the reference instrument [%].
    tracking_mae_pct
        That of the estimate against the target [%]: what the loop itself can see.
    """

    target: float
    direction: str
    mae_pct: float | None
    estimate_mae_pct: float | None
    tracking_mae_pct: float | None


@dataclass(frozen=True)
class ControlMetrics:
    """All steps of a run and their summary.

    The ``rms`` are over the whole run after the approach, in percent of the largest target.

    Parameters
    ----------
    quantity
        What was controlled: "strain", "displacement" or "force".
    steps
        Errors of each step; none if the target was not a staircase.
    mae_max_pct
        Largest of the steps' errors against the reference instrument [%]; None without one.
    mae_mean_pct
        Mean of the same [%].
    valid_share
        Fraction of the samples with a valid estimate.
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
    valid_share: float = 1.0
    rms_pct: float | None = None
    estimate_rms_pct: float | None = None
    tracking_rms_pct: float = 0.0

    def __str__(self) -> str:
        """Return a small table."""
        if not self.steps:
            return (
                f"rms error {percent(self.rms_pct)} %, of the estimate {percent(self.estimate_rms_pct)} %, "
                f"of tracking {percent(self.tracking_rms_pct)} % (of the largest target)"
            )
        lines = [
            "errors in % of the target; estimate: against the reference instrument, tracking: against the target",
            f"{'target':>10} {'':7} {'MAE %':>8} {'estimate %':>11} {'tracking %':>11}",
        ]
        factor, unit = SHOWN_AS[self.quantity]
        for step in self.steps:
            lines.append(
                f"{step.target * factor:>7.3g} {unit:2} {step.direction:7} {percent(step.mae_pct):>8} "
                f"{percent(step.estimate_mae_pct):>11} {percent(step.tracking_mae_pct):>11}"
            )
        lines.append(f"largest {percent(self.mae_max_pct)} %, mean {percent(self.mae_mean_pct)} %")
        return "\n".join(lines)


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
    """Return the mean of the absolute error in percent (Eq. 7).

    Parameters
    ----------
    values
        What was measured or estimated, (n,), in any unit.
    wanted
        What it should be, a number or (n,), in the unit of ``values``.
    per
        What the error is relative to, in the same unit; not 0. Its sign does not matter.

    Returns
    -------
    100 mean(|values - wanted|) / |per| [%].

    References
    ----------
    Lan and Fan 2010, Eq. 7.
    """
    return float(100.0 * np.mean(np.abs(values - wanted)) / abs(per))


def root_mean_square(errors: FloatArray, per: float) -> float:
    """Return the root mean square of errors over ``per``, in percent."""
    return float(100.0 * np.sqrt(np.mean(errors**2)) / per)


def control_metrics(recording: Recording, quantity: str, reference: Reference) -> ControlMetrics:
    """Return how well a closed-loop recording followed its target.

    Parameters
    ----------
    recording
        A run of the closed loop, with the columns of the quantity's target and estimate.
    quantity
        "strain", "displacement" or "force".
    reference
        The target over time; of a staircase each step is judged by itself (Eq. 7).

    Returns
    -------
    Errors of the steps and of the whole run; None if the recording lacks the reference instrument.

    References
    ----------
    Lan and Fan 2010, Eq. 7.
    """
    suffix = COLUMN_SUFFIX[quantity]
    estimated = recording[f"estimated_{suffix}"]
    measured = reference_quantity(recording, quantity)
    elapsed_s = elapsed(recording)
    steps: Sequence[Step] = reference.steps if isinstance(reference, Staircase) else ()
    rows = tuple(step_metrics(step, elapsed_s, estimated, measured) for step in steps)
    errors = [row.mae_pct for row in rows if row.mae_pct is not None]
    judged = elapsed_s > 1e-9
    target = recording[f"target_{suffix}"][judged]
    per = float(np.abs(target).max()) or 1.0
    true = None if measured is None else measured[judged]
    return ControlMetrics(
        quantity=quantity,
        rms_pct=None if true is None else root_mean_square(true - target, per),
        estimate_rms_pct=None if true is None else root_mean_square(estimated[judged] - true, per),
        tracking_rms_pct=root_mean_square(estimated[judged] - target, per),
        steps=rows,
        mae_max_pct=max(errors) if errors else None,
        mae_mean_pct=float(np.mean(errors)) if errors else None,
        valid_share=float(np.mean(recording["valid"][judged])),
    )


def elapsed(recording: Recording) -> FloatArray:
    """Return the time since the reference began, negative during the approach, (n_times,)."""
    time_s = recording["time_s"]
    return np.asarray(time_s - time_s[0] + recording.facts.sample_period_s - recording.facts.approach_s)


def step_metrics(
    step: Step,
    elapsed_s: FloatArray,
    estimated: FloatArray,
    measured: FloatArray | None,
) -> StepMetrics:
    """Return the errors of one step, from one second after its start to its end (Eq. 7).

    Parameters
    ----------
    step
        Start, end and target of the step.
    elapsed_s
        Time since the reference began [s], (n_times,), negative during the approach.
    estimated
        Estimate, (n_times,), in the unit of the target.
    measured
        Reading of the reference instrument, (n_times,), in the unit of the target; None without one.

    Returns
    -------
    The errors in percent; None if they cannot be determined.

    References
    ----------
    Lan and Fan 2010, Eq. 7: "sequentially after one second of each step (till the end of each step)".
    """
    part = (elapsed_s > step.start_s + SETTLE_S + 1e-9) & (elapsed_s <= step.stop_s + 1e-9)
    if not part.any() or step.target == 0.0:  # nothing after the first second, or nothing to be relative to
        return StepMetrics(step.target, step.direction, None, None, None)
    seen = estimated[part]
    true = None if measured is None else measured[part]
    return StepMetrics(
        target=step.target,
        direction=step.direction,
        mae_pct=None if true is None else mean_absolute_error(true, step.target, step.target),
        estimate_mae_pct=None if true is None else mean_absolute_error(seen, true, step.target),
        tracking_mae_pct=mean_absolute_error(seen, step.target, step.target),
    )
