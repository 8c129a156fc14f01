"""Who has control of a bench: one at a time, by a lease that ends when its holder is no longer there."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

# A holder who gave no sign for so long has lost control: the wire is then at its sense voltage within a second.
LEASE_S = 0.6
# At rest nothing is heated, and somebody whose machine is busy for a moment need not lose control.
LEASE_AT_REST_S = 5.0


class RequestOutcome(Enum):
    """What became of a request for control."""

    YOURS = "you have control"
    ASKED = "the holder has been asked"
    BUSY = "somebody else has already asked"


@dataclass
class ControlClient:
    """Somebody who has control or asks for it.

    Parameters
    ----------
    key
        What they are recognised by: a secret, never sent to others.
    name
        What others see.
    seen_s
        When they last gave a sign [s].
    """

    key: str
    name: str
    seen_s: float

    def is_there(self, now_s: float, lease_s: float = LEASE_S) -> bool:
        """Return whether they gave a sign recently enough."""
        return now_s - self.seen_s <= lease_s


class BenchControl:
    """Control of one bench. All times are of one clock that does not jump, given by the caller.

    ``lease_s`` is how long its holder may give no sign: ``LEASE_S`` while the wire may be heated.
    """

    def __init__(self) -> None:
        """Begin with no holder."""
        self.lease_s = LEASE_S
        self.holder: ControlClient | None = None
        self.asking: ControlClient | None = None

    def holds(self, key: str | None, now_s: float) -> bool:
        """Return whether a key has control now."""
        holder = self.holder
        return key is not None and holder is not None and holder.key == key and holder.is_there(now_s, self.lease_s)

    def ask(self, key: str, name: str, now_s: float) -> RequestOutcome:
        """Take control if nobody has it, else ask the holder for it."""
        if self.holder is None:
            self.holder = ControlClient(key, name, now_s)
            return RequestOutcome.YOURS
        if self.holder.key == key:
            return RequestOutcome.YOURS
        if self.asking is not None and self.asking.key != key and self.asking.is_there(now_s, self.lease_s):
            return RequestOutcome.BUSY
        self.asking = ControlClient(key, name, now_s)
        return RequestOutcome.ASKED

    def answer(self, key: str, give: bool, now_s: float) -> bool:
        """Answer who is asking, as the holder; return whether control went over. What is running continues."""
        if not self.holds(key, now_s) or self.asking is None:
            return False
        asking, self.asking = self.asking, None
        if not give or not asking.is_there(now_s, self.lease_s):
            return False
        self.holder = asking
        return True

    def sign_of_life(self, key: str, now_s: float) -> None:
        """Note that somebody is there; a lease that has ended does not come back by it."""
        for person in (self.holder, self.asking):
            if person is not None and person.key == key and person.is_there(now_s, self.lease_s):
                person.seen_s = now_s

    def leave(self, key: str) -> bool:
        """Take control or a request for it from somebody who leaves; return whether they had control."""
        if self.asking is not None and self.asking.key == key:
            self.asking = None
        if self.holder is None or self.holder.key != key:
            return False
        # Who asked comes next; but what the last holder began has ended.
        self.holder, self.asking = self.asking, None
        return True

    def end_lost(self, now_s: float) -> ControlClient | None:
        """Take control from a holder who is no longer there, and return them; also forget who asked and has left."""
        if self.asking is not None and not self.asking.is_there(now_s, self.lease_s):
            self.asking = None
        lost = self.holder
        if lost is None or lost.is_there(now_s, self.lease_s):
            return None
        self.leave(lost.key)
        return lost
