"""``--real-time-priority`` and ``--cpu`` on the command line."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="priority and pinning are Linux's")


def test_priority_without_a_clock_is_refused_before_anything_is_driven(
    musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    answer = musclewire("characterize", "simulated", "--real-time-priority", "-o", tmp_path / "loop.h5")
    assert answer.code == 2
    assert "add --real-time" in answer.err
    assert not (tmp_path / "loop.h5").exists()


def test_a_core_that_is_not_there_is_wrong_input(musclewire: Callable[..., Any], tmp_path: Path) -> None:
    answer = musclewire("characterize", "simulated", "--cpu", "4096", "-o", tmp_path / "loop.h5")
    assert answer.code == 2
    assert "core 4096" in answer.err


@pytest.mark.slow
def test_what_the_system_refuses_is_a_warning_and_the_run_goes_on(
    musclewire: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("musclewire.rigs.take_priority", lambda: ["real-time priority is not permitted"])
    answer = musclewire(
        "characterize", "simulated", "--real-time", "--real-time-priority", "--period", "1", "--cycles", "1",
        "-o", tmp_path / "loop.h5", "--json",
    )  # fmt: skip
    assert (tmp_path / "loop.h5").exists()
    assert "warning: real-time priority is not permitted" in answer.err
    assert "real-time priority is not permitted" in answer.json["warnings"]
