"""A message carries the arguments that it advises as data; the command line shows its own options there."""

from __future__ import annotations

import ast
import re
import tomllib
from functools import cache
from pathlib import Path

import pytest
from tests.places import CHECKOUT

from musclewire.app import as_option, in_options
from musclewire.errors import Argument, CallerError, argument, joined

SOURCES = CHECKOUT / "src/musclewire"
LISTING = tomllib.loads((CHECKOUT / "tests/house/command_surface.toml").read_text("utf-8"))
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]+")
# An argument with its value as Python has them, but for what a rig file or a part of it states.
ARGUMENT = re.compile(r"(?<![\w.'\"-])[a-z]\w+=(?:True|False|None|\.\.\.|\{'|'\w)")
# A whole command may be advised anywhere.
WHOLE_COMMAND = re.compile(r"(musclewire|firmware/build\.py) [^';)]*")
# Who writes a command's own words, programs that are started with options of theirs, style sheets, and what says itself
# which of its ways is the command line's.
COMMANDS = (
    *("app/", "_command.py", "_options.py", "/command.py", "_serial/flash.py", "_server/", "_doctor/rig_file.py"),
    *("_nidaq/guardian.py", "pages/", "_run_facts.py"),
)


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text("utf-8"))


@cache
def texts_of(path: Path) -> tuple[str, ...]:
    """Return the texts of a module but for its docstrings, with what is filled in left out."""
    nodes = list(ast.walk(tree_of(path)))
    described = {
        id(node.body[0].value)
        for node in nodes
        if isinstance(node, ast.Module | ast.FunctionDef | ast.ClassDef)
        and node.body
        and isinstance(node.body[0], ast.Expr)
    }
    joined_up = [
        "".join(part.value for part in node.values if isinstance(part, ast.Constant))
        for node in nodes
        if isinstance(node, ast.JoinedStr)
    ]
    plain = [node.value for node in nodes if isinstance(node, ast.Constant) and id(node) not in described]
    return (*joined_up, *(text for text in plain if isinstance(text, str)))


@cache
def modules() -> list[Path]:
    return [
        path
        for path in sorted(SOURCES.rglob("*.py"))
        if not any(part in path.relative_to(SOURCES).as_posix() for part in COMMANDS)
    ]


@cache
def advised() -> list[ast.Call]:
    """Return every call by which a room advises an argument."""
    return [
        node
        for path in modules()
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "argument"
    ]


def test_no_message_of_a_room_advises_an_option() -> None:
    with_options = [path for path in modules() if OPTION.search(path.read_text("utf-8"))]
    said = [(path, WHOLE_COMMAND.sub("", text)) for path in with_options for text in texts_of(path)]
    assert [f"{path.name}: {text}" for path, text in said if OPTION.search(text)] == []


def test_no_message_of_a_room_has_an_argument_as_text() -> None:
    with_arguments = [path for path in modules() if ARGUMENT.search(path.read_text("utf-8"))]
    assert [f"{path.name}: {text}" for path in with_arguments for text in texts_of(path) if ARGUMENT.search(text)] == []


def test_no_advised_argument_is_lost_in_a_formatted_text() -> None:
    formatted = [node for path in modules() for node in ast.walk(tree_of(path)) if isinstance(node, ast.FormattedValue)]
    calls = {id(call) for call in advised()}
    assert [ast.unparse(one) for one in formatted if any(id(part) in calls for part in ast.walk(one))] == []


def test_each_advised_argument_is_an_option_of_a_command() -> None:
    options = {name for command in LISTING["command"].values() for row in command.get("options", []) for name in
               OPTION.findall(row)}  # fmt: skip
    said = {as_option(eval(ast.unparse(call), {"argument": Argument, "within_v": 3.0})) for call in advised()}
    assert {text.split()[0] for text in said} <= options


@pytest.mark.parametrize(
    ("one", "in_python", "on_the_command_line"),
    [
        (argument("overwrite", True), "overwrite=True", "--overwrite"),
        (argument("load_n"), "load_n", "--load"),
        (argument("on"), "on", "--join"),
        (argument("estimator", "filter"), "estimator='filter'", "--estimator filter"),
        (argument("amplitude_v", 2.5), "amplitude_v=2.5", "--amplitude '2.5 V'"),
        (argument("bench", {"legs": 1}), "bench={'legs': 1}", "--set legs=1"),
        (argument("bench", {"pretension_n": "1.9 N"}), "bench={'pretension_n': '1.9 N'}", "--set pretension_n='1.9 N'"),
        (argument("metadata", {"leg_length_m": 0.07}), "metadata={'leg_length_m': 0.07}", "--leg-length '0.07 m'"),
    ],
)
def test_an_argument_is_an_option_on_the_command_line(one: str, in_python: str, on_the_command_line: str) -> None:
    assert f"give {one}" == f"give {in_python}"
    assert in_options("give " + one) == f"give {on_the_command_line}"


def test_what_a_user_names_stays_as_it_is_whatever_it_looks_like() -> None:
    name = "run_amplitude_v=3.2, overwrite=True, leave group out.h5"
    error = CallerError(f"{name} exists: allow replacing it (" + argument("overwrite", True) + ")")
    assert in_options(str(error)) == f"{name} exists: allow replacing it (--overwrite)"
    assert f"{error}" == f"{name} exists: allow replacing it (overwrite=True)"


def test_a_message_that_is_said_with_others_keeps_its_arguments() -> None:
    error = CallerError("wire: " + str(CallerError("say so (" + argument("load_n") + ")")))
    both = joined("; ", ["nothing", str(error)])
    assert (both, in_options(both)) == ("nothing; wire: say so (load_n)", "nothing; wire: say so (--load)")
