"""Checks at the sense voltage and over time: warming, clock, protection."""

from __future__ import annotations

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.controllers import ProtectionLimits
from musclewire.experiment._doctor.evidence import Evidence, Findings, RigCheck, SkippedCheck, VoltageLevel
from musclewire.parameters import Wire, load_alloy
from musclewire.wire import HeatBalance

# The sense voltage must not heat the wire by more.
MAX_RISE_K = 8.0
# Allowed drift of resistance while the sense voltage is held.
DRIFT_FRACTION, SIGMAS = 0.005, 4.0
PERIOD_FRACTION, RATE_FRACTION, LATE_FRACTION = 1e-3, 0.02, 0.5
# A step that deviates by this fraction is irregular; one step in a hundred may be.
STEP_FRACTION, OFF_FRACTION = 0.5, 0.01


def warmth_findings(
    evidence: Evidence, at_sense: VoltageLevel | None, wire: Wire | None, length_m: float | None, ambient_k: float
) -> Findings:
    """Return the effect of the sense voltage on the wire: measured drift and computed temperature."""
    if at_sense is None:
        why = "the sense voltage was not applied"
        return Findings((), (SkippedCheck("sense_drift", why), SkippedCheck("sense_warming_k", why)))
    drift = drift_check(evidence, at_sense)
    if wire is None or length_m is None:
        return Findings(
            (drift,), (SkippedCheck("sense_warming_k", "the rig names no wire that is known, or no length"),)
        )
    power_w = float(np.mean(at_sense.wire_voltage_v * at_sense.shunt_voltage_v)) / evidence.shunt_resistance_ohm
    alloy, factor = load_alloy(wire.alloy), wire["convection_factor"]
    heat = HeatBalance.of_wire(alloy, wire["diameter_m"], length_m, ambient_k, factor)
    rise = heat.steady_k(max(power_w, 0.0)) - ambient_k
    ok = rise <= MAX_RISE_K
    advice = f"by {1e3 * power_w:.2g} mW in still air, computed from the wire file, not measured"
    if not ok:
        advice += ": the sense voltage heats; lower it"
    return Findings((drift, RigCheck("sense_warming_k", ok, rise, "K", advice)))


def drift_check(evidence: Evidence, at_sense: VoltageLevel) -> RigCheck:
    """Check that resistance is constant while the sense voltage is held: first third against last."""
    resistance = (
        evidence.shunt_resistance_ohm
        * (at_sense.wire_voltage_v - evidence.wire.offset_v)
        / (at_sense.shunt_voltage_v - evidence.shunt.offset_v)
    )
    third = len(resistance) // 3
    first, last = resistance[:third], resistance[-third:]
    drift = float(last.mean() / first.mean() - 1.0)
    error = SIGMAS * float(np.std(resistance) / abs(resistance.mean())) * (2.0 / third) ** 0.5
    ok = abs(drift) <= DRIFT_FRACTION + error
    advice = "change of resistance while the sense voltage was held"
    if not ok:
        advice += (
            ": the wire is still cooling from before, a contact moves, or the sense voltage heats: wait and try again"
        )
    return RigCheck("sense_drift", ok, drift, "1", advice)


def clock_findings(levels: tuple[VoltageLevel, ...], sample_period_s: float, paced: bool) -> Findings:
    """Return the checks of the sample clock: its steps and, if it is a real clock, its rate against the host's."""
    steps = np.concatenate([np.diff(level.time_s) for level in levels])
    usual = float(np.median(steps))
    off = float(np.mean(np.abs(steps / sample_period_s - 1.0) > STEP_FRACTION))
    ok = bool(np.all(steps > 0.0)) and abs(usual / sample_period_s - 1.0) <= PERIOD_FRACTION and off <= OFF_FRACTION
    advice = f"usual step of the sample clock; the rig states {sample_period_s:g} s"
    if off > 0.0:
        advice += f"; {100 * off:.2g} % of the steps differ: samples lost or late, reduce the load on the machine"
    period = RigCheck("sample_period_s", ok, usual, "s", advice)
    if not paced:
        reason = "this rig does not run by a real clock"
        return Findings((period,), tuple(SkippedCheck(name, reason) for name in ("clock_rate", "arrival_jitter_s")))
    return Findings((period, *host_checks(levels[-1], sample_period_s)))


def host_checks(level: VoltageLevel, sample_period_s: float) -> tuple[RigCheck, RigCheck]:
    """Check the rig's clock against the host's, and how evenly samples arrive."""
    span = level.time_s[-1] - level.time_s[0]
    rate = float((level.host_s[-1] - level.host_s[0]) / span)
    late: FloatArray = level.host_s - level.time_s
    late = late - np.median(late)
    jitter = float(np.percentile(np.abs(late), 99.0))
    right = abs(rate - 1.0) <= RATE_FRACTION
    even = jitter <= LATE_FRACTION * sample_period_s
    off_pace = "" if right else ": the samples do not keep the period that the rig file states"
    uneven = "" if even else ": reduce the load on the machine, or choose a longer sample period"
    return (
        RigCheck("clock_rate", right, rate, "s/s", f"the host's seconds for each second of the rig{off_pace}"),
        RigCheck("arrival_jitter_s", even, jitter, "s", f"99 of 100 samples arrive this evenly{uneven}"),
    )


def protection_findings(limits: ProtectionLimits) -> Findings:
    """Return whether the protection is armed, with its limits."""
    said = (
        f"armed: {limits.maximum_current_a:.3g} A, {limits.maximum_power_w:.3g} W, "
        f"{limits.resistance_low_ohm:.3g} to {limits.resistance_high_ohm:.3g} ohm, "
        f"{limits.maximum_temperature_k - 273.15:.0f} C estimated, at most {limits.maximum_voltage_v:.3g} V"
    )
    advice = (
        "these limits detect faults and are not what the wire may carry: set the supply's own "
        "current limit by musclewire simulate (one and a half times the one-second current, or at most the lasting "
        "current if unattended)"
    )
    return Findings((RigCheck("protection", True, said, "", advice),))
