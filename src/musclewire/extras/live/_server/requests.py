"""What all HTTP routes share: the session, a body within its limits, answers as JSON, and errors as one line."""

from __future__ import annotations

import asyncio
from typing import Annotated, Any

from fastapi import Depends, FastAPI, Header, HTTPException, Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException as StarletteHTTPException
from starlette.requests import ClientDisconnect
from starlette.responses import Response

from musclewire.errors import CallerError, MusclewireError
from musclewire.extras.live._server.http_messages import ProblemAnswer
from musclewire.extras.live._server.json_texts import MAX_BYTES, compact, read_json
from musclewire.extras.live._server.session import OnlineBench, Session

__all__ = ["PROBLEMS", "BenchOf", "BodyOf", "LeaseOf", "SessionOf", "add_error_handlers", "json_answer"]

# A body that trickles in is not waited for any longer.
BODY_S = 5.0
PROBLEMS: dict[int | str, dict[str, Any]] = {
    status: {"model": ProblemAnswer, "description": text}
    for status, text in (
        (401, "a token is needed"),
        (403, "another origin, or no control of the bench"),
        (404, "nothing of that name"),
        (413, "the body is too large"),
        (415, "the body is not JSON"),
        (421, "the server was called by a name that is not its own"),
        (422, "the request is not understood"),
        (429, "too many requests"),
    )
}


def session_of(request: Request) -> Session:
    """Return the session of the application."""
    session: Session = request.app.state.session
    return session


SessionOf = Annotated[Session, Depends(session_of)]


def bench_of(bench: str, session: SessionOf) -> OnlineBench:
    """Return the bench of an address."""
    try:
        return session.bench(bench)
    except CallerError as error:
        raise HTTPException(404, str(error)) from None


async def body_of(request: Request) -> Any:
    """Return the JSON of a body; an empty one is an empty object."""
    body = bytearray()
    try:
        async with asyncio.timeout(BODY_S):
            async for portion in request.stream():
                body += portion
                if len(body) > MAX_BYTES:
                    raise HTTPException(413, f"the body is larger than {MAX_BYTES} bytes")
    except TimeoutError:
        raise HTTPException(408, f"the body has not come within {BODY_S:g} s") from None
    return read_json(bytes(body)) if body else {}


BenchOf = Annotated[OnlineBench, Depends(bench_of)]
BodyOf = Annotated[Any, Depends(body_of)]
LeaseOf = Annotated[str | None, Header(alias="Musclewire-Lease", description="The lease, from POST .../control.")]


def json_answer(value: Any, status: int = 200) -> Response:
    """Return a value as JSON."""
    return Response(compact(value), status, media_type="application/json")


def add_error_handlers(app: FastAPI) -> None:
    """Answer every error as one line of JSON."""
    app.add_exception_handler(StarletteHTTPException, on_http_error)
    app.add_exception_handler(RequestValidationError, on_wrong_request)
    app.add_exception_handler(MusclewireError, on_our_error)
    app.add_exception_handler(ClientDisconnect, on_disconnect)


async def on_http_error(_request: Request, error: Exception) -> Response:
    """Answer what a route or the router refuses."""
    assert isinstance(error, StarletteHTTPException)
    return json_answer({"problem": str(error.detail)}, error.status_code)


async def on_wrong_request(_request: Request, error: Exception) -> Response:
    """Answer a parameter that is not what it should be, without repeating it."""
    assert isinstance(error, RequestValidationError)
    first = error.errors()[0]
    place = ".".join(str(part)[:40] for part in first["loc"])
    return json_answer({"problem": f"{place}: {first['msg']}"[:300]}, 422)


async def on_our_error(_request: Request, error: Exception) -> Response:
    """Answer an error that says what is wrong."""
    return json_answer({"problem": str(error)}, 422 if isinstance(error, CallerError) else 500)


async def on_disconnect(_request: Request, _error: Exception) -> Response:
    """Answer nobody: the client has left in the middle of its body."""
    return json_answer({"problem": "the client has left"}, 400)
