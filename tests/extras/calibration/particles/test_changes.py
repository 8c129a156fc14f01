"""What has changed is named once its evidence has lasted, and not before."""

from __future__ import annotations

from typing import Any

import pytest

from musclewire.extras.calibration._particles._changes import ChangeEvidence, ChangeState, after_evidence, change_of
from musclewire.judge import Cause
from musclewire.signals import Reason

NOTHING = ChangeEvidence(0.0, 0.0, 1.0, 0.0, 0.0, 1.0, Reason.OK)


def named_after(duration_s: float, **seen: Any) -> Cause:
    state = ChangeState()
    for _ in range(round(duration_s / 0.05)):
        state = after_evidence(state, NOTHING._replace(**seen), 0.05)
    return change_of(state)


@pytest.mark.parametrize(
    ("seen", "cause"),
    [
        ({"changed_air": 0.99, "convection_ratio": 0.5}, Cause.CHANGED_AIR),
        ({"changed_air": 0.99, "convection_ratio": 2.0}, Cause.CHANGED_AIR),
        ({"changed_air": 0.99, "ambient_change_k": -15.0}, Cause.CHANGED_AIR),
        ({"changed_load": 0.99, "load_fraction": 0.5}, Cause.CHANGED_LOAD),
        ({"changed_load": 0.99, "stiffness_ratio": 0.5}, Cause.CHANGED_LOAD),
        ({"reason": Reason.UNEXPLAINED}, Cause.OTHER_WIRE),
    ],
)
def test_what_lasts_is_named_and_what_passes_is_not(seen: dict[str, Any], cause: Cause) -> None:
    assert named_after(1.1, **seen) is cause
    assert named_after(0.2, **seen) is Cause.NONE


def test_a_small_change_and_a_doubtful_one_are_not_named() -> None:
    assert named_after(5.0, changed_air=0.99, convection_ratio=1.1, ambient_change_k=2.0) is Cause.NONE
    assert named_after(5.0, changed_load=0.6, load_fraction=0.5) is Cause.NONE
    assert named_after(5.0) is Cause.NONE


def test_evidence_that_stops_is_forgotten() -> None:
    state = ChangeState()
    for _ in range(40):
        state = after_evidence(state, NOTHING._replace(changed_load=0.99, load_fraction=0.5), 0.05)
    assert change_of(after_evidence(state, NOTHING, 0.05)) is Cause.NONE
