from __future__ import annotations

import numpy as np
import pytest

from musclewire.experiment._metrics import mean_absolute_error


def test_equation_7_by_hand() -> None:
    # |1.49 - 1.5| + |1.52 - 1.5| + |1.5 - 1.5| = 0.03; a third of it is 0.01, two thirds of a percent of 1.5.
    assert mean_absolute_error(np.array([1.49, 1.52, 1.5]), 1.5, 1.5) == pytest.approx(100 * 0.01 / 1.5)
