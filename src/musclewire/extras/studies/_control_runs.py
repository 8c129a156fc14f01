"""The kind of run ``control``: the closed loop on a staircase, with each wire's own model or one for all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from math import nan
from typing import Annotated

from pydantic import Field

from musclewire.controllers import staircase
from musclewire.experiment import ControlMetrics, characterize, control, control_compiled
from musclewire.extras.studies._run_kind import (
    KindOptions,
    Outcome,
    Quantity,
    RunKind,
    StudyRun,
    StudyRuns,
    each,
    noted_overheating,
)
from musclewire.identify import fit, required_quantity
from musclewire.rigs import uncompiled
from musclewire.sensing import DEFAULT_ESTIMATOR, load_model
from musclewire.signals import measured_in

NUMBERS = {
    "mae_max_pct": Quantity(
        "1",
        "largest error of a step against the instrument, in % of its target (Eq. 7), from the first target on",
    ),
    "mae_mean_pct": Quantity("1", "mean error of the steps, in % of their targets (Eq. 7), from the first target on"),
    "mae_max_approached_pct": Quantity(
        "1", "largest error of a step, in % of its target (Eq. 7), the first step counted after the approach"
    ),
    "mae_mean_approached_pct": Quantity(
        "1", "mean error of the steps, in % of their targets (Eq. 7), the first step counted after the approach"
    ),
    "approach_s": Quantity("s", "time for which the first target was held before the first step"),
    "rms_pct": Quantity("1", "rms error of the run after its approach, in % of the largest target"),
    "estimate_rms_pct": Quantity(
        "1", "rms error of the estimate against the instrument after the approach, in % of the largest target"
    ),
    "tracking_rms_pct": Quantity(
        "1", "rms error of the estimate against the target after the approach, in % of the largest target"
    ),
    "valid_fraction": Quantity("1", "fraction of the samples with a valid estimate"),
    "model_gap": Quantity("1", "gap of the loop that the model was fitted to"),
}
SERIES = {
    "target_strain": Quantity("1", "target", True),
    "estimated_strain": Quantity("1", "estimate", True),
    "strain": Quantity("1", "strain by the reference instrument", True),
    "drive_voltage_v": Quantity("V", "drive voltage", True),
}
Strain = Annotated[float, measured_in(""), Field(gt=0.0, le=0.1)]
Seconds = Annotated[float, measured_in("s"), Field(gt=0.0, le=86400.0)]


class ControlOptions(KindOptions):
    """Keys of ``[run]`` with ``kind = "control"``. A run goes through the rig's instruments and its protection."""

    # "own": each wire is characterized and its own model fitted. Otherwise a model file (.json), which controls all
    # wires: how much a wire may differ from the one that a model was fitted to.
    model: str = "own"
    estimator: str = DEFAULT_ESTIMATOR
    controller: str | None = None  # by default that of the model's gains, which "own" finds for each wire
    in_python: bool = False  # for an estimator or a controller that has no compiled form; the numbers are the same
    period: Seconds = 90.0  # of the slow sine of "own"
    cycles: int = Field(default=2, ge=1)  # of "own"; the model is fitted to the last
    start: Strain = 0.015  # first and last target of the staircase
    stop: Strain = 0.03  # its highest target
    step: Strain = 0.003  # between targets
    hold: Seconds = 6.0  # time of each target


def quantities(options: ControlOptions) -> Mapping[str, Quantity]:  # noqa: ARG001  the same for all options
    """Return what a closed loop yields."""
    return {**NUMBERS, **SERIES}


def evaluate(runs: StudyRuns[ControlOptions]) -> Sequence[Outcome]:
    """Return the errors of each run."""
    return each(partial(on_rig, runs), runs.runs)


def on_rig(runs: StudyRuns[ControlOptions], run: StudyRun[ControlOptions]) -> Outcome:
    """Return what a closed loop on the rig of a run yields."""
    options = run.options
    with runs.open(run) as rig, noted_overheating(rig):
        if options.model == "own":
            model = fit(characterize(rig, period_s=options.period, cycles=options.cycles, minor_loop=False))
        else:
            model = load_model(options.model)
        reference = staircase(options.start, options.stop, options.step, hold_s=options.hold)
        # Two wires and faults have no compiled form; either way the numbers are the same.
        loop = control if options.in_python or uncompiled(rig) else control_compiled
        done = loop(rig, model, reference, estimator=options.estimator, controller=options.controller)
    series = {name: done[name] for name in ("target_strain", "estimated_strain", "drive_voltage_v")}
    series["strain"] = required_quantity(done, "strain")
    return {**errors_of(done.metrics), "model_gap": model.hysteresis_gap, **series}


def errors_of(metrics: ControlMetrics) -> dict[str, float]:
    """Return the errors of a run; NaN for what it cannot determine."""
    found = {
        "mae_max_pct": metrics.mae_max_pct,
        "mae_mean_pct": metrics.mae_mean_pct,
        "mae_max_approached_pct": metrics.mae_max_approached_pct,
        "mae_mean_approached_pct": metrics.mae_mean_approached_pct,
        "approach_s": metrics.approach_s,
        "rms_pct": metrics.rms_pct,
        "estimate_rms_pct": metrics.estimate_rms_pct,
        "tracking_rms_pct": metrics.tracking_rms_pct,
        "valid_fraction": metrics.valid_share,
    }
    return {name: nan if value is None else value for name, value in found.items()}


CONTROL = RunKind(ControlOptions, quantities, evaluate)
