"""Pacing of a rig without a clock of its own by the computer's clock: absolute deadlines, no drift."""

from __future__ import annotations

import time
from collections.abc import Callable
from threading import Event

from musclewire.rigs._real_time import wake_on_time

# A sleeping thread is woken some 40 us late, and more on a busy machine: for the last part the thread stays awake. This
# costs processor time in every sample period: 10 % of a core at 1 kHz, 0.2 % at the paper's 20 Hz.
SPIN_S = 1e-4
# Another thread can end a wait except in its last part, which is slept: sleeps end more exactly than waits for an
# event, on Windows by up to 16 ms. A loop of 50 Hz or faster only sleeps.
NAP_S = 0.02


class SamplePacer:
    """Paces samples on one grid: the n-th is due n periods after the first, whatever happened in between.

    A late caller gets samples at once until it has caught up; how late one may be is the protection's ``sample_late``.
    One thread waits. Another one may end all waiting or change the period meanwhile.
    """

    def __init__(
        self,
        period_s: float,
        *,
        clock_s: Callable[[], float] | None = None,
        sleep: Callable[[float], None] | None = None,
    ) -> None:
        """Wait for nothing yet: the first sample starts the grid. ``clock_s`` never runs back, as time.monotonic."""
        self._period_s = self._wanted_period_s = period_s
        self._clock_s = clock_s or time.monotonic
        self._sleep = sleep or time.sleep
        self._start_s: float | None = None
        self._samples = 0
        self._woken, self._ended = Event(), False
        wake_on_time()

    @property
    def due_s(self) -> float | None:
        """When the next sample is due [s], by the pacer's clock; None before the first."""
        # A product and not a sum of periods: a sum drifts by its roundings.
        return None if self._start_s is None else self._start_s + self._samples * self._period_s

    def late_s(self) -> float:
        """Return for how long the next sample has been due [s]; 0 if it is not due or nothing has started."""
        self._take_period()
        due_s = self.due_s
        return 0.0 if due_s is None else max(0.0, self._clock_s() - due_s)

    def wait(self) -> None:
        """Wait until the next sample is due; return at once for the first one, if it is due already, and once ended."""
        if self._start_s is None:
            self._period_s, self._start_s = self._wanted_period_s, self._clock_s()
        else:
            left_s = self._wait_for_nap()
            if left_s > SPIN_S:
                self._sleep(left_s - SPIN_S)
            due_s = self.due_s or 0.0
            while not self._ended and self._clock_s() < due_s:
                pass
        self._samples += 1

    def _wait_for_nap(self) -> float:
        """Wait until the next sample is due almost at once, or another thread ends it; return the time left [s]."""
        while not self._ended:
            self._take_period()
            left_s = (self.due_s or 0.0) - self._clock_s()
            if left_s <= NAP_S:
                return left_s
            self._woken.wait(left_s - NAP_S)
            self._woken.clear()  # before the next look at what another thread has requested, so that nothing is missed
        return 0.0

    def _take_period(self) -> None:
        """Follow a change of the period, from the last due time on; what is past by then is due now, and not late."""
        wanted_s = self._wanted_period_s
        if wanted_s == self._period_s:
            return
        if self._start_s is not None:
            last_due_s = self._start_s + (self._samples - 1) * self._period_s
            self._start_s, self._samples = max(last_due_s, self._clock_s() - wanted_s), 1
        self._period_s = wanted_s

    def change_period(self, period_s: float) -> None:
        """Pace by another period [s] from now on, also for a sample that is awaited; from any thread."""
        self._wanted_period_s = period_s
        self._woken.set()

    def end(self) -> None:
        """Let nobody wait any longer, now and later; from any thread. A wait ends within ``NAP_S``."""
        self._ended = True
        self._woken.set()

    def rest(self) -> None:
        """Drop the grid: nothing is driven, so nothing is due; the next sample starts another one."""
        self._start_s, self._samples = None, 0
