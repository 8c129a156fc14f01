"""What --version says is what is installed, and what cite says is that version."""

from __future__ import annotations

import importlib.metadata
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from musclewire.app import REQUIREMENT, commit_of


def test_the_first_line_is_the_version_alone(musclewire: Callable[..., Any]) -> None:
    answer = musclewire("--version")
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.splitlines()[0] == f"musclewire {importlib.metadata.version('musclewire')}"


def test_the_document_says_what_is_there(musclewire: Callable[..., Any]) -> None:
    found = musclewire("--version", "--json").json
    assert found["packages"]["numpy"] == np.__version__
    assert found["packages"]["llvmlite"] == importlib.metadata.version("llvmlite")
    assert found["extras"]["pandas"] is True
    assert not {"test", "oracles", "dev"} & set(found["extras"])


def test_what_to_cite_is_this_version_in_words_and_in_bibtex(musclewire: Callable[..., Any]) -> None:
    words, entries = musclewire("cite", "--json").json.values()
    assert importlib.metadata.version("musclewire") in entries[0]
    printed = musclewire("cite", "--bibtex").out
    assert printed.strip() == "\n\n".join(entries)
    assert len(words) == printed.count("@") == 4
    assert all(entry.count("{") == entry.count("}") and entry.endswith("\n}") for entry in entries)


def test_a_requirement_is_a_name_and_an_extra() -> None:
    requirement = 'nidaqmx[grpc]<2,>=1.7; python_version < "4" and extra == "nidaq"'
    found = [REQUIREMENT.match(text) for text in ("numpy>=1.26", requirement)]
    assert [match and match.groups() for match in found] == [("numpy", None), ("nidaqmx", "nidaq")]


@pytest.mark.slow
def test_the_commit_of_a_checkout_and_whether_it_was_changed(tmp_path: Path) -> None:
    def git(*arguments: str) -> str:
        who = ("-c", "user.name=a", "-c", "user.email=a@b")
        done = subprocess.run(["git", *who, *arguments], cwd=tmp_path, capture_output=True, text=True, check=True)
        return done.stdout.strip()

    (tmp_path / "pyproject.toml").touch()
    git("init", "-q")
    git("add", "-A")
    git("commit", "-q", "-m", "first")
    assert commit_of(tmp_path / "no checkout") is None
    name = git("rev-parse", "--short=12", "HEAD")
    assert commit_of(tmp_path) == name
    (tmp_path / "another").touch()
    assert commit_of(tmp_path) == f"{name}, with changes"
