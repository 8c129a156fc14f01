"""HTTP routes of the benches: state, rows, commands, stop, control."""

from __future__ import annotations

import secrets
from typing import Annotated, Any

from fastapi import APIRouter, HTTPException, Query
from starlette.responses import Response

from musclewire.extras.live._messages import NEEDS_NO_CONTROL, read_command
from musclewire.extras.live._server.frames import ROWS_PER_S, json_rows, shunt_of, thinned, with_computed
from musclewire.extras.live._server.http_messages import (
    CONTROL_ANSWER,
    CONTROL_REQUEST,
    BenchList,
    CommandResult,
    ControlAnswer,
    ControlRequest,
    ControlState,
    PhaseAnswer,
    RowsAnswer,
    read_as,
)
from musclewire.extras.live._server.json_texts import compact_finite
from musclewire.extras.live._server.leases import RequestOutcome
from musclewire.extras.live._server.requests import PROBLEMS, BenchOf, BodyOf, LeaseOf, SessionOf, json_answer
from musclewire.extras.live._server.session import SAFE_PHASES, OnlineBench, name_of

__all__ = ["ROUTES"]

# A stop is answered when the drive is off; after this time in any case.
STOP_ANSWER_S = 1.0
# Rows of a request at most, the newest: at 100 a second twenty seconds.
MAX_ROWS = 2000
ROUTES = APIRouter(prefix="/api/v1/benches", responses=PROBLEMS, tags=["benches"])


def json_body(schema: dict[str, Any]) -> dict[str, Any]:
    """Return how OpenAPI describes a body that is read by the route itself, within its limits."""
    return {"requestBody": {"content": {"application/json": {"schema": schema}}}}


@ROUTES.get("", response_model=BenchList)
async def list_benches(session: SessionOf) -> Response:
    """List the benches of the session."""
    return json_answer({"benches": [summary(bench) for bench in session.benches.values()]})


def summary(bench: OnlineBench) -> dict[str, Any]:
    """Return a bench in short."""
    rig = bench.handle.state.get("rig") or {}
    return {
        "bench": bench.name,
        "phase": bench.phase,
        "simulated": bool(rig.get("simulated")),
        "holder": name_of(bench.control.holder),
    }


@ROUTES.get("/{bench}")
async def bench_state(bench: BenchOf) -> Response:
    """Return the whole state of a bench."""
    return Response(compact_finite(bench.handle.state), media_type="application/json")


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
        found.append({"layout": layout, "columns": columns, "rows": json_rows(complete)})
    return json_answer({"cursor": cursor, "parts": found[::-1]})


@ROUTES.post(
    "/{bench}/commands", response_model=CommandResult, openapi_extra=json_body({"$ref": "#/components/schemas/Command"})
)
async def send_command(bench: BenchOf, session: SessionOf, body: BodyOf, lease: LeaseOf = None) -> Response:
    """Send a command; all but stop need control. 409 says that the bench refused it, with the reason."""
    command = read_command(body)
    if command.do not in NEEDS_NO_CONTROL and not session.may_command(bench, lease):
        raise HTTPException(403, "you do not have control of this bench: POST .../control, then send Musclewire-Lease")
    if lease is not None:
        session.sign_of_life(lease)
    answer = await session.command(bench, command, "a program")
    return json_answer({"accepted": answer.accepted, "message": answer.message}, 200 if answer.accepted else 409)


@ROUTES.post("/{bench}/stop", response_model=PhaseAnswer)
async def stop(bench: BenchOf) -> Response:
    """Switch the drive off at once; needs no control and no body. Answers when it is off, at most 1 s later."""
    bench.handle.stop("a program")
    phase = await bench.wait_until_safe(STOP_ANSWER_S)
    return json_answer({"phase": phase}, 200 if phase in SAFE_PHASES else 202)


@ROUTES.post(
    "/{bench}/control", response_model=ControlState, openapi_extra=json_body(ControlRequest.model_json_schema())
)
async def take_control(bench: BenchOf, session: SessionOf, body: BodyOf) -> Response:
    """Take control of a bench, or ask its holder for it; its lease ends without PUT for 0.6 s (at rest 5 s)."""
    request = read_as(CONTROL_REQUEST, body)
    lease = secrets.token_urlsafe(24)
    if session.ask(bench, lease, request.name) is RequestOutcome.BUSY:
        raise HTTPException(409, "somebody else has already asked for control: try again")
    return json_answer({**control_state(bench, session, lease), "lease": lease})


@ROUTES.put("/{bench}/control", response_model=ControlState, openapi_extra=json_body(ControlAnswer.model_json_schema()))
async def keep_control(bench: BenchOf, session: SessionOf, body: BodyOf, lease: LeaseOf = None) -> Response:
    """Show that the holder of a lease is there, and answer who asks for control."""
    answer = read_as(CONTROL_ANSWER, body)
    if lease is None or not known(bench, lease):
        raise HTTPException(403, "this lease has ended: POST .../control for another")
    session.sign_of_life(lease)
    if answer.give is not None:
        session.answer(bench, lease, answer.give)
    return json_answer(control_state(bench, session, lease))


@ROUTES.delete("/{bench}/control", response_model=ControlState)
async def give_control_up(bench: BenchOf, session: SessionOf, lease: LeaseOf = None) -> Response:
    """Give control up, or the request for it; a heated run ends."""
    if lease is not None:
        session.give_up(bench, lease, "who had control gave it up")
    return json_answer(control_state(bench, session, lease))


def known(bench: OnlineBench, lease: str) -> bool:
    """Return whether a lease has control of a bench, or asks for it."""
    return any(one is not None and one.key == lease for one in (bench.control.holder, bench.control.asking))


def control_state(bench: OnlineBench, session: Any, lease: str | None) -> dict[str, Any]:
    """Return who has control."""
    return {
        "yours": session.may_command(bench, lease),
        "holder": name_of(bench.control.holder),
        "asked_by": name_of(bench.control.asking),
    }
