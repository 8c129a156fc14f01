"""Every file of the corpus is read as its manifest says, or refused in one line with exit code 2 that names the cure.

The manifests are the .toml files next to this test and in its folder ``text``; ``text_files.toml`` explains their keys.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from musclewire.app import in_options
from musclewire.errors import CallerError, RecordingError
from musclewire.files import ImportMapping, read_recording
from musclewire.identify import import_recording
from musclewire.signals import parse_quantity

MANIFESTS = sorted(Path(__file__).parent.rglob("*.toml"), key=lambda path: path.name)


def entries(manifest: Path) -> list[dict[str, Any]]:
    """Return the entries of a manifest, with what is usual in it and where its files are."""
    document = tomllib.loads(manifest.read_text("utf-8"))
    usual = document.get("usual", {})
    found = [*document["file"]]
    found += [
        {"name": name, "folder": "damaged", "refused": text} for name, text in document.get("refused", {}).items()
    ]
    if usual:
        named = {one["name"] for one in found}
        there = sorted(path.name for path in (manifest.parent / "read").iterdir())
        found += [{"name": name, "folder": "read"} for name in there if name not in named]
    return [{**({} if "refused" in one else usual), **one, "beside": manifest.parent} for one in found]


ENTRIES = [entry for manifest in MANIFESTS for entry in entries(manifest)]
READ = [entry for entry in ENTRIES if "refused" not in entry]
REFUSED = [entry for entry in ENTRIES if "refused" in entry]


def name_of(entry: dict[str, Any]) -> str:
    return "-".join([entry["name"], *(key for key in ("mapping", "ignore", "sample_period") if key in entry)])


def path_of(entry: dict[str, Any]) -> Path:
    path: Path = entry["beside"] / entry["folder"] / entry["name"]
    return path


def mapping_of(entry: dict[str, Any]) -> ImportMapping:
    period = entry.get("sample_period")
    return ImportMapping(
        entry.get("mapping", {}),
        tuple(entry.get("ignore", ())),
        None if period is None else parse_quantity(period, "s"),
        entry.get("drop_missing", False),
        metadata=entry.get("metadata", {}),
        group=entry.get("group"),
    )


@pytest.mark.parametrize("entry", READ, ids=name_of)
def test_a_file_is_read_with_the_columns_and_numbers_it_holds(entry: dict[str, Any]) -> None:
    recording = read_recording(path_of(entry), mapping=mapping_of(entry))
    assert set(recording.names) == set(entry["columns"])
    assert len(recording) == entry["rows"]
    for row, place in ((0, "first"), (-1, "last")):
        for name, value in entry.get(place, {}).items():
            assert recording[name][row] == pytest.approx(value, rel=1e-6, abs=1e-6), (place, name)


@pytest.mark.parametrize("entry", READ, ids=name_of)
def test_a_preview_finds_no_problem_and_its_mapping_reads_the_same(entry: dict[str, Any]) -> None:
    understood = import_recording(path_of(entry), mapping=mapping_of(entry))
    assert understood.problem == ""
    assert understood.row_count == entry["rows"]
    again = read_recording(path_of(entry), mapping=understood.mapping)
    assert again == read_recording(path_of(entry), mapping=mapping_of(entry))


@pytest.mark.parametrize("entry", REFUSED, ids=name_of)
def test_a_file_is_refused_in_one_line_that_names_the_cure(entry: dict[str, Any]) -> None:
    with pytest.raises((RecordingError, CallerError)) as caught:
        read_recording(path_of(entry), mapping=mapping_of(entry))
    message = str(caught.value)
    assert len(message) < 700
    assert entry["refused"] in message


@pytest.mark.parametrize("name", ["only_headers.csv", "word_in_a_row.csv", "row_too_short.csv"])
def test_the_command_ends_with_2_and_that_line(name: str, musclewire: Callable[..., Any], tmp_path: Path) -> None:
    """One of each kind: no rows, a wrong one, and one whose cure is an argument in Python and an option here."""
    entry = next(entry for entry in REFUSED if entry["name"] == name)
    with pytest.raises(RecordingError) as caught:
        read_recording(path_of(entry), mapping=mapping_of(entry))
    refused = f"musclewire: {in_options(str(caught.value))}"
    answer = musclewire("import", path_of(entry), "-o", tmp_path / "out.h5", "--json")
    assert (answer.code, answer.out) == (2, "")
    # Before the refusal the line that reads the file may be named, and what was seen where a person reads.
    (said,) = (text for text in answer.err.splitlines() if not text.startswith("  try: "))
    assert said == refused
    answer = musclewire("import", path_of(entry), "-o", tmp_path / "out.h5")
    *seen, said = answer.err.splitlines()
    assert (answer.code, answer.out, said) == (2, "", refused)
    assert seen == [] if name == "only_headers.csv" else seen[0].startswith(f"{path_of(entry)}: text, separated by ")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("manifest", MANIFESTS, ids=lambda path: path.stem)
def test_the_corpus_is_as_large_as_it_has_to_be_and_nothing_in_it_is_forgotten(manifest: Path) -> None:
    for folder, least in tomllib.loads(manifest.read_text("utf-8"))["least"].items():
        listed = {(one["folder"], one["name"]) for one in entries(manifest) if one["folder"] == folder}
        assert len(listed) >= least
        known = {(one["folder"], one["name"]) for one in ENTRIES if one["beside"] == manifest.parent}
        assert {(folder, path.name) for path in (manifest.parent / folder).iterdir()} <= known
        assert listed <= {(folder, path.name) for path in (manifest.parent / folder).iterdir()}
