"""What all HTTP routes share: the session, the bench of an address, a lease, and how refusals are described."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import Depends, Header, HTTPException, Request

from musclewire.errors import CallerError
from musclewire.extras.live._server.http_messages import ProblemAnswer
from musclewire.extras.live._server.session import OnlineBench, Session

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


BenchOf = Annotated[OnlineBench, Depends(bench_of)]
LeaseOf = Annotated[str | None, Header(alias="Musclewire-Lease", description="The lease, from POST .../control.")]
