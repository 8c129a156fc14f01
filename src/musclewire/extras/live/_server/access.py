"""Who may talk to the server and has control: by the name they call it, the page they come from, and the token.

Three dangers and what is done about each. A page of another site may send requests to this machine from the user's
own browser: its ``Origin`` is not ours. Such a site may let its own name point to this machine (DNS rebinding): then
``Host`` has its name and not ours. Others on the network may connect, if the server listens there: they need a token.
"""

from __future__ import annotations

import hmac
import ipaddress
import os
import re
import secrets
import stat
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from musclewire.errors import CallerError
from musclewire.extras.live._silence import LEASE_S
from musclewire.rigs import state_folder
from musclewire.small_files import read_small

# At rest nothing is heated, and somebody whose machine is busy for a moment need not lose control.
LEASE_AT_REST_S = 5.0


class RequestOutcome(Enum):
    """What became of a request for control."""

    YOURS = "you have control"
    ASKED = "the holder has been asked"
    BUSY = "somebody else has already asked"


@dataclass
class ControlClient:
    """Somebody who has control or asks for it."""

    key: str  # what they are recognised by: a secret, never sent to others
    name: str  # what others see
    seen_s: float  # when they last gave a sign

    def is_there(self, now_s: float, lease_s: float) -> bool:
        """Return whether they gave a sign recently enough."""
        return now_s - self.seen_s <= lease_s


class BenchControl:
    """Control of one bench, at times of the caller's clock; its holder may be silent for ``lease_s``."""

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


TOKEN_BYTES = 32  # of a token of the program: 256 bits
MIN_TOKEN_LENGTH = 16  # characters of a token in a file: as many as 96 bits take
MAX_TOKEN_LENGTH = 512  # characters of one: chosen, so that no other file is read as a token
TOKEN = re.compile(r"[A-Za-z0-9._~+/=-]+")
HOST = re.compile(r"(?P<name>[A-Za-z0-9._-]+|\[[0-9A-Fa-f:.]+\])(?::\d{1,5})?")
# What a browser says of a request that does not come from a page of another origin.
OWN_SITE = frozenset({"same-origin", "none"})


def new_token() -> str:
    """Return a token that nobody can guess."""
    return secrets.token_urlsafe(TOKEN_BYTES)


def own_token() -> str | None:
    """Return this user's token, kept in the state folder, None without a home. CallerError if others may read it."""
    try:
        path = state_folder() / "live_token"
        path.parent.mkdir(parents=True, exist_ok=True)
        with suppress(FileExistsError):
            descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            with os.fdopen(descriptor, "w") as file:
                file.write(new_token())
    except OSError:
        return None
    return read_token(path, "the token of this user,")


def read_token(path: Path, what: str = "--token-file") -> str:
    """Return the token of a file. CallerError if it has none, a short one, or others on this machine may read it."""
    try:
        mode, text = path.stat().st_mode, read_small(path, what).strip()
    except OSError as error:
        raise CallerError(f"{what} {path} cannot be read: {error.strerror or error}") from None
    if os.name == "posix" and stat.S_IMODE(mode) & 0o077:
        raise CallerError(f"{what} {path} can be read by others on this machine: chmod 600 {path}")
    if not MIN_TOKEN_LENGTH <= len(text) <= MAX_TOKEN_LENGTH or not TOKEN.fullmatch(text):
        raise CallerError(
            f"{what} {path} needs one token of {MIN_TOKEN_LENGTH} to {MAX_TOKEN_LENGTH} letters, digits and "
            "any of ._~+/=-: for example openssl rand -hex 32"
        )
    return text


def is_loopback(name: str) -> bool:
    """Return whether a name or an address can only be reached from this machine."""
    if name.lower() == "localhost":
        return True
    try:
        return ipaddress.ip_address(name).is_loopback
    except ValueError:
        return False


def name_in_host(host: str) -> str | None:
    """Return the name or address in a Host header, in small letters and without port; None if it is not one."""
    found = HOST.fullmatch(host)
    return None if found is None else found["name"].strip("[]").lower().rstrip(".")


def is_address(name: str) -> bool:
    """Return whether a name is an address: no name server decides where it leads."""
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


@dataclass(frozen=True)
class Access:
    """Who may talk to this server."""

    token: str | None = None  # what everybody must show; None if the server can be reached from this machine only
    # The server's own in small letters; loopback addresses and localhost are always among them.
    names: frozenset[str] = frozenset()
    any_address: bool = False  # may be called by any address: true if it listens beyond this machine

    def host_is_ours(self, host: str | None) -> bool:
        """Return whether a Host header names this server."""
        name = None if host is None else name_in_host(host)
        if name is None:
            return False
        return is_loopback(name) or name in self.names or (self.any_address and is_address(name))

    def origin_is_ours(self, origin: str | None, site: str | None, host: str | None) -> bool:
        """Return whether a request comes from our own page, or from no page at all (a program).

        Browsers send ``Origin`` with every WebSocket and every POST, PUT and DELETE; where one is missing,
        ``Sec-Fetch-Site`` must not say that it came from another site.
        """
        if origin is None:
            return site is None or site in OWN_SITE
        return host is not None and origin.lower() in {f"http://{host.lower()}", f"https://{host.lower()}"}

    def token_is_right(self, offered: str | None) -> bool:
        """Return whether a token is ours, in a time that does not depend on where it differs."""
        if self.token is None:
            return True
        return offered is not None and hmac.compare_digest(offered.encode(), self.token.encode())
