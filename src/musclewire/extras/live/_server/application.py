"""The web application of a session: routes, the WebSocket and the page; every error is one line of JSON."""

from __future__ import annotations

from importlib.metadata import version

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException as StarletteHTTPException
from starlette.responses import JSONResponse, Response

from musclewire.errors import CallerError, MusclewireError
from musclewire.extras.live._server import bench_routes, file_routes
from musclewire.extras.live._server.live_socket import live
from musclewire.extras.live._server.session import Session
from musclewire.extras.live._server.socket_messages import one_line

LIVE = "/api/v1/live"
DESCRIPTION = (
    "State and commands of the rigs that a running 'musclewire serve' has open. All quantities are in SI units. "
    "On another address than loopback every request shows a token: Authorization: Bearer, or the cookie of the page."
)


def make_app(session: Session) -> FastAPI:
    """Return the application of a session, without the gate."""
    app = FastAPI(
        title="musclewire serve",
        version=version("musclewire"),
        description=DESCRIPTION,
        openapi_url="/api/v1/openapi.json",
        # FastAPI's own pages load scripts from the internet.
        docs_url=None,
        redoc_url=None,
        redirect_slashes=False,
    )
    app.state.session = session
    for kind, answer in ((StarletteHTTPException, on_http_error), (RequestValidationError, on_wrong_request)):
        app.add_exception_handler(kind, answer)
    app.add_exception_handler(MusclewireError, on_our_error)
    app.include_router(bench_routes.ROUTES)
    app.include_router(file_routes.ROUTES)
    app.add_api_websocket_route(LIVE, live)
    app.add_route("/", file_routes.first_page, methods=["GET"])
    app.mount("/page", file_routes.PageFiles(directory=file_routes.PAGE, check_dir=False))
    return app


async def on_http_error(_request: Request, error: Exception) -> Response:
    """Answer what a route or the router refuses."""
    assert isinstance(error, StarletteHTTPException)
    return JSONResponse({"problem": str(error.detail)}, error.status_code)


async def on_wrong_request(_request: Request, error: Exception) -> Response:
    """Answer a request that is not understood, without repeating it."""
    assert isinstance(error, RequestValidationError)
    return JSONResponse({"problem": one_line(error.errors()[0])}, 422)


async def on_our_error(_request: Request, error: Exception) -> Response:
    """Answer an error that says what is wrong."""
    return JSONResponse({"problem": str(error)}, 422 if isinstance(error, CallerError) else 500)
