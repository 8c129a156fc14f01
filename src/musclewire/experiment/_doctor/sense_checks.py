"""Checks of what a rig states, at its sense voltage and over time: warming, clock, protection."""

from __future__ import annotations

import numpy as np

from musclewire.experiment._doctor.evidence import Examined, Outcome
from musclewire.parameters import load_alloy
from musclewire.rigs import ProtectionTripError
from musclewire.wire import HeatBalance

# The sense voltage must not heat the wire by more.
MAX_RISE_K = 8.0
DRIFT_FRACTION = 0.005  # allowed drift of resistance while the sense voltage is held, beyond its uncertainty
SIGMAS = 4.0  # standard errors of the drift: its uncertainty
PERIOD_FRACTION = 1e-3  # allowed deviation of the usual step from the stated sample period
RATE_FRACTION = 0.02  # allowed deviation of the rate of the rig's clock from the host's
LATE_FRACTION = 0.5  # allowed jitter of the arrival of samples, in sample periods
STEP_FRACTION = 0.5  # of the sample period: a step that deviates by more is irregular
OFF_FRACTION = 0.01  # of the steps may be irregular


def identity(seen: Examined) -> Outcome:
    """Check that the rig identifies itself and its voltages are consistent."""
    rig, metadata = seen.rig, seen.metadata
    said = f"{metadata.get('rig', 'rig')}, wire {metadata.get('wire', 'not named')}"
    if "firmware_wire" in metadata:
        said += f"; the board's firmware is built for {metadata['firmware_wire']}"
    numbers = {
        "sense_v": rig.sense_voltage_v,
        "maximum_v": rig.maximum_voltage_v,
        "shunt_ohm": rig.shunt_resistance_ohm,
        "period_s": rig.sample_period_s,
    }
    return Outcome(rig.sense_voltage_v < rig.maximum_voltage_v and min(numbers.values()) > 0.0, said, numbers)


def protection(seen: Examined) -> Outcome:
    """Say with which limits the protection is armed."""
    limits = seen.limits
    said = (
        f"armed: {limits.maximum_current_a:.3g} A, {limits.maximum_power_w:.3g} W, "
        f"{limits.resistance_low_ohm:.3g} to {limits.resistance_high_ohm:.3g} ohm, "
        f"{limits.maximum_temperature_k - 273.15:.0f} C estimated, at most {limits.maximum_voltage_v:.3g} V"
    )
    return Outcome(True, said)


def warming(seen: Examined) -> Outcome | str:
    """Check the temperature that the wire file gives for the sense voltage."""
    level, wire = seen.levels[-1], seen.wire
    if wire is None or seen.length_m is None:
        return "the rig names no wire that is known, or no length"
    power_w = float(np.mean(level.wire_voltage_v * level.shunt_voltage_v)) / seen.rig.shunt_resistance_ohm
    ambient_k, factor = seen.limits.ambient_temperature_k, wire["convection_factor"]
    heat = HeatBalance.of_wire(load_alloy(wire.alloy), wire["diameter_m"], seen.length_m, ambient_k, factor)
    rise_k = heat.steady_k(max(power_w, 0.0)) - ambient_k
    return Outcome(rise_k <= MAX_RISE_K, rise_k, {"power_mw": 1e3 * power_w})


def drift(seen: Examined) -> Outcome:
    """Check that resistance is constant while the sense voltage is held: first third against last."""
    resistance = seen.resistance_at_sense_ohm
    third = len(resistance) // 3
    found = float(resistance[-third:].mean() / resistance[:third].mean() - 1.0)
    error = SIGMAS * float(np.std(resistance) / abs(resistance.mean())) * (2.0 / third) ** 0.5
    return Outcome(abs(found) <= DRIFT_FRACTION + error, found)


def kept_going(seen: Examined) -> Outcome:
    """Check that the rig kept going: a trip of its protection names the cause better than any check here."""
    trouble = seen.probe.trouble
    cause = trouble.event.name.lower() if isinstance(trouble, ProtectionTripError) else "rig fault"
    return Outcome(trouble is None, "yes" if trouble is None else cause, {"trouble": str(trouble)})


def sample_period(seen: Examined) -> Outcome:
    """Check the steps of the sample clock."""
    steps, stated_s = np.concatenate([np.diff(level.time_s) for level in seen.timed]), seen.rig.sample_period_s
    usual = float(np.median(steps))
    off = float(np.mean(np.abs(steps / stated_s - 1.0) > STEP_FRACTION))
    ok = bool(np.all(steps > 0.0)) and abs(usual / stated_s - 1.0) <= PERIOD_FRACTION and off <= OFF_FRACTION
    return Outcome(ok, usual, {"stated_s": stated_s, "off_pct": 100 * off}, "uneven" if off > 0.0 else "holds")


def clock_rate(seen: Examined) -> Outcome:
    """Check the rig's clock against the host's."""
    level = seen.timed[-1]
    rate = float((level.host_s[-1] - level.host_s[0]) / (level.time_s[-1] - level.time_s[0]))
    return Outcome(abs(rate - 1.0) <= RATE_FRACTION, rate)


def arrival_jitter(seen: Examined) -> Outcome:
    """Check how evenly samples arrive by the host's clock."""
    late_s = seen.timed[-1].host_s - seen.timed[-1].time_s
    jitter_s = float(np.percentile(np.abs(late_s - np.median(late_s)), 99.0))
    return Outcome(jitter_s <= LATE_FRACTION * seen.rig.sample_period_s, jitter_s)
