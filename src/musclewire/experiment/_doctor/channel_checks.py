"""Checks of the two input channels: alive, zero, quiet, the right way round, fine enough."""

from __future__ import annotations

import math

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.controllers import ProtectionLimits
from musclewire.experiment._doctor.evidence import (
    Evidence,
    Findings,
    LinearFit,
    RigCheck,
    SkippedCheck,
    VoltageLevel,
    noise_v,
)
from musclewire.signals import judge_readings

# An offset may be this fraction of the reading at the sense voltage: it shifts resistance by the same fraction there.
OFFSET_FRACTION = 0.01
# Noise may be this fraction of it; resistance then scatters by about a fifth of a percent of strain. Judged as the mean
# over 50 ms: no wire moves in less, and a rig that samples faster is not worse for it.
NOISE_FRACTION, JUDGED_S = 0.01, 0.05
# Uncertainty of a mean, in standard errors.
SIGMAS = 4.0
# Lan and Fan 2010, Table 2 and section III: 16.737 ohm at 1.506 %, 15.577 ohm at 3.034 %, R_max 17.4945 ohm. Strain per
# change of resistance, the latter as a fraction of R_max.
STRAIN_PER_RELATIVE_RESISTANCE = (0.03034 - 0.01506) / ((16.737 - 15.577) / 17.4945)
# Of a full stroke of about 4 %.
STRAIN_NOISE_BAR = 0.0025
MIN_BITS = 4.0
HUMS_HZ = (50.0, 60.0)
# A spectrum shows 60 Hz only from twice as many samples a second, with room for the filter of the converter.
HUM_RATE_HZ = 150.0
# A reading that exceeds the output by this factor cannot come from the wire.
BEYOND = 1.5


def finite_check(levels: tuple[VoltageLevel, ...]) -> RigCheck:
    """Check that every reading is a number."""
    lost = sum(
        int(np.count_nonzero(~np.isfinite(level.wire_voltage_v) | ~np.isfinite(level.shunt_voltage_v)))
        for level in levels
    )
    return RigCheck(
        "readings_are_numbers",
        lost == 0,
        float(lost),
        "samples",
        "every sample is a number" if not lost else "samples without a number: check the device, its driver and cable",
    )


def measurements_check(levels: list[VoltageLevel], limits: ProtectionLimits) -> RigCheck:
    """Check that no reading is an overload mark or at an end of a range, by the table that recordings are judged by."""
    names = ("drive_voltage_v", "wire_voltage_v", "shunt_voltage_v")
    columns = {name: np.concatenate([getattr(level, name) for level in levels] or [np.zeros(1)]) for name in names}
    stated = {
        "shunt_resistance_ohm": limits.shunt_resistance_ohm,
        "wire_voltage_range_v": limits.wire_range_v,
        "shunt_voltage_range_v": limits.shunt_range_v,
    }
    # Without a drive the numbers are right: only no resistance follows from them.
    found = [item for item in judge_readings(columns, stated).found if not item.is_real]
    count = float(np.any([item.rows for item in found], axis=0).sum()) if found else 0.0
    advice = "; ".join(item.why for item in found) or "no reading is an overload mark or stays at an end of a range"
    return RigCheck("readings_are_measurements", not found, count, "samples", advice)


def offset_checks(evidence: Evidence) -> Findings:
    """Check what each channel reads at 0 V."""
    pairs = (
        ("wire_offset_v", evidence.zero.wire_voltage_v, evidence.wire_at_sense_v),
        ("shunt_offset_v", evidence.zero.shunt_voltage_v, evidence.shunt_at_sense_v),
    )
    return Findings(tuple(offset_check(name, zero_v, reading_v, evidence) for name, zero_v, reading_v in pairs))


def offset_check(name: str, zero_v: FloatArray, at_sense_v: float, evidence: Evidence) -> RigCheck:
    """Check one channel at 0 V against what it reads at the sense voltage."""
    offset = float(zero_v.mean())
    # A channel that does not follow the drive can only be compared with the sense voltage itself.
    reading = at_sense_v if evidence.carries else evidence.sense_voltage_v
    error = SIGMAS * float(zero_v.std()) / math.sqrt(len(zero_v))
    fraction = abs(offset) / reading
    ok = abs(offset) <= OFFSET_FRACTION * reading + error
    advice = f"{100 * fraction:.2g} % of the reading at the sense voltage"
    if not ok:
        advice += (
            ": write it into the rig file ('musclewire doctor RIG --write'), or a shunt with more ohm and a smaller "
            "input range"
        )
    return RigCheck(name, ok, offset, "V", advice)


def quiet_checks(evidence: Evidence, at_sense: VoltageLevel | None, sample_period_s: float) -> Findings:
    """Check the noise of both channels, and the resulting noise of resistance and strain at the sense voltage."""
    zero = evidence.zero
    wire_v, shunt_v = noise_v(zero.wire_voltage_v), noise_v(zero.shunt_voltage_v)
    if not evidence.carries:
        names = ("wire_noise_v", "shunt_noise_v", "resistance_noise_strain", "resolution_bits")
        return Findings((), tuple(SkippedCheck(name, "no current follows the drive") for name in names))
    calmer = math.sqrt(min(1.0, sample_period_s / JUDGED_S))
    checks = [
        noise_check("wire_noise_v", wire_v, evidence.wire_at_sense_v, calmer),
        noise_check("shunt_noise_v", shunt_v, evidence.shunt_at_sense_v, calmer),
        bits_check(evidence, wire_v, shunt_v),
    ]
    if at_sense is None:
        return Findings(tuple(checks), (SkippedCheck("resistance_noise_strain", "the sense voltage was not applied"),))
    return Findings((*checks, strain_noise_check(at_sense, evidence, calmer)))


def noise_check(name: str, rms_v: float, at_sense_v: float, calmer: float) -> RigCheck:
    """Check the noise of one channel against its reading at the sense voltage; ``calmer``: factor of averaging."""
    fraction = rms_v * calmer / at_sense_v
    ok = fraction <= NOISE_FRACTION
    advice = (
        f"rms of a sample; {100 * fraction:.2g} % of the reading at the sense voltage in a mean over 50 ms or a sample"
    )
    if not ok:
        advice += ": twist the pair, shield it, average more readings, a smaller input range, or a larger shunt"
    return RigCheck(name, ok, rms_v, "V", advice)


def bits_check(evidence: Evidence, wire_noise_v: float, shunt_noise_v: float) -> RigCheck:
    """Check the resolution of the sense voltage on the poorer channel, by converter steps and noise."""
    pairs = (
        (evidence.wire_at_sense_v, wire_noise_v, evidence.levels, "wire_voltage_v"),
        (evidence.shunt_at_sense_v, shunt_noise_v, evidence.levels, "shunt_voltage_v"),
    )
    bits = min(
        math.log2(max(reading_v / max(rms_v * math.sqrt(12.0), min_step_v(levels, name)), 1.0))
        for reading_v, rms_v, levels, name in pairs
    )
    ok = bits >= MIN_BITS
    advice = "effective bits of the poorer channel at the sense voltage, from its noise and its smallest step"
    if not ok:
        advice += ": use a smaller input range, an amplifier, a larger shunt, or more readings in a sample"
    return RigCheck("resolution_bits", ok, bits, "bit", advice)


def min_step_v(levels: tuple[VoltageLevel, ...], name: str) -> float:
    """Return the smallest difference between two distinct readings of a channel."""
    steps = np.diff(np.unique(np.concatenate([getattr(level, name) for level in levels])))
    # Sums of many readings differ in their last bit, which is no step of a converter.
    steps = steps[steps > 1e-9]
    return float(steps.min()) if steps.size else 0.0


def strain_noise_check(at_sense: VoltageLevel, evidence: Evidence, calmer: float) -> RigCheck:
    """Check the strain that corresponds to the noise of the resistance at the sense voltage."""
    resistance = (at_sense.wire_voltage_v - evidence.wire.offset_v) / (
        at_sense.shunt_voltage_v - evidence.shunt.offset_v
    )
    relative = calmer * noise_v(resistance) / abs(float(resistance.mean()))
    strain = relative * STRAIN_PER_RELATIVE_RESISTANCE
    ok = strain <= STRAIN_NOISE_BAR
    advice = (
        f"{100 * relative:.2g} % of the resistance, {100 * strain:.2g} % of strain at the sense voltage, in a mean "
        "over 50 ms or a sample; it falls as the current grows"
    )
    if not ok:
        advice += ". Too much: see the noise of the channels, or a higher sense voltage"
    return RigCheck("resistance_noise_strain", ok, strain, "1", advice)


def moving_checks(evidence: Evidence) -> Findings:
    """Check that the readings of both channels change, and rise with the drive."""
    checks = []
    for name, line in (("wire", evidence.wire), ("shunt", evidence.shunt)):
        values = np.concatenate([getattr(level, f"{name}_voltage_v") for level in evidence.levels])
        alive = bool(np.any(values != values[0]))
        checks.append(
            RigCheck(
                f"{name}_channel_alive",
                alive,
                float(len(np.unique(values))),
                "different readings",
                "the readings change"
                if alive
                else "the same reading at every voltage: the channel is frozen, saturated or not connected",
            )
        )
        checks.append(polarity_check(name, line))
    return Findings(tuple(checks))


def polarity_check(name: str, line: LinearFit) -> RigCheck:
    """Check that a channel does not fall when the drive rises."""
    reversed_pair = line.moves and line.slope < 0.0
    advice = "rises with the drive" if line.moves else "does not follow the drive; see the current"
    if reversed_pair:
        advice = f"falls when the drive rises: exchange the two leads of the {name}'s pair"
    return RigCheck(f"{name}_polarity", not reversed_pair, line.slope, "V/V", advice)


def range_check(evidence: Evidence) -> RigCheck:
    """Check that no channel reads more than the output voltage."""
    worst = 0.0
    for level in evidence.levels:
        room = BEYOND * max(level.commanded_v, 0.5 * evidence.sense_voltage_v)
        for readings in (level.wire_voltage_v, level.shunt_voltage_v):
            worst = max(worst, abs(float(np.median(readings))) / room)
    ok = worst <= 1.0
    return RigCheck(
        "readings_in_range",
        ok,
        worst,
        "1",
        "no reading exceeds the output"
        if ok
        else "a channel reads more than is applied: an open input, a saturated channel, a wrong range or gain, or an "
        "output that exceeds its command",
    )


def hum_check(evidence: Evidence, sample_period_s: float) -> Findings:
    """Check for mains hum on the shunt's channel at 0 V, if the sample rate can show it."""
    if 1.0 / sample_period_s < HUM_RATE_HZ:
        reason = (
            f"{1.0 / sample_period_s:g} samples a second cannot show 50 Hz; averaging over whole mains periods "
            "(20 ms or 16.7 ms) takes it out"
        )
        return Findings((), (SkippedCheck("mains_hum_v", reason),))
    if not evidence.carries:
        return Findings((), (SkippedCheck("mains_hum_v", "no current follows the drive"),))
    readings = evidence.zero.shunt_voltage_v - evidence.zero.shunt_voltage_v.mean()
    times = evidence.zero.time_s
    found = {hertz: tone_rms_v(times, readings, hertz) for hertz in HUMS_HZ}
    hertz = max(found, key=lambda one: found[one])
    fraction = found[hertz] / evidence.shunt_at_sense_v
    ok = fraction <= NOISE_FRACTION
    advice = f"at {hertz:g} Hz, {100 * fraction:.2g} % of the shunt's reading at the sense voltage"
    if not ok:
        advice += ": twist and shield the pairs, one ground point, or average over whole mains periods"
    return Findings((RigCheck("mains_hum_v", ok, found[hertz], "V", advice),))


def tone_rms_v(time_s: FloatArray, readings_v: FloatArray, hertz: float) -> float:
    """Return the rms of one frequency in readings."""
    phase = 2.0 * math.pi * hertz * time_s
    amplitude = 2.0 * abs(complex(np.mean(readings_v * np.exp(-1j * phase))))
    return amplitude / math.sqrt(2.0)
