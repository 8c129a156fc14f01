"""HTTP routes of the benches: state, rows, commands, stop, control."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Coroutine
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Header, HTTPException, Query, Request, Response
from fastapi.routing import APIRoute

from musclewire.errors import CallerError
from musclewire.extras.live._messages import NEEDS_NO_CONTROL, Command
from musclewire.extras.live._server.access import RequestOutcome
from musclewire.extras.live._server.frames import ROWS_PER_S, shunt_of, thinned, with_computed
from musclewire.extras.live._server.http_messages import (
    BenchList,
    BenchSummary,
    CommandResult,
    ControlAnswer,
    ControlRequest,
    ControlState,
    PhaseAnswer,
    ProblemAnswer,
    RowsAnswer,
)
from musclewire.extras.live._server.json_texts import compact, read_json
from musclewire.extras.live._server.session import OnlineBench, Session, name_of

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


# Dependencies are coroutines: plain functions would wait for a thread, and a stop for whoever has all of them.
async def session_of(request: Request) -> Session:
    """Return the session of the application."""
    session: Session = request.app.state.session
    return session


SessionOf = Annotated[Session, Depends(session_of)]


async def bench_of(bench: str, session: SessionOf) -> OnlineBench:
    """Return the bench of an address."""
    try:
        return session.bench(bench)
    except CallerError as error:
        raise HTTPException(404, str(error)) from None


BenchOf = Annotated[OnlineBench, Depends(bench_of)]
LeaseOf = Annotated[str | None, Header(alias="Musclewire-Lease", description="The lease, from POST .../control.")]


# A stop is answered when the drive is off; after this time in any case.
STOP_ANSWER_S = 1.0
# Rows of a request at most, the newest: at 100 a second twenty seconds.
MAX_ROWS = 2000
# What bodies that are left out say.
NO_NAME, NO_ANSWER = ControlRequest(), ControlAnswer()


class JsonRequest(Request):
    """A request whose JSON is read as that of a WebSocket: no key twice, only UTF-8."""

    async def json(self) -> Any:
        """Return the body. Raises HTTPException for what is no JSON."""
        try:
            return read_json(await self.body())
        except CallerError as error:
            raise HTTPException(422, str(error)) from None


class JsonRoute(APIRoute):
    """A route that takes such requests."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return the handler of a request."""
        handler = super().get_route_handler()

        async def handled(request: Request) -> Response:
            return await handler(JsonRequest(request.scope, request.receive))

        return handled


ROUTES = APIRouter(prefix="/api/v1/benches", responses=PROBLEMS, tags=["benches"], route_class=JsonRoute)


@ROUTES.get("")
async def list_benches(session: SessionOf) -> BenchList:
    """List the benches of the session."""
    return BenchList(benches=[summary(bench) for bench in session.benches.values()])


def summary(bench: OnlineBench) -> BenchSummary:
    """Return a bench in short."""
    state, holder = bench.handle.state, name_of(bench.control.holder)
    return BenchSummary(bench=bench.name, phase=bench.phase, simulated=state.get("simulated", False), holder=holder)


@ROUTES.get("/{bench}")
async def bench_state(bench: BenchOf) -> Response:
    """Return the whole state of a bench."""
    return Response(compact(bench.handle.state), media_type="application/json")


@ROUTES.get("/{bench}/rows", response_model=RowsAnswer)
async def bench_rows(bench: BenchOf, after: Annotated[int, Query(ge=-1, le=2**53)] = -1) -> Response:
    """Return the rows after a cursor, thinned to 100 a second; without one, none, and the cursor of now."""
    cursor, parts, _ = bench.handle.rows(after)
    state, layouts = bench.handle.state, bench.handle.layouts
    if any(layout not in layouts for layout, _ in parts):
        cursor, parts = after, []  # their columns are on the way: they are there for the next request
    spacing_s = float(state.get("clock_speed") or 1.0) / ROWS_PER_S
    found, room = [], MAX_ROWS
    for layout, rows in reversed(parts):
        time_s = rows[:, layouts[layout].index("time_s")]
        kept = rows[thinned(time_s, spacing_s, -1e9)][-room:] if room else rows[:0]
        room -= len(kept)
        columns, complete = with_computed(layouts[layout], kept, shunt_of(state))
        found.append({"layout": layout, "columns": columns, "rows": complete.tolist()})
    return Response(compact({"cursor": cursor, "parts": found[::-1]}), media_type="application/json")


@ROUTES.post("/{bench}/commands")
async def send_command(
    bench: BenchOf, session: SessionOf, command: Command, request: Request, response: Response, lease: LeaseOf = None
) -> CommandResult:
    """Send a command; all but stop need control. 409 says that the bench refused it, with the reason."""
    if command.do not in NEEDS_NO_CONTROL and not session.may_command(bench, lease):
        raise HTTPException(403, "you do not have control of this bench: POST .../control, then send Musclewire-Lease")
    if lease is not None:
        session.sign_of_life(lease)
    answer = await session.command(bench, command, "a program", request.state.stops[bench.name])
    response.status_code = 200 if answer.accepted else 409
    return CommandResult(accepted=answer.accepted, message=answer.message)


@ROUTES.post("/{bench}/stop")
async def stop(bench: BenchOf, response: Response) -> PhaseAnswer:
    """Switch the drive off at once; needs no control and no body. Answers when it is off, at most 1 s later."""
    confirmed = await bench.stopped("a program", STOP_ANSWER_S)
    response.status_code = 200 if confirmed else 202
    return PhaseAnswer(phase=bench.phase)


@ROUTES.post("/{bench}/control")
async def take_control(bench: BenchOf, session: SessionOf, request: ControlRequest = NO_NAME) -> ControlState:
    """Take control of a bench, or ask its holder for it; its lease ends without PUT for 0.75 s (at rest 5 s)."""
    lease = secrets.token_urlsafe(24)
    if session.ask(bench, lease, request.name) is RequestOutcome.BUSY:
        raise HTTPException(409, "somebody else has already asked for control: try again")
    return control_state(bench, session, lease).model_copy(update={"lease": lease})


@ROUTES.put("/{bench}/control")
async def keep_control(
    bench: BenchOf, session: SessionOf, answer: ControlAnswer = NO_ANSWER, lease: LeaseOf = None
) -> ControlState:
    """Show that the holder of a lease is there, and answer who asks for control."""
    if lease is None or not known(bench, lease):
        raise HTTPException(403, "this lease has ended: POST .../control for another")
    session.sign_of_life(lease)
    if answer.give is not None:
        session.answer(bench, lease, answer.give)
    return control_state(bench, session, lease)


@ROUTES.delete("/{bench}/control")
async def give_control_up(bench: BenchOf, session: SessionOf, lease: LeaseOf = None) -> ControlState:
    """Give control up, or the request for it; a heated run ends."""
    if lease is not None:
        session.give_up(bench, lease, "who had control gave it up")
    return control_state(bench, session, lease)


def known(bench: OnlineBench, lease: str) -> bool:
    """Return whether a lease has control of a bench, or asks for it."""
    return any(one is not None and one.key == lease for one in (bench.control.holder, bench.control.asking))


def control_state(bench: OnlineBench, session: Session, lease: str | None) -> ControlState:
    """Return who has control."""
    return ControlState(
        yours=session.may_command(bench, lease),
        holder=name_of(bench.control.holder),
        asked_by=name_of(bench.control.asking),
    )
