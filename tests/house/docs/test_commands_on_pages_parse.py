"""Every ``musclewire`` command of a page, console blocks too, has a name and options that the command line knows.

And every block of Python is Python, and takes from ``mw`` names that are there, by keywords that they have.

It runs nothing: whether what a page shows does what it says is tried by ``test_code_blocks.py``.
"""

from __future__ import annotations

import ast
import inspect
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from tests.house.docs.test_code_blocks import PAGES, blocks, name_of
from typer.main import get_command

import musclewire as mw
from musclewire.app import app
from musclewire.errors import CallerError

# Typer carries its own copy of click: the base of all usage errors.
UsageProblem: Any = typer.BadParameter.__mro__[2]
SHELL = {"sh", "console"}
# What ends one command of a line, or belongs to the shell.
ENDS = {"&&", "||", "|", ";", "&", ">", ">>", "<", "2>"}


def commands_of(page: Path) -> Iterator[list[str]]:
    """Yield the arguments of each command of a page."""
    for language, text in blocks(page):
        if language not in SHELL:
            continue
        for line in text.replace("\\\n", " ").splitlines():
            words = shlex.split(line.removeprefix("$ "), comments=True)
            starts = [place for place, word in enumerate(words) if re.fullmatch(r"(\.venv/bin/)?musclewire", word)]
            for start in starts:
                rest = words[start + 1 :]
                end = next(
                    (place for place, word in enumerate(rest) if word in ENDS or word.startswith("2>")), len(rest)
                )
                yield [word.rstrip(";") for word in rest[:end]]


def parse(arguments: list[str]) -> None:
    """Parse arguments by the command that they name; a file that is not there is no fault of theirs."""
    command: Any = get_command(app)
    context = typer.Context(command, info_name="musclewire")
    while hasattr(command, "resolve_command") and arguments and not arguments[0].startswith("-"):
        _, command, arguments = command.resolve_command(context, arguments)
        context = typer.Context(command, parent=context)
    try:
        command.make_context("musclewire", list(arguments))
    except typer.Exit:  # --help, --version
        pass
    except (typer.BadParameter, CallerError) as error:
        if not re.search(r"does not exist|there is no \w+ file", str(error), re.I):
            raise


# Its command is that of a package which only this page installs.
OF_A_PACKAGE = "add_your_own.md"
WITH_COMMANDS = [page for page in PAGES if page.name != OF_A_PACKAGE and any(commands_of(page))]


@pytest.mark.parametrize("page", WITH_COMMANDS, ids=name_of)
def test_every_command_of_the_page_is_one_with_its_options(page: Path) -> None:
    for arguments in commands_of(page):
        try:
            parse(arguments)
        except UsageProblem as error:
            pytest.fail(f"musclewire {shlex.join(arguments)}: {error.format_message()}")


@pytest.mark.parametrize("wrong", ["fit --nonsense", "fitt loop.h5", "control simulated", "characterize --cycles many"])
def test_what_the_command_line_does_not_know_is_noticed(wrong: str) -> None:
    with pytest.raises(UsageProblem):
        parse(shlex.split(wrong))


def faults_of(text: str) -> Iterator[str]:
    """Yield what a block of Python takes from ``mw`` that is not there."""
    for node in ast.walk(ast.parse(text)):
        called = node.func if isinstance(node, ast.Call) else node
        if not (isinstance(called, ast.Attribute) and isinstance(called.value, ast.Name) and called.value.id == "mw"):
            continue
        function = getattr(mw, called.attr, None)
        if function is None and called is node:
            yield f"mw.{called.attr}"
        elif isinstance(node, ast.Call) and inspect.isfunction(function):
            known = inspect.signature(function).parameters.values()
            if not any(one.kind is one.VAR_KEYWORD for one in known):
                names = {one.name for one in known}
                yield from (f"mw.{called.attr}({one.arg}=...)" for one in node.keywords if one.arg not in names)


@pytest.mark.parametrize(
    "page", [page for page in PAGES if any(one == "python" for one, _ in blocks(page))], ids=name_of
)
def test_the_python_of_the_page_is_python_and_uses_what_is_there(page: Path) -> None:
    assert not [fault for language, text in blocks(page) if language == "python" for fault in faults_of(text)]


def test_what_mw_does_not_have_is_noticed() -> None:
    assert sorted(faults_of("mw.fitt(loop)\nmw.fit(loop, orders=3)")) == ["mw.fit(orders=...)", "mw.fitt"]
