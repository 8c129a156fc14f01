"""Tuning: the plant of a loop that is known, its gains file, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from known_plant import LIMITS, MODEL, plant_settings

from musclewire.controllers import CONTROLLERS, FuzzyPidSettings, Gains, load_gains
from musclewire.errors import CallerError, RecordingError
from musclewire.identify import Tuning, stated_heat_balance, tune
from musclewire.sensing import SensingModel, with_wire_model
from musclewire.signals import Recording

FACTS = {"sample_period_s": 0.05, "shunt_resistance_ohm": 1.0, **LIMITS}
ROWS, LOOP_S = 240, 900.0
LOOP = Recording({"time_s": np.arange(3.0)}, FACTS)


def known_wire(branch_w_per_unit: float = 5.0, gap_w: float = 0.1) -> SensingModel:
    """Return MODEL with a loop so slow that power is all loss, with straight branches a known power apart."""
    time_s = np.linspace(0.0, LOOP_S, ROWS)
    strain = 0.002 + 0.018 * (1.0 - np.cos(2.0 * math.pi * time_s / LOOP_S))
    power_w = 0.1 + np.where(time_s <= 0.5 * LOOP_S, gap_w, 0.0) + branch_w_per_unit * strain
    resistance_ohm = 15.0 + 2.5 * (0.035 - strain) / 0.03
    rows = zip(time_s.tolist(), power_w.tolist(), resistance_ohm.tolist(), strict=True)
    return with_wire_model(replace(MODEL, slow_loop=tuple(rows)), stated=stated_heat_balance(MODEL, LOOP.facts))


def test_the_branches_of_a_slow_loop_are_found() -> None:
    found = tune(known_wire(), LOOP).plant
    inside = slice(3, -3)
    wanted = 0.1 + 5.0 * found.levels
    assert np.array(found.heating_power_w)[inside] == pytest.approx(wanted[inside] + 0.1, abs=2e-3)
    assert np.array(found.cooling_power_w)[inside] == pytest.approx(wanted[inside], abs=2e-3)
    assert np.array(found.resistance_ohm)[inside] == pytest.approx(
        (17.5 - 2.5 * np.linspace(0, 1, 33))[inside], abs=1e-9
    )
    assert found.thermal_time_constant_s == pytest.approx(0.8)
    assert found.maximum_steady_power_w == pytest.approx(0.0055 * 178.0)


def test_the_fuzzy_pid_keeps_its_ranges_and_gets_a_scale() -> None:
    found = tune(known_wire(), LOOP, controller="fuzzy-pid", rule_base="fixed").settings
    assert isinstance(found, FuzzyPidSettings)
    assert found.kp_range == FuzzyPidSettings().kp_range
    assert found.rule_base == "fixed"
    assert 5.0 < found.input_scale < 100.0


@pytest.mark.parametrize("controller", ["inverse-model", "fuzzy-pid"])
def test_a_gains_file_holds_what_was_found(controller: str, tmp_path: Path) -> None:
    found = tune(known_wire(), LOOP, controller=controller)
    found.save(tmp_path / "gains.toml")
    read = load_gains(tmp_path / "gains.toml")
    assert (read.controller, read.settings) == (controller, found.settings)


def test_what_is_missing_is_named() -> None:
    bare = Recording(LOOP.columns, {key: value for key, value in FACTS.items() if "limit" not in key})
    with pytest.raises(RecordingError, match="which rig heats the wire"):
        tune(known_wire(), bare)
    with pytest.raises(CallerError, match="slow loop"):
        tune(MODEL, LOOP)


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
        tune(known_wire(), LOOP, **asked)


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
    found: Tuning = tune(known_wire(), LOOP)
    assert "SIMC" in str(found)
    axes = found.plot(style="ieee-single")
    assert axes.get_xlabel() == "steady electrical power [W]"
    assert axes.figure.get_size_inches()[0] * 25.4 == pytest.approx(88.9)


def test_gains_of_a_controller_that_was_replaced_are_those_of_the_one_in_its_place() -> None:
    gains = Gains.read({"controller": "feedforward", **plant_settings().model_dump()}, "an older file")
    assert gains == Gains("inverse-model", plant_settings())
    assert [name for name in CONTROLLERS.names() if gains.serve(name)] == ["inverse-model"]
    assert not gains.serve(lambda setup: setup)
