"""A page of a rig that does not exist is refused in one line, before anything is written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any


def test_a_page_is_not_opened_for_a_rig_that_does_not_exist(musclewire: Callable[..., Any], tmp_path: Path) -> None:
    answer = musclewire("serve", "simulatd", "-o", tmp_path / "session")
    assert answer.code == 2
    assert "did you mean 'simulated'" in answer.err
    assert len(answer.err.splitlines()) == 1
    assert not (tmp_path / "session").exists()
