"""How many messages a client may send: a bucket of tokens that fills at a steady rate."""

from __future__ import annotations

from collections import OrderedDict

__all__ = ["TokenBucket", "ClientBuckets"]

# So many clients are remembered; of more, the one that was quiet for the longest is forgotten.
MAX_CLIENTS = 1000


class TokenBucket:
    """A bucket that holds ``burst`` messages and fills with ``per_s`` in a second.

    Parameters
    ----------
    per_s
        Messages per second [1/s] in the long run.
    burst
        Messages at once.
    now_s
        The present time [s] on any clock that does not jump.
    """

    def __init__(self, per_s: float, burst: float, now_s: float) -> None:
        """Begin full."""
        self._per_s, self._burst, self._level, self._at_s = per_s, burst, burst, now_s

    def take_message(self, now_s: float, places: float = 1.0) -> bool:
        """Take a message of so many places out; return whether there was room for it."""
        self._level = min(self._burst, self._level + max(now_s - self._at_s, 0.0) * self._per_s)
        self._at_s = now_s
        if self._level < min(places, self._burst):
            return False
        self._level -= places
        return True


class ClientBuckets:
    """A bucket for each client by its address, of the last ``MAX_CLIENTS`` that came."""

    def __init__(self, per_s: float, burst: float) -> None:
        """Take rate [1/s] and burst of each."""
        self._per_s, self._burst = per_s, burst
        self._buckets: OrderedDict[str, TokenBucket] = OrderedDict()

    def take_message(self, client: str, now_s: float) -> bool:
        """Take one message out of a client's bucket; return whether there was one."""
        bucket = self._buckets.setdefault(client, TokenBucket(self._per_s, self._burst, now_s))
        self._buckets.move_to_end(client)
        if len(self._buckets) > MAX_CLIENTS:
            self._buckets.popitem(last=False)
        return bucket.take_message(now_s)
