"""The web application of a session: routes, the WebSocket, pages and documents, behind the gate."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from fastapi import FastAPI
from starlette.responses import Response
from starlette.types import ASGIApp

from musclewire.extras.live._server import bench_routes, file_routes
from musclewire.extras.live._server.access import Access
from musclewire.extras.live._server.api_pages import html_page
from musclewire.extras.live._server.documents import LIVE, asyncapi_document, openapi_document
from musclewire.extras.live._server.gate import Gate
from musclewire.extras.live._server.live_socket import live
from musclewire.extras.live._server.rate_limits import ClientBuckets
from musclewire.extras.live._server.requests import add_error_handlers, json_answer
from musclewire.extras.live._server.session import Session

__all__ = ["Limits", "gated", "make_app"]


@dataclass(frozen=True)
class Limits:
    """How much one client may send.

    Parameters
    ----------
    requests_per_s
        HTTP requests per second [1/s] of one address, in the long run.
    request_burst
        HTTP requests at once: a page's files, and some of another page.
    messages_per_s
        WebSocket messages per second [1/s] of one connection; a slider sends some dozens.
    message_burst
        WebSocket messages at once.
    """

    requests_per_s: float = 200.0
    request_burst: float = 400.0
    messages_per_s: float = 200.0
    message_burst: float = 400.0


def make_app(session: Session, limits: Limits) -> FastAPI:
    """Return the application of a session, without the gate."""
    app = FastAPI(openapi_url=None, docs_url=None, redoc_url=None, redirect_slashes=False)
    app.state.session, app.state.limits = session, limits
    add_error_handlers(app)
    app.include_router(bench_routes.ROUTES)
    app.include_router(file_routes.ROUTES)
    app.add_api_websocket_route(LIVE, live)
    add_documents(app)
    app.add_route("/", file_routes.first_page, methods=["GET"])
    app.mount("/page", file_routes.PageFiles(directory=file_routes.PAGE, check_dir=False))
    return app


def add_documents(app: FastAPI) -> None:
    """Serve the API's documents, made once."""
    openapi = openapi_document(app)
    style = files("musclewire").joinpath("pages", "style.css").read_text("utf-8")
    documents: dict[str, Callable[[], Response]] = {
        "openapi.json": lambda: json_answer(openapi),
        "asyncapi.json": lambda: json_answer(asyncapi_document()),
        "docs": lambda: Response(html_page(openapi), media_type="text/html"),
        "docs.css": lambda: Response(style, media_type="text/css"),
    }
    for name, make in documents.items():
        app.add_route(f"/api/v1/{name}", serving(make), methods=["GET"])


def serving(make: Callable[[], Response]) -> Callable[[Any], Awaitable[Response]]:
    """Return an endpoint that answers what a function makes."""

    async def endpoint(_request: Any) -> Response:
        return make()

    return endpoint


def gated(app: FastAPI, access: Access, limits: Limits, cookie: str) -> ASGIApp:
    """Return an application behind its gate."""
    return Gate(app, access, cookie, ClientBuckets(limits.requests_per_s, limits.request_burst))
