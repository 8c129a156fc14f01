"""The record of what a step costs: readable, and judged as it says. Nothing is timed here."""

from __future__ import annotations

from inspect import getsource

import numpy as np
import pytest
from checks.step_cost import FAILED, WARNED, fixed_arithmetic, fixed_python, verdict


@pytest.mark.parametrize(
    ("change", "same", "said"),
    [
        (None, True, "not on record"),
        (0.5 * WARNED, True, ""),
        (-0.5 * WARNED, True, ""),
        (-0.5, True, "cheaper"),
        (0.10, True, "WARNING: dearer"),
        (1.01 * FAILED, True, "FAILED"),
        (1.01 * FAILED, False, "WARNING"),
        (float("nan"), True, "FAILED"),
    ],
)
def test_ten_percent_is_seen_and_much_more_fails_on_a_processor_on_record(
    change: float | None, same: bool, said: str
) -> None:
    found = verdict(change, same)
    assert found.startswith(said)
    assert bool(found) == bool(said)


def test_the_fixed_work_stays_what_it_was() -> None:
    """Every ratio on record is to these lines: where they change, the record has no meaning any more."""
    table = np.linspace(0.0, 1.0, 101) ** 2
    assert fixed_arithmetic.py_func(1000, table) == pytest.approx(1.051112793174924, rel=1e-12)
    assert getsource(fixed_python).count("\n") == 13
