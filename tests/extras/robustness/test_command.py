# ruff: noqa: E402 - a package that may be missing is asked for first
"""``musclewire robustness``: a table, its files, exit code 1 for an unexpected miss, and a run that goes on."""

import pytest
from jsonschema import Draft202012Validator
from tests.tools import require_package

from musclewire.app import json_schema

require_package("musclewire_robustness", "pip install ./studies/robustness")
# README's second command does without the package: its tests are of a group that runs where developers' packages are.
pytestmark = pytest.mark.slow

from musclewire_robustness import benchmark
from musclewire_robustness.settings import KnownMisses, known_misses

ONE = ("--condition", "load +50 %", "--track", "sines", "--workers", "1")


@pytest.fixture
def one_wire(monkeypatch):
    """The benchmark with one wire, for its seconds, the polynomial, which no load forgives, and nothing expected."""
    known = benchmark.bars().model_copy(update={"default_estimator": "polynomial"})
    monkeypatch.setattr(benchmark, "held_out_seeds", lambda: (102,))
    monkeypatch.setattr(benchmark, "bars", lambda: known)
    monkeypatch.setattr(benchmark, "known_misses", lambda: KnownMisses(miss=()))


@pytest.mark.usefixtures("one_wire")
def test_an_unexpected_miss_ends_with_1_and_is_named(tmp_path, musclewire, monkeypatch):
    answer = musclewire("robustness", "-o", tmp_path / "out", "--json", *ONE)
    assert answer.code == 1
    found = answer.json
    Draft202012Validator(json_schema("output-robustness")).validate(found)
    row = next(row for row in found["rows"] if row["estimator"] == "polynomial")
    assert row["disturbance"] == "load"
    assert row["level"] == "+50 %"
    assert 1.0 < row["estimate_rms_pct"] < 8.0
    assert "load +50 %: error" in found["missed"]
    assert found["new_misses"] == found["missed"]
    assert found["seeds"] == [102]
    assert "<svg" in (tmp_path / "out" / "report.html").read_text("utf-8")
    assert (tmp_path / "out" / "rows.csv").read_text("utf-8").startswith("disturbance,level,estimator")
    kept = sorted((tmp_path / "out" / "wires").rglob("*.npz"))
    times = [file.stat().st_mtime_ns for file in kept]
    again = musclewire("robustness", "-o", tmp_path / "out", "--json", *ONE, "--plot", tmp_path / "all.svg")
    assert "<svg" in (tmp_path / "all.svg").read_text("utf-8")
    assert again.json["rows"] == found["rows"]
    assert [file.stat().st_mtime_ns for file in kept] == times
    monkeypatch.setattr(benchmark, "known_misses", known_misses)
    expected = musclewire("robustness", "-o", tmp_path / "out", "--json", *ONE)
    assert expected.code == 0
    assert (expected.json["missed"], expected.json["new_misses"]) == (found["missed"], [])


def test_the_names_can_be_listed(musclewire):
    known = musclewire("robustness", "--list", "--json").json
    assert "load -50 %" in known["conditions"]
    assert "polynomial" in known["estimators"]
