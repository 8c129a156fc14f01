"""Run the slow part of an estimator next to the loop: in line in simulation, in a thread on a rig with a clock.

Both ways give the same recording, as a correction takes effect exactly ``after_ticks`` ticks after it was requested,
never earlier; in the thread it may be late, and then the old one stays and the sample records so. Nothing here waits: a
tick checks whether the result is available and continues. An exception of the slow part never reaches the loop: it
counts as a failed correction, and the run's metadata state their number and the first one.
"""

from __future__ import annotations

import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from enum import IntEnum
from queue import SimpleQueue
from typing import Any, NamedTuple, Protocol

from musclewire.errors import CallerError
from musclewire.sensing._estimator import Estimator, SlowPart
from musclewire.signals import MetadataValue, QuantityEstimate, WireSample

CORRECTION_COLUMN = "slow_correction"
# While a slow part computes in Python, the tick gets the interpreter back after at most this; Python's default is 5 ms.
SWITCH_INTERVAL_S = 0.0005


class SlowStatus(IntEnum):
    """Status of the correction that was due at a sample."""

    NONE_DUE = 0
    APPLIED = 1
    LATE = 2
    FAILED = 3


class SlowCorrection(NamedTuple):
    """The value that a slow part returned, or the exception that it raised."""

    value: Any
    error: Exception | None = None


class CorrectionExecutor(Protocol):
    """Computes slow parts, one at a time."""

    def request(self, compute: Callable[[], Any]) -> Callable[[], SlowCorrection | None] | None:
        """Begin to compute.

        Parameters
        ----------
        compute
            The computation; an exception is part of its result.

        Returns
        -------
        A function that returns the result, or None until there is one; None itself if the last computation still runs.
        """
        ...

    def close(self) -> None:
        """End; a computation that still runs is not waited for."""
        ...


def computed(compute: Callable[[], Any]) -> SlowCorrection:
    """Return the value or the exception of a slow part."""
    try:
        return SlowCorrection(compute())
    except Exception as error:
        return SlowCorrection(None, error)


class InLine:
    """Computes at once, in the caller's thread: for simulations, whose time does not advance meanwhile."""

    def request(self, compute: Callable[[], Any]) -> Callable[[], SlowCorrection | None]:
        """Compute, and return a function that returns the result."""
        result = computed(compute)
        return lambda: result

    def close(self) -> None:
        """Do nothing."""


class InThread:
    """Computes in a thread for which neither a tick nor the end of the process waits."""

    def __init__(self) -> None:
        """Start the thread, and make the interpreter switch threads often enough for a tick."""
        self._work: SimpleQueue[tuple[Callable[[], Any], list[SlowCorrection]] | None] = SimpleQueue()
        self._running: list[SlowCorrection] | None = None
        self._interval_s = sys.getswitchinterval()
        sys.setswitchinterval(min(SWITCH_INTERVAL_S, self._interval_s))
        threading.Thread(target=self._follow, name="musclewire slow part", daemon=True).start()

    def _follow(self) -> None:
        """Compute what is requested until the run ends."""
        while (task := self._work.get()) is not None:
            compute, results = task
            results.append(computed(compute))

    def request(self, compute: Callable[[], Any]) -> Callable[[], SlowCorrection | None] | None:
        """Pass the computation to the thread; None while it is busy with the last one."""
        if self._running is not None and not self._running:
            return None
        results: list[SlowCorrection] = []
        self._running = results
        self._work.put((compute, results))
        return lambda: results[0] if results else None

    def close(self) -> None:
        """Let the thread end after its computation, and restore the interpreter's switch interval."""
        self._work.put(None)
        sys.setswitchinterval(self._interval_s)


class SlowCorrections:
    """Requests corrections of an estimator's slow part and puts them into effect, tick by tick.

    Parameters
    ----------
    slow_part
        The estimator's slow part.
    executor
        ``InLine()`` without a clock, ``InThread()`` on a rig with one.

    Raises
    ------
    CallerError
        If the slow part's ticks are inconsistent: a correction must take effect before the next one is requested.
    """

    def __init__(self, slow_part: SlowPart, executor: CorrectionExecutor) -> None:
        """Begin with an empty window."""
        if not (slow_part.window_ticks >= 1 and 1 <= slow_part.after_ticks <= slow_part.every_ticks):
            raise CallerError(
                f"a slow part with a window of {slow_part.window_ticks} ticks that is requested every "
                f"{slow_part.every_ticks} ticks and takes effect after {slow_part.after_ticks}: the window must be at "
                "least 1, and the effect from 1 tick to those between two requests"
            )
        self._slow, self._executor = slow_part, executor
        self._window: deque[WireSample] = deque(maxlen=slow_part.window_ticks)
        self._tick = 0
        self._due_tick: int | None = None
        self._result: Callable[[], SlowCorrection | None] | None = None
        self._counts = dict.fromkeys(SlowStatus, 0)
        self._first_error = ""

    def before(self, state: Any) -> tuple[Any, SlowStatus]:
        """Return the state with which the next sample is estimated, and the status of a correction due at it.

        Parameters
        ----------
        state
            The estimator's state.

        Returns
        -------
        The state, corrected if a correction was due and available, and the status to record.
        """
        if self._due_tick is None or self._tick < self._due_tick:
            return state, SlowStatus.NONE_DUE
        result = None if self._result is None else self._result()
        self._due_tick = self._result = None
        state, status = self._in_effect(state, result)
        self._counts[status] += 1
        return state, status

    def _in_effect(self, state: Any, result: SlowCorrection | None) -> tuple[Any, SlowStatus]:
        """Return the state with a correction that is due, or the old one if it is late or failed."""
        if result is None:
            return state, SlowStatus.LATE
        error = result.error
        if error is None:
            try:
                return self._slow.corrected(state, result.value), SlowStatus.APPLIED
            except Exception as raised:
                error = raised
        self._first_error = self._first_error or f"{type(error).__name__}: {error}"
        return state, SlowStatus.FAILED

    def after(self, sample: WireSample) -> None:
        """Take a sample into the window and, if it is time, request a correction; returns at once on a rig's clock."""
        self._window.append(sample)
        slow = self._slow
        since_full = self._tick - (slow.window_ticks - 1)
        if since_full >= 0 and since_full % slow.every_ticks == 0:
            window = tuple(self._window)
            self._due_tick = self._tick + slow.after_ticks
            self._result = self._executor.request(lambda: slow.correction(window))
        self._tick += 1

    def metadata(self) -> dict[str, MetadataValue]:
        """Return the numbers of corrections that were applied, late and failed, and the first error."""
        counts: dict[str, MetadataValue] = {
            f"slow_corrections_{status.name.lower()}": self._counts[status]
            for status in (SlowStatus.APPLIED, SlowStatus.LATE, SlowStatus.FAILED)
        }
        return {**counts, **({"slow_correction_error": self._first_error} if self._first_error else {})}

    def close(self) -> None:
        """End the thread, if there is one."""
        self._executor.close()


def estimates(
    estimator: Estimator, samples: Iterable[WireSample]
) -> Iterator[tuple[QuantityEstimate, tuple[float, ...]]]:
    """Estimate samples in order from the estimator's start, with its slow part in line.

    Parameters
    ----------
    estimator
        An estimator.
    samples
        The measured samples, in order.

    Returns
    -------
    For each sample the estimate, and the numbers that the estimator records.
    """
    slow = None if estimator.slow_part is None else SlowCorrections(estimator.slow_part, InLine())
    state = estimator.start()
    for sample in samples:
        if slow is not None:
            state, _ = slow.before(state)
        estimate, state, recorded = estimator.step(state, sample)
        if slow is not None:
            slow.after(sample)
        yield estimate, recorded
