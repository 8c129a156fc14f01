"""Steps are written as a text, with the time for which each is held."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from musclewire.files import read_recording


@pytest.mark.parametrize(("text", "hold_s"), [("", 6.0), (" for 2 s", 2.0), (" for 2500 ms", 2.5)])
def test_each_step_is_held_for_the_time_that_is_given(
    text: str, hold_s: float, musclewire: Callable[..., Any], model: Path, tmp_path: Path
) -> None:
    steps = ("--reference", f"1.5 % to 1.8 % by 0.3 %{text}")
    run = tmp_path / "run.h5"
    answer = musclewire("control", "simulated", model, *steps, "-o", run, "--json")
    assert [step["target_pct"] for step in answer.json["steps"]] == pytest.approx([1.5, 1.8, 1.5])
    assert len(read_recording(run)) == pytest.approx(3 * hold_s / 0.05, abs=1)


def test_a_time_without_a_unit_is_refused(musclewire: Callable[..., Any], model: Path) -> None:
    refusal = musclewire("control", "simulated", model, "--reference", "1.5 % to 1.8 % by 0.3 % for 2").refusal
    assert "'2' has no unit" in refusal
