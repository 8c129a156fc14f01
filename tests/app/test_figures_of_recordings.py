"""Commands that make a run draw it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


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
def test_whatever_is_run_estimated_or_imported_is_drawn(
    musclewire: Callable[..., Any], model: Path, tmp_path: Path
) -> None:
    loop = tmp_path / "loop.h5"
    figures = {name: tmp_path / f"{name}.svg" for name in ("loop", "demo", "train", "home", "import")}
    assert musclewire("characterize", "simulated", "-o", loop, "--plot", figures["loop"]).code == 0
    style = ("--plot-style", "ieee-single")
    assert musclewire("control", "simulated", model, "--plot", tmp_path / "run.pdf", *style).code == 0
    assert (tmp_path / "run.pdf").read_bytes().startswith(b"%PDF")
    assert musclewire("estimate", model, loop, "--plot", tmp_path / "estimate.png").code == 0
    assert (tmp_path / "estimate.png").stat().st_size > 10_000
    homed = ("-o", tmp_path / "homed.json")
    assert musclewire("home", "simulated", model, *homed, "--plot", figures["home"]).code == 0
    assert musclewire("train", "simulated", "--plot", figures["train"]).code == 0
    assert musclewire("demo", "-o", tmp_path / "demo", "--plot", figures["demo"]).code == 0
    assert musclewire("import", loop, "--plot", figures["import"]).code == 0
    assert [name for name, path in figures.items() if "<svg" not in path.read_text("utf-8")] == []
