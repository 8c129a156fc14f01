"""Checks of the two input channels: alive, zero, quiet, the right way round, fine enough."""

from __future__ import annotations

import math

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.experiment._doctor.evidence import NO_CURRENT, Channel, Examined, Outcome, noise_v
from musclewire.judge import judge_readings

# An offset may be this fraction of the reading at the sense voltage: it shifts resistance by the same fraction there.
OFFSET_FRACTION = 0.01
NOISE_FRACTION = 0.01  # noise over the same reading; strain then scatters by about a fifth of a percent
JUDGED_S = 0.05  # [s] over which noise is averaged: no wire moves in less, and a faster rig is not worse for its noise
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


def finite(seen: Examined) -> Outcome:
    """Check that every reading is a number."""
    return Outcome(seen.lost == 0, float(seen.lost))


def measurements(seen: Examined) -> Outcome:
    """Check that no reading is an overload mark or at an end of a range, by the table that recordings are judged by."""
    names = ("drive_voltage_v", "wire_voltage_v", "shunt_voltage_v")
    columns = {name: np.concatenate([getattr(level, name) for level in seen.levels] or [np.zeros(1)]) for name in names}
    stated = {
        "shunt_resistance_ohm": seen.limits.shunt_resistance_ohm,
        "wire_voltage_range_v": seen.limits.wire_range_v,
        "shunt_voltage_range_v": seen.limits.shunt_range_v,
    }
    # Without a drive the numbers are right: only no resistance follows from them.
    found = [item for item in judge_readings(columns, stated).found if not item.is_real]
    count = float(np.any([item.rows for item in found], axis=0).sum()) if found else 0.0
    return Outcome(not found, count, {"why": "; ".join(item.why for item in found)})


def offset(name: str, seen: Examined) -> Outcome:
    """Check one channel at 0 V against what it reads at the sense voltage."""
    channel = seen.channels[name]
    zero_v = channel.zero_v
    offset_v = float(zero_v.mean())
    # A channel that does not follow the drive can only be compared with the sense voltage itself.
    reading_v = channel.at_sense_v if seen.carries else seen.rig.sense_voltage_v
    error_v = SIGMAS * float(zero_v.std()) / math.sqrt(len(zero_v))
    ok = abs(offset_v) <= OFFSET_FRACTION * reading_v + error_v
    return Outcome(ok, offset_v, {"pct": 100 * (abs(offset_v) / reading_v)})


def calmer(seen: Examined) -> float:
    """Return by which factor noise falls in a mean over 50 ms, or a sample if it is longer."""
    return math.sqrt(min(1.0, seen.rig.sample_period_s / JUDGED_S))


def noise(name: str, seen: Examined) -> Outcome:
    """Check the noise of one channel against its reading at the sense voltage."""
    rms_v = noise_v(seen.channels[name].zero_v)
    fraction = rms_v * calmer(seen) / seen.channels[name].at_sense_v
    return Outcome(fraction <= NOISE_FRACTION, rms_v, {"pct": 100 * fraction})


def bits(seen: Examined) -> Outcome:
    """Check the resolution of the sense voltage on the poorer channel, by converter steps and noise."""
    found = min(bits_of(seen.channels[name]) for name in ("wire", "shunt"))
    return Outcome(found >= MIN_BITS, found)


def bits_of(channel: Channel) -> float:
    """Return the effective bits of a channel's reading at the sense voltage."""
    steps_v = np.diff(np.unique(channel.readings_v))
    # Sums of many readings differ in their last bit, which is no step of a converter.
    steps_v = steps_v[steps_v > 1e-9]
    step_v = max(noise_v(channel.zero_v) * math.sqrt(12.0), float(steps_v.min()) if steps_v.size else 0.0)
    return math.log2(max(channel.at_sense_v / step_v, 1.0))


def strain_noise(seen: Examined) -> Outcome:
    """Check the strain that corresponds to the noise of the resistance at the sense voltage."""
    resistance_ohm = seen.resistance_at_sense_ohm
    relative = calmer(seen) * noise_v(resistance_ohm) / abs(float(resistance_ohm.mean()))
    strain = relative * STRAIN_PER_RELATIVE_RESISTANCE
    return Outcome(strain <= STRAIN_NOISE_BAR, strain, {"pct": 100 * relative, "strain_pct": 100 * strain})


def alive(name: str, seen: Examined) -> Outcome:
    """Check that the readings of a channel change."""
    values = seen.channels[name].readings_v
    return Outcome(bool(np.any(values != values[0])), float(len(np.unique(values))))


def polarity(name: str, seen: Examined) -> Outcome:
    """Check that a channel does not fall when the drive rises."""
    channel = seen.channels[name]
    falls = channel.moves and channel.slope < 0.0
    return Outcome(not falls, channel.slope, {"name": name}, "" if channel.moves else "still")


def in_range(seen: Examined) -> Outcome:
    """Check that no channel reads more than the output voltage."""
    worst = 0.0
    for level in seen.low:
        room = BEYOND * max(level.commanded_v, 0.5 * seen.rig.sense_voltage_v)
        for readings in (level.wire_voltage_v, level.shunt_voltage_v):
            worst = max(worst, abs(float(np.median(readings))) / room)
    return Outcome(worst <= 1.0, worst)


def hum(seen: Examined) -> Outcome | str:
    """Check for mains hum on the shunt's channel at 0 V, if the sample rate can show it."""
    rate_hz = 1.0 / seen.rig.sample_period_s
    if rate_hz < HUM_RATE_HZ:
        return (
            f"{rate_hz:g} samples a second cannot show 50 Hz; averaging over whole mains periods (20 ms or 16.7 ms) "
            "takes it out"
        )
    if not seen.carries:
        return NO_CURRENT
    shunt = seen.channels["shunt"]
    found = {hertz: tone_rms_v(seen.low[0].time_s, shunt.zero_v - shunt.zero_v.mean(), hertz) for hertz in HUMS_HZ}
    hertz = max(found, key=lambda one: found[one])
    fraction = found[hertz] / shunt.at_sense_v
    return Outcome(fraction <= NOISE_FRACTION, found[hertz], {"hertz": hertz, "pct": 100 * fraction})


def tone_rms_v(time_s: FloatArray, readings_v: FloatArray, hertz: float) -> float:
    """Return the rms of one frequency in readings."""
    phase = 2.0 * math.pi * hertz * time_s
    amplitude = 2.0 * abs(complex(np.mean(readings_v * np.exp(-1j * phase))))
    return amplitude / math.sqrt(2.0)
