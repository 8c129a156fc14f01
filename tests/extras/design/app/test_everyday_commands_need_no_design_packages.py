"""Commands for a wire run where finite elements and drawings are not installed, and commands that say so."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from musclewire.errors import MissingExtraError

BLOCKED = """
import sys
sys.modules["skfem"] = sys.modules["ezdxf"] = None  # importing either raises ImportError
from musclewire.app._main import run
sys.exit(run(sys.argv[1:]))
"""


def without_design_packages(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", BLOCKED, *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.full
def test_a_wire_is_characterized_fitted_controlled_and_simulated(tmp_path: Path) -> None:
    for command in (
        "demo",
        "characterize simulated --cycles 1 --period 12s -o loop.h5",
        "fit loop.h5 -o model.json",
        "control simulated model.json --json",
        "simulate --wire flexinol-0.10-ht --json",
    ):
        done = without_design_packages(tmp_path, *command.split())
        assert done.returncode == 0, f"{command}\n{done.stderr}"


SIZED = ("design", "pretensioner", "--stiffness", "386.2 N/m")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "what"),
    [
        (SIZED, "sizing a part by finite elements"),
        ((*SIZED, "--drawing", "part.dxf"), "sizing a part by finite elements"),
        (("design", "finger", "--finger", "lan-fan-2010"), "sizing a part by finite elements"),
        (("reproduce", "--only", "fig14", "--seed", "1"), "sizing a part by finite elements"),
    ],
)
def test_a_command_that_needs_them_says_so_in_one_line(tmp_path: Path, command: tuple[str, ...], what: str) -> None:
    done = without_design_packages(tmp_path, *command)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1] == f"musclewire: {MissingExtraError(what, 'design')}"
    assert "Traceback" not in done.stderr
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]
