"""The closed loop: the wire positioned by its own resistance.

One sample's journey: voltages -> resistance (Eq. 1) -> normalised resistance (Eq. 3) -> strain (Eqs. 4, 5) ->
error -> fuzzy-tuned PID (Eq. 6) -> drive voltage. The reference instruments of the rig are recorded beside it
and judged afterwards; nothing here reads them.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from musclewire.controllers import DriveLimits, FuzzyPid, FuzzyPidSettings
from musclewire.controllers.fuzzy_pid import ControllerState
from musclewire.controllers.references import Reference
from musclewire.errors import CallerError, RigError
from musclewire.experiment.metrics import ControlRun, control_metrics
from musclewire.experiment.run import Decision, OnSample, run_on_rig
from musclewire.experiment.staircases import staircase_within
from musclewire.identify.recordings import COLUMN_SUFFIX
from musclewire.rigs.protocol import Metadata, Rig
from musclewire.sensing.curve import SHOWN_AS
from musclewire.sensing.known_load import KnownSpring, force_model
from musclewire.sensing.model import SensingModel
from musclewire.sensing.resistance import wire_resistance
from musclewire.sensing.tracking import SegmentState, SegmentTracker
from musclewire.signals.commands import Command, Drive
from musclewire.signals.recording import MetadataValue
from musclewire.signals.samples import RawSample

__all__ = ["SelfSensingPolicy", "check_made_for", "control", "controller_for", "settings_for"]

# In the first step the wire starts cold, where resistance does not tell strain; it gets this long to arrive.
APPROACH_S = 12.0
# A sample without current is bridged by holding the drive; this many in a row are a broken wire or circuit.
LONGEST_BLIND_SAMPLES = 10
# So far outside R_min..R_max, as a share of their span, no sample of this wire can be: another wire, or a fault.
FOREIGN_SHARE = 0.15
# Lengths that differ by less are one length, measured twice.
SAME_LENGTH_SHARE = 0.005
# What the whole range of a quantity other than strain counts as, in the controller's unit of percent strain.
RANGE_AS_PERCENT_STRAIN = 3.0
# Where friction turns round, force moves steeply with strain: so many times the friction count as range, or the loop
# chatters.
FRICTION_AS_RANGE = 8.0


def controller_for(
    rig: Rig, model: SensingModel, settings: FuzzyPidSettings | None = None, load: KnownSpring | None = None
) -> FuzzyPid:
    """Return the fuzzy-tuned PID within a rig's limits, its error unit fitted to the model's quantity."""
    return FuzzyPid(settings_for(model, settings, load), DriveLimits(rig.sense_voltage_v, rig.maximum_voltage_v))


def settings_for(
    model: SensingModel, settings: FuzzyPidSettings | None = None, load: KnownSpring | None = None
) -> FuzzyPidSettings:
    """Return the controller's settings with the error unit fitted to the model's quantity, unless they name one."""
    chosen = settings or FuzzyPidSettings()
    if model.quantity != "strain" and "error_unit" not in chosen.model_fields_set:
        steep = 0.0 if load is None else FRICTION_AS_RANGE * load.friction_n
        unit = (model.quantity_max - model.quantity_min + steep) / RANGE_AS_PERCENT_STRAIN
        chosen = chosen.model_copy(update={"error_unit": unit})
    return chosen


class SelfSensingPolicy:
    """Estimates from two voltages, compares with the target, and lets the controller choose the drive."""

    def __init__(
        self,
        model: SensingModel,
        controller: FuzzyPid,
        reference: Reference,
        *,
        shunt_resistance_ohm: float,
        sample_period_s: float,
        approach_s: float,
        first_drive_voltage_v: float,
        load: KnownSpring | None = None,
    ) -> None:
        """Start from a drive that is out already; the reference's time zero comes after the approach.

        With a ``load`` the model is one of the force on its spring, and its friction is added here.
        """
        self._model = model
        self._load = load
        # A wire that was warmed up has been contracting: it pulls against the friction.
        self._friction_n = 0.0 if load is None else load.friction_n
        self._spring_force_n: float | None = None
        self._controller = controller
        self._reference = reference
        self._shunt_resistance_ohm = shunt_resistance_ohm
        self._sample_period_s = sample_period_s
        self._approach_s = approach_s
        self._first_drive_voltage_v = controller.limits.clamp(first_drive_voltage_v)
        self._state: ControllerState | None = None
        self._estimate = model.quantity_min
        self._std = 0.0
        self._blind_samples = 0
        self._foreign_samples = 0
        self._tracker = SegmentTracker(model.resistance_min_ohm, model.resistance_max_ohm)
        self._segment: SegmentState | None = None
        suffix = COLUMN_SUFFIX[model.quantity]
        self._target_name, self._estimated_name = f"target_{suffix}", f"estimated_{suffix}"

    @property
    def columns(self) -> Sequence[str]:
        """Names of the columns this policy adds."""
        return (
            "wire_resistance_ohm",
            self._target_name,
            self._estimated_name,
            "valid",
            "proportional_gain",
            "integral_gain",
            "derivative_gain",
        )

    def first_command(self) -> Command:
        """Return the drive the loop takes over from."""
        return Drive(self._first_drive_voltage_v)

    def after(self, sample: RawSample, elapsed_s: float) -> Decision:
        """Return the controller's answer to one sample."""
        reading = wire_resistance(sample.wire_voltage_v, sample.shunt_voltage_v, self._shunt_resistance_ohm)
        # The sample that has just ended is judged by the target that held while it was taken.
        judged = self._reference.target_at(max(elapsed_s - self._sample_period_s - self._approach_s, 0.0))
        target = self._reference.target_at(max(elapsed_s - self._approach_s, 0.0))
        valid = False
        gains = (0.0, 0.0, 0.0)
        drive = sample.drive_voltage_v if self._state is None else self._state.drive_voltage_v
        if reading.valid:
            self._blind_samples = 0
            self._check_belongs(reading.resistance_ohm, sample)
            estimate = self._model.estimate(reading.resistance_ohm)
            self._estimate = estimate.value + self._friction_at(estimate.value)
            valid = estimate.valid and self._in_sensing_segment(reading.resistance_ohm, sample.wire_voltage_v)
            if self._state is None:
                self._state = self._controller.start(self._first_drive_voltage_v, self._estimate, target)
            result = self._controller.step(self._state, target, self._estimate, self._sample_period_s)
            self._state, drive = result.state, result.drive_voltage_v
            gains = (result.kp, result.ki, result.kd)
        else:
            self._lose_sight(sample)
        return Decision(
            Drive(drive),
            {
                "wire_resistance_ohm": reading.resistance_ohm,
                self._target_name: judged,
                self._estimated_name: self._estimate,
                "valid": float(valid),
                "proportional_gain": gains[0],
                "integral_gain": gains[1],
                "derivative_gain": gains[2],
            },
        )

    def _friction_at(self, spring_force_n: float) -> float:
        """Return the friction that the wire pulls beside a known spring, by which way it has been moving [N]."""
        if self._load is None:
            return 0.0
        if self._spring_force_n is not None:
            change_n = spring_force_n - self._spring_force_n
            self._friction_n = self._load.friction_after(self._friction_n, change_n)
        self._spring_force_n = spring_force_n
        return self._friction_n

    def _in_sensing_segment(self, resistance_ohm: float, wire_voltage_v: float) -> bool:
        """Tell whether the wire has come from its cold start to between B and C. The loop goes on either way.

        Once there it stays there: a reference keeps within the model's range, so the wire is not let go cold.
        """
        power_w = wire_voltage_v * wire_voltage_v / resistance_ohm
        if self._segment is None:
            self._segment = self._tracker.start(resistance_ohm, power_w)
        elif not self._segment.sensing:
            self._segment = self._tracker.step(self._segment, resistance_ohm, power_w)
        return self._segment.sensing

    def _check_belongs(self, resistance_ohm: float, sample: RawSample) -> None:
        """Stop when the resistance stays where the model's wire never is: it would read as cold and be overheated."""
        low, high = self._model.resistance_min_ohm, self._model.resistance_max_ohm
        margin = FOREIGN_SHARE * (high - low)
        inside = low - margin <= resistance_ohm <= high + margin
        self._foreign_samples = 0 if inside else self._foreign_samples + 1
        if self._foreign_samples >= LONGEST_BLIND_SAMPLES:
            raise RigError(
                f"resistance {resistance_ohm:.3f} ohm at {sample.time_s:.2f} s is not this model's wire ({low:.3f} to "
                f"{high:.3f} ohm): check wire and wiring, or recalibrate; the rig is at its sense voltage"
            )

    def _lose_sight(self, sample: RawSample) -> None:
        """Hold the drive over a sample without current; give up when sight does not come back."""
        self._blind_samples += 1
        if self._state is not None:
            self._state = self._controller.hold(self._state)
        if self._blind_samples >= LONGEST_BLIND_SAMPLES:
            raise RigError(
                f"no current through the wire for {self._blind_samples} samples up to {sample.time_s:.2f} s at "
                f"{sample.drive_voltage_v:.2f} V: check wire, clamps and shunt; the rig is at its sense voltage"
            )


def control(
    rig: Rig,
    model: SensingModel,
    reference: Reference | None = None,
    *,
    settings: FuzzyPidSettings | None = None,
    load: KnownSpring | None = None,
    approach_s: float = APPROACH_S,
    path: str | Path | None = None,
    overwrite: bool = False,
    on_sample: OnSample | None = None,
) -> ControlRun:
    """Move the wire along a reference with no sensor but its resistance; the paper's staircase by default.

    With a ``load`` force is controlled: a model of strain, or of the connector's displacement, gives it by the load's
    stiffness. The wire first gets ``approach_s`` to reach the reference's start. Returns the recording with its metrics
    (Eq. 7 for each step, where the rig has a reference instrument). Raises CallerError for a target outside
    the model's range, RigError when the wire carries no current.
    """
    if load is not None:
        model = force_model(model, load.stiffness_n_per_m, rig.leg_length_m)
    chosen = staircase_within(model) if reference is None else reference
    check_targets(model, chosen, rig.sample_period_s)
    check_same_wire(model, rig)
    policy = SelfSensingPolicy(
        model,
        controller_for(rig, model, settings, load),
        chosen,
        shunt_resistance_ohm=rig.shunt_resistance_ohm,
        sample_period_s=rig.sample_period_s,
        approach_s=approach_s,
        first_drive_voltage_v=rig.drive_voltage_v,
        load=load,
    )
    metadata: dict[str, MetadataValue] = {
        "experiment": "closed loop",
        "quantity": model.quantity,
        "approach_s": approach_s,
    }
    if load is not None:
        metadata |= {"known_stiffness_n_per_m": load.stiffness_n_per_m, "known_friction_n": load.friction_n}
    recording = run_on_rig(
        rig,
        policy,
        approach_s + chosen.duration_s,
        metadata=metadata,
        path=path,
        overwrite=overwrite,
        on_sample=on_sample,
    )
    return ControlRun(recording.columns, recording.metadata, control_metrics(recording, model.quantity, chosen))


def check_same_wire(model: SensingModel, rig: Rig) -> None:
    """Raise CallerError when model and rig both say what their wire is, how long, or what it moves, and differ.

    Resistance goes with length, so a model of another length would read a cold wire as a contracted one; the
    displacement of a finger's endpoint belongs to that finger.
    """
    check_made_for(model, rig.metadata())


def check_made_for(model: SensingModel, known: Metadata) -> None:
    """Raise CallerError as ``check_same_wire`` does, for what is known of a rig that need not be open."""
    fitted, mounted = model.wire.get("wire"), known.get("wire")
    if fitted and mounted and fitted != mounted:
        raise CallerError(f"this model was fitted to wire {fitted}, the rig has {mounted}: fit one for this wire")
    lengths = model.wire.get("wire_length_m"), known.get("wire_length_m")
    if all(isinstance(length, (int, float)) for length in lengths):
        was, now = (float(length or 0.0) for length in lengths)
        if abs(was - now) > SAME_LENGTH_SHARE * now:
            raise CallerError(
                f"this model was fitted to a wire of {1e3 * was:g} mm, the rig has one of {1e3 * now:g} mm: fit one "
                "for this length"
            )
    moved, moves = model.wire.get("finger"), known.get("finger")
    if model.quantity == "displacement" and moved and moves and moved != moves:
        raise CallerError(f"this model was fitted to finger {moved}, the rig has {moves}: fit one for this finger")


def check_targets(model: SensingModel, reference: Reference, sample_period_s: float) -> None:
    """Raise CallerError when a reference leaves the range in which the model can sense."""
    if reference.duration_s < sample_period_s:
        raise CallerError(
            f"the reference lasts {reference.duration_s:g} s, less than one sample of {sample_period_s:g} s: "
            "its last row says when it ends"
        )
    times = [index * sample_period_s for index in range(round(reference.duration_s / sample_period_s) + 1)]
    targets = reference.targets_at(times)
    low, high = float(targets.min()), float(targets.max())
    margin = 1e-3 * (model.quantity_max - model.quantity_min)
    if low < model.quantity_min - margin or high > model.quantity_max + margin:
        factor, unit = SHOWN_AS[model.quantity]
        raise CallerError(
            f"the reference goes from {factor * low:.4g} to {factor * high:.4g} {unit}, but this model senses "
            f"{model.quantity} only from {factor * model.quantity_min:.4g} to {factor * model.quantity_max:.4g} "
            f"{unit}: choose targets inside"
        )
