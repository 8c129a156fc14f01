"""Every estimator over a recorded run: what it would have said in the loop."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from musclewire import ESTIMATORS, EstimatorSetup, FloatArray, SensingModel, WireSample
from musclewire.experiment import ScaleByB
from musclewire.sensing import EstimatorFactory, KnownSpring, estimates
from musclewire.wire import WireConstants
from musclewire_robustness.recorded_run import RecordedRun


class EstimatedRun(NamedTuple):
    """An estimator's answers over a run, each (n_samples,).

    ``columns`` are those that it records itself, ``b_has_moved`` is where B was known to be at another height.
    """

    value: FloatArray
    std: FloatArray
    valid: npt.NDArray[np.bool_]
    reason: npt.NDArray[np.int64]
    columns: dict[str, FloatArray]
    b_has_moved: npt.NDArray[np.bool_]
    failure: str


def samples_of(run: RecordedRun) -> Iterator[WireSample]:
    """Yield what an estimator sees of a run."""
    rows = zip(
        run.clock_s.tolist(),
        run.drive_voltage_v.tolist(),
        run.wire_voltage_v.tolist(),
        run.shunt_voltage_v.tolist(),
        strict=True,
    )
    for row in rows:
        yield WireSample(*row)


def estimated(
    run: RecordedRun,
    model: SensingModel,
    estimator: str | EstimatorFactory,
    wire: WireConstants | None = None,
    load: KnownSpring | None = None,
    *,
    zeroed: bool = False,
) -> EstimatedRun:
    """Return what an estimator says over a recorded run, as in a loop that watches the height of B.

    Parameters
    ----------
    run
        The run.
    model
        The user's model.
    estimator
        Name or factory.
    wire
        Constants of the user's wire file on his load; None without one.
    load
        The spring that the wire pulls, for a model of force; None for other quantities.
    zeroed
        Whether strain counts from today's zero, so that the resistance may be scaled by B.

    Returns
    -------
    Its answers.
    """
    factory = ESTIMATORS.find(estimator) if isinstance(estimator, str) else estimator
    made = factory(setup_of(run, model, wire, load))
    scale = ScaleByB.of_model(model, run.facts["sense_voltage_v"], run.facts["shunt_resistance_ohm"])

    def given() -> Iterator[WireSample]:
        for sample in samples_of(run):
            yield scale.scaled(sample) if zeroed else sample
            scale.watch(sample)

    answers = [
        (scale.judged(one) if zeroed else one, recorded, scale.has_moved) for one, recorded in estimates(made, given())
    ]
    found, recorded, moved = zip(*answers, strict=True)
    failure = next((one.failure for one in found if one.failure), "")
    return EstimatedRun(
        np.array([one.value for one in found]),
        np.array([one.std for one in found]),
        np.array([one.valid for one in found]),
        np.array([int(one.reason) for one in found]),
        dict(zip(made.columns, np.array(recorded, dtype=np.float64).T, strict=True)),
        np.array(moved),
        failure,
    )


def setup_of(
    run: RecordedRun, model: SensingModel, wire: WireConstants | None, load: KnownSpring | None
) -> EstimatorSetup:
    """Return what a factory makes an estimator from."""
    known: dict[str, Any] = {}
    if "wire" in {item.name for item in fields(EstimatorSetup)}:
        known["wire"] = wire
    return EstimatorSetup(model, run.facts["shunt_resistance_ohm"], run.facts["sample_period_s"], load, **known)
