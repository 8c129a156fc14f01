"""The interpreter that tests of boards with MicroPython need, fetched before by ``python -m emulation.interpreter``."""

from __future__ import annotations

from emulation.interpreter import Interpreter, interpreter
from tests.tools import not_run

from musclewire.errors import CallerError

__all__ = ["require_interpreter"]


def require_interpreter() -> Interpreter:
    """Return the interpreter; without it skip the test, or fail it in CI, with the command that fetches it."""
    __tracebackhide__ = True
    try:
        return interpreter()
    except CallerError as missing:
        not_run(str(missing))
