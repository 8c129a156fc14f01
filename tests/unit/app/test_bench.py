"""``musclewire bench`` prints ratios with the work that they are for, and one JSON document on request."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.places import CHECKOUT

from musclewire.app import _bench_rows as bench_rows


def test_the_table_says_what_the_time_is_for_and_on_which_machine(musclewire: Callable[..., Any]) -> None:
    answer = musclewire("bench", "--quick", "--only", "closed_loop_period")
    assert answer.code == 0, answer.err
    assert "What the time is for" in answer.out
    assert "Gflop/s" in answer.out
    assert "1 of 2: closed_loop_period" in answer.err


@pytest.fixture
def _outside_a_checkout(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_rows, "checkout", lambda: None)


@pytest.mark.usefixtures("_outside_a_checkout")
def test_an_installed_wheel_times_four_rows_and_names_the_others(musclewire: Callable[..., Any]) -> None:
    answer = musclewire("bench", "--quick", "--json")
    assert answer.code == 0, answer.err
    assert answer.err == ""
    found = answer.json
    assert set(found) == {"rows", "left_out", "machine", "quick", "wall_s"}
    assert all(
        {"name", "ours_us", "theirs_us", "theirs", "ratio", "work", "turns"} <= set(row) for row in found["rows"]
    )
    names = [row["name"].partition("[")[0] for row in found["rows"]]
    assert names == ["step", "closed_loop_period", "exchange", "fuzzy_pid_tick"]
    assert all(min(row["ours_us"], row["theirs_us"], row["ratio"]) > 0.0 for row in found["rows"])
    assert found["left_out"] == [{"name": name, "needs_extra": None} for name in bench_rows.CHECKOUT_ROWS]
    assert found["machine"]["cores"] >= 1
    assert found["machine"]["vector_flops_per_s"] is None


def test_the_rows_that_only_a_checkout_has_are_listed() -> None:
    folder = bench_rows.checkout()
    assert folder is not None
    names = [case.name for case in bench_rows.checkout_module(folder, "cases").cases()]
    assert [name for name in names if "threads" not in name] == list(bench_rows.CHECKOUT_ROWS)


def test_a_checkout_is_the_tree_of_the_package_or_else_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tree, installed = tmp_path / "tree", tmp_path / "lib" / "site-packages" / "musclewire" / "__init__.py"
    for name in ("src/musclewire/__init__.py", "benchmarks/speed/cases.py"):
        (tree / name).parent.mkdir(parents=True)
        (tree / name).touch()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(bench_rows.musclewire, "__file__", str(installed))
    assert bench_rows.checkout() is None
    monkeypatch.chdir(tree)
    assert bench_rows.checkout() == tree
    (tree / "src/musclewire/__init__.py").unlink()
    assert bench_rows.checkout() is None, "benchmarks of another project are not run"
    monkeypatch.undo()
    assert bench_rows.checkout() == CHECKOUT
