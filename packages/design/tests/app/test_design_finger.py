"""``musclewire design finger``: what a maker types, what comes back, and one line for whatever cannot be."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from tests.places import DOCS

from musclewire.parameters import load_finger

COMMAND = ("design", "finger")
PAPER = ("--stiffness", "1084.4 N/m", "--endpoint", "6 mm", "--travel", "1.05 mm", "--wire", "paper-100um")
PAGE = (DOCS / "how-to/design_a_finger.md").read_text("utf-8").replace("\n", " ")


def test_the_papers_stiffness_and_endpoint_become_a_finger_with_file_drawings_and_figure(
    musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    toml, svg, dxf, png = (tmp_path / name for name in ("f.toml", "f.svg", "f.dxf", "f.png"))
    answer = musclewire(*COMMAND, *PAPER, "-o", toml, "--drawing", svg, "--drawing", dxf, "--plot", png, "--json")
    assert answer.code == 0, answer.err
    found = answer.json
    assert found["stiffness_n_per_m"] == pytest.approx(1084.4, rel=0.01)
    assert found["endpoint_m"] == pytest.approx(6e-3, rel=1e-6)
    assert found["travel_m"] <= 0.03 * 35e-3
    assert found["stress_max_pa"] < 65e6
    assert found["wire"]["endpoint_m"] > 6e-3
    assert all(check["ok"] for check in found["checks"])
    assert all(path.stat().st_size > 200 for path in (toml, svg, dxf, png))
    drawn = ElementTree.parse(svg).getroot()
    assert drawn.get("width", "").endswith("mm")
    assert load_finger(str(toml)).curve.stiffness_n_per_m == pytest.approx(1084.4, rel=0.01)
    again = musclewire(*COMMAND, "--finger", toml, "--json").json
    assert again["geometry"] == found["geometry"]
    assert again["curve"] == found["curve"]
    # The numbers of docs/how-to/design_a_finger.md are those of the command it shows.
    for number in (
        f"{1e3 * found['geometry']['beam_thickness_m']:.2f} mm",
        f"{found['stiffness_n_per_m']:.1f} N/m",
        f"{1e3 * found['travel_m']:.3f} mm of travel",
        f"{found['pulling_force_n']:.3f} N pulling",
        f"{1e-6 * found['stress_max_pa']:.1f} MPa",
    ):
        assert number in PAGE, number


def test_columns_that_bend_themselves_are_found_out(musclewire: Callable[..., Any]) -> None:
    answer = musclewire(*COMMAND, "--stiffness", "1084.4 N/m", "--endpoint", "2 mm")
    assert answer.code == 1
    assert "warning: it does not hold: endpoint, plane stress" in answer.err


@pytest.mark.slow
def test_the_included_finger_grips_foam_and_is_compared(musclewire: Callable[..., Any], tmp_path: Path) -> None:
    figure = tmp_path / "finger.svg"
    asked = ("--finger", "lan-fan-2010", "--object-stiffness", "50 N/m", "--clearance", "4 mm", "--compare")
    answer = musclewire(*COMMAND, *asked, "--plot", figure, "--refined", "3", "--json")
    assert answer.code == 0, answer.err
    found = answer.json
    assert figure.read_text("utf-8").startswith("<?xml")
    fractions = [scheme["range_over_length"] for scheme in found["schemes"]]
    assert fractions == sorted(fractions, reverse=True)
    assert found["foam"]["force_n"] == pytest.approx(found["foam"]["linear_force_n"], rel=0.03)


def test_given_dimensions_are_answered_in_words(musclewire: Callable[..., Any]) -> None:
    answer = musclewire(*COMMAND, "--thickness", "0.18 mm", "--offset", "1 mm", "--depth", "4 mm", "--friction", "0.3")
    assert answer.code == 0, answer.err
    assert "beam          0.18 mm thick, 4.00 mm deep" in answer.out
    assert "easing (friction 0.3)" in answer.out
    assert "no process listed for pom makes a beam of 0.18 mm: the finest, mill, makes 0.8 mm" in answer.err


SIZED = ("--stiffness", "1084.4 N/m")
GIVEN = ("--finger", "lan-fan-2010")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "say which finger"),
        (("--thickness", "0.2 mm"), "--thickness and --offset belong together"),
        ((*SIZED, "--material", "pon"), "did you mean 'pom'?"),
        ((*SIZED, "--wire", "paper-100um", "--wire-length", "5 cm"), " % short"),
        ((*GIVEN, "--depth", "5 mm"), "--depth and --finger exclude each other: a finger's file has all dimensions"),
        ((*GIVEN, "--clearance", "3 mm"), "--clearance has an effect only with --object-stiffness"),
    ],
)
def test_what_cannot_be_is_one_line_and_exit_code_2(
    arguments: tuple[str, ...],
    said: str,
    musclewire: Callable[..., Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert said in musclewire(*COMMAND, *arguments).refusal
    assert list(tmp_path.iterdir()) == []
