"""The model of a wire: tables and numbers of its slow loop, how fast it is, and what its file keeps."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from musclewire.errors import CallerError
from musclewire.identify import fit
from musclewire.sensing import SensingModel, load_model, with_wire_model
from musclewire.signals import Recording

NUMBERS = {
    *("time_constant_s", "heat_j_per_unit", "resistance_noise_ohm", "sensed_from", "phase_resistance", "minor_loops"),
    *("lowest_power_w", "highest_power_w"),
}


@pytest.fixture(scope="module")
def wire(model: SensingModel) -> Any:
    assert model.wire_model is not None
    return model.wire_model


def of_elsewhere(loop: Recording, *without: str) -> Recording:
    """Return a recording as another laboratory has it: without what a rig states, and without some facts."""
    kept = {key: value for key, value in loop.metadata.items() if not key.startswith("limit_") and key not in without}
    return Recording(loop.columns, kept)


# What a fit says.


def test_a_fit_says_each_number_with_its_deviation_and_origin(model: SensingModel, wire: Any) -> None:
    said = model.report()["wire_model"]
    assert set(said) == NUMBERS
    assert all(set(one) == {"value", "std", "origin"} and one["std"] > 0.0 for one in said.values())
    assert said["time_constant_s"]["value"] == model.gains["thermal_time_constant_s"]
    assert said["heat_j_per_unit"]["value"] == pytest.approx(model.gains["heat_per_unit"], rel=1e-12)
    assert "states" in said["time_constant_s"]["origin"]
    assert "between 2 cycles" in said["phase_resistance"]["origin"]
    assert said["highest_power_w"]["value"] == wire.heating_power_w[-1]


def test_a_recording_from_elsewhere_is_as_wide_as_what_is_known_of_its_wire(loop: Recording, wire: Any) -> None:
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
    model: SensingModel, wire: Any, tmp_path: Path, musclewire: Callable[..., Any], loop: Recording
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
