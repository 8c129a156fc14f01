"""Many closed loops at once: the loop that ``control`` runs, in compiled code, for many seeds over all cores.

Every loop is a rig of its own, opened with its own seed, and one task of a pool of threads: its numbers depend neither
on the other loops nor on how many run at a time. A loop to which something unusual happens (a reading that the
protection does not find sound, a tick that fails) is run again by ``control``, which decides what follows.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.controllers import ControllerFactory, Reference, State
from musclewire.errors import CallerError, NumericsError, RigError, argument
from musclewire.experiment._calm_air import heed_air
from musclewire.experiment._closed_loop import FACTOR, LoopChoice, PreparedLoop, control, prepared_loop
from musclewire.experiment._endings import cause_of, software_version
from musclewire.experiment._loop_outcomes import LoopOutcome, ManyControlRuns
from musclewire.experiment._metrics import ControlRun, with_metrics
from musclewire.experiment._run import what_protects
from musclewire.experiment._run_warnings import found_in, run_warnings
from musclewire.experiment._timing_facts import NO_CLOCK
from musclewire.judge import KEPT, RunCorrection, judgement_of
from musclewire.physics import wire_resistance
from musclewire.rigs import (
    CompiledLoopEnd,
    CompiledRun,
    DeviceConfiguration,
    GuardedRig,
    LoopTicks,
    open_rig,
    rig_configuration,
    run_compiled,
    run_known_drive,
    times_on_rig_s,
)
from musclewire.sensing import EstimatorFactory, KnownSpring, SensingModel
from musclewire.signals import (
    COLUMN_SUFFIX,
    COOLING_FROM,
    ELECTRICAL_COLUMNS,
    OF_THE_ESTIMATE,
    MetadataValue,
    QuantityEstimate,
    Recording,
    WireSample,
    declared_tick,
    with_answers_of,
)


class LoopCase(NamedTuple):
    """One loop to run."""

    rig: DeviceConfiguration
    model: SensingModel
    seed: int


class CompiledLoop(NamedTuple):
    """What the loops of one rig and one model share; ``elapsed_s`` counts on through the cooling after a loop."""

    model: SensingModel
    choice: LoopChoice
    prepared: PreparedLoop
    ticks: LoopTicks
    targets: FloatArray
    elapsed_s: FloatArray
    first_drive_v: float
    announced_miss: FloatArray | None


def control_many(
    rig: str | Path | DeviceConfiguration | Sequence[str | Path | DeviceConfiguration],
    model: SensingModel | Sequence[SensingModel],
    reference: Reference | None = None,
    *,
    seeds: Iterable[int],
    estimator: str | EstimatorFactory | None = None,
    controller: str | ControllerFactory | None = None,
    settings: Any = None,
    load: KnownSpring | None = None,
    approach_s: float | None = None,
    zero_from: str = KEPT,
    known_strain: float | tuple[float, float] | None = None,
    threads: int | None = None,
    keep_recordings: bool = False,
    in_python: bool = False,
    on_outcome: Callable[[LoopOutcome], None] | None = None,
) -> ManyControlRuns:
    """Run many closed loops of simulated rigs as one call: for each seed what ``control`` runs on a rig of that seed.

    Wire, instruments, protection, estimator and controller are stepped in compiled code, one loop on each core at a
    time. All recorded numbers are those of ``control``, whatever the number of threads and loops. A loop in which the
    protection finds a reading that is not sound, or in which the estimator or the controller ends the run, is run again
    by ``control``; its error, if it has one, is its outcome.

    Parameters
    ----------
    rig
        A simulated rig, as for ``open_rig``; or as many as seeds, one for each loop.
    model
        The model of its wire; or as many as seeds.
    reference
        The target over time, in the model's quantity; the paper's staircase if None.
    seeds
        The seeds of the rigs, each 0 or more, such as ``range(1, 1001)``.
    estimator
        Name of an estimator, or a factory of one; as of ``control`` if None. It needs a compiled tick.
    controller
        Name of a controller, or a factory of one; as of ``control`` if None. It needs a compiled tick.
    settings
        The controller's settings; as of ``control`` if None.
    load
        A known spring, if force is controlled through its stiffness.
    approach_s
        Time [s] for which the reference's start is held before the reference begins; as of ``control`` if None.
    zero_from, known_strain
        As of ``control``.
    threads
        How many loops run at a time; by default one on each core.
    keep_recordings
        Whether the outcomes have their recordings.
    in_python
        Whether every loop is run by ``control``, one after another.
    on_outcome
        Called with each outcome.

    Returns
    -------
    The outcome of each loop, in the order of the seeds, with their medians and spreads.

    Raises
    ------
    CallerError
        If estimator, controller or rig has no compiled form and ``in_python`` is not set; and as ``control`` and
        ``open_rig`` do.

    References
    ----------
    Lan and Fan 2010, section III and Fig. 11.

    Examples
    --------
    >>> import musclewire as mw
    >>> with mw.open_rig("simulated") as rig:
    ...     model = mw.fit(mw.characterize(rig))
    >>> runs = mw.control_many("simulated", model, mw.staircase(stop=0.018), seeds=range(1, 4))
    >>> runs.mae_pct.shape  # loops, steps
    (3, 3)
    """
    choice = LoopChoice(
        estimator, controller, settings, load, approach_s, zero_from=zero_from, known_strain=known_strain
    )
    cases = cases_of(rig, model, tuple(seeds))
    if in_python:
        found = outcomes_in_python(cases, reference, choice)
    else:
        found = compiled_outcomes(cases, reference, choice, threads)
    outcomes: list[LoopOutcome] = []
    for outcome in found:
        outcomes.append(outcome if keep_recordings else outcome._replace(run=None))
        if on_outcome is not None:
            on_outcome(outcomes[-1])
    return ManyControlRuns(tuple(outcomes))


def control_compiled(
    rig: GuardedRig,
    model: SensingModel,
    reference: Reference | None = None,
    *,
    estimator: str | EstimatorFactory | None = None,
    controller: str | ControllerFactory | None = None,
    settings: Any = None,
    load: KnownSpring | None = None,
    approach_s: float | None = None,
) -> ControlRun:
    """Run the loop of ``control`` from the present state of a simulated rig in compiled code, and close the rig.

    For studies that open a rig, do something with it, and end with a closed loop. The recording is that of ``control``.
    Where something unusual happens, ``control`` runs the loop.

    Parameters
    ----------
    rig
        The rig, open, and not being driven: after an experiment it is at its sense voltage.
    model
        The model of its wire.
    reference
        The target over time, in the model's quantity; the paper's staircase if None.
    estimator
        Name of an estimator, or a factory of one; as of ``control`` if None. It needs a compiled tick.
    controller
        Name of a controller, or a factory of one; as of ``control`` if None. It needs a compiled tick.
    settings
        The controller's settings; as of ``control`` if None.
    load
        A known spring, if force is controlled through its stiffness.
    approach_s
        Time [s] for which the reference's start is held before the reference begins; as of ``control`` if None.

    Returns
    -------
    The recording with its metrics.

    Raises
    ------
    CallerError
        If estimator, controller or rig has no compiled form, and as ``control`` does.
    RigError
        As ``control`` does.
    NumericsError
        As ``control`` does.
    """
    choice = LoopChoice(estimator, controller, settings, load, approach_s)
    with rig:
        loop = compiled_loop_on(rig, model, reference, choice)
        run = run_of(rig, loop)
        if run is not None:
            return control_run(rig, loop, run)
        return control(rig, model, loop.prepared.reference, **choice.options)


def cases_of(rigs: Any, models: SensingModel | Sequence[SensingModel], seeds: tuple[int, ...]) -> list[LoopCase]:
    """Return the loops to run. Raises CallerError for no seeds, lists not as long as the seeds, and an open rig."""
    if not seeds:
        raise CallerError("no seeds: give at least one, such as range(1, 1001)")
    each_rig = list(rigs) if isinstance(rigs, Sequence) and not isinstance(rigs, str) else [rigs]
    each_model = [models] if isinstance(models, SensingModel) else list(models)
    for name, given in (("rigs", each_rig), ("models", each_model)):
        if len(given) not in (1, len(seeds)):
            raise CallerError(f"{len(given)} {name} for {len(seeds)} seeds: give one, or one for each seed")
    if any(isinstance(one, GuardedRig) for one in each_rig):
        raise CallerError(
            "an open rig cannot run many loops: give its name, file or configuration, each loop opens its own"
        )
    known = {id(one): rig_configuration(one, may_import=True)[0] for one in each_rig}
    configurations = [known[id(one)] for one in each_rig] * (len(seeds) // len(each_rig))
    return list(map(LoopCase, configurations, each_model * (len(seeds) // len(each_model)), seeds))


def outcomes_in_python(cases: list[LoopCase], reference: Reference | None, choice: LoopChoice) -> Iterator[LoopOutcome]:
    """Yield the outcomes of loops in Python, one after another."""
    for case in cases:
        with open_rig(case.rig, seed=case.seed) as rig:
            yield outcome_in_python(rig, case.model, reference, choice, case.seed)


def compiled_outcomes(
    cases: list[LoopCase], reference: Reference | None, choice: LoopChoice, threads: int | None
) -> Iterator[LoopOutcome]:
    """Yield the outcomes of compiled loops in the order of the cases."""
    loops: dict[tuple[int, int], CompiledLoop] = {}
    for case in cases:
        key = (id(case.rig), id(case.model))
        if key not in loops:
            with open_rig(case.rig, seed=case.seed) as rig:
                loops[key] = compiled_loop_on(rig, case.model, reference, choice)

    def outcome(case: LoopCase) -> LoopOutcome:
        loop = loops[id(case.rig), id(case.model)]
        with open_rig(case.rig, seed=case.seed) as rig:
            heed_air(rig, loop.model)
            run = run_of(rig, loop)
            if run is not None:
                whole = control_run(rig, loop, run)
                said, against = run_warnings(whole), judgement_of(whole).does_not_hold
                return LoopOutcome(case.seed, "done", True, whole.metrics, whole, said, against)
        with open_rig(case.rig, seed=case.seed) as rig:
            return outcome_in_python(rig, loop.model, loop.prepared.reference, loop.choice, case.seed)

    with ThreadPoolExecutor(min(threads or os.cpu_count() or 1, len(cases))) as pool:
        try:
            yield from pool.map(outcome, cases)
        finally:
            pool.shutdown(cancel_futures=True)


def compiled_loop_on(
    rig: GuardedRig, model: SensingModel, reference: Reference | None, choice: LoopChoice
) -> CompiledLoop:
    """Return what all loops on such a rig with one model share. Raises CallerError for what has no compiled form."""
    prepared = prepared_loop(rig, model, reference, choice)
    first_drive_v = prepared.controller.limits.clamp(rig.drive_voltage_v)
    ticks = ticks_of(prepared, first_drive_v)
    samples, cooling = (round(one / rig.sample_period_s) for one in (prepared.duration_s, prepared.cooling_s))
    times_s = times_on_rig_s(rig, samples + cooling)
    start_s = times_s[0] - rig.sample_period_s
    # As the loop in Python rounds them; NumPy would round the product and not the number.
    elapsed_s = np.array([round(time_s - start_s, 9) for time_s in times_s.tolist()])
    held = np.maximum(elapsed_s[:samples] - rig.sample_period_s - prepared.approach_s, 0.0)
    following = np.maximum(elapsed_s[:samples] - prepared.approach_s, 0.0)
    values = np.array([prepared.reference.targets_at(held), prepared.reference.targets_at(following)])
    fastest = prepared.fastest
    announced = None if fastest is None else np.array([fastest.miss(target) for target in values[0].tolist()])
    return CompiledLoop(model, choice, prepared, ticks, values, elapsed_s, first_drive_v, announced)


def ticks_of(prepared: PreparedLoop, first_drive_v: float) -> LoopTicks:
    """Return the compiled ticks of a loop. Raises CallerError naming what has none."""
    estimator = declared_tick(prepared.estimator)
    controller = declared_tick(prepared.controller, first_drive_v)
    for kind, name, tick in (
        ("estimator", prepared.metadata["estimator"], estimator),
        ("controller", prepared.metadata["controller"], controller),
    ):
        if tick is None:
            raise CallerError(
                f"the {kind} {name} has no compiled tick: declare one by a method compiled_tick of its own class, or "
                "run the loops in Python (" + argument("in_python", True) + ")"
            )
    assert estimator is not None
    assert controller is not None
    return LoopTicks(estimator, controller, prepared.estimator.columns, prepared.controller.columns)


def run_of(rig: GuardedRig, loop: CompiledLoop) -> CompiledRun | None:
    """Return a compiled loop and its cooling, by today's model after each correction; None if Python has to run it."""
    samples = loop.targets.shape[1]
    correction = loop.prepared.correction_of()
    parts: list[dict[str, FloatArray]] = []
    ticks, drive_v, state, begins = loop.ticks, loop.first_drive_v, State.ARMED, 0
    while True:
        now, variance = correction.correction, correction.variance
        elapsed_s, targets = loop.elapsed_s[begins:samples], loop.targets[:, begins:]
        ends_after = partial(corrects_after, correction, elapsed_s - rig.sample_period_s)
        in_own_zero = np.array([targets[0], targets[1] + now.zero])
        run = run_compiled(rig, ticks, elapsed_s, in_own_zero, drive_v, ends_after=ends_after, state=state)
        if run.ended is not CompiledLoopEnd.DONE or correction.is_refused:
            return None
        std = np.sqrt(run.columns["estimate_std"] ** 2 + variance)
        shown = {"estimated": run.columns["estimated"] - now.zero, "estimate_std": std}
        factor = {FACTOR: np.full(run.samples, now.scale)} if loop.prepared.corrects else {}
        parts.append({**run.columns, **shown, **factor})
        begins += run.samples
        if begins == samples:
            cooled = cooling_of(rig, loop.elapsed_s.size - samples)
            if cooled is None:
                return None
            nothing = np.full(loop.elapsed_s.size - samples, np.nan)
            parts.append({name: cooled.get(name, nothing) for name in parts[0]})
            return run._replace(columns={name: np.concatenate([one[name] for one in parts]) for name in parts[0]})
        estimator = declared_tick(loop.prepared.estimator_of(correction.correction))
        assert estimator is not None
        ticks = ticks._replace(estimator=estimator, controller=run.controller)
        drive_v, state = run.next_drive_v, State.RUN


def cooling_of(rig: GuardedRig, samples: int) -> dict[str, FloatArray] | None:
    """Return what a rig measures in the samples of a cooling; None if something unusual happens."""
    if not samples:
        return {}
    rig.make_safe()
    run = run_known_drive(rig, np.full(samples, rig.sense_voltage_v))
    if run.ended is not CompiledLoopEnd.DONE:
        return None
    voltages_v = run.columns["wire_voltage_v"], run.columns["shunt_voltage_v"]
    seen = {name: run.columns[name] for name in (*ELECTRICAL_COLUMNS, *rig.reference_columns)}
    return {**seen, OF_THE_ESTIMATE: wire_resistance(*voltages_v, rig.shunt_resistance_ohm).resistance_ohm}


def corrects_after(correction: RunCorrection, taken_s: FloatArray, run: CompiledRun) -> int | None:
    """Return after how many samples of a part a correction follows from them; None if none does."""
    names = ("time_s", "drive_voltage_v", "wire_voltage_v", "shunt_voltage_v", "estimated", "estimate_std", "valid")
    rows = zip(*(run.columns[name].tolist() for name in names), taken_s.tolist(), strict=True)
    for row, (*sample, value, std, valid, taken) in enumerate(rows):
        if not correction.watches:
            break
        if correction.watch(WireSample(*sample), QuantityEstimate(value, std, valid > 0.0), taken):
            return row + 1
    return None


def control_run(rig: GuardedRig, loop: CompiledLoop, run: CompiledRun) -> ControlRun:
    """Return a compiled loop that reached its end as ``control`` returns it."""
    return with_metrics(recording_of(rig, loop, run), loop.prepared.model.quantity, loop.prepared.reference)


def recording_of(rig: GuardedRig, loop: CompiledLoop, run: CompiledRun) -> Recording:
    """Return a compiled loop as the recording that ``control`` would have made; it has no times of computing."""
    suffix = COLUMN_SUFFIX[loop.prepared.model.quantity]
    renamed = {"target": f"target_{suffix}", "estimated": f"estimated_{suffix}"}
    columns = {renamed.get(name, name): column for name, column in run.columns.items()}
    metadata: dict[str, MetadataValue] = {
        **what_protects(rig),
        **rig.metadata(),
        **loop.prepared.metadata,
        "software_version": software_version(),
        "start_time": datetime.now(UTC).isoformat(timespec="seconds"),
        "pace": NO_CLOCK,
        "compiled_loop": True,
        "ended": "done",
    }
    samples = loop.targets.shape[1]
    if loop.announced_miss is not None:
        columns["announced_miss"] = np.append(loop.announced_miss, np.full(loop.elapsed_s.size - samples, np.nan))
    if loop.prepared.cooling_s:
        metadata[COOLING_FROM] = float(loop.elapsed_s[samples - 1])
    recording = Recording({**columns, "time_s": loop.elapsed_s}, metadata)
    return with_answers_of(recording.with_metadata(found_in(recording)), recording)


def outcome_in_python(
    rig: GuardedRig, model: SensingModel, reference: Reference | None, choice: LoopChoice, seed: int
) -> LoopOutcome:
    """Return the outcome of ``control`` on a rig; its error, if it is one of the run, is part of it."""
    try:
        run = control(rig, model, reference, **choice.options)
    except (RigError, NumericsError) as error:
        return LoopOutcome(seed, cause_of(error), False, None, getattr(error, "recording", None))
    return LoopOutcome(seed, "done", False, run.metrics, run, run_warnings(run), judgement_of(run).does_not_hold)
