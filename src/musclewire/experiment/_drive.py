"""A plain drive: supply or current on for a time, then off, to see a wire's response before parts are bought.

Both policies would run on a real rig: the held current is regulated by the current that is measured.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, Unpack

import numpy as np

from musclewire.errors import CallerError, RigError
from musclewire.experiment._known_drive import KnownDrive, KnownDrivePolicy
from musclewire.experiment._run import Decision, Policy, RunOptions, run_on_rig
from musclewire.physics import wire_resistance
from musclewire.rigs import HasTrueState, Rig, ability
from musclewire.sensing import dropout_failure
from musclewire.signals import Command, Drive, MetadataValue, RawSample, Recording

# Samples without current after which a wire counts as broken.
MAX_DROPOUTS = 5


class PulseTrain(NamedTuple):
    """A square wave in whole samples: the first ``on`` samples of every ``period`` are driven."""

    on: int = 1
    period: int = 1

    def driven(self, since_on: int) -> bool:
        """Return whether the drive is on in a sample, counted from switching on."""
        return since_on % self.period < self.on


# No pauses.
ALWAYS = PulseTrain()
# A period has at least this many samples, so that a duty is met to a twentieth.
MIN_PERIOD_SAMPLES = 10


def pulses_of(duty: float, period_s: float, sample_period_s: float) -> PulseTrain:
    """Return the square wave nearest to a duty and a period. Raises CallerError for one that samples cannot make."""
    if not 0.0 < duty <= 1.0:
        raise CallerError(f"the duty is {duty:g}: it must be above 0 and at most 1 (100 %)")
    period = round(period_s / sample_period_s)
    if period < MIN_PERIOD_SAMPLES:
        raise CallerError(
            f"a duty's period of {period_s:g} s has fewer than {MIN_PERIOD_SAMPLES} samples of {sample_period_s:g} s: "
            "give a longer one; pulses of kilohertz are the key [pwm] of a simulated rig's file"
        )
    return PulseTrain(max(round(duty * period), 1), period)


class HeldVoltage:
    """A supply switched on after one sample, all the time or in pulses, and off ``on_s`` later: the sense voltage."""

    columns: tuple[str, ...] = ()

    def __init__(
        self,
        drive_voltage_v: float,
        sense_voltage_v: float,
        sample_period_s: float,
        on_s: float,
        pulses: PulseTrain = ALWAYS,
    ) -> None:
        """Hold ``drive_voltage_v`` for ``on_s``; the first sample senses the wire cold."""
        self._drive_voltage_v = drive_voltage_v
        self._sense_voltage_v = sense_voltage_v
        self._sample_period_s, self._pulses = sample_period_s, pulses
        self._off_at_s = sample_period_s + on_s

    def first_command(self) -> Command:
        """Return the sense voltage."""
        return Drive(self._sense_voltage_v)

    def after(self, sample: RawSample, elapsed_s: float) -> Decision:  # noqa: ARG002
        """Return the supply's voltage until it is time to switch off."""
        return Decision(Drive(self._drive_at_v(elapsed_s)))

    def known_drive(self, elapsed_s: tuple[float, ...]) -> KnownDrive:
        """Return the drive of each sample."""
        drives_v = [self._sense_voltage_v, *map(self._drive_at_v, elapsed_s[:-1])]
        return KnownDrive(np.array(drives_v), np.empty((len(elapsed_s), 0)))

    def _drive_at_v(self, elapsed_s: float) -> float:
        driven = elapsed_s < self._off_at_s - 1e-9 and self._pulses.driven(round(elapsed_s / self._sample_period_s) - 1)
        return self._drive_voltage_v if driven else self._sense_voltage_v


class HeldCurrent:
    """A current regulated by measurement: the circuit's resistance is the last drive voltage over the last current.

    It lags by one sample, in which a wire's resistance changes by little. A sample without current keeps the drive;
    five of them raise RigError.
    """

    columns: tuple[str, ...] = ()

    def __init__(
        self,
        current_a: float,
        sense_voltage_v: float,
        maximum_voltage_v: float,
        shunt_resistance_ohm: float,
        sample_period_s: float,
        on_s: float,
        pulses: PulseTrain = ALWAYS,
    ) -> None:
        """Hold ``current_a`` for ``on_s`` within ``maximum_voltage_v``; the first sample measures."""
        self._current_a = current_a
        self._sense_voltage_v = sense_voltage_v
        self._maximum_voltage_v = maximum_voltage_v
        self._shunt_resistance_ohm = shunt_resistance_ohm
        self._sample_period_s, self._pulses = sample_period_s, pulses
        self._off_at_s = sample_period_s + on_s
        self._dropouts = 0

    def first_command(self) -> Command:
        """Return the sense voltage."""
        return Drive(self._sense_voltage_v)

    def after(self, sample: RawSample, elapsed_s: float) -> Decision:
        """Return the voltage that drives the wanted current through the resistance just measured."""
        paused = not self._pulses.driven(round(elapsed_s / self._sample_period_s) - 1)
        if paused or elapsed_s >= self._off_at_s - 1e-9:
            return Decision(Drive(self._sense_voltage_v))
        reading = wire_resistance(sample.wire_voltage_v, sample.shunt_voltage_v, self._shunt_resistance_ohm)
        if not reading.valid:
            return Decision(Drive(self._kept(sample)))
        self._dropouts = 0
        circuit_ohm = sample.drive_voltage_v * self._shunt_resistance_ohm / sample.shunt_voltage_v
        wanted_v = self._current_a * circuit_ohm
        return Decision(Drive(min(max(wanted_v, self._sense_voltage_v), self._maximum_voltage_v)))

    def _kept(self, sample: RawSample) -> float:
        self._dropouts += 1
        failure = dropout_failure(self._dropouts, sample, MAX_DROPOUTS)
        if failure:
            raise RigError(failure)
        return sample.drive_voltage_v


class WithTruth:
    """Another policy, with numbers of the wire's state recorded as well, which only a simulation knows."""

    def __init__(self, policy: Policy, truth: HasTrueState, names: Mapping[str, str]) -> None:
        """Record fields of the state after each sample, by the names of their columns; the policy does not see them."""
        self._policy, self._truth, self._names = policy, truth, names
        self.columns = (*policy.columns, *names)

    def first_command(self) -> Command:
        """Return the policy's own."""
        return self._policy.first_command()

    def after(self, sample: RawSample, elapsed_s: float) -> Decision:
        """Return the policy's decision with the true numbers added."""
        decision, state = self._policy.after(sample, elapsed_s), self._truth.wire_state
        true = (float(getattr(state, name)) for name in self._names.values())
        return Decision(decision.command, (*decision.values, *true))

    def known_drive(self, elapsed_s: tuple[float, ...]) -> KnownDrive | None:
        """Return the policy's own with the true numbers added, if it knows its drive."""
        known = self._policy.known_drive(elapsed_s) if isinstance(self._policy, KnownDrivePolicy) else None
        return known and known._replace(true_names=tuple(self._names.values()))


def drive_wire(
    rig: Rig,
    *,
    on_s: float,
    duration_s: float,
    supply_v: float | None = None,
    current_a: float | None = None,
    pulses: PulseTrain = ALWAYS,
    **run: Unpack[RunOptions],
) -> Recording:
    """Switch a supply or a held current on for ``on_s`` and record the rig for ``duration_s`` in total.

    With ``pulses`` it is on and off in turn until then. With a current, ``supply_v`` only limits the voltage. The
    first sample is taken at the sense voltage. A simulated rig's recording also has the wire's true temperature.
    Raises CallerError for impossible numbers or neither supply nor current, RigError if no current flows.
    """
    refuse_impossible(rig, on_s, duration_s, supply_v, current_a)
    policy = policy_for(rig, on_s, rig.maximum_voltage_v if supply_v is None else supply_v, current_a, pulses)
    described: dict[str, MetadataValue] = {"experiment": "drive", "on_s": on_s}
    if pulses != ALWAYS:
        described |= {"duty": pulses.on / pulses.period, "duty_period_s": pulses.period * rig.sample_period_s}
    described |= {} if supply_v is None else {"supply_v": supply_v}
    described |= {} if current_a is None else {"held_current_a": current_a}
    return run_on_rig(rig, policy, duration_s, metadata=described, **run)


def policy_for(rig: Rig, on_s: float, limit_v: float, current_a: float | None, pulses: PulseTrain) -> Policy:
    """Return a policy that holds a voltage or a limited current, with the true temperature if the rig knows it."""
    policy: Policy = HeldVoltage(limit_v, rig.sense_voltage_v, rig.sample_period_s, on_s, pulses)
    if current_a is not None:
        policy = HeldCurrent(
            current_a, rig.sense_voltage_v, limit_v, rig.shunt_resistance_ohm, rig.sample_period_s, on_s, pulses
        )
    truth = ability(rig, HasTrueState)
    return policy if truth is None else WithTruth(policy, truth, {"wire_temperature_k": "temperature_k"})


def refuse_impossible(
    rig: Rig, on_s: float, duration_s: float, supply_v: float | None, current_a: float | None
) -> None:
    """Raise CallerError for an impossible drive."""
    if supply_v is None and current_a is None:
        raise CallerError("give a supply voltage or a current to hold: without either nothing is driven")
    if current_a is not None and not current_a > 0.0:
        raise CallerError(f"the current to hold is {current_a} A: give one above 0")
    if supply_v is not None and not rig.sense_voltage_v < supply_v <= rig.maximum_voltage_v:
        raise CallerError(
            f"supply {supply_v} V must lie above the sense voltage of {rig.sense_voltage_v} V and not above the rig's "
            f"maximum of {rig.maximum_voltage_v} V"
        )
    if not (on_s > 0.0 and duration_s >= on_s):
        raise CallerError(
            f"switched on for {on_s} s within {duration_s} s: both must be above 0, and off before the end"
        )
