"""Health of wire and loop: what has changed or is at its limit, as a named cause that every estimator may record."""

from __future__ import annotations

from enum import IntEnum


class Cause(IntEnum):
    """Why a result may not hold; the number is what a recording holds."""

    NONE = 0
    SATURATION = 1
    """The drive is at its limit, or at the power of the highest temperature, and the target is not reached."""
    CHANGED_LOAD = 2
    """Force or stiffness of the load differ from those of the characterization."""
    CHANGED_AIR = 3
    """Temperature or flow of the air differ from those of the characterization."""
    OTHER_WIRE = 4
    """The resistance is not that of the wire of the model: another wire, or one that has aged."""
    STALLED = 5
    """The drive is at its upper limit and the resistance does not follow: a tendon is slack or something blocks."""
    OSCILLATION = 6
    """The drive swings to and fro while one target holds."""
    CONTRADICTED = 9
    """The reference instrument is too often beyond the interval that the estimate states."""
    OTHER_HEIGHT_OF_B = 10
    """B was passed at another resistance than in the model's slow loop, or the resistance was above that loop's."""
    HARDLY_SENSED = 11
    """Too few samples were valid for the loop to have been closed."""
    MISSED_KNOWN_STRAIN = 12
    """The estimate missed a strain that was known at one moment by more than its interval."""
    BAD_CONTACT = 13
    """At a steady drive the resistance jumped up within one sample, as a contact's does and no wire's."""
    OVERSHOOT = 14
    """Several steps took the wire well beyond their target and back."""
    TARGET_MISSED = 15
    """The estimate was farther from the target than its tolerance and interval, and no speed limit explains it."""
    WIDE_INTERVAL = 16
    """The estimate was away from the target, and its interval too wide to say whether the wire was."""


CAUSE_TEXT = {
    Cause.SATURATION: "the drive is at its limit, at the power that holds the highest temperature or at what the "
    "protection gives instead, and the target is not reached: a slower reference, a smaller step, calmer air, or for "
    "heating a higher maximum_voltage within the wire's limits",
    Cause.CHANGED_LOAD: "the load is not that of the characterization: put it back, or characterize with this one",
    Cause.CHANGED_AIR: "the air is warmer, colder, calmer or faster than at the characterization",
    Cause.OTHER_WIRE: "not the resistance of this model's wire: another wire, or an aged one (musclewire home)",
    Cause.STALLED: "the drive is at its upper limit and the resistance does not follow: the tendon is slack, or "
    "something blocks the wire",
    Cause.OSCILLATION: "the drive swings to and fro while the target holds: the wire follows later than its gains "
    "expect, by a coating, a filter or a slow link, or the air moves; tune for a longer closed-loop time",
    Cause.CONTRADICTED: "the reference instrument is too often beyond the 95 % interval of the estimate: load, "
    "resistance or air are not those of the characterization, or the instrument counts from another zero",
    Cause.OTHER_HEIGHT_OF_B: "the resistance was not where the model's slow loop has it: the load or "
    "the resistance (contact, lead, age) has changed since the model was made, or the air, if this wire turns below "
    "about 50 C, or the wire began warm: let it cool, put the change back, or characterize again; for resistance alone "
    "musclewire home",
    Cause.HARDLY_SENSED: "the loop was closed for a part of the run only: the wire was cold of B, beyond C, or carried "
    "no current; give targets further from both ends, or check the contacts",
    Cause.MISSED_KNOWN_STRAIN: "the estimate missed the strain that is known: load, spring, resistance, air or zero "
    "are not those of the characterization; what came before is wrong, and from there on the resistance is scaled",
    Cause.BAD_CONTACT: "at a steady drive the resistance jumps up within one sample, as a contact's does and no "
    "wire's: crimp it again, or measure the voltage on the wire itself",
    Cause.OVERSHOOT: "steps take the wire well beyond their target and back: it follows later than its gains expect, "
    "the air moves, or its wide gap takes less heat to cross than the slow loop's; more pretension narrows the gap "
    "(musclewire pretension)",
    Cause.TARGET_MISSED: "the estimate is farther from the target than 3 % of it (1 % of the model's range at least) "
    "and its own 95 % interval, longer than the speed limits explain: the wire was not where it was asked to be",
    Cause.WIDE_INTERVAL: "the estimate is away from the target, and its 95 % interval, more than a tenth of the "
    "model's range to either side, too wide to say whether the wire is, too",
}
