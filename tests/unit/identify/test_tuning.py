"""Tuning: SIMC against the closed forms of its literature, and the plant of a loop that is known."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from known_plant import LIMITS, MODEL, plant_settings

import musclewire as mw
from musclewire.controllers import CONTROLLERS, FuzzyPidSettings, Gains, load_gains
from musclewire.errors import CallerError, RecordingError
from musclewire.identify._tuning import Tuning, feedback_gains, margins_of, tune, worst_margins
from musclewire.signals import Recording

PERIOD_S, RESISTANCE_OHM = 0.05, 16.0


def slow_loop(branch_w_per_unit: float = 5.0, gap_w: float = 0.1, period_s: float = 90.0) -> Recording:
    """Return a loop so slow that power is all loss, with straight branches a known power apart."""
    time_s = np.arange(1, round(period_s / PERIOD_S) + 1) * PERIOD_S
    swing = 0.5 * (1.0 - np.cos(2.0 * math.pi * time_s / period_s))
    strain = 0.002 + 0.036 * swing
    heating = time_s <= 0.5 * period_s
    power = 0.1 + np.where(heating, gap_w, 0.0) + branch_w_per_unit * strain
    current = np.sqrt(power / RESISTANCE_OHM)
    columns = {
        "time_s": time_s,
        "wire_voltage_v": current * RESISTANCE_OHM,
        "shunt_voltage_v": current * 1.0,
        "displacement_m": strain * 0.07,
    }
    facts = {"sample_period_s": PERIOD_S, "shunt_resistance_ohm": 1.0, "leg_length_m": 0.07}
    return Recording(columns, {**facts, **LIMITS})


@pytest.mark.parametrize(
    ("lag_s", "gain", "phase_deg", "delay_over_theta"), [(1e4, 2.96, 46.9, 1.59), (0.8, 3.14, 61.4, 2.14)]
)
def test_simc_has_the_margins_of_its_literature(
    lag_s: float, gain: float, phase_deg: float, delay_over_theta: float
) -> None:
    """Skogestad 2003, Table 1, with tau_c = theta: an integrating process, and one of first order with T_i = tau."""
    settings = plant_settings(thermal_time_constant_s=lag_s)
    margins = margins_of(lag_s * 5.0 / 0.2, 5.0, settings)
    assert margins.gain == pytest.approx(gain, abs=0.03)
    assert math.degrees(margins.phase_rad) == pytest.approx(phase_deg, abs=0.5)
    assert margins.delay_s == pytest.approx(delay_over_theta * settings.dead_time_s, rel=0.03)


def test_gains_follow_the_rule() -> None:
    heating, cooling = feedback_gains(plant_settings(heat_per_unit=2.5))
    assert heating == pytest.approx([(0.8 * 5.0 + 2.5) / 0.2] * 33)
    assert cooling == pytest.approx(heating)


def test_a_longer_closed_loop_time_has_larger_margins() -> None:
    quick, slow = worst_margins(plant_settings()), worst_margins(plant_settings(closed_loop_time_s=0.4))
    assert slow.gain > quick.gain
    assert slow.delay_s > quick.delay_s


def test_the_branches_of_a_slow_loop_are_found() -> None:
    found = tune(MODEL, slow_loop(period_s=900.0)).plant
    inside = slice(3, -3)
    wanted = 0.1 + 5.0 * found.levels
    assert np.array(found.heating_power_w)[inside] == pytest.approx(wanted[inside] + 0.1, abs=2e-3)
    assert np.array(found.cooling_power_w)[inside] == pytest.approx(wanted[inside], abs=2e-3)
    assert np.array(found.resistance_ohm) == pytest.approx(RESISTANCE_OHM)
    assert found.thermal_time_constant_s == pytest.approx(0.8)
    assert found.maximum_steady_power_w == pytest.approx(0.0055 * 178.0)
    assert found.integral_time_s == pytest.approx(0.8)


def test_the_fuzzy_pid_keeps_its_ranges_and_gets_a_scale() -> None:
    found = tune(MODEL, slow_loop(), controller="fuzzy-pid", rule_base="fixed").settings
    assert isinstance(found, FuzzyPidSettings)
    assert found.kp_range == FuzzyPidSettings().kp_range
    assert found.rule_base == "fixed"
    assert 5.0 < found.input_scale < 100.0


@pytest.mark.parametrize("controller", ["inverse-model", "fuzzy-pid"])
def test_a_gains_file_holds_what_was_found(controller: str, tmp_path: Path) -> None:
    found = tune(MODEL, slow_loop(), controller=controller)
    found.save(tmp_path / "gains.toml")
    read = load_gains(tmp_path / "gains.toml")
    assert (read.controller, read.settings) == (controller, found.settings)


def self_sensed_loop(period_s: float) -> Recording:
    """Return the slow loop of a wire that follows MODEL, without the instrument."""
    measured = slow_loop(period_s=period_s)
    strain = measured["displacement_m"] / 0.07
    resistance = 15.0 + 2.5 * (0.035 - strain) / 0.03
    current = np.sqrt(measured["wire_voltage_v"] * measured["shunt_voltage_v"] / resistance)
    voltages = {"wire_voltage_v": current * resistance, "shunt_voltage_v": current}
    return Recording({"time_s": measured["time_s"], **voltages}, measured.metadata)


def test_without_an_instrument_the_model_reads_its_own_strain() -> None:
    blind, seeing = tune(MODEL, self_sensed_loop(900.0)), tune(MODEL, slow_loop(period_s=900.0))
    assert (blind.self_sensed, seeing.self_sensed) == (True, False)
    assert blind.plant.heating_power_w == pytest.approx(seeing.plant.heating_power_w, abs=2e-3)
    assert blind.plant.cooling_power_w == pytest.approx(seeing.plant.cooling_power_w, abs=2e-3)
    assert np.array(blind.plant.resistance_ohm) == pytest.approx(17.5 - 2.5 * np.linspace(0, 1, 33), abs=2e-3)
    assert "by the model's own branches" in str(blind)


@pytest.mark.slow
def test_a_simulated_wire_is_tuned_alike_without_its_instrument() -> None:
    """The bars of docs/how-to/tune_a_controller.md."""
    with mw.open_rig("simulated") as rig:
        slow = mw.characterize(rig)
    electrical = {name: slow[name] for name in slow.names if name not in {"displacement_m", "force_n"}}
    model = mw.fit(slow)
    seeing, blind = (tune(model, one).plant for one in (slow, Recording(electrical, slow.metadata)))
    for wanted, found in (
        (seeing.heating_power_w, blind.heating_power_w),
        (seeing.cooling_power_w, blind.cooling_power_w),
    ):
        assert found[0] == pytest.approx(wanted[0], rel=0.04)
        assert found[1:] == pytest.approx(wanted[1:], rel=0.01)


def test_what_is_missing_is_named() -> None:
    whole = slow_loop()
    bare = Recording(whole.columns, {key: value for key, value in whole.metadata.items() if "limit" not in key})
    with pytest.raises(RecordingError, match="which rig heats the wire"):
        tune(MODEL, bare)
    half = Recording({key: row[:900] for key, row in whole.columns.items()}, whole.metadata)
    with pytest.raises(RecordingError, match="both branches"):
        tune(MODEL, half)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"controller": "inverse-modell"}, "'inverse-model'"),
        ({"controller": "feedforward"}, "replaced by inverse-model"),
        ({"rule_base": "fixed"}, "rule base"),
        ({"closed_loop_time_s": 0.0}, "above 0 s"),
    ],
)
def test_what_cannot_be_tuned_is_refused(asked: dict[str, Any], said: str) -> None:
    with pytest.raises(CallerError, match=said):
        tune(MODEL, slow_loop(), **asked)


def test_files_that_are_no_gains_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "gains.toml"
    path.write_text('format = "musclewire-gains"\ncontroller = "inverse-modell"\n[settings]\n')
    with pytest.raises(CallerError, match="did you mean 'inverse-model'"):
        load_gains(path)
    path.write_text("a = 1\n")
    with pytest.raises(CallerError, match="not a gains file"):
        load_gains(path)
    with pytest.raises(CallerError, match="musclewire tune"):
        load_gains(tmp_path / "none.toml")


def test_its_text_states_gains_and_margins() -> None:
    found: Tuning = tune(MODEL, slow_loop())
    assert "SIMC" in str(found)
    axes = found.plot(style="ieee-single")
    assert axes.get_xlabel() == "steady electrical power [W]"
    assert axes.figure.get_size_inches()[0] * 25.4 == pytest.approx(88.9)


def test_gains_of_a_controller_that_was_replaced_are_those_of_the_one_in_its_place() -> None:
    gains = Gains.read({"controller": "feedforward", **plant_settings().model_dump()}, "an older file")
    assert gains == Gains("inverse-model", plant_settings())
    assert [name for name in CONTROLLERS.names() if gains.serve(name)] == ["inverse-model"]
    assert not gains.serve(lambda setup: setup)
