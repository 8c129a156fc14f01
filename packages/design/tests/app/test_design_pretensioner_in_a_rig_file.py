"""The file of a designed pretensioner as the load of a rig."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest


@pytest.mark.slow
def test_a_pretensioners_file_stands_in_a_rig_file_for_its_stiffness(musclewire: Any, tmp_path: Path) -> None:
    made = musclewire("design", "pretensioner", "--stiffness", "386.2 N/m", "-o", tmp_path / "p.toml")
    assert made.code == 0
    text = (
        'wire = "finger-100um"\nbench = "finger"\n'
        '[[load]]\npart = "pretensioner"\nfile = "p.toml"\n'
        '[[load]]\npart = "finger"\nfinger = "lan-fan-2010"\n'
    )
    (tmp_path / "rig.toml").write_text(text, "utf-8")
    assert musclewire("characterize", tmp_path / "rig.toml", "-o", tmp_path / "loop.h5", "--cycles", "1").code == 0
    (tmp_path / "rig.toml").write_text(text.replace('file = "p.toml"', ""), "utf-8")
    answer = musclewire("characterize", tmp_path / "rig.toml", "-o", tmp_path / "again.h5")
    assert (answer.code, "either a stiffness or a file" in answer.err) == (2, True)
