"""Every estimator over a recorded run: what it would have said in the loop."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from musclewire import ESTIMATORS, EstimatorSetup, FloatArray, SensingModel, WireSample
from musclewire.identify import load_facts
from musclewire.judge import JudgedLoop, KnownB, RunCorrection, odd_resistance
from musclewire.sensing import UNCORRECTED, Correction, EstimatorFactory, KnownSpring, state_going_on
from musclewire.signals import Recording
from musclewire.wire import WireConstants
from musclewire_robustness.recorded_run import RecordedRun


class EstimatedRun(NamedTuple):
    """An estimator's answers over a run, each (n_samples,).

    ``columns`` are those that it records itself, ``resistance_is_odd`` is where B was known to be at another height,
    the resistance to have jumped, or to be above all that the slow loop showed.
    """

    value: FloatArray
    std: FloatArray
    valid: npt.NDArray[np.bool_]
    reason: npt.NDArray[np.int64]
    columns: dict[str, FloatArray]
    resistance_is_odd: npt.NDArray[np.bool_]
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
    known_b = KnownB.of_model(model, run.facts["sense_voltage_v"])
    correction = RunCorrection(model, run.facts["shunt_resistance_ohm"], known_b)
    made = factory(setup_of(run, model, wire, load))
    state, answers = made.start(), []
    for sample in samples_of(run):
        own, state, recorded = made.step(state, sample)
        answers.append((correction.shown(own) if zeroed else own, recorded, correction.has_moved))
        if correction.watch(sample, own, sample.time_s) and zeroed:
            made = factory(setup_of(run, model, wire, load, correction.correction))
            state = state_going_on(made, state)
    found, recorded, moved = zip(*answers, strict=True)
    since = since_first_odd(run, model, np.array([one.valid for one in found]))
    failure = next((one.failure for one in found if one.failure), "")
    return EstimatedRun(
        np.array([one.value for one in found]),
        np.array([one.std for one in found]),
        np.array([one.valid for one in found]),
        np.array([int(one.reason) for one in found]),
        dict(zip(made.columns, np.array(recorded, dtype=np.float64).T, strict=True)),
        np.array(moved) | since,
        failure,
    )


def since_first_odd(run: RecordedRun, model: SensingModel, valid: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return the samples since the first whose resistance is none of the wire's, once it is sensed, (n_samples,)."""
    current_a = run.shunt_voltage_v / run.facts["shunt_resistance_ohm"]
    columns = {
        "time_s": run.time_s,
        "drive_voltage_v": run.drive_voltage_v,
        "wire_resistance_ohm": run.wire_voltage_v / np.maximum(current_a, 1e-9),
        "valid": valid.astype(np.float64),
    }
    stated = {**load_facts(model, {}), "limit_sense_voltage_v": run.facts["sense_voltage_v"]}
    odd = odd_resistance(JudgedLoop(Recording(columns, {**stated, "sample_period_s": run.facts["sample_period_s"]})))
    marked = np.zeros(valid.size, dtype=np.bool_)
    for rows in (odd.jumps, odd.above):
        marked[rows[0] if rows.size else valid.size :] = True
    return marked


def setup_of(
    run: RecordedRun,
    model: SensingModel,
    wire: WireConstants | None,
    load: KnownSpring | None,
    correction: Correction = UNCORRECTED,
) -> EstimatorSetup:
    """Return what a factory makes an estimator from."""
    shunt_ohm, period_s = run.facts["shunt_resistance_ohm"], run.facts["sample_period_s"]
    return EstimatorSetup(correction.applied_to(model), shunt_ohm, period_s, load, wire, correction)
