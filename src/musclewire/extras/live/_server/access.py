"""Who may talk to the server: by the name they call it, the page they come from, and the token they show.

Three dangers and what is done about each. A page of another site may send requests to this machine from the user's
own browser: its ``Origin`` is not ours. Such a site may let its own name point to this machine (DNS rebinding): then
``Host`` has its name and not ours. Others on the network may connect, if the server listens there: they need a token.
"""

from __future__ import annotations

import hmac
import ipaddress
import re
import secrets
import stat
from dataclasses import dataclass
from pathlib import Path

from musclewire.errors import CallerError

# A token of the program has 256 bits; one of a file must have as many characters as 96 bits take.
TOKEN_BYTES, MIN_TOKEN_LENGTH, MAX_TOKEN_LENGTH = 32, 16, 512
TOKEN = re.compile(r"[A-Za-z0-9._~+/=-]+")
HOST = re.compile(r"(?P<name>[A-Za-z0-9._-]+|\[[0-9A-Fa-f:.]+\])(?::\d{1,5})?")
# What a browser says of a request that does not come from a page of another origin.
OWN_SITE = frozenset({"same-origin", "none"})


def new_token() -> str:
    """Return a token that nobody can guess."""
    return secrets.token_urlsafe(TOKEN_BYTES)


def read_token(path: Path) -> str:
    """Return the token of a file. CallerError if it has none, a short one, or others on this machine may read it."""
    try:
        mode, text = path.stat().st_mode, path.read_text("ascii").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise CallerError(f"--token-file {path} cannot be read: {error}") from None
    if stat.S_IMODE(mode) & 0o077:
        raise CallerError(f"--token-file {path} can be read by others on this machine: chmod 600 {path}")
    if not MIN_TOKEN_LENGTH <= len(text) <= MAX_TOKEN_LENGTH or not TOKEN.fullmatch(text):
        raise CallerError(
            f"--token-file {path} needs one token of {MIN_TOKEN_LENGTH} to {MAX_TOKEN_LENGTH} letters, digits and "
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
    """Who may talk to this server.

    Parameters
    ----------
    token
        What everybody must show; None if the server can be reached from this machine only.
    names
        The server's own names, in small letters. Loopback addresses and localhost are always among them.
    any_address
        Whether it may also be called by any address: true if it listens beyond this machine.
    """

    token: str | None = None
    names: frozenset[str] = frozenset()
    any_address: bool = False

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
