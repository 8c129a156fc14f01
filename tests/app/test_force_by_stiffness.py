"""``musclewire control --known-stiffness``: force by a model of strain."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from musclewire.parameters import load_bench


def test_control_turns_strain_into_force_by_a_stiffness(musclewire: Callable[..., Any], model: Path) -> None:
    said = musclewire(
        "control", "simulated", model, "--quantity", "force", "--known-stiffness", "588.6 N/m", "--json"
    ).json
    assert said["known_stiffness_n_per_m"] == 588.6
    assert said["known_friction_n"] == pytest.approx(load_bench("paper").guide_friction_n.value, abs=0.002)
    assert said["mae_max_approached_pct"] <= 5.0
    assert len(said["steps"]) == 11
