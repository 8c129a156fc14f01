"""An impossible seed is refused in one line wherever a seed is given."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import musclewire as mw
from musclewire.errors import CallerError
from musclewire.parameters import require_seed
from musclewire.rigs import RigConfiguration

TAKERS: dict[str, Callable[[Any], Any]] = {
    "open_rig": lambda seed: mw.open_rig("simulated", seed=seed),
    "a rig's configuration": lambda seed: RigConfiguration(seed=seed),
}


@given(st.integers(0, 2**70))
def test_every_whole_number_from_0_is_a_seed(seed: int) -> None:
    assert require_seed(seed) == seed
    np.random.default_rng(require_seed(seed))


@pytest.mark.parametrize(("seed", "near"), [(-1, 1), (-7, 7), (1.5, 2), (-0.2, 0), ("one", 1), (None, 1), (np.nan, 1)])
def test_the_refusal_names_a_seed_that_works(seed: object, near: int) -> None:
    with pytest.raises(CallerError, match=f"must be a whole number of 0 or more, as {near}$"):
        require_seed(seed)


@pytest.mark.parametrize("taker", TAKERS)
@pytest.mark.parametrize("seed", [-1, 1.5, "one"])
def test_whatever_takes_a_seed_refuses_an_impossible_one(taker: str, seed: object) -> None:
    with pytest.raises(CallerError, match=r"seed.*whole number|seed: must be 0 or more"):
        TAKERS[taker](seed)
