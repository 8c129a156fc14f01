"""The numbers of a run on a terminal: what they say, and that the loop only leaves a row behind."""

from __future__ import annotations

import math
from io import StringIO

import pytest
from rich.console import Console

import musclewire as mw
from musclewire.app import _output as output
from musclewire.app._live_numbers import numbers_text

ROW = {"time_s": 1.0, "drive_voltage_v": 1.5, "wire_voltage_v": 1.4, "shunt_voltage_v": 0.1}


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        (
            {"target_strain": 0.025, "estimated_strain": 0.0248, "estimate_std": 1e-4, "valid": 1.0},
            "target 2.50 %   estimate 2.48 %   resistance 14.000 ohm   drive 1.500 V   about 77 C",
        ),
        (
            {"estimated_grip_force_n": 0.5, "target_grip_force_n": math.nan, "estimated_temperature_k": 363.15},
            "target -   estimate 0.500 N   resistance 14.000 ohm   drive 1.500 V   about 90 C",
        ),
        ({"shunt_voltage_v": 0.0}, "resistance -   drive 1.500 V   about 77 C"),
    ],
)
def test_a_row_is_said_with_the_units_of_its_columns(columns: dict[str, float], said: str) -> None:
    assert numbers_text({**ROW, **columns}, 1.0, 350.15) == said


def test_a_bar_shows_the_numbers_of_the_last_sample_when_it_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    shown = StringIO()
    monkeypatch.setattr(output, "console", lambda: Console(file=shown, force_terminal=True, width=120))
    with mw.open_rig("simulated") as rig, output.progress_bar("Closed loop", 10.0, rig=rig) as on_sample:
        for _ in range(3):
            sample = rig.exchange(1.0)
            on_sample({**sample._asdict(), "target_strain": 0.02, "estimated_strain": 0.019, "valid": 1.0})
    assert "target 2.00 %   estimate 1.90 %   resistance" in shown.getvalue()
    assert "drive 1.000 V   about" in shown.getvalue()


def test_on_a_pipe_there_is_one_line_without_numbers(capsys: pytest.CaptureFixture[str]) -> None:
    with mw.open_rig("simulated") as rig, output.progress_bar("Closed loop", 10.0, rig=rig) as on_sample:
        for _ in range(3):
            on_sample(rig.exchange(1.0)._asdict())
    assert capsys.readouterr().err == "Closed loop\n"
