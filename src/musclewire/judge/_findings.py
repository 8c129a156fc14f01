"""The findings of closed loops, a row each, and the judgement of a recording by all of them in one pass.

A new one is a row here, a remedy in ``data/remedies.toml`` and a test.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

from musclewire.judge._basics import contradicted, hardly_sensed, saturation, stalled
from musclewire.judge._first_heating import not_compared
from musclewire.judge._known_strain import known_strain_unused, missed_known_strain
from musclewire.judge._loop import Cause, DetectedRows, JudgedLoop
from musclewire.judge._missed_target import MAX_MISSED, interval_too_wide, target_missed
from musclewire.judge._odd_resistance import bad_contact, other_height_of_b
from musclewire.judge._steps import oscillation, overshoot
from musclewire.signals import Recording, asked_once
from musclewire.small_files import read_toml

# A run with a finding does not hold if the samples of the finding are a larger fraction of the time with a target.
ALWAYS = 0.0
NEVER = math.inf


class Finding(NamedTuple):
    """What may be wrong with a closed loop, so that its result may not hold."""

    key: str  # its name for programs
    name: str  # in words
    grave_beyond: float  # from more than which part of the time with a target on a run does not hold
    detect: Callable[[JudgedLoop], DetectedRows] | None  # None if an estimator alone finds it
    recorded: Cause = Cause.NONE  # what an estimator that finds it records in the column ``health``

    def found_in(self, loop: JudgedLoop) -> DetectedRows:
        """Return the samples at which it is found."""
        return DetectedRows(loop.recorded(self.recorded)) if self.detect is None else loop.once(self.detect)

    @property
    def remedy(self) -> str:
        """What it means, and what to do."""
        return remedies("loop")[self.key]


FINDINGS = (
    Finding("saturation", "saturation", MAX_MISSED, saturation),
    Finding("stalled", "stalled or slack", ALWAYS, stalled),
    Finding("contradicted", "contradicted", ALWAYS, contradicted),
    Finding("other_height_of_b", "changed load or resistance", ALWAYS, other_height_of_b),
    Finding("bad_contact", "bad contact", ALWAYS, bad_contact),
    Finding("overshoot", "overshoot", NEVER, overshoot),
    Finding("oscillation", "oscillation", NEVER, oscillation),
    Finding("target_missed", "target missed", ALWAYS, target_missed),
    Finding("wide_interval", "interval too wide", ALWAYS, interval_too_wide),
    Finding("hardly_sensed", "hardly sensed", ALWAYS, hardly_sensed),
    Finding("missed_known_strain", "known strain missed", ALWAYS, missed_known_strain),
    Finding("changed_load", "changed load", ALWAYS, None, Cause.CHANGED_LOAD),
    # With changed air a run holds: the estimator that has found it takes it into account.
    Finding("changed_air", "changed air", NEVER, None, Cause.CHANGED_AIR),
    Finding("other_wire", "wrong or aged wire", ALWAYS, None, Cause.OTHER_WIRE),
)
# What an estimator records with which a run does not hold.
GRAVE = tuple(one.recorded for one in FINDINGS if one.recorded and one.grave_beyond == ALWAYS)


@cache
def remedies(table: str) -> dict[str, str]:
    """Return what the findings of a table mean and what to do, by their keys."""
    found: dict[str, str] = read_toml(Path(__file__).parent / "data" / "remedies.toml", "table of remedies")[table]
    return found


class TimedFinding(NamedTuple):
    """A finding: since when [s], for how long [s] in total, whether the run does not hold, its numbers in words."""

    finding: Finding
    from_s: float
    lasted_s: float
    grave: bool
    numbers: str = ""

    @property
    def key(self) -> str:
        """Its name for programs."""
        return self.finding.key

    @property
    def answer(self) -> dict[str, object]:
        """The finding as a JSON object."""
        return {"cause": self.key, **dict(zip(self._fields[1:], self[1:], strict=True))}

    @property
    def in_brackets(self) -> str:
        """Its numbers as an insertion."""
        return f" ({self.numbers})" if self.numbers else ""


@dataclass(frozen=True)
class Judgement:
    """What is wrong in a closed loop; nothing in a recording without a target."""

    findings: tuple[TimedFinding, ...]  # in the order of time
    does_not_hold: str  # why: model, load, grave findings; "" if its result holds
    not_compared: tuple[str, ...]  # what it was to be compared with and was not, in words

    @property
    def metadata(self) -> dict[str, str]:
        """The findings for the recording's own metadata, under ``health``; nothing if all is well."""
        said = [
            f"{one.finding.name} at {one.from_s:.2f} s for {one.lasted_s:.2f} s{one.in_brackets}"
            for one in self.findings
        ]
        return {"health": "; ".join(said)} if said else {}

    @property
    def warnings(self) -> tuple[str, ...]:
        """A warning for each finding: name, time and what to do."""
        return tuple(
            f"{one.finding.name} from {one.from_s:.1f} s on, {one.lasted_s:.1f} s in total{one.in_brackets}: "
            f"{one.finding.remedy}"
            for one in self.findings
        )


def judgement_of(recording: Recording) -> Judgement:
    """Return what is wrong in a closed loop; however often it is asked, each detector looks at a recording once."""
    return asked_once(recording, judge_loop)


def judge_loop(recording: Recording) -> Judgement:
    """Return what is wrong in a closed loop, in one pass over the table."""
    loop = JudgedLoop(recording)
    found = sorted(findings_in(loop), key=lambda one: one.from_s)
    against = [loop.facts.text_or_none(name) for name in ("model_does_not_hold", "other_load")]
    against += [one.finding.name for one in found if one.grave]
    not_done = (not_compared(loop), known_strain_unused(loop))
    return Judgement(tuple(found), "; ".join(filter(None, against)), tuple(filter(None, not_done)))


def findings_in(loop: JudgedLoop) -> list[TimedFinding]:
    """Return what is found in a loop, in the order of the table."""
    found, with_target = [], int(loop.with_target.sum()) if loop.suffix else 0
    for finding in FINDINGS if loop.suffix else ():
        rows, in_words = finding.found_in(loop)
        count = int(rows.sum())
        if count:
            grave = count > finding.grave_beyond * with_target
            from_s = float(loop.time_s[rows.argmax()])
            found.append(TimedFinding(finding, from_s, count * loop.period_s, grave, in_words()))
    return found
