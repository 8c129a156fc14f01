"""Changes of air, load and wire, named once the evidence of the hypotheses has lasted: one sample says little."""

from __future__ import annotations

from typing import NamedTuple

from musclewire.judge import Cause
from musclewire.signals import Reason

# A change is named from this probability on, if it is also this large: what is smaller does no harm.
SURE = 0.9
MIN_CONVECTION_RATIO = 1.25  # of the heat loss, up or down
MIN_AMBIENT_K = 4.0  # [K] of the air
MIN_LOAD_FRACTION = 0.15  # of the load
MIN_STIFFNESS_RATIO = 1.35  # of the spring's stiffness, up or down
# How long [s] the evidence must last.
LASTING_S = 0.5
OTHER_WIRE_S = 1.0


class ChangeEvidence(NamedTuple):
    """What an estimator by hypotheses has found in a sample; ratios are over the characterization."""

    changed_air: float
    changed_load: float
    convection_ratio: float
    ambient_change_k: float
    load_fraction: float  # change of the load's constant force over the pretension
    stiffness_ratio: float
    reason: Reason


class ChangeState(NamedTuple):
    """For how long [s] there has been evidence for changed air, for a changed load, and for another wire."""

    air_s: float = 0.0
    load_s: float = 0.0
    other_wire_s: float = 0.0


def factor(ratio: float) -> float:
    """Return a ratio above 1, whichever of its two numbers is larger."""
    return max(ratio, 1.0 / ratio)


def after_evidence(state: ChangeState, seen: ChangeEvidence, duration_s: float) -> ChangeState:
    """Return for how long there has been evidence, after one more sample."""
    other_air = factor(seen.convection_ratio) > MIN_CONVECTION_RATIO or abs(seen.ambient_change_k) > MIN_AMBIENT_K
    other_load = abs(seen.load_fraction) > MIN_LOAD_FRACTION or factor(seen.stiffness_ratio) > MIN_STIFFNESS_RATIO
    other_wire = seen.reason in (Reason.UNEXPLAINED, Reason.MISMATCH)
    return ChangeState(
        state.air_s + duration_s if other_air and seen.changed_air > SURE else 0.0,
        state.load_s + duration_s if other_load and seen.changed_load > SURE else 0.0,
        state.other_wire_s + duration_s if other_wire else 0.0,
    )


def change_of(state: ChangeState) -> Cause:
    """Return the gravest change whose evidence has lasted, NONE without one."""
    if state.other_wire_s >= OTHER_WIRE_S:
        return Cause.OTHER_WIRE
    if state.load_s >= LASTING_S:
        return Cause.CHANGED_LOAD
    return Cause.CHANGED_AIR if state.air_s >= LASTING_S else Cause.NONE
