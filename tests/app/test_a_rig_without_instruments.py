"""A rig that measures no movement, as a board: a recording of it is what was asked for, not a failure."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import musclewire as mw
from musclewire.signals import Recording

PERIOD_S = 30.0
INSTRUMENTS = ("force_n", "displacement_m", "endpoint_displacement_m", "endpoint_force_n")


@pytest.fixture(scope="module")
def without_instruments(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A rig file that replays a slow loop from which the instruments' columns are taken."""
    folder = tmp_path_factory.mktemp("rig")
    with mw.open_rig("simulated", seed=3) as rig:
        loop = mw.characterize(rig, period_s=PERIOD_S, cycles=1)
    kept = {name: values for name, values in loop.whole_columns.items() if name not in INSTRUMENTS}
    Recording(kept, loop.metadata).save(folder / "recorded.h5")
    (folder / "rig.toml").write_text('kind = "replay"\nrecording = "recorded.h5"\n', "utf-8")
    return folder / "rig.toml"


def test_a_perfect_run_without_an_instrument_ends_well_and_says_how_a_model_comes(
    without_instruments: Path, musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    output = tmp_path / "loop.h5"
    arguments = ("characterize", without_instruments, "-o", output, "--period", f"{PERIOD_S} s", "--cycles", "1")
    answer = musclewire(*arguments)
    assert answer.code == 0, answer.err
    assert "measures no movement" in answer.out
    assert "'musclewire fit' with --wire" in answer.out
    assert "displacement_m" in answer.out
    assert musclewire(*arguments, "--overwrite", "--json").json["strain_gap_pct"] is None


def test_a_recording_that_has_the_instrument_and_shows_no_loop_still_ends_with_one(
    musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    answer = musclewire("characterize", "simulated", "-o", tmp_path / "x.h5", "--amplitude", "0.4 V", "--period", "5 s")
    assert answer.code == 1
    assert answer.out.count("\n") == 2
