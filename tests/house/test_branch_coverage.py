"""The measure of branch coverage: what its file names exists, shares add up, and parts of other source are refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from checks import branch_coverage
from tests.places import CHECKOUT

SUITE = branch_coverage.SETTINGS["without_compilation"]


@pytest.mark.parametrize("name", [*SUITE["tests"], *(left_out["test"] for left_out in SUITE["deselect"])])
def test_every_test_that_it_names_exists(name: str) -> None:
    """pytest says nothing of a deselected test that nobody has."""
    path, _, function = name.partition("::")
    assert (CHECKOUT / path).exists()
    assert not function or f"def {function.partition('[')[0]}(" in (CHECKOUT / path).read_text("utf-8")


def test_every_test_left_out_belongs_to_the_suite_and_has_its_reason() -> None:
    for left_out in SUITE["deselect"]:
        assert left_out["test"].partition("::")[0] in SUITE["tests"]
        assert len(left_out["reason"]) > 20


def test_a_share_is_lines_and_branches_together_and_a_room_is_its_folder() -> None:
    def figures(run: int, there: int) -> dict[str, int]:
        return {"covered_lines": run, "covered_branches": 1, "num_statements": there, "num_branches": 2}

    files = {"rigs/one.py": figures(7, 8), "rigs/serial/two.py": figures(9, 18), "rigs_of_others.py": figures(0, 50)}
    share = branch_coverage.share_of("rigs", files, 60.0)
    assert (share.run, share.there) == (18, 30)
    assert share.percent == pytest.approx(60.0)
    assert not share.missed
    assert branch_coverage.share_of("", files, None).there == 82
    assert branch_coverage.share_of("rigs", files, 60.1).missed


def test_groups_that_were_measured_before_count_unless_the_source_has_changed(tmp_path: Path) -> None:
    def keep(group: str, passed: bool, source: str) -> None:
        (tmp_path / group).mkdir()
        (tmp_path / group / "run.json").write_text(json.dumps({"passed": passed, "source": source}), "utf-8")

    keep("slow", False, branch_coverage.source_hash())
    keep("default", True, branch_coverage.source_hash())
    (tmp_path / "browser").mkdir()  # interrupted before its end
    assert branch_coverage.kept(tmp_path) == {"default": True, "slow": False}
    keep("emulated", True, "of last week")
    with pytest.raises(SystemExit, match="other source of the package: run --groups emulated again"):
        branch_coverage.kept(tmp_path)
