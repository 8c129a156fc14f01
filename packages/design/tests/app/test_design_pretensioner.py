"""``musclewire design pretensioner``: a part to cut from a stiffness, and one line for whatever cannot be."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from tests.places import DOCS

COMMAND = ("design", "pretensioner")
PAPER = ("--stiffness", "386.2 N/m", "--pretension", "0.71 N", "--finger-stiffness", "1084.4 N/m")
# A small one, quickly computed.
SMALL = ("--beams", "2", "--half-length", "6 mm", "--pitch", "3 mm", "--thickness", "0.8 mm", "--depth", "5 mm")
THIN = ("--beams", "2", "--half-length", "10 mm", "--pitch", "5 mm", "--thickness", "0.5 mm")


@pytest.mark.slow
def test_the_papers_stiffness_becomes_a_part_with_drawings_figure_and_file(
    musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    files = [tmp_path / name for name in ("p.toml", "p.svg", "p.dxf", "figure.svg")]
    toml, svg, dxf, figure = files
    answer = musclewire(*COMMAND, *PAPER, "-o", toml, "--drawing", svg, "--drawing", dxf, "--plot", figure, "--json")
    assert answer.code == 0, answer.err
    found = answer.json
    assert found["stiffness_n_per_m"] == pytest.approx(386.2, rel=0.01)
    assert found["stress_max_pa"] < found["stress_allowable_pa"] < found["stress_yield_pa"]
    geometry = found["geometry"]
    assert geometry["across_m"] <= 24.6e-3
    assert geometry["along_m"] <= 27.6e-3
    assert geometry["depth_m"] <= 10e-3
    assert all(check["ok"] for check in found["checks"])
    assert found["finger_share"] == pytest.approx(1084.4 / (1084.4 + found["stiffness_n_per_m"]))
    assert all(200 < path.stat().st_size < 500_000 for path in files)
    the_drawings_have_its_size(svg, dxf, geometry)
    page = (DOCS / "how-to/design_a_finger.md").read_text("utf-8")
    for key in ("stiffness_n_per_m", "stiffness_guided_n_per_m"):
        assert f"{found[key]:.1f} N/m" in page, "the page has the numbers of the command it shows"
    again = musclewire(*COMMAND, "--file", toml, "--json")
    assert again.code == 0, again.err
    assert again.json["stiffness_n_per_m"] == pytest.approx(found["stiffness_n_per_m"], rel=1e-12)
    assert again.json["geometry"] == geometry


def the_drawings_have_its_size(svg: Path, dxf: Path, geometry: dict[str, float]) -> None:
    import ezdxf

    root = ElementTree.fromstring(svg.read_text("utf-8"))
    margin = 4.0
    assert float(str(root.get("width")).removesuffix("mm")) == pytest.approx(1e3 * geometry["across_m"] + margin)
    assert float(str(root.get("height")).removesuffix("mm")) == pytest.approx(1e3 * geometry["along_m"] + margin)
    document = ezdxf.readfile(dxf)
    assert not document.audit().errors
    outlines = document.modelspace().query("LWPOLYLINE")
    assert [outline.closed for outline in outlines] == [True]
    assert len(document.modelspace().query("CIRCLE")) == 3
    xs = [point[0] for point in outlines[0].get_points()]
    assert max(xs) - min(xs) == pytest.approx(1e3 * geometry["across_m"], abs=1e-6)


def test_dimensions_as_given_are_computed(musclewire: Callable[..., Any]) -> None:
    answer = musclewire(*COMMAND, *THIN, "--travel", "2 mm", "--process", "mill", "--json")
    assert answer.code == 1, "half a millimetre is thinner than is milled"
    found = answer.json
    formula = 3 * 2.6e9 * (10e-3 * 0.5e-3**3 / 12) / (2 * 10e-3**2 * (20e-3 + 15e-3))
    assert found["stiffness_n_per_m"] == pytest.approx(formula, rel=0.03)
    assert [check["name"] for check in found["checks"] if not check["ok"]] == ["thickness"]
    assert "it does not hold: thickness" in answer.err


def test_a_part_larger_than_its_room_is_refused_by_name(musclewire: Callable[..., Any]) -> None:
    answer = musclewire(
        *COMMAND, *SMALL, "--travel", "0.2 mm", "--process", "mill", "--envelope", "30x10x5mm", "--json"
    )
    assert answer.code == 1
    assert [check["name"] for check in answer.json["checks"] if not check["ok"]] == ["size along the wire"]


def test_materials_are_listed(musclewire: Callable[..., Any]) -> None:
    listed = musclewire(*COMMAND, "--list", "--json").json["materials"]
    assert {"pom", "pa12", "spring-steel"} <= {row["name"] for row in listed}
    assert all(math.isfinite(row["youngs_modulus_pa"]) for row in listed)
    assert "spring-steel" in musclewire(*COMMAND, "--list").out


@pytest.mark.slow
def test_a_material_of_ones_own_is_read_from_its_file(musclewire: Callable[..., Any], tmp_path: Path) -> None:
    from musclewire.parameters import folder_of_materials

    own = tmp_path / "mine.toml"
    text = (folder_of_materials() / "pom.toml").read_text("utf-8")
    own.write_text(text.replace('name = "pom"', 'name = "mine"').replace("2.6e9", "1.3e9"), "utf-8")
    arguments = (*COMMAND, *SMALL, "--travel", "0.2 mm", "--process", "mill", "--json")
    stiff, soft = musclewire(*arguments).json, musclewire(*arguments, "--material", own).json
    assert soft["stiffness_n_per_m"] == pytest.approx(0.5 * stiff["stiffness_n_per_m"], rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), ("--stiffness", "--thickness", "--file")),
        (("--stiffness", "386.2 N/m", "--beams", "4"), ("--stiffness and --beams contradict",)),
        (("--stiffness", "386.2 N/m", "--envelope", "24.6x27.6 mm"), ("three sizes and a unit",)),
        (("--file", "nowhere.toml"), ("there is no pretensioner file nowhere.toml",)),
        (("--stiffness", "386.2 N/m", "--drawing", "p.pdf"), ("a drawing is one of .svg, .dxf",)),
    ],
)
def test_what_cannot_be_is_one_line_and_exit_code_2(
    arguments: tuple[str, ...],
    words: tuple[str, ...],
    musclewire: Callable[..., Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    line = musclewire(*COMMAND, *arguments).refusal
    for word in words:
        assert word in line
    assert list(tmp_path.iterdir()) == []
