"""The package in examples/own_package, installed as anybody's would be, adds a command, a reader and a kind of rig."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable

import pytest
from tests.places import EXAMPLES

OWN = EXAMPLES / "own_package"
Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="module")
def run_beside_it(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Install a copy of the package in a folder of its own; return what runs Python with it, with its files there."""
    folder = tmp_path_factory.mktemp("beside")
    shutil.copytree(OWN, folder / "own_package")
    offline = ("--no-deps", "--no-build-isolation", "--no-index", "--disable-pip-version-check")
    subprocess.run(
        [sys.executable, "-m", "pip", "install", "-q", *offline, "--target", "installed", "./own_package"],
        cwd=folder,
        check=True,
    )
    before = os.environ.get("PYTHONPATH", "")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [before, str(folder / "installed")]))}

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, *arguments]
        done = subprocess.run(command, cwd=OWN, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done

    return run


@pytest.mark.slow
def test_its_command_is_listed_in_its_own_panel_and_runs(run_beside_it: Run) -> None:
    listed = run_beside_it("-m", "musclewire", "--help").stdout
    assert "Print the resistance in each row of a .wirelog." in listed[listed.index("Wire logs") :]
    assert "--shunt-ohm" in run_beside_it("-m", "musclewire", "ohms", "--help").stdout
    told = run_beside_it("-m", "musclewire", "ohms", "three_rows.wirelog").stdout
    assert told.splitlines() == ["17.000 ohm", "16.900 ohm", "16.800 ohm"]


@pytest.mark.slow
def test_a_file_of_its_format_is_imported_as_a_recording(run_beside_it: Run) -> None:
    told = run_beside_it("-m", "musclewire", "import", "three_rows.wirelog").stdout
    assert "three_rows.wirelog: wire log, 3 rows" in told
    assert "wire_voltage_v: 1.68 to 1.7 V" in told


@pytest.mark.slow
def test_its_kind_of_rig_is_opened_by_a_rig_file_and_gives_a_sample(run_beside_it: Run) -> None:
    program = (
        "import musclewire as mw\n"
        "with mw.open_rig('resistor.toml') as rig:\n"
        "    print(round(rig.exchange(1.8).wire_voltage_v, 3))\n"
    )
    assert run_beside_it("-c", program).stdout == "1.7\n"
