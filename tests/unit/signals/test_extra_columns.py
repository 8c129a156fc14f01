"""Columns of other packages' estimators and controllers: recorded and read anywhere, without the package."""

from __future__ import annotations

from pathlib import Path

import pytest

from musclewire.errors import CallerError
from musclewire.signals._columns import COLUMNS, known_column
from musclewire.signals._reading import read_recording
from musclewire.signals._recording import Recording

VALUES = {"time_s": [0.0, 0.1], "extra_hottest_k": [300.0, 301.0], "extra_mode": [1.0, 2.0]}


def test_the_unit_of_an_extra_column_is_how_its_name_ends() -> None:
    assert known_column("extra_hottest_k").unit == "K"
    assert known_column("extra_line_resistance_ohm").unit == "ohm"
    assert known_column("extra_mode").unit == ""
    assert known_column("extra_k").unit == ""
    assert "extra_mode" in COLUMNS
    assert "extra_mode" not in list(COLUMNS)


@pytest.mark.parametrize("name", ["extra_", "extra_A", "extra__k", "extra-k", "offset", "extra_k "])
def test_other_names_stay_unknown(name: str) -> None:
    assert name not in COLUMNS
    with pytest.raises(CallerError, match="unknown column"):
        known_column(name)


@pytest.mark.parametrize("suffix", ["h5", "csv"])
def test_they_come_back_from_a_file(tmp_path: Path, suffix: str) -> None:
    Recording(VALUES).save(tmp_path / f"run.{suffix}")
    back = read_recording(tmp_path / f"run.{suffix}")
    assert {name: back[name].tolist() for name in VALUES} == VALUES
