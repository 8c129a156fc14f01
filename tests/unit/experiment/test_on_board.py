"""A run whose targets go to a board: what is ready before the board is armed, and what the recording says."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import pytest
from tests.unit.rigs.serial.board_in_memory import BoardInMemory, rig_on

from musclewire.experiment.on_board import TargetRig
from musclewire.experiment.open_loop import WaveformPolicy
from musclewire.experiment.run import run_on_rig
from musclewire.signals.samples import RawSample


def test_the_file_is_made_before_the_board_is_armed_so_that_its_heater_does_not_expire_meanwhile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.h5"
    rig = rig_on(BoardInMemory())
    take = rig.exchange_target

    def exchange_target(target: float) -> RawSample:
        assert path.exists()
        return take(target)

    monkeypatch.setattr(rig, "exchange_target", exchange_target)
    with rig:
        recording = run_on_rig(cast(Any, TargetRig(rig)), WaveformPolicy(lambda _time_s: 0.01, 0.02), 0.25, path=path)
    assert len(recording) == 5
    assert recording.metadata["limit_maximum_voltage_v"] == rig.maximum_voltage_v
