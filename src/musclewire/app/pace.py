"""How evenly the samples of a paced run came, by the computer's clock."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

__all__ = ["Pace"]


class Pace:
    """Notes the arrival of every sample; say nothing of a run that no clock paces."""

    def __init__(self, sample_period_s: float, paced: bool) -> None:
        """Watch a run of this sample period."""
        self._period_s = sample_period_s
        self._paced = paced
        self._arrivals_s: list[float] = []

    def note(self, _row: Mapping[str, float]) -> None:
        """Take down the arrival of one sample."""
        self._arrivals_s.append(time.monotonic())

    def report(self) -> dict[str, Any]:
        """Return missed deadlines and jitter [us] at the 50th, 99th and 99.9th percentile; jitter None if unpaced.

        Jitter is how far the time between two samples is from the sample period; a deadline is missed when a sample
        comes half a period late.
        """
        if not self._paced or len(self._arrivals_s) < 2:
            return {"deadline_misses": 0, "jitter_us": None}
        import numpy as np

        late_s = np.diff(self._arrivals_s) - self._period_s
        p50, p99, p999 = np.percentile(np.abs(late_s) * 1e6, [50.0, 99.0, 99.9])
        return {
            "deadline_misses": int((late_s > 0.5 * self._period_s).sum()),
            "jitter_us": {"p50": float(p50), "p99": float(p99), "p999": float(p999)},
        }
