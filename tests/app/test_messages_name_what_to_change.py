"""What a person typed is named in the answer: the option without its unit, the rigs that come along."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from musclewire.rigs.configuration import rig_names


@pytest.mark.parametrize(
    ("arguments", "option"),
    [
        (("characterize", "simulated", "-o", "x.h5", "--amplitude", "3"), "--amplitude"),
        (("pretension", "simulated", "--at", "1.9 N", "--at", "2"), "--at"),
        (("fit", "lan-fan-2010-table-2", "--order", "3", "--length", "70"), "--length"),
        (("simulate", "--supply", "7"), "--supply"),
        (("grip", "--stiffness", "200"), "--stiffness"),
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


@pytest.mark.parametrize("command", ["characterize", "pretension", "control", "train"])
def test_the_help_names_every_rig_that_comes_along(command: str, musclewire: Callable[..., Any]) -> None:
    words = musclewire(command, "--help").out
    assert all(f"'{name}'" in words for name in rig_names())


def test_an_amplitude_too_high_names_the_setting_and_by_how_much(musclewire: Callable[..., Any], tmp_path: Any) -> None:
    answer = musclewire("characterize", "finger", "-o", tmp_path / "x.h5", "--amplitude", "2.3 V")
    assert answer.code == 2
    assert "amplitude 2.3 V is 0.275 V above the rig's maximum of 2.025 V" in answer.err
    assert "setting maximum_voltage_v" in answer.err
