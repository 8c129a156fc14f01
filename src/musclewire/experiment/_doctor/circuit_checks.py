"""Checks of the circuit: current, the wire that the rig file names, and an output that follows its command."""

from __future__ import annotations

import math
from typing import NamedTuple

from musclewire.experiment._doctor.evidence import Evidence, Findings, RigCheck, SkippedCheck

# Eq. 1 treats less than 1 mA as no current; a sense current must be twice that.
MIN_SENSE_CURRENT_A = 2e-3
# Spools, length measured by a ruler, pretension and the R-phase: the right wire is this close to the catalogue's value.
RESISTANCE_FRACTION = 0.15
# Voltage of the shunt over that of the wire: with less it is hard to read, with more it wastes the drive and warms up.
MIN_SHUNT_FRACTION, MAX_SHUNT_FRACTION = 0.001, 0.3
# Allowed deviation of the output from its command.
GAIN_FRACTION, OUTPUT_OFFSET_FRACTION = 0.1, 0.1
# Leads, clamps, switch and amplifier between the output and the measured voltages, as a fraction of the wire's
# resistance.
OUTSIDE_FRACTION = 0.05
# Shunts are usually confused with neighbours in the standard series of values.
USUAL_FACTORS = (0.001, 0.01, 0.1, 0.22, 0.47, 1 / 2.2, 2.2, 4.7, 10.0, 100.0, 1000.0)
NAMED_WITHIN = 0.12


class ArrivingFractions(NamedTuple):
    """Least and largest fraction of an order at wire and shunt, and what has shown it: the rig file's ``[arrives]``."""

    least: float
    largest: float
    by: str


class ExpectedWire(NamedTuple):
    """The rig file's statements about the wire: cold resistance, the window of all its states, what arrives at it."""

    resistance_ohm: float | None
    low_ohm: float
    high_ohm: float
    why_unknown: str = ""
    arriving: ArrivingFractions | None = None


def circuit_findings(evidence: Evidence, expected: ExpectedWire) -> Findings:
    """Return the checks of output, current, wire and shunt."""
    made = [output_at_zero_check(evidence), output_gain_check(evidence, expected.arriving), current_check(evidence)]
    swapped = swapped_findings(evidence, expected)
    if not evidence.carries:
        names = ("wire_resistance_ohm", "resistance_in_window", "shunt_share", "outside_resistance_ohm")
        rest = tuple(SkippedCheck(name, "no current follows the drive") for name in names)
        return Findings(tuple(made)) + swapped + Findings((), rest)
    made += [shunt_fraction_check(evidence), outside_check(evidence)]
    return Findings(tuple(made)) + swapped + resistance_findings(evidence, expected)


def output_at_zero_check(evidence: Evidence) -> RigCheck:
    """Check that the output is off at 0 V: a stuck output heats whatever the software commands."""
    level = evidence.zero
    volts = float((level.wire_voltage_v + level.shunt_voltage_v).mean())
    ok = abs(volts) <= OUTPUT_OFFSET_FRACTION * evidence.sense_voltage_v
    advice = "what wire and shunt carry together at 0 V"
    if not ok:
        advice = (
            "wire and shunt carry this at 0 V. CUT THE POWER before anything else: the output is stuck, the transistor "
            "has failed, or the channels have a large offset"
        )
    return RigCheck("output_at_zero_v", ok, volts, "V", advice)


def output_gain_check(evidence: Evidence, arriving: ArrivingFractions | None) -> RigCheck:
    """Check that the voltage at wire and shunt follows the command, or is what something else has shown to arrive."""
    gain = abs(evidence.wire.slope) + abs(evidence.shunt.slope)
    ok = abs(gain - 1.0) <= GAIN_FRACTION
    advice = "volts at wire and shunt per commanded volt"
    if arriving is not None:
        ok = arriving.least <= gain <= arriving.largest
        advice += f"; by {arriving.by} {arriving.least:.3f} to {arriving.largest:.3f} ([arrives] of the rig file)"
        if not ok:
            advice += ": a channel's gain is wrong, or it was another circuit; measure again, and correct what differs"
    elif gain < 0.5:
        advice = "the drive does not arrive: check supply, fuse, emergency switch, amplifier and the clamps"
    elif gain < 1.0 - GAIN_FRACTION:
        advice += (
            ": too few; leads, clamps or switch take the rest, or the amplifier's gain is not as the rig file states"
        )
    elif gain > 1.0 + GAIN_FRACTION:
        advice += ": too many; the amplifier's gain or a channel's range is not as the rig file states"
    return RigCheck("output_gain", ok, gain, "V/V", advice)


def current_check(evidence: Evidence) -> RigCheck:
    """Check that enough current flows at the sense voltage to measure resistance."""
    current = abs(evidence.sense_current_a) if evidence.shunt.moves else 0.0
    ok = current >= MIN_SENSE_CURRENT_A
    advice = "at the sense voltage, by the shunt's slope"
    if not ok and current > 0.0:
        advice += f": below {1e3 * MIN_SENSE_CURRENT_A:g} mA; raise the sense voltage"
    elif not ok and evidence.wire.moves:
        advice = (
            "the voltage arrives at the wire's terminals and no current flows: the wire is broken or a clamp is open, "
            "or the shunt's channel is bridged, dead or drowned in noise"
        )
    elif not ok:
        advice = "neither channel follows the drive: see the output's gain"
    return RigCheck("sense_current_a", ok, current, "A", advice)


def swapped_findings(evidence: Evidence, expected: ExpectedWire) -> Findings:
    """Check that wire and shunt channels are not swapped, if their resistances differ enough to decide."""
    if not evidence.carries or expected.resistance_ohm is None:
        why = expected.why_unknown if evidence.carries else "no current follows the drive"
        return Findings((), (SkippedCheck("channels_in_place", why),))
    measured, shunt, right = abs(evidence.resistance_ohm), evidence.shunt_resistance_ohm, expected.resistance_ohm
    if abs(math.log(right / shunt)) < math.log(1.5):
        reason = f"wire ({right:.3g} ohm) and shunt ({shunt:.3g} ohm) are too similar to tell them apart"
        return Findings((), (SkippedCheck("channels_in_place", reason),))
    # Swapped channels would read shunt^2 / wire.
    as_is, other_way = abs(math.log(measured / right)), abs(math.log(shunt * shunt / right / measured))
    ok = as_is <= other_way
    advice = (
        "the channel with the larger voltage is the wire's, as it should be"
        if ok
        else ("the channels have changed places: swap their cables, or the channels in the rig file")
    )
    return Findings((RigCheck("channels_in_place", ok, measured, "ohm", advice),))


def resistance_findings(evidence: Evidence, expected: ExpectedWire) -> Findings:
    """Check the wire's resistance against the vendor's value per metre, and against the protection's window."""
    measured = evidence.resistance_ohm
    made: list[RigCheck] = []
    missing: list[SkippedCheck] = []
    if expected.resistance_ohm is None:
        missing.append(SkippedCheck("wire_resistance_ohm", expected.why_unknown))
    else:
        made.append(resistance_check(measured, expected.resistance_ohm, evidence))
    ok = expected.low_ohm <= measured <= expected.high_ohm
    advice = f"the protection allows {expected.low_ohm:.3g} to {expected.high_ohm:.3g} ohm"
    made.append(RigCheck("resistance_in_window", ok, measured, "ohm", advice))
    return Findings(tuple(made), tuple(missing))


def resistance_check(measured_ohm: float, right_ohm: float, evidence: Evidence) -> RigCheck:
    """Check the wire's resistance against that of a cold wire of its length, and name a likely cause."""
    ratio = measured_ohm / right_ohm
    ok = abs(ratio - 1.0) <= RESISTANCE_FRACTION
    advice = f"the wire file's ohm per metre times the length is {right_ohm:.4g} ohm"
    if not ok:
        advice += "; " + likely_cause(ratio, evidence)
    return RigCheck("wire_resistance_ohm", ok, measured_ohm, "ohm", advice)


def likely_cause(ratio: float, evidence: Evidence) -> str:
    """Return what most likely makes a resistance wrong by a factor."""
    if ratio < 0.0:
        return "negative: a pair is reversed, see the polarities"
    named = [factor for factor in USUAL_FACTORS if abs(ratio * factor - 1.0) < NAMED_WITHIN]
    if named:
        shunt = named[0] * evidence.shunt_resistance_ohm
        return f"a shunt of {shunt:.3g} ohm instead of {evidence.shunt_resistance_ohm:.3g} ohm would explain it"
    if ratio < 0.2:
        return "the wire is bridged, or the pair at the wire does not reach its ends"
    if ratio < 1.0:
        return "too small: a shorter or thicker wire, one leg only, a wire still hot, or a larger shunt than stated"
    if ratio < 2.0 and evidence.circuit.slope > 1.0 - OUTSIDE_FRACTION:
        return (
            "too large and nothing is lost outside: leads or clamps count as wire (two-wire connection), take a pair "
            "of their own to the crimps; or a longer or thinner wire"
        )
    return "too large: a longer or thinner wire, a strand half broken, a bad clamp, or a smaller shunt than stated"


def shunt_fraction_check(evidence: Evidence) -> RigCheck:
    """Check that the shunt's voltage is large enough to read and small enough not to waste the drive."""
    fraction = abs(evidence.shunt.slope / evidence.wire.slope)
    ok = MIN_SHUNT_FRACTION <= fraction <= MAX_SHUNT_FRACTION
    advice = "the shunt's voltage over the wire's"
    if fraction > MAX_SHUNT_FRACTION:
        advice += ": the shunt takes much of the drive and warms up; a smaller one (musclewire simulate says which)"
    elif not ok:
        advice += ": hard to read; a larger shunt (musclewire simulate says which)"
    return RigCheck("shunt_share", ok, fraction, "1", advice)


def outside_check(evidence: Evidence) -> RigCheck:
    """Check the resistance between the output and the measured voltages: leads, clamps, switch, amplifier."""
    lost = 1.0 - abs(evidence.wire.slope) - abs(evidence.shunt.slope)
    outside = evidence.shunt_resistance_ohm * lost / abs(evidence.shunt.slope)
    ok = outside <= OUTSIDE_FRACTION * abs(evidence.resistance_ohm)
    advice = "leads, clamps and amplifier outside the measured voltages, if the output is as commanded"
    if not ok:
        advice += ": too much; shorter or thicker leads, clean clamps, or the output's gain differs from the rig file"
    return RigCheck("outside_resistance_ohm", ok, outside, "ohm", advice)
