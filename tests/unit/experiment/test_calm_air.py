"""A model whose slow loop, or a run that, passed B with less power than still air needs lowers what is allowed."""

from __future__ import annotations

import logging
from contextlib import suppress
from functools import cache
from typing import NamedTuple

import pytest

import musclewire as mw
from musclewire.controllers import ProtectionLimits
from musclewire.errors import RigError
from musclewire.experiment._calm_air import CALM_FRACTION, AirWatch, heed_air, still_air_b_power_w
from musclewire.rigs import GuardedRig, RigConfiguration, SimulatedDevice, Surroundings
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
        assert "loss_factor = 1 if it hangs bare" in caplog.text
        caplog.clear()
        heed_air(rig, model_in(loss))  # said once, and nothing raises it
        rig.lower_heat_loss(before.heat_loss_w_per_k, "a test")
        assert rig.protection_limits.heat_loss_w_per_k == lowered * before.heat_loss_w_per_k
        assert not caplog.text


def test_a_loss_that_the_user_states_is_not_lowered_by_where_a_wire_passes_b() -> None:
    """Grains may turn far below the alloy's temperature: in still air, too, B is then passed with half the power."""
    rig, before = in_still_air()
    rig.air_is_stated = True
    with rig:
        heed_air(rig, model_in(0.5))
        assert rig.protection_limits == before
        assert AirWatch(rig)._needed_w is None


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


def test_a_wire_in_air_that_is_warmer_than_b_passes_it_without_any_power() -> None:
    with mw.open_rig("simulated", ambient_temperature_k=420.0) as rig:
        assert still_air_b_power_w(rig) == 0.0


def sleeved(loss: float) -> RigConfiguration:
    return RigConfiguration(surroundings=Surroundings(convection=loss))


def slow_loop(rig: GuardedRig, **sine: float) -> tuple[float, float]:
    """Heat a wire until the end of its loop or a trip; return its highest true temperature [C] and the loss kept."""
    before, hottest_k = rig.protection_limits.heat_loss_w_per_k, [0.0]
    device = rig.device
    assert isinstance(device, SimulatedDevice)

    def on_sample(_row: object) -> None:
        hottest_k[0] = max(hottest_k[0], device.wire_state.temperature_k)

    with rig, suppress(RigError):
        mw.characterize(rig, cycles=1, on_sample=on_sample, **sine)
    return hottest_k[0] - 273.15, rig.protection_limits.heat_loss_w_per_k / before


@pytest.mark.parametrize(("loss", "period_s"), [(0.5, 20.0), (0.5, 90.0), (0.7, 90.0)])
def test_a_run_without_a_model_heats_no_wire_in_a_sleeve_beyond_its_limit(
    loss: float, period_s: float, caplog: pytest.LogCaptureFixture
) -> None:
    """The protection knows nothing of the sleeve; without the run's own B it lets this wire get 243 C."""
    hottest_c, kept = slow_loop(mw.open_rig(sleeved(loss)), amplitude_v=3.6, period_s=period_s)
    assert 130.0 < hottest_c <= 210.0
    assert CALM_FRACTION * loss < kept <= loss
    assert "the wire passed B with" in caplog.text
    assert "loss_factor or ambient_temperature" in caplog.text


class AirNow(NamedTuple):
    warmer_k: float
    convection_ratio: float


class WarmerAir:
    """Air that is warmer than the rig file says."""

    loss = 1.0

    def after(self, _time_s: float, _dt_s: float) -> AirNow:
        return AirNow(warmer_k=40.0, convection_ratio=1.0)


@pytest.mark.parametrize("period_s", [20.0, 90.0])
def test_a_run_without_a_model_heats_no_wire_in_warmer_air_beyond_its_limit(
    period_s: float, caplog: pytest.LogCaptureFixture
) -> None:
    """The protection knows of 22 C and not of 62 C."""
    rig = mw.open_rig("simulated")
    assert isinstance(rig.device, SimulatedDevice)
    rig.device.air = WarmerAir()  # type: ignore[assignment]
    hottest_c, kept = slow_loop(rig, amplitude_v=3.6, period_s=period_s)
    assert 100.0 < hottest_c <= 210.0
    assert kept < CALM_FRACTION
    assert "the wire passed B with" in caplog.text


def test_a_run_in_still_air_changes_nothing(caplog: pytest.LogCaptureFixture) -> None:
    assert slow_loop(mw.open_rig("simulated"), period_s=10.0)[1] == 1.0
    assert "passed B" not in caplog.text


def test_a_run_that_begins_warm_says_nothing_of_its_air() -> None:
    """The resistance of a wire that is still contracted falls at once, at no power that B needs."""
    with mw.open_rig("simulated") as rig:
        for _ in range(60):
            rig.exchange(3.2)
        before = rig.protection_limits
        mw.characterize(rig, cycles=1, period_s=10.0, on_sample=lambda _row: None)
        assert rig.protection_limits == before


class Lab:
    """A rig with a clock that simulates nothing, for what is said before it is heated."""

    paced, air_is_known, air_is_stated, sample_period_s, shunt_resistance_ohm = True, False, False, 0.05, 1.0

    def __init__(self, rig: GuardedRig) -> None:
        self.protection_limits, self.protection, self.device = rig.protection_limits, rig.protection, self
        self.leg_length_m = rig.leg_length_m

    def metadata(self) -> dict[str, str]:
        return {"wire": "paper-100um"}


def test_what_is_assumed_of_the_air_is_said_once_before_a_real_wire_is_heated_without_a_model(
    caplog: pytest.LogCaptureFixture,
) -> None:
    with mw.open_rig("simulated") as simulated:
        AirWatch(simulated)
        lab = Lab(simulated)
    assert not caplog.text
    for _ in range(2):
        AirWatch(lab)  # type: ignore[arg-type]
    assert caplog.text.count("protected as a bare one in still air") == 1
    assert "state loss_factor or ambient_temperature in the rig file before it is heated" in caplog.text
