"""Both sides of the batch do the work that the row says."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.speed.batch_cases import batch_cases
from benchmarks.speed.our_wire import different_wires


def test_the_wires_of_the_batch_all_differ() -> None:
    batch = different_wires(40, 0.01, 1)
    batch.advance(np.full(40, 2.0), 0.5)
    kelvin = batch.states["temperature_k"]
    assert np.unique(kelvin).size == 40
    assert kelvin.min() > 300.0


@pytest.mark.parametrize("case", list(batch_cases()), ids=lambda case: case.name)
def test_both_sides_run_and_share_a_unit(case: object) -> None:
    ours, theirs = case.sides(True)  # type: ignore[attr-defined]
    assert ours.units == theirs.units
    assert ours.time_us() > 0.0
    assert theirs.time_us() > 0.0
