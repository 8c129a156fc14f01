"""The examination: levels below the sense voltage first, and only if they pass the sense voltage itself.

A check is a row of the tables here, with its words in judge/data/remedies.toml.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from musclewire.errors import CallerError, RigError
from musclewire.experiment._doctor import channel_checks, circuit_checks, rig_file, sense_checks
from musclewire.experiment._doctor.evidence import (
    LOW_FRACTIONS,
    NO_CURRENT,
    Examined,
    Findings,
    Outcome,
    RigCheck,
    SkippedCheck,
    VoltageProbe,
)
from musclewire.judge import remedies
from musclewire.rigs import Metadata, Rig
from musclewire.signals import RawSample

# How long each level is held [s]; chosen: a longer hold averages more noise and makes the examination longer.
ZERO_S = 2.0
LOW_S = 1.0
SENSE_S = 5.0  # the longest, as the drift of the resistance is seen in it
# Why a check is skipped that needs what is not there; "" for one that is left out.
WITHOUT = {
    "low": "",
    "has_zero": "",
    "has_fits": "",
    "timed": "",
    "carries": NO_CURRENT,
    "at_sense": "the sense voltage was not applied",
    "paced": "this rig does not run by a real clock",
}
FITS = ("has_fits",)
CURRENT = (*FITS, "carries")
SENSE = (*FITS, "at_sense")


class CheckRow(NamedTuple):
    """A check: its name, the unit of its value, what looks, where its words are, what it needs of ``Examined``."""

    name: str
    unit: str
    look: Callable[[Examined], Outcome | str | None]
    words: str
    needs: tuple[str, ...] = ()
    stops: bool = False  # if it fails, the wiring is not what the rig file says and the sense voltage is not applied

    def looked(self, seen: Examined) -> RigCheck | SkippedCheck | None:
        """Return what the check finds, or why it is skipped; None if there is nothing to say."""
        missing = next((one for one in self.needs if not getattr(seen, one)), None)
        found = self.look(seen) if missing is None else WITHOUT[missing] or None
        if not isinstance(found, Outcome):
            return None if found is None else SkippedCheck(self.name, found)
        words: Any = remedies("rig")[self.words]
        said, numbers = words.get(found.said or ("holds" if found.ok else "fails"), words["holds"]), found.numbers
        advice = said.format(holds=words["holds"].format(**numbers), **numbers)
        return RigCheck(self.name, found.ok, found.value, self.unit, advice)


def why_not_judged(seen: Examined) -> str | None:
    """Return why the wiring cannot be judged; None if it can."""
    why = "too few valid samples" if seen.low else "the rig gave no sample at all"
    return None if seen.has_fits else why


# Checks below the sense voltage.
BELOW = (
    CheckRow("identity", "", sense_checks.identity, "identity"),
    CheckRow("protection", "", sense_checks.protection, "protection"),
    CheckRow("readings_are_numbers", "samples", channel_checks.finite, "finite", ("low",), True),
    CheckRow("wiring", "", why_not_judged, ""),
    CheckRow("readings_in_range", "1", channel_checks.in_range, "in_range", FITS, True),
    CheckRow("wire_channel_alive", "different readings", partial(channel_checks.alive, "wire"), "alive", FITS, True),
    CheckRow("wire_polarity", "V/V", partial(channel_checks.polarity, "wire"), "polarity", FITS, True),
    CheckRow("shunt_channel_alive", "different readings", partial(channel_checks.alive, "shunt"), "alive", FITS, True),
    CheckRow("shunt_polarity", "V/V", partial(channel_checks.polarity, "shunt"), "polarity", FITS, True),
    CheckRow("output_at_zero_v", "V", circuit_checks.output_at_zero, "at_zero", ("has_zero",), True),
    CheckRow("output_gain", "V/V", circuit_checks.output_gain, "gain", FITS, True),
    CheckRow("sense_current_a", "A", circuit_checks.current, "current", FITS, True),
    CheckRow("shunt_share", "1", circuit_checks.shunt_share, "share", CURRENT),
    CheckRow("outside_resistance_ohm", "ohm", circuit_checks.outside, "outside", CURRENT),
    CheckRow("channels_in_place", "ohm", circuit_checks.channels_in_place, "in_place", CURRENT, True),
    CheckRow("wire_resistance_ohm", "ohm", circuit_checks.resistance, "resistance", CURRENT, True),
    CheckRow("resistance_in_window", "ohm", circuit_checks.resistance_in_window, "window", CURRENT, True),
    CheckRow("wire_offset_v", "V", partial(channel_checks.offset, "wire"), "offset", FITS),
    CheckRow("shunt_offset_v", "V", partial(channel_checks.offset, "shunt"), "offset", FITS),
)
# A check of the levels so far, and again of all of them.
LEVELS = CheckRow("readings_are_measurements", "samples", channel_checks.measurements, "measurements", (), True)
# Checks at the sense voltage, over time, and of noise.
LATER = (
    LEVELS,
    CheckRow("wire_noise_v", "V", partial(channel_checks.noise, "wire"), "noise", CURRENT),
    CheckRow("shunt_noise_v", "V", partial(channel_checks.noise, "shunt"), "noise", CURRENT),
    CheckRow("resolution_bits", "bit", channel_checks.bits, "bits", CURRENT),
    CheckRow("resistance_noise_strain", "1", channel_checks.strain_noise, "strain_noise", (*CURRENT, "at_sense")),
    CheckRow("mains_hum_v", "V", channel_checks.hum, "hum", FITS),
    CheckRow("sense_drift", "1", sense_checks.drift, "drift", SENSE),
    CheckRow("sense_warming_k", "K", sense_checks.warming, "warming", SENSE),
    CheckRow("rig_kept_going", "", sense_checks.kept_going, "kept_going"),
    CheckRow("sample_period_s", "s", sense_checks.sample_period, "period", ("timed",)),
    CheckRow("clock_rate", "s/s", sense_checks.clock_rate, "rate", ("timed", "paced")),
    CheckRow("arrival_jitter_s", "s", sense_checks.arrival_jitter, "jitter", ("timed", "paced")),
)
STOPPING = frozenset(row.name for row in (*BELOW, *LATER) if row.stops)


class Examination(NamedTuple):
    """Findings of the doctor, in the order in which they were made; ``trouble`` is the rig's own fault."""

    findings: Findings
    calibration: tuple[rig_file.ChannelCalibration, ...]
    metadata: Metadata
    highest_v: float
    trouble: RigError | None

    @property
    def ok(self) -> bool:
        """Whether every check that could be made holds and the rig had no fault."""
        return self.trouble is None and not self.findings.failed

    def write_calibration(self, path: Path) -> Path:
        """Write offsets and gains into a rig file. Raises the rig's own fault, or CallerError for wrong wiring."""
        blocking = sorted(self.findings.failed & STOPPING - {"wire_resistance_ohm", "output_gain"})
        if self.trouble is not None:
            raise self.trouble
        if blocking or not self.calibration:
            raise CallerError(f"nothing is written: {', '.join(blocking) or 'the readings'} must be corrected first")
        return rig_file.write_calibration(path, self.calibration)


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
    on_sample: Callable[[RawSample], None] | None = None,
) -> Examination:
    """Check a rig at its sense voltage and below; the rig ends at its sense voltage or off.

    The meters' readings, taken at the sense voltage, give the gains of the channels. A fault of the rig is a finding
    too: ``trouble``. Raises CallerError for a meter's reading that cannot belong to its channel.
    """
    probe = VoltageProbe(rig, clock, on_sample)
    seen = Examined(rig, probe)
    try:
        look_low(probe, rig)
        findings = checked(seen, BELOW)
        stopped = STOPPING & (findings + checked(seen, (LEVELS,))).failed
        if seen.has_fits and probe.trouble is None and not stopped:
            seen.at_sense = probe.hold(rig.sense_voltage_v, hold_s) is not None
        findings += checked(seen, LATER)
    finally:
        rig.make_safe()
    at_sense = probe.levels[-1] if seen.at_sense else None
    zero = seen.low[0] if seen.has_fits else None
    found = rig_file.calibrations(zero, at_sense, meter_wire_v, meter_shunt_v)
    return Examination(findings, found, seen.metadata, probe.highest_v, probe.trouble)


def look_low(probe: VoltageProbe, rig: Rig) -> None:
    """Hold 0 V and the levels at which the protection expects no current yet; stop if the output is not 0 V."""
    zero = probe.hold(0.0, ZERO_S)
    # An output that does not follow its command gets no higher one.
    if zero is None or abs(float((zero.wire_voltage_v + zero.shunt_voltage_v).mean())) > rig.sense_voltage_v:
        return
    for fraction in LOW_FRACTIONS:
        if probe.hold(fraction * rig.sense_voltage_v, LOW_S) is None:
            break


def checked(seen: Examined, rows: tuple[CheckRow, ...]) -> Findings:
    """Return what the checks of some rows find, in their order."""
    found = [row.looked(seen) for row in rows]
    made = tuple(one for one in found if isinstance(one, RigCheck))
    return Findings(made, tuple(one for one in found if isinstance(one, SkippedCheck)))
