"""Messages over the WebSocket, each a record: what a page may send, and what it is sent."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from musclewire.errors import CallerError
from musclewire.extras.live._messages import Command

__all__ = ["FROM_PAGE", "TO_PAGE", "FromPage", "ToPage", "read_message"]

BenchName: TypeAlias = Annotated[str, Field(min_length=1, max_length=100)]
PersonName: TypeAlias = Annotated[str, Field(min_length=1, max_length=60)]
Number: TypeAlias = Annotated[int, Field(ge=0, le=2**53)]


class Message(BaseModel):
    """A message without unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Pong(Message):
    """Answer to a ping, sent at once by the page's main thread: by it a holder of control stays one."""

    type: Literal["pong"]
    n: Number


class CommandMessage(Message):
    """A command to a bench; ``id`` comes back with its answer."""

    type: Literal["command"]
    id: Number
    bench: BenchName
    command: Command


class AskControl(Message):
    """Take control of a bench, or ask its holder for it."""

    type: Literal["ask_control"]
    bench: BenchName
    name: PersonName | None = None


class AnswerControl(Message):
    """Give control to who asks, or keep it."""

    type: Literal["answer_control"]
    bench: BenchName
    give: bool


class GiveUpControl(Message):
    """Give control up, or take back the request for it."""

    type: Literal["give_up_control"]
    bench: BenchName


class Hello(Message):
    """The first message of the server: who the viewer is, and which benches there are."""

    type: Literal["hello"] = "hello"
    version: str
    you: str
    benches: list[str]
    token_needed: bool


class StateMessage(Message):
    """The whole state of a bench, sent when it changes."""

    type: Literal["state"] = "state"
    state: dict[str, Any]


class Rule(Message):
    """A fuzzy rule that fires: its input sets, its weight, and what it says of the three gains."""

    error: str
    change: str
    weight: float
    kp: str
    ki: str
    kd: str


class RowsMessage(Message):
    """Rows of a bench, oldest first, null for NaN; columns come with the first rows of a layout."""

    type: Literal["rows"] = "rows"
    bench: str
    layout: int
    columns: list[str] | None = None
    rows: list[list[float | None]]
    rules: list[Rule] | None = None


class ControlMessage(Message):
    """Who has control of a bench, and who asks for it."""

    type: Literal["control"] = "control"
    bench: str
    holder: str | None
    you_hold: bool
    asked_by: str | None


class Ping(Message):
    """A sign of life is expected: a pong with the same number."""

    type: Literal["ping"] = "ping"
    n: int


class CommandAnswer(Message):
    """Whether a command has begun, and if not, why."""

    type: Literal["answer"] = "answer"
    id: int
    accepted: bool
    message: str


class Problem(Message):
    """A message that was not understood or not permitted."""

    type: Literal["problem"] = "problem"
    message: str


FromPage: TypeAlias = Annotated[
    Pong | CommandMessage | AskControl | AnswerControl | GiveUpControl, Field(discriminator="type")
]
ToPage: TypeAlias = Annotated[
    Hello | StateMessage | RowsMessage | ControlMessage | Ping | CommandAnswer | Problem, Field(discriminator="type")
]
FROM_PAGE: TypeAdapter[FromPage] = TypeAdapter(FromPage)
TO_PAGE: TypeAdapter[ToPage] = TypeAdapter(ToPage)


def read_message(data: object) -> FromPage:
    """Return a page's message from decoded JSON. CallerError, in one line, for anything else."""
    try:
        return FROM_PAGE.validate_python(data)
    except (ValidationError, RecursionError, OverflowError) as error:
        raise CallerError(one_line(error)) from None


def one_line(error: Exception) -> str:
    """Return the first fault of a message: where, and what."""
    if not isinstance(error, ValidationError):
        return "message: cannot be read, send a JSON object"
    first = error.errors(include_url=False, include_input=False, include_context=False)[0]
    place = ".".join(str(part)[:40] for part in first["loc"][:6])
    return f"message{': ' + place if place else ''}: {first['msg']}"[:300]
