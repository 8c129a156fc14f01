"""The command that runs a study: what it writes, what it refuses, and how it ends when it is stopped."""

from __future__ import annotations

import csv
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from tests.app.interrupting import ONE_IN_CI, PATIENCE_S, start
from tests.command_line import CommandLine

STUDY = """
format = "musclewire-study"
version = 1
name = "two & three"
run = { kind = "simulate", supply = "3.2 V", duration = "3 s", keep = ["stroke", "energy_j", "strain"] }
sampling = { method = "sobol", samples = 64 }
parameters.pretension.values = ["1.5 N", "1.9 N"]
parameters.convection_factor = { low = 0.85, high = 0.95 }
"""

BLOCKED = """
import sys
for package in ("dask", "distributed", "xarray", "pyarrow", "SALib"):
    sys.modules[package] = None  # importing it raises ImportError
"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    path = tmp_path / "study.toml"
    path.write_text(STUDY, "utf-8")
    return path


@pytest.mark.slow
def test_it_writes_a_data_set_a_table_and_a_page_that_needs_no_other_file(study: Path, musclewire: CommandLine) -> None:
    folder = study.parent / "out"
    answer = musclewire("sweep", study, "-o", folder, "--workers", 1, "--json")
    assert answer.code == 0, answer.err
    assert (answer.json["runs"], answer.json["evaluated"], answer.json["failed"]) == (128, 128, 0)
    assert sorted(path.name for path in folder.iterdir()) == [
        "chunks", "data.parquet", "report.html", "sensitivity.csv", "study.json",
    ]  # fmt: skip
    assert list((folder / "chunks").iterdir()) == []
    rows = list(csv.DictReader((folder / "sensitivity.csv").read_text("utf-8").splitlines()))
    assert {(row["quantity"], row["parameter"]) for row in rows} == {
        (quantity, name) for quantity in ("stroke", "energy_j") for name in ("pretension", "convection_factor")
    }
    page = (folder / "report.html").read_text("utf-8")
    assert "two &amp; three" in page
    assert not re.search(r'(?:src|href)="(?!data:|#|https://doi\.org)[^"]', page)
    assert page.count("<svg") >= 5
    again = musclewire("sweep", study, "-o", folder, "--json", "--plot", folder / "all.svg", "--plot-style", "nature")
    assert again.json["evaluated"] == 0
    assert "<svg" in (folder / "all.svg").read_text("utf-8")
    assert again.json["quantities"] == answer.json["quantities"]


def test_a_plan_runs_nothing(study: Path, musclewire: CommandLine) -> None:
    answer = musclewire("sweep", study, "--plan", "--json")
    assert answer.json["runs"] == 128
    assert answer.json["parameters"]["pretension"] == {"unit": "N", "from": 1.5, "to": 1.9}
    assert [path.name for path in study.parent.iterdir()] == ["study.toml"]


def test_the_list_has_every_kind_and_what_may_vary(musclewire: CommandLine) -> None:
    answer = musclewire("sweep", "--list", "--json")
    assert {"characterize", "simulate", "control"} <= set(answer.json["kinds"])
    assert answer.json["parameters"]["pretension_n"] == "N"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["sweep"], "give a study file"),
        (["sweep", "STUDY", "--scheduler", "tcp://x:1", "--workers", "2"], "leave one out"),
    ],
)
def test_wrong_usage_is_one_line(arguments: list[str], words: str, study: Path, musclewire: CommandLine) -> None:
    assert words in musclewire(*[str(study) if item == "STUDY" else item for item in arguments]).refusal


def test_a_study_in_which_every_run_fails_ends_with_1(study: Path, musclewire: CommandLine) -> None:
    study.write_text(STUDY.replace("3.2 V", "9 V"), "utf-8")
    answer = musclewire("sweep", study, "-o", study.parent / "out", "--workers", 1)
    assert answer.code == 1
    assert "128 of 128 runs failed; the first: CallerError: the drive of 9 V" in answer.err


def without_extra(folder: Path, code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", BLOCKED + code], cwd=folder, capture_output=True, text=True, check=False
    )


def test_without_the_extra_the_command_says_so_before_it_computes_anything(study: Path) -> None:
    code = "from musclewire.app._main import run; sys.exit(run(['sweep', 'study.toml']))"
    done = without_extra(study.parent, code)
    assert done.returncode == 2
    assert 'pip install ".[sweep]"' in done.stderr
    assert [path.name for path in study.parent.iterdir()] == ["study.toml"]


@pytest.mark.slow
def test_without_the_extra_python_runs_studies_all_the_same(study: Path) -> None:
    code = "import musclewire as mw; result = mw.sweep('study.toml', 'out'); print(len(result), result.failed)"
    done = without_extra(study.parent, code)
    assert done.stdout.split() == ["128", "0"], done.stderr


@pytest.mark.parametrize(("number", "code"), ONE_IN_CI)
def test_a_stopped_study_says_how_to_continue(number: signal.Signals, code: int, study: Path) -> None:
    study.write_text(STUDY.replace("samples = 64", "samples = 8192").replace('"3 s"', '"60 s"'), "utf-8")
    folder = study.parent / "out"
    process, chunks = start("sweep", study, "-o", folder, "--runs-per-chunk", 32), folder / "chunks"
    while process.poll() is None and not list(chunks.glob("*-*.npz")):
        time.sleep(0.05)
    process.send_signal(number)
    _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == code, err
    assert f"finished runs are kept in {folder}, and the same command continues" in err
    assert list(chunks.glob("*-*.npz"))
