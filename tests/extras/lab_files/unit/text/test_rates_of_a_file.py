"""Rates that a text file states twice, or that are not those of its own times: a disagreement is named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from musclewire.errors import RecordingError
from musclewire.files import ImportMapping, read_recording
from musclewire.identify import import_recording
from musclewire.judge import judge_readings

TIMES_S = 0.05 * np.arange(200)


def written(path: Path, head: str, clock: float | None = None) -> Path:
    volts = 3.0 + np.sin(TIMES_S)
    names = "U [V];I [A]" if clock is None else "t [s];U [V];I [A]"
    times = ["" if clock is None else f"{clock * t:.6g};" for t in TIMES_S]
    rows = [f"{t}{v:.6f};{v / 10.0:.6f}" for t, v in zip(times, volts, strict=True)]
    path.write_text("\n".join([head, "", names, *rows, ""]), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "head", ["Abtastrate Kanal 1: 20 Hz\nAbtastrate Kanal 2: 10 Hz", "Abtastrate: 20 Hz\nAbtastrate: 10 Hz"]
)
def test_of_two_rates_without_times_none_is_chosen(tmp_path: Path, head: str) -> None:
    path = written(tmp_path / "meter.txt", head)
    with pytest.raises(RecordingError, match=r"a row every 0\.05 s, .* a row every 0\.1 s: give the sample period"):
        read_recording(path)
    given = read_recording(path, mapping=ImportMapping(sample_period_s=0.05))
    assert given["time_s"][-1] == pytest.approx(TIMES_S[-1])


def test_one_rate_of_both_channels_is_the_clock(tmp_path: Path) -> None:
    recording = read_recording(written(tmp_path / "meter.txt", "Abtastrate Kanal 1: 20 Hz\nAbtastrate Kanal 2: 20 Hz"))
    assert recording["time_s"][-1] == pytest.approx(TIMES_S[-1])
    assert "clock_doubted" not in recording.metadata


def test_times_in_another_unit_than_the_stated_rate_are_named_by_import_and_by_what_uses_them(tmp_path: Path) -> None:
    path = written(tmp_path / "meter.txt", "Abtastrate: 20 Hz", clock=1e3)
    understood = import_recording(path, tmp_path / "meter.h5")
    assert any("abtastrate_hz states a row every 0.05 s" in note for note in understood.notes)
    for file in (path, tmp_path / "meter.h5"):
        recording = read_recording(file)
        assert "one every 50 s" in "".join(judge_readings(recording.columns, recording.metadata).findings)
