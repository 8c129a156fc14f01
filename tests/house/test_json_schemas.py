"""Schemas of files accept the files that are read, and refuse what reading refuses for a key or a kind of value."""

from __future__ import annotations

import importlib.metadata
import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from checks.files_of_release import FOLDER, manifest_of
from jsonschema import Draft202012Validator, ValidationError

import musclewire.parameters
from musclewire.app import file_models, json_schema, schema_names

SHIPPED = Path(musclewire.parameters.__file__).parent / "data"
WRITTEN = FOLDER / importlib.metadata.version("musclewire")
KINDS = {name: entry["kind"] for name, entry in manifest_of(WRITTEN)["files"].items()}
FILES = [
    *sorted(SHIPPED.glob("rigs/*.toml")),
    *sorted(SHIPPED.glob("materials/*.toml")),
    *sorted(SHIPPED.glob("fingers/*.toml")),
    *(WRITTEN / name for name, kind in KINDS.items() if kind in {"rig", *file_models()}),
]


def document(path: Path) -> dict[str, Any]:
    text = path.read_text("utf-8")
    found: dict[str, Any] = json.loads(text) if path.suffix == ".json" else tomllib.loads(text)
    return found


def schema_of(path: Path) -> str:
    if path.parent.name == "rigs" or path.name == "rig.toml":
        return f"rig-{document(path).get('kind', 'simulated')}"
    return KINDS.get(path.name) or path.parent.name.removesuffix("s")


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name} {path.name}")
def test_what_ships_and_what_is_written_is_valid_and_a_key_that_no_file_has_is_not(path: Path) -> None:
    schema = Draft202012Validator(json_schema(schema_of(path)))
    schema.validate(document(path))
    with pytest.raises(ValidationError):
        schema.validate({**document(path), "no_such_key": 1})


def test_every_schema_is_valid_itself() -> None:
    for name in schema_names():
        Draft202012Validator.check_schema(json_schema(name))
