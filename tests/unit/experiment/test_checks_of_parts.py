"""The doctor runs the checks that parts outside the core offer."""

from __future__ import annotations

import sys

import pytest

import musclewire as mw
from musclewire.experiment._doctor.evidence import Findings, RigCheck
from musclewire.manifest import Manifest
from musclewire.rigs import GuardedRig


def fan_stands_still(rig: GuardedRig) -> Findings:
    return Findings((RigCheck("fan", False, rig.sense_voltage_v, "V", "a part's fan stands still"),))


def test_a_check_that_a_part_offers_is_among_the_findings(monkeypatch: pytest.MonkeyPatch) -> None:
    from musclewire.experiment._doctor import examine

    module = sys.modules[examine.__module__]
    offer = Manifest("fans", doctor_checks=("fans:fan_stands_still",))
    monkeypatch.setattr(module, "manifests", lambda: (offer,))
    monkeypatch.setattr(module, "loaded", {"fans:fan_stands_still": fan_stands_still}.__getitem__)
    with mw.open_rig("simulated") as rig:
        findings = examine(rig).findings
    assert "fan" in findings.failed
