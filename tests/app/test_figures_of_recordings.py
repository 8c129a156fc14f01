"""Commands that make a run draw it, and refuse a wrong style before anything is heated."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


def test_a_wrong_style_is_one_line_before_anything_is_heated(musclewire: Callable[..., Any], tmp_path: Path) -> None:
    loop = tmp_path / "loop.h5"
    answer = musclewire("characterize", "simulated", "-o", loop, "--plot", tmp_path / "a.svg", "--plot-style", "natur")
    assert answer.code == 2
    assert "'nature'" in answer.err
    assert not loop.exists()


def test_a_style_without_a_figure_is_refused(musclewire: Callable[..., Any]) -> None:
    answer = musclewire("fit", "lan-fan-2010-table-2", "--plot-style", "nature")
    assert answer.code == 2
    assert "--plot-style belongs to --plot" in answer.err


def test_the_older_figures_have_a_style_too(musclewire: Callable[..., Any], tmp_path: Path) -> None:
    from matplotlib import pyplot

    pyplot.close("all")
    figure = tmp_path / "model.svg"
    assert (
        musclewire("fit", "lan-fan-2010-table-2", "--order", "3", "--plot", figure, "--plot-style", "nature").code == 0
    )
    assert f'width="{89.0 / 25.4 * 72.0:.6g}' in figure.read_text("utf-8")
    assert pyplot.get_fignums() == []


@pytest.mark.slow
def test_loop_run_and_estimate_are_drawn(musclewire: Callable[..., Any], tmp_path: Path) -> None:
    loop, model = tmp_path / "loop.h5", tmp_path / "model.json"
    assert musclewire("characterize", "simulated", "-o", loop, "--plot", tmp_path / "loop.svg").code == 0
    assert musclewire("fit", loop, "-o", model).code == 0
    style = ("--plot-style", "ieee-single")
    assert musclewire("control", "simulated", model, "--plot", tmp_path / "run.pdf", *style).code == 0
    assert musclewire("estimate", model, loop, "--plot", tmp_path / "estimate.png").code == 0
    assert "<svg" in (tmp_path / "loop.svg").read_text("utf-8")
    assert (tmp_path / "run.pdf").read_bytes().startswith(b"%PDF")
    assert (tmp_path / "estimate.png").stat().st_size > 10_000


@pytest.mark.slow
def test_training_home_move_demo_and_what_was_imported_are_drawn(
    musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    loop, model = tmp_path / "loop.h5", tmp_path / "model.json"
    figures = {name: tmp_path / f"{name}.svg" for name in ("demo", "train", "home", "import")}
    assert musclewire("characterize", "simulated", "-o", loop).code == 0
    assert musclewire("fit", loop, "-o", model).code == 0
    homed = ("-o", tmp_path / "homed.json")
    assert musclewire("home", "simulated", model, *homed, "--plot", figures["home"]).code == 0
    assert musclewire("train", "simulated", "--plot", figures["train"]).code == 0
    assert musclewire("demo", "-o", tmp_path / "demo", "--plot", figures["demo"]).code == 0
    assert musclewire("import", loop, "--plot", figures["import"]).code == 0
    assert [name for name, path in figures.items() if "<svg" not in path.read_text("utf-8")] == []


def test_a_figure_of_two_files_that_are_not_joined_is_refused(musclewire: Callable[..., Any], tmp_path: Path) -> None:
    answer = musclewire("import", "one.csv", "two.csv", "--plot", tmp_path / "both.svg")
    assert answer.code == 2
    assert "--plot draws one recording, 2 were given" in answer.err
