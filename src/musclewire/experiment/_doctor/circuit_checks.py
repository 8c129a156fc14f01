"""Checks of the circuit: current, the wire that the rig file names, and an output that follows its command."""

from __future__ import annotations

import math

from musclewire.experiment._doctor.evidence import Examined, Outcome

# Eq. 1 treats less than 1 mA as no current; a sense current must be twice that.
MIN_SENSE_CURRENT_A = 2e-3
# Spools, length measured by a ruler, pretension and the R-phase: the right wire is this close to the catalogue's value.
RESISTANCE_FRACTION = 0.15
# Voltage of the shunt over that of the wire.
MIN_SHUNT_FRACTION = 0.001  # with less it is hard to read
MAX_SHUNT_FRACTION = 0.3  # with more it wastes the drive and warms up
# Allowed deviation of the output from its command.
GAIN_FRACTION = 0.1  # of its change, over that of the command
OUTPUT_OFFSET_FRACTION = 0.1  # of the sense voltage, when 0 V is ordered
# Leads, clamps, switch and amplifier between the output and the measured voltages, as a fraction of the wire's
# resistance.
OUTSIDE_FRACTION = 0.05
# Shunts are usually confused with neighbours in the standard series of values.
USUAL_FACTORS = (0.001, 0.01, 0.1, 0.22, 0.47, 1 / 2.2, 2.2, 4.7, 10.0, 100.0, 1000.0)
NAMED_WITHIN = 0.12


def output_at_zero(seen: Examined) -> Outcome | None:
    """Check that the output is off at 0 V: a stuck one heats, and is the only finding of too few readings."""
    low, sense_v = seen.low[0], seen.rig.sense_voltage_v
    volts = float((low.wire_voltage_v + low.shunt_voltage_v).mean())
    if seen.has_fits:
        return Outcome(abs(volts) <= OUTPUT_OFFSET_FRACTION * sense_v, volts)
    return Outcome(False, volts, said="stuck") if abs(volts) > sense_v else None


def output_gain(seen: Examined) -> Outcome:
    """Check that the voltage at wire and shunt follows the command, or is what something else has shown to arrive."""
    gain = abs(seen.channels["wire"].slope) + abs(seen.channels["shunt"].slope)
    if seen.arriving is not None:
        least, largest, by = seen.arriving
        ok = least <= gain <= largest
        return Outcome(ok, gain, {"by": by, "least": least, "largest": largest}, "arrives" if ok else "other_arrives")
    ends = {"none": 0.5, "few": 1.0 - GAIN_FRACTION, "holds": 1.0 + GAIN_FRACTION}
    said = next((name for name, end in ends.items() if gain < end), "many")
    return Outcome(abs(gain - 1.0) <= GAIN_FRACTION, gain, said=said)


def current(seen: Examined) -> Outcome:
    """Check that enough current flows at the sense voltage to measure resistance."""
    wire, shunt, rig = seen.channels["wire"], seen.channels["shunt"], seen.rig
    found_a = abs(shunt.slope * rig.sense_voltage_v / rig.shunt_resistance_ohm) if shunt.moves else 0.0
    said = "low" if found_a > 0.0 else "open" if wire.moves else "none"
    ok = found_a >= MIN_SENSE_CURRENT_A
    return Outcome(ok, found_a, {"least_ma": 1e3 * MIN_SENSE_CURRENT_A}, "" if ok else said)


def channels_in_place(seen: Examined) -> Outcome | str:
    """Check that wire and shunt channels are not swapped, if their resistances differ enough to decide."""
    measured, shunt, right = abs(seen.resistance_ohm), seen.rig.shunt_resistance_ohm, seen.right_ohm
    if right is None:
        return seen.why_unknown
    if abs(math.log(right / shunt)) < math.log(1.5):
        return f"wire ({right:.3g} ohm) and shunt ({shunt:.3g} ohm) are too similar to tell them apart"
    # Swapped channels would read shunt^2 / wire.
    as_is, other_way = abs(math.log(measured / right)), abs(math.log(shunt * shunt / right / measured))
    return Outcome(as_is <= other_way, measured)


def resistance(seen: Examined) -> Outcome | str:
    """Check the wire's resistance against that of a cold wire of its length, and name a likely cause."""
    if seen.right_ohm is None:
        return seen.why_unknown
    ratio, shunt_ohm = seen.resistance_ohm / seen.right_ohm, seen.rig.shunt_resistance_ohm
    ok = abs(ratio - 1.0) <= RESISTANCE_FRACTION
    other = next((one for one in USUAL_FACTORS if abs(ratio * one - 1.0) < NAMED_WITHIN), None)
    numbers = {"right": seen.right_ohm, "shunt": shunt_ohm, "other": (other or 0.0) * shunt_ohm}
    causes = {
        "reversed": ratio < 0.0,
        "other_shunt": other is not None,
        "bridged": ratio < 0.2,
        "small": ratio < 1.0,
        "two_wire": ratio < 2.0 and seen.channels["circuit"].slope > 1.0 - OUTSIDE_FRACTION,
        "large": True,
    }
    likely = next(name for name, there in causes.items() if there)
    return Outcome(ok, seen.resistance_ohm, numbers, "" if ok else likely)


def resistance_in_window(seen: Examined) -> Outcome:
    """Check the wire's resistance against the protection's window."""
    low, high = seen.limits.resistance_low_ohm, seen.limits.resistance_high_ohm
    return Outcome(low <= seen.resistance_ohm <= high, seen.resistance_ohm, {"low": low, "high": high})


def shunt_share(seen: Examined) -> Outcome:
    """Check that the shunt's voltage is large enough to read and small enough not to waste the drive."""
    fraction = abs(seen.channels["shunt"].slope / seen.channels["wire"].slope)
    ok = MIN_SHUNT_FRACTION <= fraction <= MAX_SHUNT_FRACTION
    return Outcome(ok, fraction, said="large" if fraction > MAX_SHUNT_FRACTION else "")


def outside(seen: Examined) -> Outcome:
    """Check the resistance between the output and the measured voltages: leads, clamps, switch, amplifier."""
    wire, shunt = (abs(seen.channels[name].slope) for name in ("wire", "shunt"))
    found_ohm = seen.rig.shunt_resistance_ohm * (1.0 - wire - shunt) / shunt
    return Outcome(found_ohm <= OUTSIDE_FRACTION * abs(seen.resistance_ohm), found_ohm)
