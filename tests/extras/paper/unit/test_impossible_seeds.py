"""Reproducing refuses an impossible seed in one line, as whatever else is given one."""

from __future__ import annotations

import pytest

from musclewire.errors import CallerError
from musclewire.extras.paper._reproduce.reproduction import reproduce


@pytest.mark.parametrize("seed", [-1, 1.5, "one"])
def test_reproducing_refuses_an_impossible_seed(seed: object) -> None:
    with pytest.raises(CallerError, match=r"seed.*whole number|seed: must be 0 or more") as caught:
        reproduce("table1", seeds=[seed])  # type: ignore[list-item]
    assert "\n" not in str(caught.value)
