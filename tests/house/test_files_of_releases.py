"""Today's code reads what every released version wrote: every number that was in a file is still read out of it."""

from __future__ import annotations

import hashlib
import importlib.metadata
import math
import re
from pathlib import Path
from typing import Any

import pytest
from checks.files_of_release import FOLDER, KINDS, manifest_of, read_as

from musclewire.registry import REPLACED

VERSIONS = sorted(FOLDER.iterdir())
# Readers of other programs' files may round the last digits differently in another version.
RELATIVE = 1e-12
FILES = [
    pytest.param(folder, name, entry, id=f"{folder.name} {name}")
    for folder in VERSIONS
    for name, entry in manifest_of(folder)["files"].items()
]


def differences(was: Any, now: Any, place: str = "") -> list[str]:
    """Where something that was read is missing or another value now; what has been added since is no difference."""
    if isinstance(was, dict) and isinstance(now, dict):
        missing = [f"{place}.{key} is gone" for key in was.keys() - now.keys()]
        return missing + [
            one for key in was.keys() & now.keys() for one in differences(was[key], now[key], f"{place}.{key}")
        ]
    if isinstance(was, list) and isinstance(now, list) and len(was) == len(now):
        return [one for i in range(len(was)) for one in differences(was[i], now[i], f"{place}[{i}]")]
    if isinstance(was, float) and isinstance(now, float | int):
        return [] if math.isclose(was, now, rel_tol=RELATIVE) else [f"{place}: {was} is now {now}"]
    return [] if was == now else [f"{place}: {was!r} is now {now!r}"]


@pytest.mark.parametrize(("folder", "name", "entry"), FILES)
def test_no_old_file_was_changed_and_every_number_is_read_out_of_it(
    folder: Path, name: str, entry: dict[str, Any]
) -> None:
    assert hashlib.sha256((folder / name).read_bytes()).hexdigest() == entry["sha256"]
    if entry["kind"]:
        assert differences(as_of_today(entry), read_as(entry["kind"], folder / name)) == []


def as_of_today(entry: dict[str, Any]) -> dict[str, Any]:
    """What a file is to be read as: gains of a controller that was replaced without the numbers that only it had."""
    read: dict[str, Any] = entry["reads"]
    if entry["kind"] != "gains":
        return read
    gone = re.compile(r" (?:pulse_time_s|tolerance|gap_fraction)=\S+")
    name = read["controller"]
    return read | {"controller": REPLACED.get(name, name), "settings": gone.sub("", read["settings"])}


def test_this_version_has_its_files_and_every_kind_is_among_them() -> None:
    folder = FOLDER / importlib.metadata.version("musclewire")
    manifest = manifest_of(folder)
    assert manifest["version"] == folder.name
    assert {entry["kind"] for entry in manifest["files"].values()} - {""} == set(KINDS)
    kept = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert kept == {*manifest["files"], "manifest.json"}


@pytest.mark.parametrize(
    ("was", "now", "said"),
    [
        ({"a": 1.0}, {"a": 1.0, "b": 2.0}, []),
        ({"a": 1.0}, {}, [".a is gone"]),
        ({"a": [1.0, 2.0]}, {"a": [1.0, 2.1]}, [".a[1]: 2.0 is now 2.1"]),
        ({"a": None}, {"a": "x"}, [".a: None is now 'x'"]),
    ],
)
def test_a_difference_is_named(was: Any, now: Any, said: list[str]) -> None:
    assert differences(was, now) == said
