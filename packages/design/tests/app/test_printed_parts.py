"""The parts of examples/printed: all checks hold, no warning, thick enough for the printer."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from musclewire_design._finger.chain import finger_chain
from musclewire_design._finger.curve import beam_stress_pa
from musclewire_design._finger.geometry import FingerGeometry
from musclewire_design._finger.statics import equilibria
from tests.places import CHECKOUT
from tests.tools import require_oracle

from musclewire.parameters import load_material

FOLDER = CHECKOUT / "examples" / "printed"
PAGE = (CHECKOUT / "docs/how-to/design_a_finger.md").read_text("utf-8")
FINGERS = {"petg_finger": "petg", "tpu_finger": "tpu-95a"}


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.toml")), ids=lambda path: path.stem)
def test_the_page_has_a_command_for_the_file(path: Path) -> None:
    assert f" {path.name} " in PAGE


def stress_at(dimensions: dict[str, float], travel_m: float) -> float:
    """The beam's largest stress where the fully heated wire pulls it to, further than was asked for."""
    geometry = FingerGeometry(**{key: value for key, value in dimensions.items() if key != "segment_length_m"})
    steps = np.linspace(0.0, travel_m, 9)
    there = equilibria(finger_chain(geometry), geometry.stiffness_n_m2, steps)[-1]
    return float(beam_stress_pa(geometry, there).max())


@pytest.mark.oracles
@pytest.mark.parametrize(("name", "material"), FINGERS.items())
def test_the_finger_keeps_every_limit_of_printer_material_and_wire(
    name: str, material: str, musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    answer = musclewire("design", "finger", FOLDER / f"{name}.toml", "--solid", tmp_path / "finger.stl", "--json")
    assert answer.code == 0, answer.err
    found, made_of = answer.json, load_material(material)
    assert found["holds"]
    assert found["warnings"] == []
    thinnest_m = made_of.minimum_thickness_by("fdm")
    assert found["geometry"]["beam_thickness_m"] >= thinnest_m
    assert found["geometry"]["column_width_m"] >= thinnest_m
    assert stress_at(found["geometry"], found["wire"]["travel_m"]) < made_of.allowable_stress_pa.value
    assert found["wire"]["wire_stress_pa"] < 172e6  # what the vendor allows
    mesh = require_oracle("trimesh").load_mesh(tmp_path / "finger.stl")
    assert mesh.is_volume
    assert mesh.extents[2] == pytest.approx(1e3 * found["geometry"]["beam_depth_m"], abs=0.05)


@pytest.mark.oracles
def test_the_pretensioner_keeps_every_limit_of_printer_and_material(
    musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    file = FOLDER / "petg_pretensioner.toml"
    answer = musclewire("design", "pretensioner", file, "--solid", tmp_path / "part.stl", "--json")
    assert answer.code == 0, answer.err
    found = answer.json
    assert found["holds"]
    assert found["process"] == "print"
    assert found["geometry"]["thickness_m"] >= load_material("petg").minimum_thickness_by("print")
    assert found["stress_max_pa"] < found["stress_allowable_pa"]
    mesh = require_oracle("trimesh").load_mesh(tmp_path / "part.stl")
    geometry = found["geometry"]
    size = [geometry[key] for key in ("across_m", "along_m", "depth_m")]
    assert mesh.is_volume
    assert np.asarray(mesh.extents) == pytest.approx(1e3 * np.array(size), abs=0.05)
