"""The examination: levels below the sense voltage first, and only if they pass the sense voltage itself."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

from musclewire.controllers import ProtectionLimits
from musclewire.errors import CallerError, RigError
from musclewire.experiment._doctor.channel_checks import (
    finite_check,
    hum_check,
    measurements_check,
    moving_checks,
    offset_checks,
    quiet_checks,
    range_check,
)
from musclewire.experiment._doctor.circuit_checks import ArrivingFractions, ExpectedWire, circuit_findings
from musclewire.experiment._doctor.evidence import (
    LOW_FRACTIONS,
    Evidence,
    Findings,
    OnProbe,
    RigCheck,
    SkippedCheck,
    VoltageLevel,
    VoltageProbe,
    evidence_of,
)
from musclewire.experiment._doctor.rig_file import ChannelCalibration, calibrations
from musclewire.experiment._doctor.sense_checks import clock_findings, protection_findings, warmth_findings
from musclewire.parameters import Wire, load_wire
from musclewire.rigs import Metadata, ProtectionTripError, Rig, keeps_real_time
from musclewire.signals import RunFacts

ZERO_S, LOW_S, SENSE_S = 2.0, 1.0, 5.0
# With one of these the sense voltage is not applied: the wiring is not what the rig file says.
STOPPING = frozenset(
    {
        "readings_are_numbers",
        "readings_are_measurements",
        "readings_in_range",
        "output_at_zero_v",
        "output_gain",
        "sense_current_a",
        "wire_channel_alive",
        "shunt_channel_alive",
        "wire_polarity",
        "shunt_polarity",
        "channels_in_place",
        "wire_resistance_ohm",
        "resistance_in_window",
    }
)


class Examination(NamedTuple):
    """Findings of the doctor.

    ``findings`` are in the order in which they were made. ``highest_v`` is the highest output voltage [V]; ``trouble``
    is the rig's own fault, None without one. ``calibration`` may be empty.
    """

    findings: Findings
    calibration: tuple[ChannelCalibration, ...]
    metadata: Metadata
    highest_v: float
    trouble: RigError | None

    @property
    def ok(self) -> bool:
        """Whether every check that could be made holds and the rig had no fault."""
        return self.trouble is None and not self.findings.failed

    @property
    def blocks_calibration(self) -> frozenset[str]:
        """The failed checks by which the wiring is wrong in a way that no offset or gain corrects."""
        return self.findings.failed & STOPPING - {"wire_resistance_ohm", "output_gain"}


class ExaminedRig(NamedTuple):
    """A rig with its metadata's statements about the wire, looked up once."""

    rig: Rig
    metadata: Metadata
    wire: Wire | None
    length_m: float | None
    limits: ProtectionLimits
    expected: ExpectedWire


def examination_s(hold_s: float = SENSE_S) -> float:
    """Return about how long an examination takes on a rig with a real clock."""
    return ZERO_S + LOW_S * len(LOW_FRACTIONS) + hold_s


def examine(
    rig: Rig,
    *,
    hold_s: float = SENSE_S,
    meter_wire_v: float | None = None,
    meter_shunt_v: float | None = None,
    clock: Callable[[], float] = time.monotonic,
    on_sample: OnProbe | None = None,
) -> Examination:
    """Check a rig at its sense voltage and below; the rig ends at its sense voltage or off.

    ``hold_s`` is how long the sense voltage is held; the meters' readings, taken at the sense voltage, give the gains
    of the channels. A fault of the rig is a finding too: ``trouble``. Raises CallerError for a meter's
    reading that cannot belong to its channel.
    """
    subject = subject_of(rig)
    probe = VoltageProbe(rig, clock, on_sample)
    findings = identity_findings(subject) + protection_findings(subject.limits)
    try:
        evidence, at_sense, seen = probed(probe, subject, findings, hold_s)
        findings += seen
    finally:
        rig.make_safe()
    found = calibrations(evidence, at_sense, meter_wire_v, meter_shunt_v) if evidence is not None else ()
    return Examination(findings, found, subject.metadata, probe.highest_v, probe.trouble)


def trip_findings(trouble: RigError | None) -> Findings:
    """Return whether the rig kept going: a trip of its protection names the cause better than any check here."""
    if trouble is None:
        return Findings((RigCheck("rig_kept_going", True, "yes", "", "the protection had nothing to switch off"),))
    cause = trouble.event.name.lower() if isinstance(trouble, ProtectionTripError) else "rig fault"
    return Findings((RigCheck("rig_kept_going", False, cause, "", str(trouble)),))


def probed(
    probe: VoltageProbe, subject: ExaminedRig, before: Findings, hold_s: float
) -> tuple[Evidence | None, VoltageLevel | None, Findings]:
    """Return evidence, the level at the sense voltage if it was held, and findings.

    A failed check among those ``before`` may forbid holding it.
    """
    rig, at_sense = subject.rig, None
    evidence, findings = low_findings(look_low(probe, rig), subject)
    below = Findings((measurements_check(probe.levels, subject.limits),))
    if evidence is not None and probe.trouble is None and not STOPPING & (before + findings + below).failed:
        at_sense = probe.hold(rig.sense_voltage_v, hold_s)
    findings += Findings((measurements_check(probe.levels, subject.limits),))
    if evidence is not None:
        findings += sense_findings(evidence, at_sense, subject)
    findings += trip_findings(probe.trouble)
    timed = tuple(level for level in probe.levels if len(level.time_s) > 2)
    if timed:
        findings += clock_findings(timed, rig.sample_period_s, keeps_real_time(rig))
    return evidence, at_sense, findings


def subject_of(rig: Rig) -> ExaminedRig:
    """Return a rig with its statements about its wire; None for what it does not state."""
    metadata = rig.metadata()
    limits = rig.protection_limits
    facts = RunFacts(metadata, "this rig")
    length_m = facts.positive_or_none("wire_length_m")
    wire, why = known_wire(facts.text_or_none("wire"))
    if wire is not None and length_m is None:
        why = "the rig does not state the length of its wire"
    if facts.wires > 1.0:
        # In series or in parallel: the protection's window accounts for it, ohm per metre times length does not.
        wire, why = None, "several wires share the drive; see the window"
    cold = None if wire is None or length_m is None else wire.resistance_per_metre_ohm_per_m.value * length_m
    by, least = facts.text_or_none("arriving_fraction_by"), facts.positive_or_none("arriving_fraction_least")
    arriving = None if by is None or least is None else ArrivingFractions(least, limits.arriving_fraction, by)
    expected = ExpectedWire(cold, limits.resistance_low_ohm, limits.resistance_high_ohm, why, arriving)
    return ExaminedRig(rig, metadata, wire, length_m, limits, expected)


def known_wire(name: str | None) -> tuple[Wire | None, str]:
    """Return a wire by its name, or None and why not."""
    if name is None:
        return None, "the rig does not state which wire is mounted"
    try:
        return load_wire(name), ""
    except CallerError as error:
        return None, f"the rig's wire is not known: {error}"


def identity_findings(subject: ExaminedRig) -> Findings:
    """Return whether the rig identifies itself and its voltages are consistent."""
    rig = subject.rig
    ok = (
        0.0 < rig.sense_voltage_v < rig.maximum_voltage_v
        and rig.shunt_resistance_ohm > 0.0
        and rig.sample_period_s > 0.0
    )
    said = f"{subject.metadata.get('rig', 'rig')}, wire {subject.metadata.get('wire', 'not named')}"
    if "firmware_wire" in subject.metadata:
        said += f"; the board's firmware is built for {subject.metadata['firmware_wire']}"
    advice = (
        f"sense {rig.sense_voltage_v:g} V of at most {rig.maximum_voltage_v:g} V, shunt "
        f"{rig.shunt_resistance_ohm:g} ohm, a sample every {rig.sample_period_s:g} s"
    )
    return Findings((RigCheck("identity", ok, said, "", advice),))


def look_low(probe: VoltageProbe, rig: Rig) -> tuple[VoltageLevel, ...]:
    """Hold 0 V and the levels at which the protection expects no current yet; stop if the output is not 0 V."""
    zero = probe.hold(0.0, ZERO_S)
    if zero is None:
        return tuple(probe.levels)
    out_v = abs(float((zero.wire_voltage_v + zero.shunt_voltage_v).mean()))
    if out_v > rig.sense_voltage_v:
        return tuple(probe.levels)  # an output that does not follow its command gets no higher one
    for fraction in LOW_FRACTIONS:
        if probe.hold(fraction * rig.sense_voltage_v, LOW_S) is None:
            break
    return tuple(probe.levels)


def low_findings(levels: tuple[VoltageLevel, ...], subject: ExaminedRig) -> tuple[Evidence | None, Findings]:
    """Return the fits and checks of the low levels; no fits if there are too few numbers."""
    if not levels:
        return None, Findings((), (SkippedCheck("wiring", "the rig gave no sample at all"),))
    finite = finite_check(levels)
    if not finite.ok or len(levels) < 2 or min(len(level.time_s) for level in levels) < 3:
        stuck = stuck_findings(levels, subject) if finite.ok else Findings(())
        return None, Findings((finite,), (SkippedCheck("wiring", "too few valid samples"),)) + stuck
    rig = subject.rig
    evidence = evidence_of(levels, rig.sense_voltage_v, rig.shunt_resistance_ohm)
    findings = Findings((finite, range_check(evidence)))
    findings += moving_checks(evidence) + circuit_findings(evidence, subject.expected) + offset_checks(evidence)
    return evidence, findings


def stuck_findings(levels: tuple[VoltageLevel, ...], subject: ExaminedRig) -> Findings:
    """Return the check that is possible if only 0 V was commanded: whether the output is 0 V."""
    zero = levels[0]
    volts = float((zero.wire_voltage_v + zero.shunt_voltage_v).mean())
    if abs(volts) <= subject.rig.sense_voltage_v:
        return Findings(())
    advice = (
        "wire and shunt carry this at 0 V. CUT THE POWER before anything else: the output is stuck, the transistor has "
        "failed, or a channel is saturated or not connected"
    )
    return Findings((RigCheck("output_at_zero_v", False, volts, "V", advice),))


def sense_findings(evidence: Evidence, at_sense: VoltageLevel | None, subject: ExaminedRig) -> Findings:
    """Return the checks that need the sense voltage, and those of noise."""
    ambient = subject.limits.ambient_temperature_k
    return (
        quiet_checks(evidence, at_sense, subject.rig.sample_period_s)
        + hum_check(evidence, subject.rig.sample_period_s)
        + warmth_findings(evidence, at_sense, subject.wire, subject.length_m, ambient)
    )
