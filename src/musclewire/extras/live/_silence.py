"""How long somebody has been silent, counted only while the one who listens was awake."""

from __future__ import annotations

import time

# [s] without a sign after which a client loses control: the wire is at its sense voltage within a second then.
LEASE_S = 0.75
# [s] from one ping of the client in control to the next: five without an answer end its lease.
PING_S = 0.15


class ListeningClock:
    """Seconds in which this process listened.

    A process that got no processor for a second has asked nobody in that second and knows nothing of their silence: the
    time between two looks counts for ``PING_S`` at most, and who is gone stays silent afterwards.
    """

    def __init__(self) -> None:
        """Begin to listen."""
        self._now_s, self._looked_s = 0.0, time.monotonic()

    def now_s(self) -> float:
        """Return the seconds since it was made [s]; to be called more often than every ``PING_S``."""
        looked_s = time.monotonic()
        self._now_s += min(looked_s - self._looked_s, PING_S)
        self._looked_s = looked_s
        return self._now_s
