"""What every request passes before any route sees it: name, origin, token, kind and size of content; what goes back.

The rules are those of ``access``. A stop is never turned away for its content's kind.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from typing import Any, NamedTuple
from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from musclewire.extras.live._server.access import Access
from musclewire.extras.live._server.connections import Connections, Turns
from musclewire.extras.live._server.json_texts import MAX_BYTES

CONTENT_SECURITY_POLICY = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self' data: blob:",
        "font-src 'self'",
        "connect-src 'self'",
        "manifest-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)
SECURITY_HEADERS = {
    "Content-Security-Policy": CONTENT_SECURITY_POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
# A body that has not come as a whole by then is not waited for any longer.
BODY_S = 5.0
# Of all bodies that are being received at once: as many of the largest as people send paths at once.
MAX_BODIES_BYTES = 16 * MAX_BYTES
CHANGING = frozenset({"POST", "PUT", "DELETE", "PATCH"})
# After the token's link: a page that leads on. A redirect would not do, since browsers keep a SameSite=Strict cookie
# back in a chain of redirects that began elsewhere, in a mail for example.
ENTERED = b"""<!doctype html><html lang="en"><head><meta charset="utf-8"><meta http-equiv="refresh" content="0;url=/">
<title>musclewire</title></head><body><p><a href="/">Go to the page</a></p></body></html>"""


class Refusal(NamedTuple):
    """Why a request is not answered: the status of HTTP, and one line."""

    status: int
    problem: str


class Gate:
    """ASGI middleware around the application; ``stops`` counts each bench's stops, before a request's body comes."""

    def __init__(
        self,
        app: ASGIApp,
        access: Access,
        cookie: str,
        connections: Connections,
        turns: Turns,
        stops: Callable[[], Mapping[str, int]],
    ) -> None:
        """Take the application and the rules."""
        self.app, self.access, self.cookie = app, access, cookie
        self.connections, self.turns, self.stops, self.bodies = connections, turns, stops, Bodies()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        if scope["type"] == "http" and self.enters(scope):
            self.passed(scope)
            await answer(send, HTTPStatus.OK, ENTERED, "text/html; charset=utf-8", self.new_cookie())
            return
        refusal = self.refusal(scope)
        if refusal is None:
            self.passed(scope)
        if refusal is not None or not (is_stop(scope) or self.connections.has_lease(scope)):
            await self.turns.come()
        if refusal is None and scope["type"] == "websocket":
            await self.app(scope, receive, send)
        elif refusal is None:
            with self.bodies.one() as received:
                await self.app(scope, received.limited(receive), with_headers(send))
            self.connections.answered(scope)
        elif scope["type"] == "websocket":
            await receive()  # the request to connect; refusing it before it is accepted answers with 403
            await send({"type": "websocket.close", "code": 1008, "reason": refusal.problem})
        else:
            body = json.dumps({"problem": refusal.problem}).encode()
            extra = {"WWW-Authenticate": "Bearer"} if refusal.status == HTTPStatus.UNAUTHORIZED else {}
            await answer(send, refusal.status, body, "application/json", extra)

    def passed(self, scope: Scope) -> None:
        """Note that a request may pass."""
        self.connections.passed(scope, is_stop(scope), asyncio.get_running_loop().time())
        scope.setdefault("state", {})["stops"] = self.stops()

    def refusal(self, scope: Scope) -> Refusal | None:
        """Return why a request is refused; None if it may pass."""
        headers = Headers(scope=scope)
        return (
            self.host_refusal(headers)
            or self.origin_refusal(scope, headers)
            or self.token_refusal(headers)
            or content_refusal(scope, headers)
        )

    def host_refusal(self, headers: Headers) -> Refusal | None:
        """Refuse a request that calls this server by a name which is not its own."""
        hosts = headers.getlist("host")
        if len(hosts) == 1 and self.access.host_is_ours(hosts[0]):
            return None
        return Refusal(HTTPStatus.MISDIRECTED_REQUEST, "this is not the server of that name: use the printed address")

    def origin_refusal(self, scope: Scope, headers: Headers) -> Refusal | None:
        """Refuse what a page of another site sends: connections, and every request that could change something."""
        if scope["type"] == "http" and scope["method"] not in CHANGING:
            return None
        origins = headers.getlist("origin")
        site, host = headers.get("sec-fetch-site"), headers.get("host")
        if len(origins) <= 1 and self.access.origin_is_ours(next(iter(origins), None), site, host):
            return None
        return Refusal(HTTPStatus.FORBIDDEN, "a page of another origin may not do this: open the printed address")

    def token_refusal(self, headers: Headers) -> Refusal | None:
        """Refuse a request without the token, if one is needed."""
        if any(self.access.token_is_right(token) for token in (None, *self.tokens_in(headers))):
            return None
        return Refusal(
            HTTPStatus.UNAUTHORIZED,
            "open the link that 'musclewire serve' printed, or send Authorization: Bearer TOKEN",
        )

    def tokens_in(self, headers: Headers) -> Iterable[str]:
        """Return the tokens a request shows: in its Authorization header, and in its cookie."""
        scheme, _, token = headers.get("authorization", "").partition(" ")
        if scheme.lower() == "bearer":
            yield token.strip()
        try:
            kept = SimpleCookie(headers.get("cookie", "")).get(self.cookie)
        except CookieError:
            kept = None
        if kept is not None:
            yield kept.value

    def enters(self, scope: Scope) -> bool:
        """Return whether a request opens the printed link with the right token."""
        if self.access.token is None or scope["path"] != "/" or scope["method"] != "GET":
            return False
        if self.host_refusal(Headers(scope=scope)) is not None:
            return False
        try:
            tokens = parse_qs(scope["query_string"].decode("ascii", "replace"), max_num_fields=5).get("token", [])
        except ValueError:
            return False
        return len(tokens) == 1 and self.access.token_is_right(tokens[0])

    def new_cookie(self) -> Mapping[str, str]:
        """Return the header that keeps the token in the browser, out of reach of scripts and of other sites."""
        return {"Set-Cookie": f"{self.cookie}={self.access.token}; Path=/; HttpOnly; SameSite=Strict"}


def is_stop(scope: Scope) -> bool:
    """Return whether a request is a stop."""
    return bool(scope["type"] == "http" and scope["method"] == "POST" and scope["path"].endswith("/stop"))


def content_refusal(scope: Scope, headers: Headers) -> Refusal | None:
    """Refuse content that is not JSON: a form of another page can send some kinds without being asked for more."""
    if scope["type"] != "http" or scope["method"] not in CHANGING or is_stop(scope):
        return None
    empty = headers.get("content-length", "0") == "0" and "transfer-encoding" not in headers
    if empty or headers.get("content-type", "").partition(";")[0].strip().lower() == "application/json":
        return None
    return Refusal(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "send JSON: Content-Type: application/json")


class Bodies:
    """The bodies of requests that are being received: none too large or too slow, and not too many at once."""

    def __init__(self) -> None:
        """Begin with none."""
        self.size = 0

    @contextmanager
    def one(self) -> Iterator[Body]:
        """Receive a body inside this block."""
        body = Body(self)
        try:
            yield body
        finally:
            self.size -= body.size


class Body:
    """A body that is being received."""

    def __init__(self, bodies: Bodies) -> None:
        """Begin with nothing of it."""
        self.bodies, self.size = bodies, 0

    def limited(self, receive: Receive) -> Receive:
        """Return a way to receive it within the limits; else that raises what is answered, and the connection ends."""
        whole, ends_s = False, asyncio.get_running_loop().time() + BODY_S

        async def receive_limited() -> Message:
            nonlocal whole
            if whole:
                return await receive()  # that the client has left, which may take as long as it likes
            try:
                async with asyncio.timeout_at(ends_s):
                    message = await receive()
            except TimeoutError:
                raise dropped(408, f"the body has not come within {BODY_S:g} s") from None
            length, whole = len(message.get("body", b"")), not message.get("more_body", False)
            self.size, self.bodies.size = self.size + length, self.bodies.size + length
            if self.size > MAX_BYTES:
                raise dropped(413, f"the body is larger than {MAX_BYTES} bytes")
            if self.bodies.size > MAX_BODIES_BYTES:
                raise dropped(503, "too many large bodies at once: try again")
            return message

        return receive_limited


def dropped(status: int, problem: str) -> HTTPException:
    """Return what ends a connection whose request is not received as a whole."""
    return HTTPException(status, problem, {"Connection": "close"})


def with_headers(send: Send) -> Send:
    """Return a way to send that adds the security headers to every response that has none of its own."""

    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in SECURITY_HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return send_with_headers


async def answer(send: Send, status: int, body: bytes, kind: str, extra: Mapping[str, str]) -> None:
    """Send a whole response without asking the application."""
    headers: dict[str, Any] = {**SECURITY_HEADERS, "Content-Type": kind, "Content-Length": str(len(body)), **extra}
    raw = [(name.lower().encode("latin-1"), value.encode("latin-1")) for name, value in headers.items()]
    await send({"type": "http.response.start", "status": int(status), "headers": raw})
    await send({"type": "http.response.body", "body": body})
