"""Every ``musclewire`` command of a page, console blocks too, has a name and options that the command line knows.

It runs nothing: whether what a page shows does what it says is tried by ``test_code_blocks.py``.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from tests.house.docs.test_code_blocks import PAGES, blocks, name_of
from typer.main import get_command

from musclewire.app._main import app

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
    command: click.Command = get_command(app)
    context = click.Context(command, info_name="musclewire")
    while isinstance(command, click.Group) and arguments and not arguments[0].startswith("-"):
        _, found, arguments = command.resolve_command(context, arguments)
        assert found is not None
        command, context = found, click.Context(found, parent=context)
    try:
        command.make_context("musclewire", list(arguments))
    except click.exceptions.Exit:  # --help, --version
        pass
    except click.BadParameter as error:
        if not re.search(r"does not exist|no such file|not found", str(error), re.I):
            raise


@pytest.mark.parametrize("page", [page for page in PAGES if any(commands_of(page))], ids=name_of)
def test_every_command_of_the_page_is_one_with_its_options(page: Path) -> None:
    for arguments in commands_of(page):
        try:
            parse(arguments)
        except click.UsageError as error:
            pytest.fail(f"musclewire {shlex.join(arguments)}: {error.format_message()}")


@pytest.mark.parametrize("wrong", ["fit --nonsense", "fitt loop.h5", "control simulated", "characterize --cycles many"])
def test_what_the_command_line_does_not_know_is_noticed(wrong: str) -> None:
    with pytest.raises(click.UsageError):
        parse(shlex.split(wrong))
