"""Single precision as Python simulates it before a library is written, held to the compiler's."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from tests.extras.board.export.export_parts import Exported

from musclewire.extras.board._c.precision import single_estimates


def test_the_simulated_single_precision_is_the_compiler_s_to_the_bit(
    exported: Callable[[str], Exported], loaded: Callable[[str, bool], object]
) -> None:
    one, library = exported("zhao-1993"), loaded("zhao-1993", False)
    low, high = one.model.valid_resistance_ohm
    resistances = np.linspace(low - 0.1, high + 0.1, 500)
    ours = single_estimates(one.library.constants, resistances)
    compiled = [library.estimate(float(ohm))[0] for ohm in resistances]  # type: ignore[attr-defined]
    assert ours.tolist() == compiled
