"""Messages of the rooms advise arguments of Python; the command line says its options in their place."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest
from tests.places import CHECKOUT

from musclewire.app import IN_OPTIONS, in_options

SOURCES = CHECKOUT / "src/musclewire"
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]+")
# A whole command may be advised anywhere.
WHOLE_COMMAND = re.compile(r"(musclewire|firmware/build\.py) [^';)]*")
# Who writes a command's own words, programs that are started with options of theirs, style sheets, and what says itself
# which of its ways is the command line's.
COMMANDS = (
    *("app/", "_command.py", "_options.py", "/command.py", "_serial/flash.py", "_server/", "_doctor/rig_file.py"),
    *("_nidaq/guardian.py", "pages/", "_run_facts.py"),
)


@cache
def texts_of(path: Path) -> tuple[str, ...]:
    """Return the texts of a module but for its docstrings, with what is filled in left out."""
    nodes = list(ast.walk(ast.parse(path.read_text("utf-8"))))
    described = {
        id(node.body[0].value)
        for node in nodes
        if isinstance(node, ast.Module | ast.FunctionDef | ast.ClassDef)
        and node.body
        and isinstance(node.body[0], ast.Expr)
    }
    joined = [
        "".join(part.value for part in node.values if isinstance(part, ast.Constant))
        for node in nodes
        if isinstance(node, ast.JoinedStr)
    ]
    plain = [node.value for node in nodes if isinstance(node, ast.Constant) and id(node) not in described]
    return (*joined, *(text for text in plain if isinstance(text, str)))


@cache
def modules() -> list[Path]:
    return [
        path
        for path in sorted(SOURCES.rglob("*.py"))
        if not any(part in path.relative_to(SOURCES).as_posix() for part in COMMANDS)
    ]


def test_no_message_of_a_room_advises_an_option() -> None:
    with_options = [path for path in modules() if OPTION.search(path.read_text("utf-8"))]
    said = [(path, WHOLE_COMMAND.sub("", text)) for path in with_options for text in texts_of(path)]
    assert [f"{path.name}: {text}" for path, text in said if OPTION.search(text)] == []


@pytest.mark.parametrize("advice", IN_OPTIONS)
def test_each_advice_is_one_that_a_room_gives(advice: str) -> None:
    assert any(advice in text for path in modules() for text in texts_of(path))


def test_a_number_of_the_bench_is_given_by_set() -> None:
    said = in_options("give bench={'legs': 1} for a straight wire, or bench={'pretension_n': '1.9 N'}")
    assert said == "give --set legs=1 for a straight wire, or --set pretension_n='1.9 N'"
