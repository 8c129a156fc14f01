"""A wire file stands for one wire: what was written is read back to the last bit, and a mistake in it is one line."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.parameters import Parameter, bench_known_with, load_alloy, load_wire, read_wire_file, wire_file_text
from musclewire.small_files import toml_text

FRICTION = Parameter(value=0.0123, unit="N", kind="fitted", source="a loop", note="0.01 to 0.02")


def text(name: str = "paper-125um") -> str:
    wire = load_wire(name)
    return wire_file_text("mine", "as found", wire, load_alloy(wire.alloy), {"guide_friction_n": FRICTION})


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "mine.toml"
    path.write_text(text(), "utf-8")
    return path


@pytest.mark.parametrize("name", ["paper-125um", "flexinol-0.10-lt"])
def test_wire_alloy_and_bench_read_back_as_they_were(name: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text(name), "utf-8")
    wire, found = load_wire(name), load_wire(str(path))
    assert found.items() == wire.items()
    assert load_alloy(found.alloy).items() == load_alloy(wire.alloy).items()
    assert (found.name, found.description) == ("mine", "as found")
    assert bench_known_with(str(path)) == {"guide_friction_n": FRICTION}


def test_a_file_without_early_grains_means_one_population(tmp_path: Path) -> None:
    """Files of earlier versions, which calibrate wrote: what they do not say is assumed, and said to be."""
    path = tmp_path / "mine.toml"
    old = re.sub(r"\[alloy\.early_(fraction|width)\]\n(?:.+\n)+\n?", "", text())
    assert "early" not in old
    path.write_text(old, "utf-8")
    alloy = load_alloy(load_wire(str(path)).alloy)
    assert (alloy.early_fraction.value, alloy.early_width.value) == (0.0, 1.0)
    assert alloy.early_fraction.kind == alloy.early_width.kind == "assumed"


QUANTILES = """
[alloy.grain_quantiles]
fraction = [0.0, 0.17, 0.5, 1.0]
offset = [-4.7, -1.0, 0.1, 4.0]
kind = "measured"
source = "an isobar"
"""


def test_measured_quantiles_read_back_as_they_were(tmp_path: Path) -> None:
    path, again = tmp_path / "mine.toml", tmp_path / "again.toml"
    path.write_text(text() + QUANTILES, "utf-8")
    found = read_wire_file(path)
    assert found.alloy.grain_quantiles is not None
    assert found.alloy.grain_quantiles.offset == (-4.7, -1.0, 0.1, 4.0)
    again.write_text(wire_file_text("mine", "", found.wire, found.alloy, {}), "utf-8")
    assert read_wire_file(again).alloy.grain_quantiles == found.alloy.grain_quantiles


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("0.17, 0.5, 1.0", "0.17, 1.0", "fraction has 3 numbers and offset 4: give one for each fraction"),
        ("0.5, 1.0", "0.5, 0.9", "fraction goes from 0 to 0.9: let it begin with 0 and end with 1"),
        ("0.17, 0.5", "0.5, 0.17", "fraction must ascend, and 0.17 comes after 0.5: sort the table"),
        ("-1.0, 0.1", "-1.0, -1.0", "offset must ascend, and -1 comes after -1: sort the table"),
        ("0.1, 4.0", "nan, 4.0", "grain_quantiles.offset.2: must be a finite number"),
        ("[-4.7, -1.0, 0.1, 4.0]", "1.0", "grain_quantiles.offset: must be a list of numbers"),
    ],
)
def test_quantiles_that_are_none_are_one_line_that_says_what_to_do(
    tmp_path: Path, old: str, new: str, words: str
) -> None:
    path = tmp_path / "mine.toml"
    assert old in QUANTILES
    path.write_text(text() + QUANTILES.replace(old, new), "utf-8")
    refused(path, words)


def refused(path: Path, words: str) -> None:
    with pytest.raises(CallerError) as caught:
        read_wire_file(path)
    message = str(caught.value)
    assert message.startswith(f"wire file {path}")
    assert words in message


@given(st.text(st.characters(exclude_categories=["Cs"])))
def test_any_text_survives_toml(given_text: str) -> None:
    assert tomllib.loads(toml_text({"x": [given_text]})) == {"x": [given_text]}


@given(st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False, allow_infinity=False))
def test_a_yes_a_no_and_any_number_survive_toml_to_the_bit(value: float) -> None:
    read = tomllib.loads(toml_text({"x": value}))["x"]
    assert (type(read), read) == (type(value), value)


def test_a_wire_file_that_changes_is_read_afresh(file: Path) -> None:
    before = load_wire(str(file)).diameter_m.value
    file.write_text(text("paper-200um"), "utf-8")
    assert load_wire(str(file)).diameter_m.value != before


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[wire.diameter_m]", "[wire.diametre_m]", "unknown key 'wire.diametre_m'; did you mean 'diameter_m'?"),
        ("[bench.guide_friction_n]", "[bench.guide_frictoin_n]", "did you mean 'guide_friction_n'?"),
        ('format = "musclewire-wire"', "", "'format' is missing"),
        ("version = 1", "version = 2", "version"),
        ("value = 0.0123", "value = -0.1", "bench.guide_friction_n is -0.1 N, it must be 0 or more"),
        ('unit = "N"\nkind = "fitted"', 'unit = "mN"\nkind = "fitted"', "it must be given in 'N'"),
        ("version = 1", "version", "cannot be read"),
    ],
)
def test_a_mistake_is_one_line_that_names_the_file_and_the_key(file: Path, old: str, new: str, words: str) -> None:
    whole = text()
    assert old in whole
    file.write_text(whole.replace(old, new), "utf-8")
    refused(file, words)


def test_a_file_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(CallerError, match="there is no wire file"):
        load_wire(str(tmp_path / "none.toml"))
