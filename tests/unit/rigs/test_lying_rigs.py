"""A device that lies about readings, clock and drive burns nothing, without a pace; benchmarks.lying_rigs has more."""

from __future__ import annotations

from functools import cache

import pytest
from benchmarks.lying_rigs import ALLOWED_K, all_limits, told

from musclewire.controllers import ProtectionLimits


@cache
def limits_by_rig() -> dict[str, ProtectionLimits]:
    return all_limits()


# Seeds with the hottest wires of the first thousand, and those that were hotter before a sample was judged beforehand.
@pytest.mark.parametrize("seed", [92, 241, 325, 488, 644, 682, 750, 784, 906, 971, *range(2001, 2011)])
def test_no_lie_heats_a_wire_beyond_its_limit(seed: int) -> None:
    assert told(seed, limits_by_rig()).above_k <= ALLOWED_K
