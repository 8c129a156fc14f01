"""Friction that the load cannot overcome keeps the connector where it is, and the rig's recordings say so."""

from __future__ import annotations

import pytest

import musclewire as mw
from musclewire.experiment import friction_warnings, run_warnings
from musclewire.signals import Recording

STIFFNESS_N_PER_M = 588.6


def loop(friction_n: float, pretension_n: float, **settings: float | str) -> Recording:
    with mw.open_rig("simulated", guide_friction_n=friction_n, pretension_n=pretension_n, **settings) as rig:
        return mw.characterize(rig, cycles=1)


@pytest.mark.parametrize(("friction_n", "pretension_n"), [(0.0, 0.0), (0.02, 1.9), (0.3, 1.0), (1.0, 1.9)])
def test_where_the_load_can_pull_the_wire_back_nothing_is_said(friction_n: float, pretension_n: float) -> None:
    recording = loop(friction_n, pretension_n)
    assert recording.metadata["friction_held_m"] == 0.0
    assert friction_warnings(recording) == ()


@pytest.mark.parametrize(("friction_n", "pretension_n"), [(1.0, 0.5), (0.3, 0.1), (2.5, 1.9)])
def test_where_it_cannot_the_run_says_so_and_the_force_stays_between_both_limits(
    friction_n: float, pretension_n: float
) -> None:
    recording = loop(friction_n, pretension_n)
    held_m = recording.facts.number_or_none("friction_held_m")
    assert held_m is not None
    assert held_m > 1e-4
    warning = run_warnings(recording)[-1]
    assert warning.startswith("friction holds the wire")
    load_n = pretension_n + STIFFNESS_N_PER_M * recording["displacement_m"][-20:]
    force_n = recording["force_n"][-20:]
    assert (force_n > load_n - friction_n - 0.02).all()
    assert (force_n < load_n + friction_n + 0.02).all()
    assert force_n == pytest.approx(0.0, abs=0.02)  # the wire is slack


def test_another_setting_of_the_stage_begins_without_what_friction_held_before() -> None:
    with mw.open_rig("simulated", guide_friction_n=1.0, pretension_n=0.5) as rig:
        assert mw.characterize(rig, cycles=1).metadata["friction_held_m"] > 1e-4
        stage = rig.device
        stage.set_pretension(1.9)
        rig.forget_readings()
        assert mw.characterize(rig, cycles=1).metadata["friction_held_m"] == 0.0


def test_under_a_weight_that_friction_carries_the_wire_stays_contracted() -> None:
    recording = loop(1.1, 1.0, bench="dead-weight")
    assert recording["displacement_m"][-1] > 0.9 * recording["displacement_m"].max()
    assert friction_warnings(recording) != ()
