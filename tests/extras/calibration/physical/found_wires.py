"""A wire drawn from the prior, three recordings of it, and quick calibrations from them, each made once."""

from __future__ import annotations

from functools import cache

from made_wires import cooling, driven, isobars, slow_sine, true_wire

import musclewire as mw
from musclewire.extras.calibration import Calibration, calibrate

TRUTH, _ = true_wire(1)
RECORDINGS = {
    "loop": driven(TRUTH, slow_sine(), keep=("force_n",)),
    "isobars": isobars(TRUTH),
    "cooling": cooling(TRUTH),
}


@cache
def found(*names: str) -> Calibration:
    """A quick calibration from some of the recordings."""
    return calibrate({name: RECORDINGS[name] for name in names}, settings=mw.settings_of_effort("quick"))
