"""A slow sine says whether it shows C, and its amplitude rises until it does or a limit is met."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from musclewire.experiment import characterize
from musclewire.experiment._open_loop import levelling_amplitude
from musclewire.files import read_recording
from musclewire.identify import shows_c
from musclewire.rigs import open_rig
from musclewire.signals import Recording


def test_a_loop_that_still_falls_where_it_turned_says_so_in_its_file(tmp_path: Path) -> None:
    with open_rig("simulated") as rig:
        low = characterize(rig, cycles=1, path=tmp_path / "loop.h5")
        high = characterize(rig, cycles=1, amplitude_v=3.6)
    assert low.metadata["shows_c"] is False
    assert read_recording(tmp_path / "loop.h5").metadata["shows_c"] == low.metadata["shows_c"]
    assert high.metadata["shows_c"] is True


def test_a_recording_without_transformation_or_power_is_not_judged() -> None:
    time_s = np.arange(100) * 0.05
    columns = {"time_s": time_s, "cycle": np.ones(100), "wire_resistance_ohm": np.full(100, 17.0)}
    assert shows_c(Recording(columns, {})) is None
    voltages = {"wire_voltage_v": 0.5 + time_s, "shunt_voltage_v": (0.5 + time_s) / 17.0}
    assert shows_c(Recording({**columns, **voltages}, {"shunt_resistance_ohm": 1.0})) is None


@pytest.mark.parametrize("settings", [{}, {"wire": "paper-125um"}, {"pretension_n": 1.0}])
def test_the_amplitude_rises_up_to_a_limit_that_is_named(settings: dict[str, float]) -> None:
    with open_rig("simulated", **settings) as rig:
        found = levelling_amplitude(rig)
        assert rig.drive_amplitude_v < found.amplitude_v <= rig.maximum_voltage_v
        assert not found.levelled
        assert found.stopped_by.endswith("138 C, up to which the alloy was measured")
        raised = characterize(rig, cycles=1, until_level=True)
    assert raised.metadata["amplitude_v"] == pytest.approx(found.amplitude_v, abs=0.02)
    assert raised.metadata["amplitude_raised"] == found.stopped_by


def test_where_no_limit_is_near_it_levels_off_and_an_amplitude_that_is_given_is_kept() -> None:
    with open_rig("simulated", wire="paper-200um") as rig:
        found = levelling_amplitude(rig)
    assert found.levelled
    assert found.stopped_by == ""
    with open_rig("simulated") as rig:
        assert characterize(rig, amplitude_v=3.0, cycles=1, until_level=True).metadata["amplitude_v"] == 3.0


def test_an_amplitude_at_which_the_fall_has_levelled_off_already_is_not_called_raised() -> None:
    with open_rig("simulated", wire="flexinol-0.15-lt", pretension_n=2.9) as rig:
        loop = characterize(rig, cycles=1, until_level=True)
        assert loop.metadata["amplitude_v"] == rig.drive_amplitude_v
    assert "amplitude_raised" not in loop.metadata
    assert loop.metadata["shows_c"] is True
