"""The .zip of an exported library keeps to Arduino's written library specification (format 1.5).

arduino-lint, which checks the same and more, is in no package registry that CI reaches, and was not run.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from tests.extras.board.export.export_parts import usual_model, whole_model

from musclewire.app import run
from musclewire.sensing import save_model

FIELDS = ("name", "version", "author", "maintainer", "sentence", "paragraph", "category", "url", "architectures")
CATEGORIES = (
    "Display", "Communication", "Signal Input/Output", "Sensors", "Device Control", "Timing", "Data Storage",
    "Data Processing", "Other",
)  # fmt: skip
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _.-]{0,62}")
SEMANTIC = re.compile(r"\d+\.\d+(\.\d+)?([-+][0-9A-Za-z.-]+)?")


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    """Return the .zip that the command writes."""
    folder = tmp_path_factory.mktemp("arduino")
    save_model(whole_model(), folder / "model.json")
    asked = ["export", "c", folder / "model.json", "-o", folder / "library", "--name", "elbow"]
    assert run([str(one) for one in (*asked, "--arduino-zip", folder / "elbow.zip")]) == 0
    return zipfile.ZipFile(folder / "elbow.zip")


def properties(archive: zipfile.ZipFile) -> dict[str, str]:
    lines = archive.read("elbow/library.properties").decode("utf-8").splitlines()
    return dict(line.split("=", 1) for line in lines)


def test_one_folder_holds_all_of_it(archive: zipfile.ZipFile) -> None:
    names = archive.namelist()
    assert {name.split("/")[0] for name in names} == {"elbow"}
    assert {"elbow/library.properties", "elbow/keywords.txt", "elbow/LICENSE"} <= set(names)
    assert not [name for name in names if name.endswith((".exe", ".o", ".a")) or "/." in name]


def test_its_properties_are_those_of_the_specification(archive: zipfile.ZipFile) -> None:
    found = properties(archive)
    assert set(FIELDS) <= set(found)
    assert NAME.fullmatch(found["name"])
    assert not found["name"].lower().startswith("arduino")
    assert SEMANTIC.fullmatch(found["version"])
    assert found["category"] in CATEGORIES
    assert all(found[field] for field in FIELDS if field != "url")
    assert not found["paragraph"].startswith(found["sentence"])
    assert all(f"elbow/src/{header.strip()}" in archive.namelist() for header in found["includes"].split(","))


def test_a_sketch_has_the_name_of_its_folder_and_includes_the_library(archive: zipfile.ZipFile) -> None:
    sketches = [name for name in archive.namelist() if name.startswith("elbow/examples/") and name.endswith(".ino")]
    assert [Path(name).stem for name in sketches] == [Path(name).parent.name for name in sketches] == ["elbow"]
    assert "#include <musclewire.h>" in archive.read(sketches[0]).decode("utf-8")


def test_keywords_are_names_of_the_header_with_a_tab(archive: zipfile.ZipFile) -> None:
    header = archive.read("elbow/src/musclewire.h").decode("utf-8")
    rows = [line.split("\t") for line in archive.read("elbow/keywords.txt").decode("utf-8").splitlines()]
    assert all(len(row) == 2 and row[0] in header and row[1] in {"KEYWORD1", "KEYWORD2"} for row in rows)
    assert {"mw_controller", "mw_start", "mw_tick"} <= {row[0] for row in rows}


def test_another_ending_is_refused_before_anything_is_written(tmp_path: Path, musclewire: Callable[..., Any]) -> None:
    asked = ("export", "c", "model.json", "-o", tmp_path / "library", "--arduino-zip", tmp_path / "a.tar")
    assert ".zip" in musclewire(*asked).refusal
    assert not (tmp_path / "library").exists()


def test_gains_that_no_controller_can_have_are_refused_before_anything_is_written(
    tmp_path: Path, musclewire: Callable[..., Any]
) -> None:
    """Whoever edited them has to hear of it, also where the fuzzy PID takes none."""
    impossible = {"controller": "feedforward", "settings": {"closed_loop_time_s": -1.0}}
    save_model(replace(usual_model(), gains=impossible), tmp_path / "model.json")
    refusal = musclewire("export", "c", tmp_path / "model.json", "-o", tmp_path / "library").refusal
    assert "gains" in refusal
    assert "closed_loop_time_s" in refusal
    assert not (tmp_path / "library").exists()
