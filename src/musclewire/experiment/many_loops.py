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
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple, TypedDict, Unpack

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.controllers.controller import ControllerFactory
from musclewire.controllers.references import Reference
from musclewire.errors import CallerError, NumericsError, RigError
from musclewire.experiment.closed_loop import APPROACH_S, LoopChoice, PreparedLoop, control, name_of, prepared_loop
from musclewire.experiment.loop_outcomes import LoopOutcome, ManyControlRuns
from musclewire.experiment.metrics import ControlRun, control_metrics
from musclewire.experiment.run import NO_CLOCK, cause_of, what_protects
from musclewire.identify.recordings import COLUMN_SUFFIX
from musclewire.rigs.compiled_loop.kernel import Ended
from musclewire.rigs.compiled_loop.running import CompiledRun, LoopTicks, Targets, run_compiled, times_on_rig_s
from musclewire.rigs.configuration import open_rig, rig_configuration
from musclewire.rigs.guarded import GuardedRig
from musclewire.rigs.kinds import DeviceConfiguration
from musclewire.sensing.estimator import EstimatorFactory
from musclewire.sensing.known_load import KnownSpring
from musclewire.sensing.model import SensingModel
from musclewire.signals.compiled_tick import declared_tick
from musclewire.signals.recording import MetadataValue, Recording

__all__ = ["ManyLoopsOptions", "control_many"]

# If a compiled loop ended like this, the loop in Python must end with an error. After a reading that is not sound the
# protection may also hold the drive and go on.
ENDS_A_RUN = (Ended.COMMAND_NOT_SOUND, Ended.WIRE_NOT_RESOLVED, Ended.ESTIMATOR_FAILED, Ended.CONTROLLER_FAILED)


class ManyLoopsOptions(TypedDict, total=False):
    """Keywords of :func:`control_many`.

    ``approach_s`` is the time in which each wire reaches the reference's start; ``threads`` how many loops run at a
    time, by default one on each core; ``keep_recordings`` whether the outcomes have their recordings; ``in_python``
    whether every loop is run by ``control``, one after another; ``on_outcome`` is called with each outcome.
    """

    approach_s: float
    threads: int | None
    keep_recordings: bool
    in_python: bool
    on_outcome: Callable[[LoopOutcome], None]


class Case(NamedTuple):
    """One loop to run."""

    rig: DeviceConfiguration
    model: SensingModel
    seed: int


class CompiledLoop(NamedTuple):
    """What the loops of one rig and one model share: ticks, targets, and where they start."""

    prepared: PreparedLoop
    ticks: LoopTicks
    targets: Targets
    elapsed_s: FloatArray
    first_drive_v: float


def control_many(
    rig: str | Path | DeviceConfiguration | Sequence[str | Path | DeviceConfiguration],
    model: SensingModel | Sequence[SensingModel],
    reference: Reference | None = None,
    *,
    seeds: Iterable[int],
    estimator: str | EstimatorFactory = "polynomial",
    controller: str | ControllerFactory = "fuzzy-pid",
    settings: Any = None,
    load: KnownSpring | None = None,
    **options: Unpack[ManyLoopsOptions],
) -> ManyControlRuns:
    """Run many closed loops of simulated rigs as one call: for each seed what ``control`` runs on a rig of that seed.

    Wire, instruments, protection, estimator and controller are stepped in compiled code, one loop on each core at a
    time. All recorded numbers are those of ``control`` to the bit, whatever the number of threads and loops. A loop in
    which the protection finds a reading that is not sound, or in which the estimator or the controller ends the run, is
    run again by ``control``; its error, if it has one, is its outcome.

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
        Name of an estimator, or a factory of one. It needs a compiled tick.
    controller
        Name of a controller, or a factory of one. It needs a compiled tick.
    settings
        The controller's settings; its defaults if None.
    load
        A known spring, if force is controlled through its stiffness.
    options
        ``approach_s``, ``threads``, ``keep_recordings``, ``in_python`` and ``on_outcome``: see
        :class:`ManyLoopsOptions`.

    Returns
    -------
    The outcome of each loop, in the order of the seeds, with their medians and spreads.

    Raises
    ------
    CallerError
        If estimator, controller or rig has no compiled form and ``in_python`` is not set; and as ``control`` and
        ``open_rig`` do.
    NumericsError
        If a compiled tick ends a run that its ``step`` in Python does not end.

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
    choice = LoopChoice(estimator, controller, settings, load, options.get("approach_s", APPROACH_S))
    cases = cases_of(rig, model, tuple(seeds))
    in_python = partial(loop_in_python, reference=reference, choice=choice)
    if options.get("in_python", False):
        found: Iterable[LoopOutcome] = map(in_python, cases)
    else:
        found = compiled_outcomes(cases, reference, choice, options.get("threads"), in_python)
    kept = options.get("keep_recordings", False)
    outcomes: list[LoopOutcome] = []
    for outcome in found:
        outcomes.append(outcome if kept else outcome._replace(run=None))
        if "on_outcome" in options:
            options["on_outcome"](outcomes[-1])
    return ManyControlRuns(tuple(outcomes))


def cases_of(rigs: Any, models: SensingModel | Sequence[SensingModel], seeds: tuple[int, ...]) -> list[Case]:
    """Return the loops to run. Raises CallerError for no seeds, and for lists that are not as long as the seeds."""
    if not seeds:
        raise CallerError("no seeds: give at least one, such as range(1, 1001)")
    each_rig = list(rigs) if isinstance(rigs, Sequence) and not isinstance(rigs, str) else [rigs]
    each_model = [models] if isinstance(models, SensingModel) else list(models)
    for name, given in (("rigs", each_rig), ("models", each_model)):
        if len(given) not in (1, len(seeds)):
            raise CallerError(f"{len(given)} {name} for {len(seeds)} seeds: give one, or one for each seed")
    known = {id(one): rig_configuration(one)[0] for one in each_rig}
    configurations = [known[id(one)] for one in each_rig] * (len(seeds) // len(each_rig))
    return list(map(Case, configurations, each_model * (len(seeds) // len(each_model)), seeds))


def compiled_outcomes(
    cases: list[Case],
    reference: Reference | None,
    choice: LoopChoice,
    threads: int | None,
    in_python: Callable[[Case], LoopOutcome],
) -> Iterator[LoopOutcome]:
    """Yield the outcomes of compiled loops in the order of the cases."""
    loops: dict[tuple[int, int], CompiledLoop] = {}
    for case in cases:
        key = (id(case.rig), id(case.model))
        if key not in loops:
            loops[key] = shared_loop(case, reference, choice)
    run = partial(compiled_outcome, software_version=version("musclewire"))
    count = min(threads or os.cpu_count() or 1, len(cases))
    with ThreadPoolExecutor(count) as pool:
        try:
            for case, (ended, outcome) in zip(
                cases, pool.map(lambda case: run(case, loops[id(case.rig), id(case.model)]), cases), strict=True
            ):
                yield outcome if outcome is not None else repeated(case, ended, in_python)
        finally:
            pool.shutdown(cancel_futures=True)


def shared_loop(case: Case, reference: Reference | None, choice: LoopChoice) -> CompiledLoop:
    """Return what all loops of a rig and a model share. Raises CallerError for what has no compiled form."""
    with open_rig(case.rig, seed=case.seed) as rig:
        prepared = prepared_loop(rig, case.model, reference, choice)
        first_drive_v = prepared.controller.limits.clamp(rig.drive_voltage_v)
        ticks = ticks_of(prepared, choice, first_drive_v)
        times_s = times_on_rig_s(rig, round(prepared.duration_s / rig.sample_period_s))
        start_s = times_s[0] - rig.sample_period_s
        # As the loop in Python rounds them; NumPy would round the product and not the number.
        elapsed_s = np.array([round(time_s - start_s, 9) for time_s in times_s.tolist()])
        held = np.maximum(elapsed_s - rig.sample_period_s - choice.approach_s, 0.0)
        following = np.maximum(elapsed_s - choice.approach_s, 0.0)
        values = np.array([prepared.reference.targets_at(held), prepared.reference.targets_at(following)])
        return CompiledLoop(prepared, ticks, Targets(times_s, values), elapsed_s, first_drive_v)


def ticks_of(prepared: PreparedLoop, choice: LoopChoice, first_drive_v: float) -> LoopTicks:
    """Return the compiled ticks of a loop. Raises CallerError naming what has none."""
    estimator = declared_tick(prepared.estimator)
    controller = declared_tick(prepared.controller, first_drive_v)
    for kind, name, tick in (
        ("estimator", name_of(choice.estimator), estimator),
        ("controller", name_of(choice.controller), controller),
    ):
        if tick is None:
            raise CallerError(
                f"the {kind} {name} has no compiled tick: declare one by a method compiled_tick of its own class, or "
                "run the loops in Python (in_python=True, --in-python)"
            )
    if prepared.estimator.slow_part is not None:
        raise CallerError(
            f"the estimator {name_of(choice.estimator)} has a slow part, which has no compiled form: run the loops in "
            "Python (in_python=True, --in-python)"
        )
    assert estimator is not None
    assert controller is not None
    return LoopTicks(estimator, controller, prepared.estimator.columns, prepared.controller.columns)


def compiled_outcome(case: Case, loop: CompiledLoop, *, software_version: str) -> tuple[Ended, LoopOutcome | None]:
    """Run one compiled loop; return how it ended, and its outcome unless it has to be repeated in Python."""
    with open_rig(case.rig, seed=case.seed) as rig:
        run = run_compiled(rig, loop.ticks, loop.targets, loop.first_drive_v)
        if run.ended is not Ended.DONE:
            return run.ended, None
        recording = recording_of(rig, loop, run, software_version)
    metrics = control_metrics(recording, loop.prepared.model.quantity, loop.prepared.reference)
    whole = ControlRun(recording.columns, recording.metadata, metrics)
    return run.ended, LoopOutcome(case.seed, "done", True, metrics, whole)


def recording_of(rig: GuardedRig, loop: CompiledLoop, run: CompiledRun, software_version: str) -> Recording:
    """Return a compiled loop as the recording that ``control`` would have made; it has no times of computing."""
    suffix = COLUMN_SUFFIX[loop.prepared.model.quantity]
    renamed = {"target": f"target_{suffix}", "estimated": f"estimated_{suffix}"}
    columns = {renamed.get(name, name): column for name, column in run.columns.items()}
    metadata: dict[str, MetadataValue] = {
        **what_protects(rig),
        **rig.metadata(),
        **loop.prepared.metadata,
        "software_version": software_version,
        "start_time": datetime.now(UTC).isoformat(timespec="seconds"),
        "pace": NO_CLOCK,
        "compiled_loop": True,
        "ended": "done",
    }
    return Recording({**columns, "time_s": loop.elapsed_s}, metadata)


def repeated(case: Case, ended: Ended, in_python: Callable[[Case], LoopOutcome]) -> LoopOutcome:
    """Return the outcome of a loop in Python after the compiled one ended before its time."""
    outcome = in_python(case)
    if outcome.ended == "done" and ended in ENDS_A_RUN:
        raise NumericsError(
            f"the compiled loop of seed {case.seed} ended by {ended.name.lower()}, the loop in Python did not: a "
            "compiled tick differs from its step; run the loops in Python (in_python=True, --in-python)"
        )
    return outcome


def loop_in_python(case: Case, reference: Reference | None, choice: LoopChoice) -> LoopOutcome:
    """Return the outcome of ``control`` on a rig of a seed; its error, if it is one of the run, is part of it."""
    with open_rig(case.rig, seed=case.seed) as rig:
        try:
            run = control(
                rig,
                case.model,
                reference,
                estimator=choice.estimator,
                controller=choice.controller,
                settings=choice.settings,
                load=choice.load,
                approach_s=choice.approach_s,
            )
        except (RigError, NumericsError) as error:
            return LoopOutcome(case.seed, cause_of(error), False, None, getattr(error, "recording", None))
    return LoopOutcome(case.seed, "done", False, run.metrics, run)
