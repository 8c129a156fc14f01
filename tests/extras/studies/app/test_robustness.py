"""``musclewire robustness``: a table, its files, exit code 1 for a missed bar, and a run that goes on."""

import pytest

ONE = ("--condition", "load +50 %", "--track", "sines", "--controllers", "none", "--workers", "1")


@pytest.fixture
def one_wire(monkeypatch):
    """The benchmark with one wire, so that it takes seconds, and with the polynomial, which no load forgives."""
    from musclewire.extras.studies._robustness import benchmark

    known = benchmark.bars().model_copy(update={"default_estimator": "polynomial"})
    monkeypatch.setattr(benchmark, "held_out_seeds", lambda: (102,))
    monkeypatch.setattr(benchmark, "bars", lambda: known)


@pytest.mark.slow
@pytest.mark.usefixtures("one_wire")
def test_a_missed_bar_ends_with_1_and_is_named(tmp_path, musclewire):
    answer = musclewire("robustness", "-o", tmp_path / "out", "--json", *ONE)
    assert answer.code == 1
    found = answer.json
    row = next(row for row in found["rows"] if row["estimator"] == "polynomial")
    assert row["disturbance"] == "load"
    assert row["level"] == "+50 %"
    assert row["controller"] is None
    assert 1.0 < row["estimate_rms_pct"] < 8.0
    assert "load +50 %: error" in found["missed"]
    assert found["seeds"] == [102]
    assert "<svg" in (tmp_path / "out" / "report.html").read_text("utf-8")
    assert (tmp_path / "out" / "rows.csv").read_text("utf-8").startswith("disturbance,level,estimator")
    kept = sorted((tmp_path / "out" / "wires").rglob("*.npz"))
    times = [file.stat().st_mtime_ns for file in kept]
    again = musclewire("robustness", "-o", tmp_path / "out", "--json", *ONE, "--plot", tmp_path / "all.svg")
    assert "<svg" in (tmp_path / "all.svg").read_text("utf-8")
    assert again.json["rows"] == found["rows"]
    assert [file.stat().st_mtime_ns for file in kept] == times


def test_the_names_can_be_listed(musclewire):
    known = musclewire("robustness", "--list", "--json").json
    assert "load -50 %" in known["conditions"]
    assert "polynomial" in known["estimators"]
