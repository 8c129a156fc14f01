"""The web application of a session: routes, the WebSocket of a viewer and the page; every error is one line of JSON."""

from __future__ import annotations

import asyncio
import time
from contextlib import suppress
from importlib.metadata import version
from typing import Any, TypeAlias

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException as StarletteHTTPException
from starlette.responses import JSONResponse, Response
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from musclewire.errors import CallerError, MusclewireError
from musclewire.extras.live._messages import NEEDS_NO_CONTROL
from musclewire.extras.live._server import bench_routes, file_routes
from musclewire.extras.live._server.json_texts import read_json
from musclewire.extras.live._server.session import ORDERED, OnlineBench, Session
from musclewire.extras.live._server.socket_messages import (
    AnswerControl,
    AskControl,
    CommandAnswer,
    CommandMessage,
    FromPage,
    Pong,
    Problem,
    one_line,
    read_message,
)
from musclewire.extras.live._server.viewers import Viewer, ViewerTooSlowError

MESSAGES_A_SECOND = 400  # from one client: a slider sends some dozens of targets a second
CHARACTERS_EACH = 8192  # for which a long message counts as one more
# What comes too fast is not read, but for a stop:
SHORT = 200  # characters of a message at most that may be a stop, and is read
MAX_UNREAD = 1000  # messages that are not read before the client is disconnected
MAX_COMMANDS_WAITING = 8
SEND_S = 5.0  # [s] after which a message could not be sent, and the connection is closed
CLOSE_S = 1.0  # [s] that closing may take
# Codes with which a WebSocket is closed.
POLICY = 1008  # a policy was violated
LATER = 1013  # try again later

Ended: TypeAlias = int | None


async def live(websocket: WebSocket) -> None:
    """Serve one viewer from the handshake to the end."""
    session: Session = websocket.app.state.session
    await websocket.accept()
    client = websocket.client
    viewer = session.enter(None if client is None else (client.host, client.port))
    if viewer is None:
        await websocket.close(LATER, "too many viewers")
        return
    await ViewerConnection(websocket, session, viewer).run()


class ViewerConnection:
    """A viewer's connection, accepted."""

    def __init__(self, websocket: WebSocket, session: Session, viewer: Viewer) -> None:
        """Take the parts."""
        self._websocket, self._session, self._viewer = websocket, session, viewer
        self._second, self._count = 0, 0
        self._unread = 0
        self._commands: set[asyncio.Task[None]] = set()

    async def run(self) -> None:
        """Read and send until one of both ends; then the viewer has left."""
        tasks = [asyncio.create_task(self._read()), asyncio.create_task(self._send())]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self._session.leave(self._viewer)
            for task in (*tasks, *self._commands):
                task.cancel()
            ends = await asyncio.gather(*tasks, return_exceptions=True)
        await self._close(next((end for end in ends if isinstance(end, int)), LATER))
        for end in ends:
            if isinstance(end, Exception):
                raise end

    async def _close(self, code: int) -> None:
        if self._websocket.application_state is WebSocketState.CONNECTED:
            with suppress(TimeoutError, RuntimeError, WebSocketDisconnect, OSError):
                await asyncio.wait_for(self._websocket.close(code), CLOSE_S)

    async def _send(self) -> Ended:
        while True:
            try:
                text = await self._viewer.next_text()
                async with asyncio.timeout(SEND_S):
                    await self._websocket.send_text(text)
            except (ViewerTooSlowError, TimeoutError):
                return LATER
            except (WebSocketDisconnect, RuntimeError, OSError):
                return None

    async def _read(self) -> Ended:
        while True:
            message = await self._websocket.receive()
            if message["type"] != "websocket.receive":
                return None
            self._take(message.get("text"))
            if self._unread > MAX_UNREAD:
                return POLICY
            # Many small messages come in one portion; between two of them it is everybody else's turn.
            await asyncio.sleep(0)

    def _take(self, text: str | None) -> None:
        """Take a message, if its sender keeps to the limits; a stop is always taken."""
        second = int(time.monotonic())
        self._second, self._count = second, self._count if second == self._second else 0
        self._count += 1 + len(text or "") // CHARACTERS_EACH
        allowed = self._count <= MESSAGES_A_SECOND
        if not allowed:
            self._unread += 1
            if text is None or len(text) > SHORT or '"stop"' not in text:
                return
        try:
            if text is None:
                raise CallerError("message: send text, not bytes")
            message = read_message(read_json(text))
            if allowed or is_stop(message):
                self._act(message)
        except CallerError as error:
            self._problem(str(error))

    def _act(self, message: FromPage) -> None:
        viewer, session = self._viewer, self._session
        if isinstance(message, Pong):
            session.pong(viewer.key, message.n)
            return
        bench = session.bench(message.bench)
        if isinstance(message, CommandMessage):
            self._command(bench, message)
        elif isinstance(message, AskControl):
            viewer.name = message.name or viewer.name
            session.ask(bench, viewer.key, viewer.name)
        elif isinstance(message, AnswerControl):
            session.answer(bench, viewer.key, message.give)
        else:
            session.give_up(bench, viewer.key, f"{viewer.name} gave control up")

    def _command(self, bench: OnlineBench, message: CommandMessage) -> None:
        """Begin a command. A stop goes out here and now; the others wait for the bench's answer in tasks."""
        if is_stop(message):
            bench.handle.stop(self._viewer.name)
            self._answer(message.id, True, ORDERED)
        elif message.command.do not in NEEDS_NO_CONTROL and not self._session.may_command(bench, self._viewer.key):
            self._answer(message.id, False, "you do not have control of this bench: ask for it first")
        elif len(self._commands) >= MAX_COMMANDS_WAITING:
            self._answer(message.id, False, "too many commands wait for the bench's answer")
        else:
            task = asyncio.create_task(self._passed_on(bench, message, bench.handle.stops))
            self._commands.add(task)
            task.add_done_callback(self._commands.discard)

    async def _passed_on(self, bench: OnlineBench, message: CommandMessage, stops_before: int) -> None:
        try:
            answer = await self._session.command(bench, message.command, self._viewer.name, stops_before)
        except CallerError as error:
            self._answer(message.id, False, str(error))
        else:
            self._answer(message.id, answer.accepted, answer.message)

    def _answer(self, number: int, accepted: bool, text: str) -> None:
        self._viewer.say(CommandAnswer(id=number, accepted=accepted, message=text).model_dump_json())

    def _problem(self, text: str) -> None:
        self._viewer.say(Problem(message=text).model_dump_json())


def is_stop(message: Any) -> bool:
    """Return whether a message is a stop."""
    return isinstance(message, CommandMessage) and message.command.do == "stop"


LIVE = "/api/v1/live"
DESCRIPTION = (
    "State and commands of the rigs that a running 'musclewire serve' has open. All quantities are in SI units. "
    "Every request shows the token of the printed link: Authorization: Bearer, or the cookie of the page."
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
    return JSONResponse({"problem": str(error.detail)}, error.status_code, error.headers)


async def on_wrong_request(_request: Request, error: Exception) -> Response:
    """Answer a request that is not understood, without repeating it."""
    assert isinstance(error, RequestValidationError)
    return JSONResponse({"problem": one_line(error.errors()[0])}, 422)


async def on_our_error(_request: Request, error: Exception) -> Response:
    """Answer an error that says what is wrong."""
    return JSONResponse({"problem": str(error)}, 422 if isinstance(error, CallerError) else 500)
