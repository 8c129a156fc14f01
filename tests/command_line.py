"""The command line, run in the process of a test."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, NamedTuple

import pytest

__all__ = ["Answer", "CommandLine", "musclewire"]


class Answer(NamedTuple):
    """What a command ended with and what it printed."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        """The document that it printed."""
        return json.loads(self.out)

    @property
    def refusal(self) -> str:
        """What a wrong call is refused with: exit code 2, nothing on standard output, one line."""
        assert (self.code, self.out) == (2, ""), self
        (line,) = self.err.strip().splitlines()
        return line


CommandLine = Callable[..., Answer]


@pytest.fixture
def musclewire(capsys: pytest.CaptureFixture[str]) -> CommandLine:
    """Run the command line in this process: exit code, stdout, stderr."""
    from musclewire.app import run  # not before a test asks for it: most need no command line

    def call(*arguments: object) -> Answer:
        code = run([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return Answer(code, captured.out, captured.err)

    return call
