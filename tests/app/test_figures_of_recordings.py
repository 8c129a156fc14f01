"""Commands that make a run draw it."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.command_line import CommandLine


@pytest.mark.slow
def test_whatever_is_run_estimated_or_imported_is_drawn(musclewire: CommandLine, model: Path, tmp_path: Path) -> None:
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
