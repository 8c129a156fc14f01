"""The check of docstrings finds what a caller would miss: an argument, a unit, a return value, an error."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

import pytest
from tests.tools import require_oracle

from musclewire.errors import CallerError

require_oracle("numpydoc")
problems_of = importlib.import_module("checks.public_docstrings").problems_of
pytestmark = pytest.mark.oracles


def complete(voltage_v: float, folder: str) -> float | None:
    """Return half of a voltage.

    Parameters
    ----------
    voltage_v
        The voltage [V].
    folder
        Where nothing is written.

    Returns
    -------
    The half [V].

    Raises
    ------
    CallerError
        If the voltage is negative.
    """
    if voltage_v < 0.0:
        raise CallerError(folder)
    return voltage_v / 2.0


def without_unit(voltage_v: float) -> None:
    """Take a voltage.

    Parameters
    ----------
    voltage_v
        The voltage.
    """


def silent_about_errors() -> None:
    """Raise."""
    raise CallerError("always")


@pytest.mark.parametrize(
    ("function", "expected"),
    [
        (complete, []),
        (without_unit, ["parameter 'voltage_v' does not state the unit [V]"]),
        (silent_about_errors, ["does not say when it raises CallerError"]),
    ],
    ids=lambda item: getattr(item, "__name__", ""),
)
def test_what_is_missing_is_named(function: Callable[..., Any], expected: list[str]) -> None:
    assert problems_of(f"tests.{function.__name__}", function) == expected
