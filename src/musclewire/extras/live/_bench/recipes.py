"""What a bench can be asked to do: each command of ``live.messages`` with the experiment that carries it out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from musclewire.controllers import FuzzyPidSettings, Reference, SteeredReference, sampled_reference, staircase
from musclewire.errors import CallerError
from musclewire.experiment import (
    MINOR_LOOP_CYCLES,
    HeldVoltage,
    LoopChoice,
    characterize,
    control,
    cooling_time_s,
    examination_s,
    examine,
    home,
    home_duration_s,
    pretension_sweep,
    run_on_rig,
    run_warnings,
    staircase_within,
)
from musclewire.extras.live import _messages as messages
from musclewire.extras.live._bench.descriptions import (
    described_examination,
    described_metrics,
    described_model,
    described_rig,
    described_sweep,
)
from musclewire.extras.live._bench.session import BenchSession
from musclewire.identify import fit
from musclewire.judge import MissWatch
from musclewire.rigs import GuardedRig, HasStage, ability
from musclewire.sensing import SensingModel, load_model
from musclewire.signals import COLUMN_SUFFIX, Recording

# A drawn path may last this long [s].
MAX_DURATION_S = 3600.0


def reference_of(asked: object, model: SensingModel, sample_period_s: float) -> Reference:
    """Return the reference of a command, in the model's quantity. Raises CallerError for an impossible one."""
    if isinstance(asked, messages.Steer):
        low, high = model.quantity_min, model.quantity_max
        return SteeredReference(0.5 * (low + high) if asked.start is None else asked.start, lowest=low, highest=high)
    if isinstance(asked, messages.Steps):
        return staircase_of(asked, model)
    if isinstance(asked, messages.Sine):
        return sine_of(asked, sample_period_s)
    assert isinstance(asked, messages.DrawnPath)
    return path_of(asked, sample_period_s)


def staircase_of(asked: messages.Steps, model: SensingModel) -> Reference:
    """Return a staircase; the paper's if no level is given."""
    levels = (asked.start, asked.stop, asked.step)
    if all(level is None for level in levels):
        return staircase_within(model)
    if any(level is None for level in levels):
        raise CallerError("a staircase needs its start, its stop and its step: give all three, or none for the paper's")
    start, stop, step = (float(level or 0.0) for level in levels)
    return staircase(start, stop, step, asked.hold_s)


def sine_of(asked: messages.Sine, sample_period_s: float) -> Reference:
    """Return a sine, sampled as the rig samples; it begins at its middle and rises."""
    duration_s = asked.cycles * asked.period_s
    require_bounded(duration_s)
    time_s = np.arange(0.0, duration_s + 0.5 * sample_period_s, sample_period_s)
    return sampled_reference(time_s, asked.middle + asked.amplitude * np.sin(2.0 * np.pi * time_s / asked.period_s))


def path_of(asked: messages.DrawnPath, sample_period_s: float) -> Reference:
    """Return a drawn path, straight between its points. Raises CallerError for points that are not in order."""
    points_s, targets = np.asarray(asked.time_s), np.asarray(asked.target)
    if points_s.shape != targets.shape or points_s.size < 2 or (np.diff(points_s) <= 0.0).any():
        raise CallerError("a path needs two points or more, one target for each time, and times that increase")
    require_bounded(float(points_s[-1] - points_s[0]))
    time_s = np.arange(0.0, points_s[-1] - points_s[0] + 0.5 * sample_period_s, sample_period_s)
    return sampled_reference(time_s, np.interp(time_s + points_s[0], points_s, targets))


def require_bounded(duration_s: float) -> None:
    """Raise CallerError for a reference that lasts for more than an hour."""
    if duration_s > MAX_DURATION_S:
        raise CallerError(f"the reference lasts {duration_s:g} s: an hour at most, so that no wire heats forgotten")


# A first pulse at this part of the amplitude that completes the transformation: warm enough to be seen, far from harm.
PULSE_FRACTION = 0.6
PULSE_REST_S = 2.0


class CommandRecipe(NamedTuple):
    """How a command is carried out, its name in words, and whether the wire may be heated, which needs a person."""

    title: str
    run: Callable[[BenchSession, Any], None]
    heats: bool = True
    duration_s: Callable[[BenchSession, Any], float | None] = lambda session, command: None  # noqa: ARG005


def rig_of(session: BenchSession) -> GuardedRig:
    """Return the open rig. Raises CallerError if it is not switched on."""
    if session.rig is None or session.shown.state.phase in ("off", "stopped", "failed"):
        raise CallerError("the rig is not switched on: switch on first")
    return session.rig


def model_of(session: BenchSession) -> SensingModel:
    """Return the session's model. Raises CallerError if there is none."""
    if session.work.model is None:
        raise CallerError("there is no model yet: characterize the wire and fit one, or load one")
    return session.work.model


def new_file(session: BenchSession, what: str, suffix: str = "h5") -> Path:
    """Return a file of the session's folder that does not exist yet."""
    stem = f"{what}-{datetime.now():%Y%m%d-%H%M%S}"
    names = (f"{stem}{'' if number == 1 else f'-{number}'}.{suffix}" for number in range(1, 10_000))
    return next(path for path in (session.folder / name for name in names) if not path.exists())


def take_model(session: BenchSession, model: SensingModel, file: str) -> None:
    """Make a model the session's."""
    session.work.model, session.work.model_file = model, file
    session.shown.done("model", model=described_model(model, file))
    session.shown.say("warning", *model.warnings)


def examine_rig(session: BenchSession, _command: messages.Doctor) -> None:
    """Check the rig at its sense voltage and below."""
    found = examine(rig_of(session), on_sample=session.on_probe)
    session.shown.change(doctor=described_examination(found))
    if found.trouble is not None:
        raise found.trouble
    if found.ok:
        session.shown.done("doctor")
        session.shown.say("info", f"doctor: {found.findings.summary}")
    else:
        session.shown.say("error", f"doctor: {found.findings.summary}")


def pulse(session: BenchSession, command: messages.Pulse) -> None:
    """Warm the wire for a moment and say whether its resistance has moved."""
    rig = rig_of(session)
    voltage_v = command.drive_voltage_v or PULSE_FRACTION * rig.drive_amplitude_v
    if voltage_v > rig.maximum_voltage_v:
        raise CallerError(
            f"a pulse of {voltage_v:g} V is above this rig's maximum of {rig.maximum_voltage_v:g} V: give less"
        )
    policy = HeldVoltage(voltage_v, rig.sense_voltage_v, rig.sample_period_s, command.duration_s)
    recording = run_on_rig(
        rig,
        policy,
        command.duration_s + PULSE_REST_S,
        metadata={"experiment": "pulse", "drive_voltage_v": voltage_v},
        path=new_file(session, "pulse"),
        on_sample=session.on_sample,
    )
    session.shown.done("pulse")
    session.shown.say("info", pulse_in_words(recording, rig.shunt_resistance_ohm, voltage_v))


def pulse_in_words(recording: Recording, shunt_resistance_ohm: float, voltage_v: float) -> str:
    """Return by how much a pulse has changed the resistance."""
    ohm = shunt_resistance_ohm * recording["wire_voltage_v"] / recording["shunt_voltage_v"]  # Eq. 1
    cold, warm = float(ohm[0]), float(ohm[recording["drive_voltage_v"] >= 0.99 * voltage_v][-1])
    return f"pulse of {voltage_v:.2f} V: from {cold:.3f} ohm to {warm:.3f} ohm while warm"


def record_slow_loop(session: BenchSession, command: messages.Characterize) -> None:
    """Heat and cool the wire slowly; the recording is what a model is fitted to."""
    rig, path = rig_of(session), new_file(session, "characterize")
    loop = characterize(
        rig,
        amplitude_v=command.amplitude_v,
        period_s=command.period_s,
        cycles=command.cycles,
        minor_loop=command.minor_loop,
        path=path,
        on_sample=session.on_sample,
    )
    session.work.loop = loop
    session.shown.done("loop", loop={"recording": path.name, "shows_c": loop.facts.stated.get("shows_c")})
    session.shown.say("warning", *run_warnings(loop))


def fit_model(session: BenchSession, command: messages.Fit) -> None:
    """Fit a model to the last slow loop, and keep it as a file."""
    if session.work.loop is None:
        raise CallerError("there is no slow loop in this session yet: characterize the wire first")
    model, path = fit(session.work.loop, quantity=command.quantity), new_file(session, "model", "json")
    model.save(path)
    take_model(session, model, path.name)


def home_move(session: BenchSession, _command: messages.Home) -> None:
    """Bring the model up to the wire of today."""
    rig, model = rig_of(session), model_of(session)
    homing = home(rig, model, path=new_file(session, "home"), on_sample=session.on_sample)
    path = new_file(session, "model", "json")
    homing.model.save(path)
    take_model(session, homing.model, path.name)
    session.shown.say("info", "home move: the model is that of today's wire", *homing.notes)


def sweep_pretension(session: BenchSession, command: messages.SweepPretension) -> None:
    """Characterize the wire at several pretensions and show their gaps."""
    folder = new_file(session, "pretensions", "sweep").with_suffix("")
    sweep = pretension_sweep(rig_of(session), command.pretensions_n, folder=folder, on_sample=session.on_sample)
    session.shown.change(pretensions=described_sweep(sweep))


def choose_pretension(session: BenchSession, command: messages.ChoosePretension) -> None:
    """Move the stage; the model and the loop of another pretension no longer hold."""
    rig = rig_of(session)
    stage = ability(rig, HasStage)
    if stage is None:
        raise CallerError("this rig has no stage that software can move: set the pretension by hand")
    stage.set_pretension(command.pretension_n)
    session.work.loop = session.work.model = None
    described = described_rig(rig, session.name, simulated=session.simulated)
    session.shown.change(model=None, loop=None, rig=described)
    session.shown.say("info", f"pretension {command.pretension_n:g} N: characterize the wire again")


def control_wire(session: BenchSession, command: messages.Control) -> None:
    """Close the loop; a steered target moves until the run is ended."""
    rig, model = rig_of(session), model_of(session)
    reference = reference_of(command.reference, model, rig.sample_period_s)
    steered = session.work.steered = reference if isinstance(reference, SteeredReference) else None
    approach_s = approach_of(command, reference, model, rig.sample_period_s)
    watch = MissWatch(COLUMN_SUFFIX[model.quantity], model.quantity_max - model.quantity_min, approach_s)

    def show(row: Mapping[str, float | None]) -> None:
        session.on_sample(row)
        said = watch.after(row)
        if said != session.shown.state.health:
            session.shown.change(health=said)

    session.shown.change(health="")
    try:
        run = control(
            rig,
            model,
            reference,
            estimator=command.estimator,
            controller=command.controller,
            settings=settings_of(command),
            approach_s=approach_s,
            path=new_file(session, "control"),
            on_sample=show,
            until=session.end_asked,
        )
    finally:
        session.work.steered = None
    # A steered loop begins cold and has no step of its own to judge: an error of the whole run would say nothing.
    metrics = None if steered else described_metrics(run.metrics)
    moved = {"metrics": metrics, "health": str(run.metadata.get("health", ""))}
    session.shown.done("moved", **moved)
    session.shown.say("warning", *run_warnings(run))


def settings_of(command: messages.Control) -> FuzzyPidSettings | None:
    """Return the controller's settings. Raises CallerError for those of a controller that takes none from here."""
    if command.settings is None:
        return None
    if command.controller not in (None, "fuzzy-pid"):
        raise CallerError(f"settings belong to the controller fuzzy-pid, not to {command.controller}: leave them out")
    given: dict[str, Any] = {key: tuple(one) if isinstance(one, list) else one for key, one in command.settings.items()}
    return FuzzyPidSettings(**given)


def load_from_folder(session: BenchSession, command: messages.LoadModel) -> None:
    """Take a model from the session's folder, by its name alone."""
    path = session.folder / command.name
    if (
        Path(command.name).name != command.name
        or not path.is_file()
        or path.resolve().parent != session.folder.resolve()
    ):
        raise CallerError(f"there is no model '{command.name}' in this session's folder: choose one of its files")
    take_model(session, load_model(path), command.name)


def control_s(session: BenchSession, command: messages.Control) -> float | None:
    """Return how long a closed loop will take; None if it is steered."""
    if session.work.model is None or session.rig is None:
        return None
    reference = reference_of(command.reference, session.work.model, session.rig.sample_period_s)
    approach_s = approach_of(command, reference, session.work.model, session.rig.sample_period_s)
    duration_s = approach_s + reference.duration_s
    steered = isinstance(reference, SteeredReference)
    return None if steered else duration_s + cooling_time_s(session.rig, session.work.model, duration_s)


def approach_of(command: messages.Control, reference: Reference, model: SensingModel, sample_period_s: float) -> float:
    """Return for how long [s] a loop holds its first target before the reference begins; a steered one does not."""
    choice = LoopChoice(controller=command.controller, settings=settings_of(command))
    return 0.0 if isinstance(reference, SteeredReference) else choice.settled(model, sample_period_s).approach_s


RECIPES: dict[type, CommandRecipe] = {
    messages.Doctor: CommandRecipe(
        "Doctor", examine_rig, heats=False, duration_s=lambda _session, _command: examination_s()
    ),
    messages.Pulse: CommandRecipe("First pulse", pulse, duration_s=lambda _session, one: one.duration_s + PULSE_REST_S),
    messages.Characterize: CommandRecipe(
        "Characterization",
        record_slow_loop,
        duration_s=lambda _session, one: (one.cycles + one.minor_loop * MINOR_LOOP_CYCLES) * one.period_s,
    ),
    messages.Fit: CommandRecipe("Fit", fit_model, heats=False),
    messages.Home: CommandRecipe(
        "Home move",
        home_move,
        duration_s=lambda session, _command: home_duration_s(rig_of(session), model_of(session)),
    ),
    messages.SweepPretension: CommandRecipe("Pretension sweep", sweep_pretension),
    messages.ChoosePretension: CommandRecipe("Pretension", choose_pretension, heats=False),
    messages.Control: CommandRecipe("Closed loop", control_wire, duration_s=control_s),
    messages.LoadModel: CommandRecipe("Model", load_from_folder, heats=False),
}
