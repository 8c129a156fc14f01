"""A model whose slow loop passed B with less power than still air needs lowers what its rig is allowed."""

from __future__ import annotations

import logging
from functools import cache

import pytest

import musclewire as mw
from musclewire.controllers import ProtectionLimits
from musclewire.experiment._calm_air import CALM_FRACTION, heed_air, still_air_b_power_w
from musclewire.rigs import GuardedRig
from musclewire.sensing import SensingModel

CONVECTION_FACTOR = 0.817678  # the paper's wire's own


@cache
def model_in(loss: float) -> SensingModel:
    """The model of the paper's wire that loses so much of its heat to the air."""
    with mw.open_rig("simulated", convection_factor=loss * CONVECTION_FACTOR) as rig:
        return mw.fit(mw.characterize(rig, cycles=1))


def in_still_air() -> tuple[GuardedRig, ProtectionLimits]:
    rig = mw.open_rig("simulated")
    return rig, rig.protection_limits


@pytest.mark.parametrize("rig", ["simulated", "finger"])
def test_a_loop_in_still_air_changes_nothing(rig: str) -> None:
    with mw.open_rig(rig) as opened:
        model, before = mw.fit(mw.characterize(opened, cycles=1)), opened.protection_limits
        heed_air(opened, model)
        assert opened.protection_limits == before


@pytest.mark.parametrize("loss", [0.5, 0.7])
def test_calm_air_lowers_the_heat_loss_to_no_more_than_it_is(loss: float, caplog: pytest.LogCaptureFixture) -> None:
    rig, before = in_still_air()
    with rig, caplog.at_level(logging.WARNING, logger="musclewire.rigs"):
        heed_air(rig, model_in(loss))
        lowered = rig.protection_limits.heat_loss_w_per_k / before.heat_loss_w_per_k
        assert CALM_FRACTION * loss < lowered <= loss
        assert "loss_factor or ambient_temperature" in caplog.text
        caplog.clear()
        heed_air(rig, model_in(loss))  # said once, and nothing raises it
        rig.lower_heat_loss(before.heat_loss_w_per_k, "a test")
        assert rig.protection_limits.heat_loss_w_per_k == lowered * before.heat_loss_w_per_k
        assert not caplog.text


def test_nothing_is_known_of_a_wire_that_is_not_of_the_catalogue(monkeypatch: pytest.MonkeyPatch) -> None:
    rig, before = in_still_air()
    with rig:
        monkeypatch.setattr(rig.device, "metadata", lambda: {"wire": "mine"})
        assert still_air_b_power_w(rig) is None
        heed_air(rig, model_in(0.5))
        assert rig.protection_limits == before


def test_warm_air_counts_as_calm_air() -> None:
    rig, before = in_still_air()
    with mw.open_rig("simulated", ambient_temperature_k=before.ambient_temperature_k + 40.0) as warm:
        model = mw.fit(mw.characterize(warm, cycles=1))
    with rig:
        heed_air(rig, model)
        assert rig.protection_limits.heat_loss_w_per_k < 0.5 * before.heat_loss_w_per_k
