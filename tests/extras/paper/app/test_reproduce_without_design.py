"""`musclewire reproduce` where the package that sizes parts is not installed: it names the rows that it leaves out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from tests.command_line import CommandLine

from musclewire import manifest
from musclewire.errors import CallerError
from musclewire.extras.paper import PaperCheck, all_checks
from musclewire.extras.paper._reproduce import all_checks as all_checks_file
from musclewire.extras.paper._reproduce import reproduction
from musclewire.extras.paper._reproduce.designed_parts import paper_pretensioner, schemes_of_fig13

INSTALL = "not installed: pip install ./packages/design in the checkout"
GOOD = PaperCheck("eq1.good", 2.0, "ohm", 0.5, "because", "printed", lambda _: 2.0, origin="predicted")
SIZED = replace(GOOD, name="fig14.sized", needs="design")


@pytest.fixture(autouse=True)
def _without_design(monkeypatch: pytest.MonkeyPatch) -> None:
    there = tuple(one for one in manifest.manifests() if one.name != "design")
    monkeypatch.setattr(manifest, "manifests", lambda: there)


@pytest.mark.parametrize("only", ["fig13a", "fig13b.inward_gain_deg", "fig14", "fig14.envelope_mm[along]"])
def test_a_row_that_is_asked_for_and_cannot_be_measured_is_refused_in_one_line(
    only: str, musclewire: CommandLine, tmp_path: Path
) -> None:
    said = musclewire("reproduce", "--only", only, "--output", tmp_path / "out").refusal
    assert said.startswith(f"musclewire: {only}")
    assert said.strip().endswith(INSTALL)
    assert not (tmp_path / "out").exists()


def test_rows_that_cannot_be_measured_are_left_out_and_named(
    musclewire: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for room in (all_checks_file, reproduction):
        monkeypatch.setattr(room, "all_checks", lambda: [GOOD, SIZED])
    monkeypatch.setattr(reproduction, "known_failures", dict)
    answer = musclewire("reproduce", "--seed", "1", "--output", tmp_path)
    assert answer.code == 0
    left_out = answer.out.split("left out: ")[1]
    assert INSTALL in left_out
    assert "  fig14.sized" in left_out
    found = musclewire("reproduce", "--seed", "1", "--output", tmp_path, "--json").json
    assert [row["name"] for row in found["rows"]] == ["eq1.good"]
    assert list(found["lacking"]) == ["fig14.sized"]
    page = " ".join((tmp_path / "reproduce.html").read_text("utf-8").split())
    assert "Left out: fig14.sized. " in page
    assert INSTALL in page


def test_every_row_that_is_measured_on_a_designed_part_says_so() -> None:
    assert {check.name.split("[")[0] for check in all_checks() if check.needs} == {
        *("fig13a.range_ratio", "fig13b.inward_gain_deg", "fig14.pretensioner_stiffness_n_per_m", "fig14.envelope_mm"),
        *("fig14.softer_than_finger", "fig14.thickness_exponent"),
    }


@pytest.mark.parametrize("sized", [paper_pretensioner, schemes_of_fig13])
def test_a_figure_of_a_designed_part_cannot_be_drawn_and_says_why(sized: Callable[[], object]) -> None:
    sized.cache_clear()  # type: ignore[attr-defined]
    with pytest.raises(CallerError, match=r"pip install \./packages/design in the checkout"):
        sized()
