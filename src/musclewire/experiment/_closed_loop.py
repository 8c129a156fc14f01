"""The closed loop: the wire positioned by its own resistance.

One sample's journey: the guarded rig judges it (``rigs._guarded``); the run notes its times (``_run``); the estimator
makes of its two voltages the resistance (Eq. 1) and, by the wire's heat balance, the quantity (``sensing``, or Eqs. 3
to 5 without a wire model); today's zero is taken off what is shown (``judge.RunCorrection``); the controller asks for
the next drive (``controllers``: the inverse of the wire's model, or the paper's fuzzy-tuned PID, Eq. 6, for a model
without gains); and the rig lets it through as far as the wire stays within its limits. This file only joins them. The
reference instruments of the rig are recorded as well and compared afterwards; nothing here reads them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, NamedTuple, Unpack

from musclewire.controllers import (
    CONTROLLERS,
    Controller,
    ControllerFactory,
    ControllerSetup,
    DriveLimits,
    Reference,
    controller_of,
)
from musclewire.errors import CallerError, RigError, nearest_hint
from musclewire.experiment._calm_air import heed_air
from musclewire.experiment._cooling import cooling_after, cooling_time_s
from musclewire.experiment._metrics import ControlRun, with_metrics
from musclewire.experiment._run import Decision, RunOptions, run_on_rig, what_protects
from musclewire.experiment._speed_limits import check_targets, checked_reference, fastest_way, speed_metadata
from musclewire.identify import (
    FastestWay,
    check_made_for,
    check_wire_file,
    error_unit_for,
    gains_of,
    load_facts,
    users_wire,
)
from musclewire.judge import KEPT, TODAY, ZEROS, KnownB, RunCorrection, known_strain_in
from musclewire.rigs import Rig, refuse_no_rig
from musclewire.sensing import (
    ESTIMATORS,
    UNCORRECTED,
    Correction,
    Estimator,
    EstimatorFactory,
    EstimatorSetup,
    KnownSpring,
    SensingModel,
    default_estimator,
    force_model,
    state_going_on,
)
from musclewire.signals import (
    COLUMN_SUFFIX,
    Command,
    Drive,
    MetadataValue,
    RawSample,
    wire_sample,
)

# A wire at rest is cold, where resistance does not determine strain. A controller that does not say how long it needs
# gets this long to come to the first target before the first step begins. Eq. 7 is given from the first target on, and
# after this approach.
APPROACH_S = 12.0
# What drives a wire whose model has no gains.
PAPER_CONTROLLER = "fuzzy-pid"
# The column of what the resistance was scaled by.
FACTOR = "resistance_factor"


def approach_of(controller: str | ControllerFactory, given_s: float | None = None) -> float:
    """Return the time [s] a controller has to come to the first target: as given, its own, or that of any."""
    if given_s is not None:
        return given_s
    factory = CONTROLLERS.find(controller) if isinstance(controller, str) else controller
    return float(getattr(factory, "approach_s", APPROACH_S))


class SelfSensingPolicy:
    """Estimates from two voltages, compares with the target, and lets the controller choose the command.

    The approach is the time that the wire gets to reach the first target, before the reference's time zero.
    """

    def __init__(self, rig: Rig, loop: PreparedLoop) -> None:
        """Start estimator and controller from the present drive voltage."""
        self._loop, self._estimator, self._correction = loop, loop.estimator, loop.correction_of()
        self._sample_period_s = rig.sample_period_s
        self._first = Drive(loop.controller.limits.clamp(rig.drive_voltage_v))
        self._estimator_state = loop.estimator.start()
        self._controller_state = loop.controller.start(self._first.voltage_v)
        suffix = COLUMN_SUFFIX[loop.estimator.quantity]
        self._columns = (
            *loop.estimator.columns,
            f"target_{suffix}",
            f"estimated_{suffix}",
            "estimate_std",
            "valid",
            *loop.controller.columns,
            *((FACTOR,) if loop.corrects else ()),
            *(() if loop.fastest is None else ("announced_miss",)),
        )

    @property
    def columns(self) -> Sequence[str]:
        """Names of the columns this policy adds: the estimator's, those of every loop, the controller's."""
        return self._columns

    def first_command(self) -> Command:
        """Return the drive the loop takes over from."""
        return self._first

    def after(self, sample: RawSample, elapsed_s: float) -> Decision:
        """Return the controller's answer to one sample. Raises RigError if the estimator cannot continue."""
        # The sample that has just ended is judged by the target that held while it was taken.
        taken_s = elapsed_s - self._sample_period_s
        # Its time is that of the recording: whoever estimates that, or replays it, finds the same to the bit.
        read = wire_sample(sample)._replace(time_s=elapsed_s)
        own, self._estimator_state, sensed = self._estimator.step(self._estimator_state, read)
        if own.failure:
            raise RigError(own.failure)
        now, estimate = self._correction.correction, self._correction.shown(own)
        reference, approach_s, fastest = self._loop.reference, self._loop.approach_s, self._loop.fastest
        followed = reference.target_at(max(taken_s - approach_s, 0.0))
        target = reference.target_at(max(elapsed_s - approach_s, 0.0))
        # In the model's own zero, which the controller's tables have, and with the estimator's own deviation: what
        # widens the interval is one error for the whole run, and no reason to follow slowly.
        heeded = own._replace(valid=estimate.valid, reason=estimate.reason)
        command, self._controller_state, controlled = self._loop.controller.step(
            self._controller_state, target + now.zero, heeded, self._sample_period_s
        )
        if self._correction.watch(read, own, taken_s):
            self._estimator = self._loop.estimator_of(self._correction.correction)
            self._estimator_state = state_going_on(self._estimator, self._estimator_state)
        factor = (now.scale,) if self._loop.corrects else ()
        announced = () if fastest is None else (fastest.miss(followed),)
        seen = (followed, estimate.value, estimate.std, float(estimate.valid))
        return Decision(command, (*sensed, *seen, *controlled, *factor, *announced))


def control(
    rig: Rig,
    model: SensingModel,
    reference: Reference | None = None,
    *,
    estimator: str | EstimatorFactory | None = None,
    controller: str | ControllerFactory | None = None,
    settings: Any = None,
    load: KnownSpring | None = None,
    approach_s: float | None = None,
    wire_file: str | Path | None = None,
    zero_from: str = KEPT,
    known_strain: float | tuple[float, float] | None = None,
    **run: Unpack[RunOptions],
) -> ControlRun:
    """Move the wire along a target in a closed loop that senses by the wire's resistance alone.

    Displacement sensor and load cell, if the rig has them, are recorded and used to judge the run, never to control it.

    Parameters
    ----------
    rig
        The rig, open; it is driven.
    model
        The model of its wire, as ``fit`` returns it.
    reference
        The target over time, in the model's quantity: ``staircase`` and ``sampled_reference`` make one, and a
        :class:`~musclewire.controllers.SteeredReference` is moved while the loop runs. The paper's staircase if None.
    estimator
        Name of an estimator (``musclewire.sensing.ESTIMATORS``), or a factory of one. None for the default, "filter";
        for a model that shows no slow loop, on which it is, "polynomial", the paper's.
    controller
        Name of a controller (``musclewire.controllers.CONTROLLERS``), or a factory of one. None for that of the
        settings, or of the model's gains, which ``fit`` finds; "fuzzy-pid", the paper's, for a model without gains, and
        for force.
    settings
        The controller's settings, such as ``FuzzyPidSettings`` for "fuzzy-pid". None for those in the model's gains, or
        for the controller's defaults.
    load
        A known spring: then force is controlled, and a model of strain, or of the connector's displacement, yields it
        through the spring's stiffness.
    approach_s
        Time [s] for which the reference's start is held before the reference begins. By default 0 for a controller that
        brings a cold wire to its target by itself ("inverse-model"), and 12 s for others, enough for a wire to warm up.
        The metrics give Eq. 7 from the first target on, which counts the first step without it, and after it; with 0
        both are the same.
    wire_file
        The wire's own file, as ``calibrate`` writes it, for the estimator "particle-filter", or another on physics.
    zero_from
        Where strain counts from: "kept", the cold wire of the characterization, or "today", this run's. From today's, a
        first heating that turns at another resistance than the model's slow loop scales the resistance for the rest of
        the run and widens the interval; where it differs too much, no estimate is valid from there on. And in another
        room, by the air that the rig's file states and stated then (22 C unless it does), estimates count from where
        the wire is cold there.
    known_strain
        A strain (of another model displacement [m] or force [N]) that is known at one moment, as at an end stop: alone
        at the end of the first hold, or with the time [s] of the run. Where the estimate, over the last second that the
        wire has been still, misses it by more than its interval, the model is corrected for the rest of the run, the
        interval is widened, and it is a finding.
    **run
        ``path`` of the recording, ``overwrite`` one that exists, ``on_sample`` called with every recorded row; it
        may raise to stop the run, ``until`` asked after each whether the run is to end now.

    Returns
    -------
    The recording with its metrics (Eq. 7 for each step in both readings, if the rig has a reference instrument).

    Raises
    ------
    CallerError
        If a target is outside the model's range, a name is unknown, the model is of another wire, or the estimator
        reads no wire file.
    RigError
        If the wire carries no current, or has a resistance that the model's wire never has.

    References
    ----------
    Lan and Fan 2010, section III and Fig. 10.

    Examples
    --------
    >>> import musclewire as mw
    >>> with mw.open_rig("simulated") as rig:
    ...     model = mw.fit(mw.characterize(rig))
    ...     run = mw.control(rig, model, mw.staircase(stop=0.018))
    >>> [step.target for step in run.metrics.steps]
    [0.015, 0.018, 0.015]
    """
    choice = LoopChoice(estimator, controller, settings, load, approach_s, wire_file, zero_from, known_strain)
    loop = prepared_loop(rig, model, reference, choice)
    from_cold = loop.approach_s == 0.0
    beforehand = speed_metadata(rig, loop.model, loop.reference, loop.settings, from_cold=from_cold)
    metadata = loop.metadata | beforehand
    policy = SelfSensingPolicy(rig, loop)
    following = cooling_after(rig, policy.columns, loop.cooling_s)
    with rig.holding_back():
        recording = run_on_rig(rig, policy, loop.duration_s, metadata=metadata, following=following, **run)
    return with_metrics(recording, loop.model.quantity, loop.reference)


@dataclass(frozen=True)
class LoopChoice:
    """Estimator and controller of a loop; None is what the caller leaves open, which ``settled`` fills in."""

    estimator: str | EstimatorFactory | None = None
    controller: str | ControllerFactory | None = None
    settings: Any = None
    load: KnownSpring | None = None
    approach_s: float | None = None
    wire_file: str | Path | None = None
    zero_from: str = KEPT  # where strain counts from
    known_strain: float | tuple[float, float] | None = None

    def settled(self, model: SensingModel, sample_period_s: float) -> SettledChoice:
        """Return the choice with what it leaves open: from the model's gains, else as in the paper.

        Force keeps the fuzzy PID: it jumps by twice the guide's friction where the motion turns, which the inverse of
        the model does not count. Raises CallerError for settings that do not say whose they are, for gains that a
        model's file has wrong, and for a wire file that the estimator does not read.
        """
        gains = None if self.load is not None else gains_of(model, sample_period_s)
        of_force = self.load is not None or model.quantity == "force"
        controller, settings = self.controller, self.settings
        if controller is None and settings is not None:
            controller = controller_of(settings)
        open_to_gains = controller is None
        if controller is None:
            controller = PAPER_CONTROLLER if gains is None or of_force else gains.controller
        if settings is None and gains is not None and gains.serve(controller):
            settings = gains.settings
        estimator, without_filter = (self.estimator, "") if self.estimator else default_estimator(model)
        check_wire_file(self.wire_file, estimator)
        return SettledChoice(
            estimator,
            controller,
            settings,
            approach_of(controller, self.approach_s),
            without_gains(model) if open_to_gains and gains is None and not of_force else "",
            without_filter,
        )

    @property
    def options(self) -> dict[str, Any]:
        """The keywords of ``control``."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    def metadata(self, settled: SettledChoice) -> dict[str, MetadataValue]:
        """Return what a recording says of it."""
        known: dict[str, MetadataValue] = {
            "approach_s": settled.approach_s,
            "estimator": name_of(settled.estimator),
            "controller": name_of(settled.controller),
            "zero_from": self.zero_from,
        }
        without = {"without_gains": settled.without_gains, "without_filter": settled.without_filter}
        known |= {name: why for name, why in without.items() if why}
        if self.wire_file is not None:
            known["wire_file"] = Path(self.wire_file).name
        if self.load is not None:
            known |= {"known_stiffness_n_per_m": self.load.stiffness_n_per_m, "known_friction_n": self.load.friction_n}
        return known


class SettledChoice(NamedTuple):
    """Estimator and controller of a loop, its settings, the approach [s], and why by default not those on the model."""

    estimator: str | EstimatorFactory
    controller: str | ControllerFactory
    settings: Any
    approach_s: float
    without_gains: str
    without_filter: str


def without_gains(model: SensingModel) -> str:
    """Return what to say of a loop with a model that has no gains: why it has none, and how to get the better loop."""
    why = f" ({model.no_gains})" if model.no_gains else ""
    return (
        f"this model has no gains{why}: the paper's fuzzy PID drives the wire, which needs {APPROACH_S:g} s to come to "
        "the first target; 'musclewire tune MODEL LOOP -o MODEL' finds them in the wire's slow loop, for a loop that "
        "is quick from cold"
    )


class PreparedLoop(NamedTuple):
    """A closed loop before it begins: all that follows from rig, model, reference and choice."""

    model: SensingModel
    reference: Reference
    estimator: Estimator
    controller: Controller
    settings: Any
    approach_s: float
    duration_s: float
    cooling_s: float
    metadata: dict[str, MetadataValue]
    corrects: bool
    correction_of: Callable[[], RunCorrection]
    estimator_of: Callable[[Correction], Estimator]
    fastest: FastestWay | None


def prepared_loop(rig: Rig, model: SensingModel, reference: Reference | None, choice: LoopChoice) -> PreparedLoop:
    """Return the loop on a rig, checked. Raises CallerError for what does not fit together, as ``control`` does."""
    refuse_no_rig(rig)
    if choice.zero_from not in ZEROS:
        raise CallerError(f"there is no zero '{choice.zero_from}'{nearest_hint(choice.zero_from, ZEROS)}")
    load, settled = choice.load, choice.settled(model, rig.sample_period_s)
    if load is not None:
        model = force_model(model, load.stiffness_n_per_m, rig.leg_length_m)
    chosen = checked_reference(model, reference)
    # Resistance is proportional to length: a model of another length would read a cold wire as a contracted one. And
    # the displacement of a finger's endpoint belongs to that finger.
    facts = rig.metadata()
    check_made_for(model, facts)
    heed_air(rig, model)
    wire = None if choice.wire_file is None else users_wire(choice.wire_file, facts)
    limits = DriveLimits(rig.sense_voltage_v, rig.maximum_voltage_v)
    metadata = {
        "experiment": "closed loop",
        "quantity": model.quantity,
        **choice.metadata(settled),
        **load_facts(model, facts),
    }
    known = known_strain_in(choice.known_strain, chosen, settled.approach_s, rig.sample_period_s)
    if known is not None:
        metadata |= known.metadata()
    from_today = choice.zero_from == TODAY
    room = None
    if from_today:
        # Only now: another room's heat balance is that of the home move, which no loop from the kept zero needs.
        from musclewire.identify import zero_of_room

        room = zero_of_room(model, what_protects(rig))
    check_targets(model, chosen, rig.sample_period_s, 0.0 if room is None else room.correction.zero)
    if room is not None:
        metadata |= {"zero_of_room": room.said}

    def estimator_of(correction: Correction) -> Estimator:
        today = correction.applied_to(model)
        setup = EstimatorSetup(today, rig.shunt_resistance_ohm, rig.sample_period_s, load, wire, correction)
        made: Estimator = ESTIMATORS.make(settled.estimator, setup)
        return made

    def correction_of() -> RunCorrection:
        b = KnownB.of_model(model, rig.sense_voltage_v) if from_today else None
        return RunCorrection(model, rig.shunt_resistance_ohm, b, known, None if room is None else room.correction)

    duration_s = settled.approach_s + chosen.duration_s
    correction_of()  # a known strain that the model does not reach is refused before anything is heated
    return PreparedLoop(
        model,
        chosen,
        estimator_of(UNCORRECTED),
        CONTROLLERS.make(settled.controller, ControllerSetup(limits, error_unit_for(model, load), settled.settings)),
        settled.settings,
        settled.approach_s,
        duration_s,
        cooling_time_s(rig, model, duration_s),
        metadata,
        from_today or known is not None,
        correction_of,
        estimator_of,
        fastest_way(rig, model, settled.settings, from_cold=settled.approach_s == 0.0),
    )


def name_of(kind: str | EstimatorFactory | ControllerFactory) -> str:
    """Return the name of an estimator or a controller in a recording: as registered, or its factory's."""
    return kind if isinstance(kind, str) else str(getattr(kind, "__name__", type(kind).__name__))
