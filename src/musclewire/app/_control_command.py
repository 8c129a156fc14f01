"""The command that closes the loop by the wire's own resistance, once or for many seeds at a time: control."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from musclewire.app._figure_options import FigureOptions
from musclewire.app._files import opened_model, require_recording_file
from musclewire.app._home_command import HomeOptions, home_found, home_text
from musclewire.app._options import (
    APPROACH,
    CONTROLLER,
    ESTIMATOR,
    FOLLOWED_QUANTITY,
    GAINS,
    IN_PYTHON,
    KNOWN_STIFFNESS,
    KNOWN_STRAIN,
    ON_BOARD,
    OVERWRITE,
    REFERENCE,
    RULES,
    RUNS,
    SEED,
    THREADS,
    WIRE_FILE,
    ZERO_FROM,
    RigName,
    in_si,
    own_help,
)
from musclewire.app._output import Result, progress_bar, warn
from musclewire.app._rig_options import TimingOptions
from musclewire.app._stopping import stops_between_samples
from musclewire.errors import CallerError, MusclewireError, RecordingError, nearest_hint

if TYPE_CHECKING:
    from musclewire.app._answers import ControlRunAnswer
    from musclewire.controllers import Reference
    from musclewire.experiment import ControlMetrics, ControlRun, LoopChoice, LoopOutcome, SettledChoice
    from musclewire.identify import Homing, SpeedLimits
    from musclewire.rigs import Rig
    from musclewire.sensing import KnownSpring, SensingModel


# Steps as a text: "2.5 mm to 6 mm by 0.5 mm", or "... for 20 s".
STEPS = re.compile(r"(.+?)\s+to\s+(.+?)\s+by\s+(.+?)(?:\s+for\s+(.+))?")
# The paper's controller, whose rule base --rules names.
FUZZY_PID = "fuzzy-pid"
UNITS = {"strain": "", "displacement": "m", "force": "N"}
NO_RULES = "--rules belong to the controller fuzzy-pid, not to {}: leave one of them out"


@dataclass(frozen=True)
class ControlledLoopOptions:
    """What is controlled, along which reference, by which estimator and controller, and where the loop is closed."""

    quantity: Annotated[str, FOLLOWED_QUANTITY] = "strain"
    known_stiffness: Annotated[str | None, KNOWN_STIFFNESS] = None
    reference: Annotated[str, REFERENCE] = "staircase"
    estimator: Annotated[str | None, ESTIMATOR] = None
    wire_file: Annotated[Path | None, WIRE_FILE] = None
    controller: Annotated[str | None, CONTROLLER] = None
    rules: Annotated[str | None, RULES] = None
    gains: Annotated[Path | None, GAINS] = None
    approach: Annotated[str | None, APPROACH] = None
    zero_from: Annotated[str, ZERO_FROM] = "kept"
    known_strain: Annotated[str | None, KNOWN_STRAIN] = None
    on_board: Annotated[bool, ON_BOARD] = False


def control(
    rig: RigName,
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="Model file from 'musclewire fit'.")],
    loop: ControlledLoopOptions,
    timing: TimingOptions,
    many: ManyLoopsChoice,
    homing: HomeOptions,
    figure: FigureOptions,
    output: Annotated[Path | None, own_help("--output", "Recording to write (.h5).")] = None,
    seed: Annotated[int | None, SEED] = None,
    overwrite: Annotated[bool, OVERWRITE] = False,
) -> Result:
    """Closed loop: move the wire by its own resistance; MAE of each step, with --runs for many seeds."""
    from musclewire.experiment import cooling_time_s
    from musclewire.identify import known_against
    from musclewire.rigs import open_rig

    loaded = opened_model(model)
    refuse_single_run_options(many, single_run_options(loop, timing, figure, output, overwrite) | homing.given())
    load = known_spring(loaded, model, loop.quantity, in_si("--known-stiffness", loop.known_stiffness))
    target = read_reference(loop.reference, loop.quantity, loaded)
    choice = choice_of(loop, load)
    homing.check(on_board=loop.on_board)
    if many.runs is not None:
        with open_rig(rig, seed=seed) as opened:
            warn(known_against(loaded, opened.metadata()).values())
            follows = target or staircase_for(loaded, load, opened.leg_length_m)
            settled = choice.settled(loaded, opened.sample_period_s)
            print_speed_limits(opened, loaded, follows, settled, load)
        return run_many_loops(rig, seed, many, loaded, choice, follows, settled.approach_s + follows.duration_s)
    figure.check()
    if output is not None:
        require_recording_file(output, overwrite)
    follow = loop_of(choice, loop)
    homed: Homing | None = None
    with stops_between_samples(), timing.open_rig(rig, seed) as opened:
        said = [*timing.apply(opened), *warn(known_against(loaded, opened.metadata()).values())]
        if homing.home == "start":
            homed = homing.homed(opened, loaded)
            loaded = homed.model
        if target is None:
            target = staircase_for(loaded, load, opened.leg_length_m)
        settled = choice.settled(loaded, opened.sample_period_s)
        limits = print_speed_limits(opened, loaded, target, settled, load)
        loop_s = settled.approach_s + target.duration_s
        with progress_bar("Closed loop", loop_s + cooling_time_s(opened, loaded, loop_s), opened) as on_sample:
            run = follow(opened, loaded, target, path=output, overwrite=overwrite, on_sample=on_sample)
        if homing.home == "idle":
            homed = homing.homed(opened, loaded)
    figure.draw(run.plot)
    answer = control_answer(run, load, limits, homed, said)
    text = [] if homed is None else [home_text(homed)]
    return Result(answer, "\n".join([*text, str(run.metrics)]), error=error_of_run(run))


def control_answer(
    run: ControlRun, load: KnownSpring | None, limits: SpeedLimits | None, homed: Homing | None, said: list[str]
) -> ControlRunAnswer:
    """Return the answer of a closed loop; its warnings are also printed, but for those that were ``said`` before."""
    from musclewire.app._answers import ControlRunAnswer
    from musclewire.experiment import run_warnings, timing_json
    from musclewire.judge import judgement_of

    facts = {"health": "", **run.metadata}
    return ControlRunAnswer.of_run(
        run.metrics,
        **timing_json(facts),
        known_stiffness_n_per_m=None if load is None else load.stiffness_n_per_m,
        known_friction_n=None if load is None else load.friction_n,
        **{name: facts.get(name) for name in ("estimator", "controller", "health", "ended")},
        findings=[one.answer for one in judgement_of(run).findings],
        samples=len(run),
        warnings=[
            *said,
            *warn(one for one in run_warnings(run) if one not in said),
            *(() if limits is None else limits.warnings),
        ],
        speed_limits=limits,
        home=None if homed is None else home_found(homed),
    )


def print_speed_limits(
    opened: Rig, loaded: SensingModel, target: Reference, settled: SettledChoice, load: KnownSpring | None
) -> SpeedLimits | None:
    """Print where a reference is faster than the wire, or the supply too weak, before it is heated; return it.

    None if model or rig do not state what it follows from.
    """
    from musclewire.experiment import speed_limits

    try:
        from_cold = settled.approach_s == 0.0
        limits = speed_limits(opened, loaded, target, settings=settled.settings, load=load, from_cold=from_cold)
    except RecordingError:
        return None
    warn(limits.warnings)
    return limits


def error_of_run(run: ControlRun) -> MusclewireError | None:
    """Return why the result of a run does not hold, None if it does."""
    from musclewire.judge import judgement_of

    return MusclewireError("this does not hold: see the warnings above") if judgement_of(run).does_not_hold else None


def single_run_options(
    loop: ControlledLoopOptions, timing: TimingOptions, figure: FigureOptions, output: Path | None, overwrite: bool
) -> dict[str, bool]:
    """Return which options that only a single run can have were given, by name."""
    return {
        "--output": output is not None,
        "--overwrite": overwrite,
        "--plot": figure.plot is not None,
        "--on-board": loop.on_board,
        "--wire-file": loop.wire_file is not None,
        "--real-time": timing.real_time,
        "--clock-speed": timing.clock_speed != 1.0,
        "--real-time-priority": timing.real_time_priority,
        "--cpu": timing.cpu is not None,
        "--wire-temperature": timing.wire_temperature is not None,
    }


def loop_of(choice: LoopChoice, loop: ControlledLoopOptions) -> Callable[..., ControlRun]:
    """Return what runs the closed loop: on the host, or on a board that was built for this model.

    Raises CallerError for options that change the host's numbers if the firmware's are to run.
    """
    if not loop.on_board:
        from musclewire.experiment import control as control_on_host

        return partial(control_on_host, **choice.options)
    if loop.estimator is not None or choice.controller not in (None, FUZZY_PID) or loop.wire_file is not None:
        raise CallerError(
            "--on-board runs the firmware's own estimator and controller: leave both names and --wire-file out"
        )
    if choice.load is not None:
        raise CallerError("--on-board runs by the firmware's own numbers: leave out --known-stiffness")
    from musclewire.experiment import control_on_board

    kept = ("settings", "approach_s", "zero_from", "known_strain")
    return partial(control_on_board, **{name: choice.options[name] for name in kept})


def choice_of(loop: ControlledLoopOptions, load: KnownSpring | None) -> LoopChoice:
    """Return what the options choose for a loop, None for the model's gains. Raises CallerError as ``settings_of``."""
    from musclewire.experiment import LoopChoice
    from musclewire.sensing import ESTIMATORS

    if loop.estimator is not None:
        ESTIMATORS.find(loop.estimator)
    controller, settings = settings_of(loop)
    approach_s = in_si("--approach", loop.approach)
    known = known_strain_of(loop)
    return LoopChoice(loop.estimator, controller, settings, load, approach_s, loop.wire_file, loop.zero_from, known)


def known_strain_of(loop: ControlledLoopOptions) -> float | tuple[float, float] | None:
    """Return a strain, displacement [m] or force [N] that is known, with its time [s] if given; None for none."""
    from musclewire.signals import parse_quantity

    if loop.known_strain is None:
        return None
    text, at, time = loop.known_strain.strip().partition(" at")
    try:
        value = parse_quantity(text, UNITS[loop.quantity])
        return (value, parse_quantity(time, "s")) if at else value
    except CallerError as error:
        raise CallerError(f"--known-strain: {error}") from None


def settings_of(loop: ControlledLoopOptions) -> tuple[str | None, Any]:
    """Return controller and settings: those of a gains file, or by name; None for what the model's gains decide.

    Raises CallerError for an unknown controller, and for rules or a name that contradict the gains file.
    """
    from musclewire.controllers import CONTROLLERS, FuzzyPidSettings, load_gains

    if loop.gains is not None:
        if loop.rules is not None:
            raise CallerError(f"gains file {loop.gains} names its own rule base: leave out --rules")
        gains = load_gains(loop.gains)
        controller = loop.controller or gains.controller
        if not gains.serve(controller):
            raise CallerError(f"gains file {loop.gains} is for {gains.controller}: leave out --controller")
        return controller, gains.settings
    if loop.controller is not None:
        CONTROLLERS.find(loop.controller)
    if loop.rules is None:
        return loop.controller, None
    if loop.controller not in (None, FUZZY_PID):
        raise CallerError(NO_RULES.format(loop.controller))
    return FUZZY_PID, FuzzyPidSettings(rule_base=loop.rules)


def known_spring(loaded: SensingModel, path: Path, quantity: str, stiffness: float | None) -> KnownSpring | None:
    """Return the load of known stiffness, None without. Raises CallerError if the model does not sense the quantity."""
    from musclewire.sensing import KnownSpring
    from musclewire.signals import QUANTITIES

    if quantity not in QUANTITIES:
        raise CallerError(f"there is no quantity '{quantity}'{nearest_hint(quantity, QUANTITIES)}")
    if stiffness is None:
        if loaded.quantity == quantity:
            return None
        way = " or, for a known load, give --known-stiffness" if quantity == "force" else ""
        raise CallerError(
            f"model {path} senses {loaded.quantity}, not {quantity}: fit one with --quantity {quantity}{way}"
        )
    if quantity != "force":
        raise CallerError(
            f"--known-stiffness turns strain into force, but --quantity is {quantity}: give --quantity force"
        )
    friction = loaded.wire.get("guide_friction_n")
    return KnownSpring(stiffness, float(friction) if isinstance(friction, (int, float)) else 0.0)


def staircase_for(loaded: SensingModel, load: KnownSpring | None, leg_length_m: float) -> Reference:
    """Return the built-in staircase for a model, in force if a load's stiffness is known."""
    from musclewire.experiment import staircase_within
    from musclewire.sensing import force_model

    return staircase_within(loaded if load is None else force_model(loaded, load.stiffness_n_per_m, leg_length_m))


def read_reference(reference: str, quantity: str, loaded: SensingModel) -> Reference | None:
    """Return the steps that the text describes, or the targets in a recording file; None for the built-in staircase."""
    from musclewire.controllers import sampled_reference, staircase
    from musclewire.experiment import check_targets
    from musclewire.files import read_recording
    from musclewire.sensing import SHOWN_AS
    from musclewire.signals import COLUMN_SUFFIX, parse_quantity

    if reference == "staircase":
        return None
    if steps := STEPS.fullmatch(reference.strip()):
        unit = UNITS[quantity]
        start, stop, by = (parse_quantity(text, unit) for text in steps.groups()[:3])
        hold_s = staircase().hold_s if steps[4] is None else parse_quantity(steps[4], "s")
        # Whether the top is within the model's range matters more than whether the increments meet it.
        if quantity == loaded.quantity and stop > start:
            whole = staircase(start, stop, stop - start, hold_s)
            check_targets(loaded, whole, whole.hold_s)
        return staircase(start, stop, by, hold_s, shown_as=SHOWN_AS[quantity])
    if not Path(reference).exists():
        raise CallerError(
            f"there is no reference '{reference}'{nearest_hint(reference, ['staircase'])}, or give a file"
        )
    table = read_recording(reference)
    return sampled_reference(table["time_s"] - table["time_s"][0], table[f"target_{COLUMN_SUFFIX[quantity]}"])


@dataclass(frozen=True)
class ManyLoopsChoice:
    """How many loops run at once, and how."""

    runs: Annotated[int | None, RUNS] = None
    in_python: Annotated[bool, IN_PYTHON] = False
    threads: Annotated[int | None, THREADS] = None


def refuse_single_run_options(many: ManyLoopsChoice, single: dict[str, bool]) -> None:
    """Raise CallerError for options of one run together with --runs, and for those of many runs without it.

    ``single`` holds which options of one run were given, by name.
    """
    if many.runs is None:
        given = [name for name, on in (("--in-python", many.in_python), ("--threads", many.threads)) if on]
        if given:
            raise CallerError(f"{given[0]} belongs to --runs: give the number of loops, or leave it out")
    elif any(single.values()):
        name = next(name for name, on in single.items() if on)
        raise CallerError(f"{name} belongs to a single run: leave it out, or --runs")


def run_many_loops(
    rig: str,
    seed: int | None,
    many: ManyLoopsChoice,
    model: SensingModel,
    choice: LoopChoice,
    target: Reference,
    duration_s: float,
) -> Result:
    """Run the loops, of so many seconds each, and return their errors, which hold if every single loop's do."""
    from musclewire.app._answers import LoopRunAnswer, ManyLoopsAnswer
    from musclewire.experiment import control_many

    assert many.runs is not None
    first, done = 1 if seed is None else seed, 0
    with progress_bar("Closed loops", many.runs * duration_s) as advance:

        def on_outcome(_: LoopOutcome) -> None:
            nonlocal done
            done += 1
            advance({"time_s": done * duration_s})

        found = control_many(
            rig,
            model,
            target,
            seeds=range(first, first + many.runs),
            estimator=choice.estimator,
            controller=choice.controller,
            settings=choice.settings,
            load=choice.load,
            approach_s=choice.approach_s,
            zero_from=choice.zero_from,
            known_strain=choice.known_strain,
            threads=many.threads,
            in_python=many.in_python,
            on_outcome=on_outcome,
        )
    warn(found.warnings)
    ended = next(iter(found.metrics), None)
    answer = ManyLoopsAnswer.read_from(
        approach_s=None if ended is None else ended.approach_s,
        approach=None if ended is None else ended.approach,
        steps=found.steps,
        runs=[LoopRunAnswer.read_from(one, one.metrics, **step_errors(one.metrics)) for one in found.outcomes],
    )
    return Result(answer, str(found), holds=not (found.failed or found.doubtful))


def step_errors(metrics: ControlMetrics | None) -> dict[str, list[float | None]]:
    """Return the errors of each step of a loop in both readings; nothing without metrics."""
    names = () if metrics is None else ("mae_pct", "mae_approached_pct")
    return {name: [getattr(step, name) for step in metrics.steps] for name in names if metrics is not None}
