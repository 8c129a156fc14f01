"""``--real-time-priority`` and ``--cpu`` on the command line."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="priority and pinning are Linux's")


@pytest.mark.slow
def test_what_the_system_refuses_is_a_warning_and_the_run_goes_on(
    musclewire: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("musclewire.rigs.take_priority", lambda: ["real-time priority is not permitted"])
    answer = musclewire(
        "characterize", "simulated", "--real-time", "--clock-speed", 10, "--real-time-priority", "--period", "1 s",
        "--cycles", "1", "-o", tmp_path / "loop.h5", "--json",
    )  # fmt: skip  # no sample is too late for a clock that is faster than time
    assert (tmp_path / "loop.h5").exists(), answer
    assert "warning: real-time priority is not permitted" in answer.err
    assert "real-time priority is not permitted" in answer.json["warnings"]
