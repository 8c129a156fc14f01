"""docs/reference/versions.md says what this version writes and which Pythons it is for."""

from __future__ import annotations

import importlib.metadata
import json
import tomllib

import pytest
from checks.files_of_release import FOLDER
from tests.house.docs.doc_pages import tables_of
from tests.places import CHECKOUT

PAGE = (CHECKOUT / "docs/reference/versions.md").read_text("utf-8")
FILES = FOLDER / importlib.metadata.version("musclewire")
WRITTEN = {row["File"]: row["`version` that is written"] for table in tables_of(PAGE) for row in table if "File" in row}


@pytest.mark.parametrize(
    ("file", "row"),
    [
        ("model.json", "model, `.json`"),
        ("gripper.json", "trained gripper, `.json`"),
        ("wire.toml", "wire file"),
        ("study.toml", "study"),
        ("finger.toml", "finger, pretensioner, material"),
        ("pretensioner.toml", "finger, pretensioner, material"),
        ("mapping.toml", "mapping"),
    ],
)
def test_the_page_names_the_version_that_is_written(file: str, row: str) -> None:
    text = (FILES / file).read_text("utf-8")
    found = json.loads(text) if file.endswith(".json") else tomllib.loads(text)
    assert WRITTEN[row] == str(found["version"])
