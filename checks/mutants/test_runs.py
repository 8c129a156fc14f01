"""What a run of pytest for mutation testing has in common: its options, few examples, a limit on each test's time."""

from __future__ import annotations

import os
import signal
from types import FrameType
from typing import Any

import pytest
from hypothesis import Phase, settings

__all__ = ["FewExamples", "TooLongError", "cpu_s", "options", "time_limit"]

# Examples of a Hypothesis property: in plain Python a step of a wire takes some hundred times as long.
EXAMPLES = {"compiled": 25, "plain": 10}


class TooLongError(BaseException):
    """A test has taken too long; no test and no library catches it."""


def options(mode: str, temporary: str) -> list[str]:
    """Return pytest's options; in plain Python NumPy warns of what compiled code does silently."""
    found = ["-q", "-x", "--tb=no", "-p", "no:cacheprovider", f"--basetemp={temporary}"]
    # Hypothesis is imported before pytest can rewrite its assertions: there are none in it.
    found += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]
    return [*found, "-W", "ignore::RuntimeWarning"] if mode == "plain" else found


def cpu_s() -> float:
    """Return the processor time of this process and of those that it has started and that have ended [s]."""
    spent = os.times()
    return spent.user + spent.system + spent.children_user + spent.children_system


class FewExamples:
    """Fewer examples of each property, always the same, and no search for the smallest that fails."""

    def __init__(self, mode: str) -> None:
        """Take "compiled" or "plain"."""
        self._examples = EXAMPLES[mode]

    @pytest.hookimpl(trylast=True)
    def pytest_sessionstart(self) -> None:
        """Replace the profile that tests/conftest.py has loaded."""
        settings.register_profile(
            "mutation",
            deadline=None,
            derandomize=True,
            database=None,
            max_examples=self._examples,
            phases=(Phase.explicit, Phase.generate),
        )
        settings.load_profile("mutation")


class time_limit:  # noqa: N801
    """End what runs within it by a TooLongError after so much processor time, or eight times as much of the clock."""

    def __init__(self, limit_s: float) -> None:
        """Take the processor time [s]."""
        self._limit_s = limit_s

    def __enter__(self) -> None:
        """Set both timers."""
        for kind in (signal.SIGPROF, signal.SIGALRM):
            signal.signal(kind, self._end)
        signal.setitimer(signal.ITIMER_PROF, self._limit_s)
        signal.setitimer(signal.ITIMER_REAL, 8.0 * self._limit_s)

    def __exit__(self, *_exception: object) -> None:
        """Stop both timers."""
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.setitimer(signal.ITIMER_REAL, 0.0)

    @staticmethod
    def _end(_number: int, _frame: FrameType | None) -> Any:
        raise TooLongError
