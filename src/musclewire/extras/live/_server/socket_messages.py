"""Messages over the WebSocket, each a record: what a page may send, and what it is sent."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import AfterValidator, Field, TypeAdapter, ValidationError

from musclewire.errors import CallerError
from musclewire.extras.live._messages import Command, Record

BenchName: TypeAlias = Annotated[str, Field(min_length=1, max_length=100)]


def plain_name(name: str) -> str:
    """Return a name with printable characters only. Raises ValueError if none is left."""
    plain = "".join(letter for letter in name if letter.isprintable()).strip()
    if not plain:
        raise ValueError("give a name of letters that can be seen")
    return plain


PersonName: TypeAlias = Annotated[str, Field(min_length=1, max_length=60), AfterValidator(plain_name)]
Number: TypeAlias = Annotated[int, Field(ge=0, le=2**53)]


class Pong(Record):
    """Answer to a ping, sent at once by the page's main thread: by it a holder of control stays one."""

    type: Literal["pong"]
    n: Number


class CommandMessage(Record):
    """A command to a bench; ``id`` comes back with its answer."""

    type: Literal["command"]
    id: Number
    bench: BenchName
    command: Command


class AskControl(Record):
    """Take control of a bench, or ask its holder for it."""

    type: Literal["ask_control"]
    bench: BenchName
    name: PersonName | None = None


class AnswerControl(Record):
    """Give control to who asks, or keep it."""

    type: Literal["answer_control"]
    bench: BenchName
    give: bool


class GiveUpControl(Record):
    """Give control up, or take back the request for it."""

    type: Literal["give_up_control"]
    bench: BenchName


class Hello(Record):
    """The first message of the server: who the viewer is, and which benches there are."""

    type: Literal["hello"] = "hello"
    version: str
    you: str
    benches: list[str]
    token_needed: bool


class StateMessage(Record):
    """The whole state of a bench, sent when it changes."""

    type: Literal["state"] = "state"
    state: dict[str, Any]


class FiredRule(Record):
    """A fuzzy rule that fires: its input sets, its weight, and what it says of the three gains."""

    error: str
    change: str
    weight: float
    kp: str
    ki: str
    kd: str


class RowsMessage(Record):
    """Rows of a bench, oldest first, null for NaN; columns come with the first rows of a layout."""

    type: Literal["rows"] = "rows"
    bench: str
    layout: int
    columns: list[str] | None = None
    rows: list[list[float | None]]
    rules: list[FiredRule] | None = None


class ControlMessage(Record):
    """Who has control of a bench, and who asks for it."""

    type: Literal["control"] = "control"
    bench: str
    holder: str | None
    you_hold: bool
    asked_by: str | None


class Ping(Record):
    """A sign of life is expected: a pong with the same number."""

    type: Literal["ping"] = "ping"
    n: int


class CommandAnswer(Record):
    """Whether a command has begun, and if not, why."""

    type: Literal["answer"] = "answer"
    id: int
    accepted: bool
    message: str


class Problem(Record):
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


def read_message(data: object) -> FromPage:
    """Return a page's message from decoded JSON. CallerError, in one line, for anything else."""
    try:
        return FROM_PAGE.validate_python(data)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False, include_context=False)[0]
        raise CallerError(one_line(first)) from None


def one_line(fault: Mapping[str, Any]) -> str:
    """Return a fault that pydantic found: where, and what, without repeating what was sent."""
    place = ".".join(str(part)[:40] for part in fault["loc"][:6])
    return f"message{': ' + place if place else ''}: {fault['msg']}"[:300]
