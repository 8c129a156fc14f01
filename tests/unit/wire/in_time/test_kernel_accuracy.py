"""The bars of `python benchmarks/kernel_accuracy.py`, in its quick mode: each can fail."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from kernel_accuracy import PARTS, Bar


@pytest.mark.slow
@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.__name__)
def test_the_bars_of_accuracy_hold(part: Callable[[bool], Iterator[Bar]]) -> None:
    bars = list(part(True))
    assert bars
    assert [bar for bar in bars if not bar.holds] == []
