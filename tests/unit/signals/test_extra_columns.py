"""Columns of other packages' estimators and controllers: under their own names, and read without the package."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from musclewire.errors import CallerError
from musclewire.files import read_recording
from musclewire.signals import COLUMNS, Recording, check_columns, known_column
from musclewire.signals._columns import _Columns

VALUES = {"time_s": [0.0, 0.1], "extra_hottest_k": [300.0, 301.0], "extra_mode": [1.0, 2.0]}


def test_the_unit_of_an_extra_column_is_how_its_name_ends() -> None:
    assert known_column("extra_hottest_k").unit == "K"
    assert known_column("extra_line_resistance_ohm").unit == "ohm"
    assert known_column("extra_mode").unit == ""
    assert known_column("extra_k").unit == ""
    assert "extra_mode" in COLUMNS
    assert "extra_mode" not in list(COLUMNS)


@pytest.mark.parametrize("name", ["extra_", "extra_A", "extra__k", "extra-k", "offset", "Offset", "extra_k "])
def test_other_names_stay_unknown(name: str) -> None:
    assert name not in COLUMNS
    with pytest.raises(CallerError, match="unknown column"):
        known_column(name)


@pytest.mark.parametrize("suffix", ["h5", "csv"])
def test_they_come_back_from_a_file(tmp_path: Path, suffix: str) -> None:
    Recording(VALUES).save(tmp_path / f"run.{suffix}")
    back = read_recording(tmp_path / f"run.{suffix}")
    assert {name: back[name].tolist() for name in VALUES} == VALUES


@pytest.fixture(autouse=True)
def nothing_declared(monkeypatch: pytest.MonkeyPatch) -> None:
    """Declare in each test for itself."""
    monkeypatch.setattr(_Columns, "declared", set())


def of(*names: str) -> SimpleNamespace:
    return SimpleNamespace(columns=names)


def test_a_declared_column_is_recorded_under_its_own_name_and_has_the_unit_it_ends_with() -> None:
    check_columns(of("wire_resistance_ohm", "air_shift_w", "play_place", "lost_power_w"), "mine")
    assert known_column("lost_power_w").unit == "W"
    assert Recording({"time_s": [0.0], "play_place": [0.5]})["play_place"].tolist() == [0.5]
    assert known_column("air_shift_w").description.startswith("estimated power")  # one of ours stays what it is


@pytest.mark.parametrize(
    ("names", "why"),
    [
        (("Place",), "lower case"),
        (("play place",), "lower case"),
        ((3,), "lower case"),
        (("force_n",), "which is already the force from a load cell"),
        (("time_s",), "which is already"),
        (("valid",), "which is already"),
        (("place", "place"), "twice"),
    ],
)
def test_a_column_that_cannot_be_recorded_is_refused_and_told_why(names: tuple[str, ...], why: str) -> None:
    with pytest.raises(CallerError, match=f"mine records .*{why}"):
        check_columns(of(*names), "mine")


def test_a_class_whose_columns_are_known_only_once_it_is_made_is_not_judged() -> None:
    check_columns(property(lambda _self: ("Place",)), "mine")
    check_columns(None, "mine")


def test_hdf5_and_a_pickle_bring_them_to_a_program_that_knows_no_such_estimator(tmp_path: Path) -> None:
    check_columns(of("lost_power_w"), "mine")
    run = Recording({"time_s": [0.0, 0.1], "lost_power_w": [1.0, 2.0]})
    run.save(tmp_path / "run.h5")
    (tmp_path / "run.pickle").write_bytes(pickle.dumps(run))
    script = (
        "import sys, pickle, pathlib, musclewire as mw\n"
        "place = pathlib.Path(sys.argv[1])\n"
        "read = mw.read_recording if place.suffix == '.h5' else lambda one: pickle.loads(one.read_bytes())\n"
        "print(read(place)['lost_power_w'].tolist())"
    )
    for name in ("run.h5", "run.pickle"):
        done = subprocess.run([sys.executable, "-c", script, tmp_path / name], capture_output=True, text=True)
        assert done.stdout == "[1.0, 2.0]\n", done.stderr
