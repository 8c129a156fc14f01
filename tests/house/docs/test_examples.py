"""Every example runs from any folder, leaves nothing behind, and prints what its title promises."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from tests.places import CHECKOUT

from musclewire.extras.studies import read_study

EXAMPLES = sorted((CHECKOUT / "examples").glob("*.py"))

# What each must print: a pattern, so that better parameters do not break the test.
PROMISES = {
    "move_a_wire_by_its_resistance": r"mean \d+\.\d+ %, largest \d+\.\d+ %",
    "fit_a_csv_recording": r"2 % strain requires \d+\.\d+ ohm",
    "compare_rule_bases": r"zhao-1993 .*%(?s:.*)fixed .*%(?s:.*)liu-7x7 .*%(?s:.*)liu-7x7-mirrored .*%",
    "couple_two_fmus": r"2\.5 % +2\.[45]\d\d %",
    "find_the_best_pretension": r"best: \d+\.\d+ N",
    "operate_a_wire_over_the_live_api": r"target 0\.0\d+, estimate 0\.0\d+\n(?s:.*)stopped by the program: stopped",
    "train_by_evolution": r"trained +mean reward -\d\.\d+ (?s:.*)mean error is \d+ % below the plain PID's",
    "train_and_home": r"settled\n(?s:.*)at B the resistance moved by [+-]\d+\.\d+ \+- \d+\.\d+ ohm",
}

# The main job; every run of the tests runs it.
FIRST = "move_a_wire_by_its_resistance"


STUDIES = sorted((CHECKOUT / "examples").glob("*.toml"))


def test_every_study_is_one_and_every_example_promises_something() -> None:
    assert STUDIES
    assert all(len(read_study(path).design) > 1 for path in STUDIES)
    assert [path.stem for path in EXAMPLES] == sorted(PROMISES)


def group_of(name: str) -> tuple[pytest.MarkDecorator, ...]:
    if name == FIRST:
        return ()
    # A training of minutes; what it runs on is tested with the environments.
    return (pytest.mark.full if name == "train_by_evolution" else pytest.mark.documented,)


@pytest.mark.parametrize(
    "path",
    [pytest.param(path, marks=group_of(path.stem)) for path in EXAMPLES],
    ids=lambda path: path.stem,
)
def test_the_example_runs_and_prints_what_it_promises(path: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", str(path)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=600,  # far above what it takes: only a program that hangs meets it
        env={**os.environ, "MPLBACKEND": "Agg"},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert re.search(PROMISES[path.stem], done.stdout), done.stdout
    assert done.stderr == ""
    assert list(tmp_path.iterdir()) == []
