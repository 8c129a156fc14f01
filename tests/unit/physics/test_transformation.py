from __future__ import annotations

import pytest

from musclewire.physics._material import advantage_k


def test_balance_moves_with_stress_by_clausius_and_clapeyron() -> None:
    assert advantage_k(350.0, 0.0, 350.0, 8e6) == 0.0
    assert advantage_k(350.0, 80e6, 350.0, 8e6) == pytest.approx(10.0)
    assert advantage_k(360.0, 80e6, 350.0, 8e6) == pytest.approx(0.0)
