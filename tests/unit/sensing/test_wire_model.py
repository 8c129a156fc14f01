"""The model of a wire: tables and numbers of its slow loop, how fast it is, and what its file keeps."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from musclewire.errors import CallerError
from musclewire.experiment import characterize
from musclewire.identify import fit
from musclewire.rigs import open_rig
from musclewire.sensing import SensingModel, WireMotion, load_model, with_wire_model
from musclewire.sensing._wire_balance import (
    ANY_LAW,
    MEASURED,
    TYPICAL_DIAMETER_M,
    HeatBalanceFound,
    balance,
    by_diameter,
    by_motion,
    heat_balance_of,
    law_of_minor_loops,
    steady_power_w,
)
from musclewire.sensing._wire_tables import WireModel
from musclewire.signals import Recording

NUMBERS = {
    *("time_constant_s", "heat_j_per_unit", "resistance_noise_ohm", "sensed_from", "phase_resistance", "minor_loops"),
    *("lowest_power_w", "highest_power_w"),
}


@pytest.fixture(scope="module")
def loop() -> Recording:
    with open_rig("simulated", seed=1) as rig:
        return characterize(rig)


@pytest.fixture(scope="module")
def model(loop: Recording) -> SensingModel:
    return fit(loop)


@pytest.fixture(scope="module")
def wire(model: SensingModel) -> WireModel:
    assert model.wire_model is not None
    return model.wire_model


def of_elsewhere(loop: Recording, *without: str) -> Recording:
    """Return a recording as another laboratory has it: without what a rig states, and without some facts."""
    kept = {key: value for key, value in loop.metadata.items() if not key.startswith("limit_") and key not in without}
    return Recording(loop.columns, kept)


def moving(tau_s: float, heat_j: float, period_s: float, noise: float = 0.0) -> WireMotion:
    """Return the motion of a wire that is the model itself: a balance, and resistance by temperature at rest."""
    time_s = np.linspace(0.0, 3.0 * period_s, 1200)
    power_w = 0.01 + 0.5 * np.sin(math.pi * time_s / period_s) ** 2
    steady_w, place = np.zeros(1200), np.zeros(1200)
    steady_w[0] = power_w[0]
    for row in range(1, time_s.size):
        dt_s = time_s[row] - time_s[row - 1]
        found, previous = place[row - 1], place[row - 1]
        for _ in range(60):  # the place is a function of the power that it takes heat from
            given_w = 0.5 * (power_w[row] + power_w[row - 1]) - heat_j * (found - previous) / dt_s
            steady_w[row] = given_w + (steady_w[row - 1] - given_w) * math.exp(-dt_s / tau_s)
            found = 0.5 * found + 0.5 * float(np.clip((steady_w[row] - 0.1) / 0.25, 0.0, 1.0))
        place[row] = found
    resistance = 0.2 + 0.3 * steady_w - 0.6 * place
    return WireMotion(time_s, power_w, place, resistance + noise * np.random.default_rng(1).standard_normal(1200))


# The balance.


def test_the_steady_power_of_a_step_is_the_exponential() -> None:
    time_s = np.linspace(0.0, 4.0, 81)
    power_w = np.where(time_s > 0.0, 1.0, 0.0)
    motion = WireMotion(time_s, power_w, np.zeros(81), np.zeros(81))
    steady_w = steady_power_w(motion, 0.8, 0.1)
    assert steady_w[1:] == pytest.approx(1.0 - np.exp(-(time_s[1:] - 0.025) / 0.8), abs=0.002)


@pytest.mark.parametrize(("tau_s", "period_s"), [(0.5, 14.0), (1.2, 14.0), (2.5, 14.0), (1.2, 30.0)])
def test_a_loop_that_is_fast_shows_its_time_constant(tau_s: float, period_s: float) -> None:
    motion = moving(tau_s, 0.05 * tau_s, period_s, noise=1e-4)
    found = by_motion(balance(1.0, 0.05, 1.0, "a guess"), motion)
    assert found.time_constant_s.origin == MEASURED
    assert abs(found.time_constant_s.value - tau_s) < 2.0 * found.time_constant_s.std
    assert found.time_constant_s.std < 0.25 * tau_s


def test_a_loop_that_is_slow_leaves_what_was_known_before() -> None:
    guess = balance(1.0, 0.05, 0.3, "a guess")
    found = by_motion(guess, moving(1.2, 0.06, 3600.0, noise=1e-3))
    assert found.time_constant_s.origin == "a guess"
    assert found.time_constant_s.std == pytest.approx(0.3, rel=0.35)


def test_an_end_where_the_wire_does_not_rest_is_left_alone() -> None:
    guess = balance(1.0, 0.05, 0.3, "a guess")
    motion = WireMotion(*(one[:12] for one in moving(1.2, 0.06, 14.0)))
    assert by_motion(guess, motion) == guess


# What a fit says.


def test_a_fit_says_each_number_with_its_deviation_and_origin(model: SensingModel, wire: WireModel) -> None:
    said = model.report()["wire_model"]
    assert set(said) == NUMBERS
    assert all(set(one) == {"value", "std", "origin"} and one["std"] > 0.0 for one in said.values())
    assert said["time_constant_s"]["value"] == model.gains["thermal_time_constant_s"]
    assert said["heat_j_per_unit"]["value"] == pytest.approx(model.gains["heat_per_unit"], rel=1e-12)
    assert "states" in said["time_constant_s"]["origin"]
    assert "between 2 cycles" in said["phase_resistance"]["origin"]
    assert said["highest_power_w"]["value"] == wire.heating_power_w[-1]


def test_a_recording_from_elsewhere_is_as_wide_as_what_is_known_of_its_wire(loop: Recording, wire: WireModel) -> None:
    named, sized, unknown = (
        fit(of_elsewhere(loop, *without)).wire_model for without in ((), ("wire",), ("wire", "wire_diameter_m"))
    )
    assert named is not None
    assert sized is not None
    assert unknown is not None
    for found in (named, sized, unknown):
        off_s = abs(found.time_constant_s.value - wire.time_constant_s.value)
        assert off_s < 2.0 * found.time_constant_s.std
        assert "characterize" in fit(of_elsewhere(loop)).no_gains
    assert named.time_constant_s.std == pytest.approx(sized.time_constant_s.std, rel=0.1)
    assert unknown.time_constant_s.std > 1.5 * sized.time_constant_s.std


def test_a_clock_that_is_rounded_to_less_than_its_samples_shows_the_same_wire(loop: Recording) -> None:
    coarse = of_elsewhere(loop).with_columns(time_s=np.floor(10.0 * loop["time_s"]) / 10.0)
    exact, found = (fit(one).wire_model for one in (of_elsewhere(loop), coarse))
    assert exact is not None
    assert found is not None
    assert found.time_constant_s.value == pytest.approx(exact.time_constant_s.value, rel=0.05)


def test_a_wire_of_no_size_is_any_that_is_sold(model: SensingModel) -> None:
    found = by_diameter(replace(model, wire={}))
    assert "0.025 to 0.51 mm" in found.time_constant_s.origin
    assert found.time_constant_s.std > found.time_constant_s.value
    typical = by_diameter(replace(model, wire={"wire_diameter_m": TYPICAL_DIAMETER_M}))
    assert typical.time_constant_s.value == pytest.approx(found.time_constant_s.value, rel=0.01)


def test_a_slow_loop_says_that_its_branches_need_neither(model: SensingModel) -> None:
    slower = tuple((20.0 * time_s, power_w, ohm) for time_s, power_w, ohm in model.slow_loop)
    found = with_wire_model(replace(model, slow_loop=slower)).wire_model
    assert found is not None
    assert "need neither" in found.time_constant_s.origin
    faster = tuple((0.1 * time_s, power_w, ohm) for time_s, power_w, ohm in model.slow_loop)
    quick = with_wire_model(replace(model, slow_loop=faster)).wire_model
    assert quick is None or "need neither" not in quick.time_constant_s.origin


def test_a_model_without_a_whole_loop_has_no_wire(model: SensingModel) -> None:
    assert with_wire_model(replace(model, slow_loop=())).wire_model is None
    assert with_wire_model(replace(model, slow_loop=model.slow_loop[-20:])).report()["wire_model"] is None


# Minor loops.


def minor(wire: WireModel, model: SensingModel, law: float) -> tuple[HeatBalanceFound, WireMotion]:
    """Return a slow motion to the middle of the branches and back, by a law, three times."""
    known = heat_balance_of(model)
    places, hours_s = wire.places, 1e5
    drive_w = np.concatenate([np.linspace(0.02, 0.42, 400), np.linspace(0.42, 0.02, 400), np.linspace(0.02, 0.42, 400)])
    up, down = (np.interp(drive_w, one, places) for one in (wire.heating_power_w, wire.cooling_power_w))
    at = up[399]
    back = (1.0 - law) * np.minimum(at, down[400:800]) + law * at * down[400:800] / places[-1]
    place = np.concatenate([up[:400], back, up[800:]])
    time_s = np.linspace(0.0, 3.0 * hours_s, 3600)
    return known, WireMotion(time_s, np.tile(drive_w, 3), np.tile(place, 3), np.zeros(3600))


@pytest.mark.parametrize("law", [0.0, 0.4, 1.0])
def test_a_minor_loop_shows_its_law(law: float, model: SensingModel, wire: WireModel) -> None:
    found = law_of_minor_loops(wire, *minor(wire, model, law))
    assert found.value == pytest.approx(law, abs=0.08)
    assert found.std < ANY_LAW.std


def test_turns_that_follow_different_laws_make_the_number_less_certain(model: SensingModel, wire: WireModel) -> None:
    (known, play), (_, scaled) = (minor(wire, model, law) for law in (0.0, 1.0))
    once = law_of_minor_loops(wire, known, play)
    later_s = play.time_s[-1] + 100.0
    places = [np.concatenate([one.place for one in pair]) for pair in ((play, play), (play, scaled))]
    time_s, power_w = np.concatenate([play.time_s, later_s + play.time_s]), np.tile(play.power_w, 2)
    alike, unlike = (
        law_of_minor_loops(wire, known, WireMotion(time_s, power_w, place, np.zeros(place.size))) for place in places
    )
    assert alike.std < once.std  # nobody knows of a single turn how much turns differ
    assert unlike.std > 0.15
    assert unlike.std > 3.0 * alike.std
    assert unlike.value == pytest.approx(0.5, abs=0.1)


def test_a_cold_end_of_a_minor_loop_says_nothing_of_its_law(model: SensingModel, wire: WireModel) -> None:
    """Below B the place goes on with the power, the quantity does not."""
    known, motion = minor(wire, model, 0.0)
    cold = motion.power_w < 0.05
    still = motion._replace(place=np.where(cold, wire.sensed_from.value, motion.place))
    assert law_of_minor_loops(wire, known, still).value == pytest.approx(0.0, abs=0.1)


def test_a_loop_without_one_may_have_any(loop: Recording) -> None:
    found = fit(loop.between()).wire_model
    assert found is not None
    assert found.minor_loops == ANY_LAW


# Files.


def test_the_file_keeps_it_to_the_bit(model: SensingModel, tmp_path: Path) -> None:
    model.save(tmp_path / "model.json")
    back = load_model(tmp_path / "model.json")
    assert back.wire_model == model.wire_model
    assert (back.converted, json.loads((tmp_path / "model.json").read_text())["version"]) == ("", 2)


def of_version_1(path: Path, **without: Any) -> None:
    """Make of a file one of the first version, which had no checksum of what came later."""
    document = json.loads(path.read_text()) | {"version": 1} | without
    del document["wire_model"], document["checksum"]
    path.write_text(json.dumps(document))


def test_a_file_of_version_1_gets_its_wire_from_its_loop_and_says_so(
    model: SensingModel, wire: WireModel, tmp_path: Path, musclewire: Callable[..., Any], loop: Recording
) -> None:
    path, recording = tmp_path / "model.json", tmp_path / "loop.h5"
    model.save(path)
    of_version_1(path)
    back = load_model(path)
    assert back.wire_model is not None
    assert back.wire_model.tables == pytest.approx(wire.tables, rel=1e-12)
    assert back.converted.endswith("version 1: its wire model was made from its slow loop")
    loop.save(recording)
    said = musclewire("estimate", path, recording, "--estimator", "filter", "--json")
    assert said.err.count("is of version 1") == 1
    of_version_1_again = load_model(path)
    of_version_1_again.save(path)
    assert load_model(path).converted == ""


def test_one_without_a_loop_keeps_the_polynomial_and_says_so(model: SensingModel, tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    model.save(path)
    of_version_1(path, slow_loop=[])
    back = load_model(path)
    assert back.wire_model is None
    assert "keeps no whole slow loop" in back.converted
    assert "\n" not in back.converted


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda wire: wire["heating_power_w"].pop(), "128 rows"),
        (lambda wire: wire.update(place_spacing=0.0), "not finite"),
        (lambda wire: wire["time_constant_s"].update(std=-1.0), "must be finite"),
        (lambda wire: wire["time_constant_s"].update(value=2.0), "not those that were written"),
    ],
)
def test_a_damaged_one_is_refused_in_one_line(
    damage: Callable[[dict[str, Any]], object], said: str, model: SensingModel, tmp_path: Path
) -> None:
    path = tmp_path / "model.json"
    model.save(path)
    document = json.loads(path.read_text())
    damage(document["wire_model"])
    path.write_text(json.dumps(document))
    with pytest.raises(CallerError, match=said):
        load_model(path)
