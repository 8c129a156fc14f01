"""``fit --relative-resistance``: what it makes reads the recordings of another wire of the kind, and moves none."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import musclewire as mw
from musclewire.signals import Recording


def test_a_relative_model_is_fitted_estimates_another_wire_and_is_refused_by_a_rig(
    musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    loop_file, other_file, model_file = (tmp_path / name for name in ("loop.h5", "other.h5", "model.json"))
    with mw.open_rig("simulated") as rig:
        loop = mw.characterize(rig, period_s=20.0)
    loop.save(loop_file)
    columns = {name: values for name, values in loop.columns.items() if name != "drive_voltage_v"}
    Recording({**columns, "wire_voltage_v": 1.2 * loop["wire_voltage_v"]}, loop.metadata).save(other_file)
    made = musclewire("fit", loop_file, "--relative-resistance", "-o", model_file, "--json")
    assert made.code == 0
    assert made.json["resistance_max_ohm"] < 1.1
    own, other = (musclewire("estimate", model_file, file, "--json").json for file in (loop_file, other_file))
    assert abs(other["rms_pct"] - own["rms_pct"]) < 0.05
    refused = musclewire("control", "simulated", model_file)
    assert refused.code == 2
    assert "--relative-resistance" in refused.err
