"""The one place where a rig without a clock of its own waits for the computer's: absolute deadlines, no drift."""

from __future__ import annotations

import time
from collections.abc import Callable

from musclewire.rigs.real_time import wake_on_time

__all__ = ["SPIN_S", "Pacer"]

# A sleeping thread is woken some 40 us late, and more on a busy machine: the last stretch is waited for awake. It costs
# this share of every sample period in processor time: 10 % of a core at 1 kHz, 0.2 % at the paper's 20 Hz.
SPIN_S = 1e-4


class Pacer:
    """Lets samples come on one grid: the n-th is due n periods after the first, whatever happened in between.

    A caller who comes late finds his sample at once, and so on until the grid is caught up with: what was late does not
    shift what follows. How late he may be is not decided here but by the protection table (event ``sample_late``).
    """

    def __init__(
        self,
        period_s: float,
        *,
        clock_s: Callable[[], float] | None = None,
        sleep: Callable[[float], None] | None = None,
    ) -> None:
        """Wait for nothing yet: the first sample starts the grid. ``clock_s`` never runs back, as time.monotonic."""
        self._period_s = period_s
        self._clock_s = clock_s or time.monotonic
        self._sleep = sleep or time.sleep
        self._start_s: float | None = None
        self._samples = 0
        wake_on_time()

    @property
    def due_s(self) -> float | None:
        """When the next sample is due, by the pacer's clock; None before the first."""
        # A product and not a sum of periods: a sum drifts by its roundings.
        return None if self._start_s is None else self._start_s + self._samples * self._period_s

    def late_s(self) -> float:
        """Return for how long the next sample has been due by now; 0 where it is not, or nothing has started."""
        due_s = self.due_s
        return 0.0 if due_s is None else max(0.0, self._clock_s() - due_s)

    def wait(self) -> None:
        """Return when the next sample is due; at once for the first and where it has been due already."""
        due_s = self.due_s
        if due_s is None:
            self._start_s = self._clock_s()
        else:
            left_s = due_s - self._clock_s()
            if left_s > SPIN_S:
                self._sleep(left_s - SPIN_S)
            while self._clock_s() < due_s:
                pass
        self._samples += 1

    def rest(self) -> None:
        """Forget the grid: nothing is driven, so nothing is due; the next sample starts another."""
        self._start_s, self._samples = None, 0
