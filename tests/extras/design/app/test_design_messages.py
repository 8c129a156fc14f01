"""What a person typed is named in the answer of a design: the option without its unit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest


@pytest.mark.parametrize(
    ("arguments", "option"),
    [
        (("design", "pretensioner", "--stiffness", "386.2 N/m", "--finger-stiffness", "1084"), "--finger-stiffness"),
        (("design", "finger", "--stiffness", "1084.4 N/m", "--column-width", "0.3"), "--column-width"),
        (("design", "finger", "--finger", "lan-fan-2010", "--wire", "x", "--wire-length", "7"), "--wire-length"),
    ],
)
def test_a_quantity_without_its_unit_names_the_option(
    arguments: tuple[str, ...], option: str, musclewire: Callable[..., Any]
) -> None:
    answer = musclewire(*arguments)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith(f"musclewire: {option}: '{arguments[-1]}' has no unit; write it with one, as ")
