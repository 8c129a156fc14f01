"""Gripping without a sensor: close, detect contact, hold a force; all from two voltages.

The rig's instruments are recorded as well and compared afterwards; no decision reads them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Unpack

import numpy as np

from musclewire.controllers import DriveLimits
from musclewire.errors import CallerError, RigError
from musclewire.experiment import Decision, RunOptions, run_on_rig
from musclewire.extras.grip._contact_detection import AirDisturbance, ContactDetector
from musclewire.extras.grip._grip_force import fall_by_cooling
from musclewire.extras.grip._gripper_training import CLOSING_S, REST_S, GripperKnowledge, closing_waveform, gripper_of
from musclewire.physics import wire_resistance
from musclewire.rigs import Rig
from musclewire.sensing import dropout_failure, evaluate
from musclewire.signals import Command, Drive, MetadataValue, RawSample, Recording

TARGET_N = 0.3
HOLD_S = 5.0
# A wire that cools a little keeps its contraction, by its hysteresis. So the hold needs no controller, only a drive
# below that which would close further, by a margin that draughts seldom exceed: 4 % in voltage are 8 % in power, a
# usual draught.
HOLD_FRACTION = 0.96
# The end of the hold is evaluated.
JUDGED_S = 3.0
# Noise of one sample's motion must not reduce the power below this fraction.
MIN_HOLDING_FRACTION = 0.4


class GripPolicy:
    """Closes with rising power until contact, on to the target force and holds; opens again without contact."""

    columns = ("wire_resistance_ohm", "contact_score", "contact", "estimated_grip_force_n", "target_grip_force_n")

    def __init__(
        self,
        rig: Rig,
        knowledge: GripperKnowledge,
        *,
        target_n: float,
        stiffness_n_per_m: float | None,
        air: AirDisturbance | None,
        closing_s: float,
    ) -> None:
        """Begin to close; with ``stiffness_n_per_m`` None it is estimated from the power that contact costs."""
        self.knowledge, self.target_n, self._known_stiffness_n_per_m = knowledge, target_n, stiffness_n_per_m
        self._curve, self._free, self._detector = knowledge.curve, knowledge.free, ContactDetector(knowledge.free, air)
        self._closing, self._closes_until_s = closing_waveform(rig, closing_s), REST_S + closing_s
        self._closed_v, self._limits = rig.drive_amplitude_v, DriveLimits(rig.sense_voltage_v, rig.maximum_voltage_v)
        self._shunt_resistance_ohm, self._sample_period_s = rig.shunt_resistance_ohm, rig.sample_period_s
        self.state = self._detector.start()
        self.stiffness_n_per_m: float | None = None
        self.contact = 1.0
        self._held_v: float | None = None
        self._held_places: list[float] = []
        self._force_n = 0.0
        self._place_before = 1.0
        self._dropouts = 0

    def first_command(self) -> Command:
        """Return the waveform's start."""
        return Drive(self._closing(0.0))

    def after(self, sample: RawSample, elapsed_s: float) -> Decision:
        """Return the next drive voltage and the state of the grip as estimated from the wire's voltages."""
        reading = wire_resistance(sample.wire_voltage_v, sample.shunt_voltage_v, self._shunt_resistance_ohm)
        drive = sample.drive_voltage_v
        if reading.valid:
            self._dropouts = 0
            drive = self._drive_after(sample, reading.resistance_ohm, elapsed_s)
        else:
            self._bridge(sample)
        return Decision(
            Drive(drive),
            (
                reading.resistance_ohm,
                self.state.score,
                float(self.state.touched),
                self._force_n,
                self.target_n if self._held_v else 0.0,
            ),
        )

    def _drive_after(self, sample: RawSample, resistance_ohm: float, elapsed_s: float) -> float:
        """Return the drive after a sample with current, by the phase of the grip."""
        place = self._free.normalised(resistance_ohm)
        if self._held_v is None and elapsed_s > self._closes_until_s:
            # Open again without contact; if the target is out of reach, stay at the drive that closes fully.
            return self._closed_v if self.state.touched else self._limits.sense_voltage_v
        if self._held_v is None:
            moved, self._place_before = self._place_before - place, place
            before_n, power_w = self._force_n, sample.wire_voltage_v**2 / resistance_ohm
            self.state = self._detector.step(self.state, resistance_ohm, power_w, self._sample_period_s)
            if not self.state.touched:
                return self._closing(elapsed_s)
            stiffness = self._follow_contact()
            self._force_n = self._curve.force_n(place, self.contact, stiffness)
            # The wire moves on for a sample: the hold begins if the next sample would reach the target.
            if self._force_n <= 0.0 or 2.0 * self._force_n - before_n < self.target_n:
                return self._closing(elapsed_s)
            self.stiffness_n_per_m = stiffness
            self._held_v = self._holding_voltage_v(sample.drive_voltage_v, power_w, place, moved)
            return self._held_v
        self._held_places.append(place)
        cooled = fall_by_cooling(self._held_places, self._sample_period_s, self._free.thermal_time_s)
        self._force_n = self._curve.force_n(place + cooled, self.contact, self.stiffness_n_per_m or 0.0)
        return self._held_v

    def _follow_contact(self) -> float:
        """Update the point of contact and return the object's stiffness: known, or estimated from power."""
        if self._known_stiffness_n_per_m is not None:
            self.contact = self._curve.contact_place(self.state, self._known_stiffness_n_per_m)
            return self._known_stiffness_n_per_m
        self.contact, stiffness = self._curve.met_by_power(self.state)
        return stiffness

    def _holding_voltage_v(self, drive_voltage_v: float, power_w: float, place: float, moved: float) -> float:
        """Return the holding drive: that without the power of the last sample's motion, less a margin."""
        per_place_j = float(evaluate(self._free.closing_energy_j, place))
        per_place_j += self.state.slope_w * self._free.thermal_time_s
        moving_w = per_place_j * max(moved, 0.0) / self._sample_period_s
        still_v = drive_voltage_v * math.sqrt(max(1.0 - moving_w / power_w, MIN_HOLDING_FRACTION))
        return self._limits.clamp(HOLD_FRACTION * still_v)

    def _bridge(self, sample: RawSample) -> None:
        """Hold the drive over a sample without current. Raises RigError after too many in a row."""
        self._dropouts += 1
        failure = dropout_failure(self._dropouts, sample, pulls="wires")
        if failure:
            raise RigError(failure)


@dataclass(frozen=True, eq=False, repr=False)
class GripRun(Recording):
    """A recording of a grip with its results; forces in newtons between endpoint and object."""

    contact_s: float | None = None  # time of contact from the start of closing; None without contact
    true_force_at_contact_n: float | None = None  # the instrument's force at contact; None without an instrument
    opening_m: float | None = None  # opening of the fingers at contact, the size of the object; None without contact
    stiffness_n_per_m: float | None = None  # stiffness of the object that the force was computed with
    held: bool = False  # whether the force was reached and held
    target_n: float = TARGET_N  # the force that was asked for
    estimated_force_n: float | None = None  # estimated force, mean over the end of the hold
    # The instrument's force, mean over the end of the hold; None without an instrument.
    true_force_n: float | None = None
    most_force_n: float | None = None  # force on a rigid object at this resistance, mean over the end of the hold


def grip(
    rig: Rig,
    knowledge: GripperKnowledge,
    *,
    target_n: float = TARGET_N,
    stiffness_n_per_m: float | None = None,
    air: AirDisturbance | None = None,
    closing_s: float = CLOSING_S,
    hold_s: float = HOLD_S,
    **run: Unpack[RunOptions],
) -> GripRun:
    """Close the fingers, detect contact, close further to a force and hold it, by the wires' resistance alone.

    Parameters
    ----------
    rig
        An open rig of a gripper.
    knowledge
        Result of training this gripper (``train_gripper``).
    target_n
        Force [N] to hold.
    stiffness_n_per_m
        Stiffness of the object [N/m]; None estimates it from the power that contact costs.
    air
        Expected motion of the air; without it that of the training.
    closing_s
        Time [s] in which it closes.
    hold_s
        Time [s] of the hold; its last 3 s are evaluated.
    **run
        ``path`` of the recording, ``overwrite`` one that exists, ``on_sample`` called with every recorded row.

    Returns
    -------
    The recording with its results.

    Raises
    ------
    CallerError
        If target or stiffness is not above 0, the hold too short, or the gripper not the one of the knowledge.
    RigError
        If the wires carry no current.
    """
    if not target_n > 0.0 or (stiffness_n_per_m is not None and not stiffness_n_per_m > 0.0):
        raise CallerError(f"target force {target_n:g} N and stiffness {stiffness_n_per_m} N/m must be above 0")
    if not hold_s > JUDGED_S:
        raise CallerError(f"a hold of {hold_s:g} s is too short: its last {JUDGED_S:g} s are evaluated")
    knowledge.gripper.require_same(gripper_of(rig))
    policy = GripPolicy(
        rig, knowledge, target_n=target_n, stiffness_n_per_m=stiffness_n_per_m, air=air, closing_s=closing_s
    )
    metadata: dict[str, MetadataValue] = {
        "experiment": "grip", "closing_s": closing_s, "rest_s": REST_S, "known_stiffness_n_per_m": stiffness_n_per_m,
    }  # fmt: skip
    with rig.holding_back():
        recording = run_on_rig(rig, policy, REST_S + closing_s + hold_s, metadata=metadata, **run)
    return with_results(recording, policy)


def with_results(recording: Recording, policy: GripPolicy) -> GripRun:
    """Return a grip with its results, and the instrument's if there is one."""
    run = GripRun(recording.columns, recording.metadata, target_n=policy.target_n)
    if not policy.state.touched:
        return run
    curve, free = policy.knowledge.curve, policy.knowledge.free
    first = int(np.argmax(recording["contact"] > 0.0))
    force = recording.columns.get("endpoint_force_n")
    end = recording["time_s"] > recording["time_s"][-1] - JUDGED_S
    held = bool((recording["target_grip_force_n"][end] > 0.0).all())
    resistance = float(recording["wire_resistance_ohm"][end].mean())
    return replace(
        run,
        contact_s=round(float(recording["time_s"][first]) - REST_S, 9),
        true_force_at_contact_n=None if force is None else float(force[first]),
        opening_m=curve.closed_m(policy.contact),
        stiffness_n_per_m=policy.stiffness_n_per_m,
        held=held,
        estimated_force_n=float(recording["estimated_grip_force_n"][end].mean()),
        true_force_n=None if force is None else float(force[end].mean()),
        most_force_n=curve.max_force_n(free.normalised(resistance), policy.contact),
    )
