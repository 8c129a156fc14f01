"""What the HTTP routes take and answer, each a record; commands and the state of a bench are in ``live.messages``."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from musclewire.errors import CallerError
from musclewire.extras.live._server.socket_messages import PersonName, one_line

__all__ = [
    "CONTROL_ANSWER",
    "CONTROL_REQUEST",
    "BenchList",
    "BenchSummary",
    "CommandResult",
    "ControlAnswer",
    "ControlRequest",
    "ControlState",
    "LayoutRows",
    "PhaseAnswer",
    "ProblemAnswer",
    "RecordingList",
    "RecordingSummary",
    "RowsAnswer",
    "read_as",
]


class StrictRecord(BaseModel):
    """A record without unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class BenchSummary(StrictRecord):
    """A bench in short."""

    bench: str = Field(description="The bench's name in addresses.")
    phase: str = Field(description="What it does: starting, off, ready, busy, ending, stopped or failed.")
    simulated: bool = Field(description="Whether its rig is simulated.")
    holder: str | None = Field(description="Who has control; null if nobody has.")


class BenchList(StrictRecord):
    """All benches of the session."""

    benches: list[BenchSummary]


class LayoutRows(StrictRecord):
    """Rows of the same columns, oldest first; null for NaN."""

    layout: int
    columns: list[str]
    rows: list[list[float | None]]


class RowsAnswer(StrictRecord):
    """Rows since a cursor, at most 100 a second, and the cursor for the next request."""

    cursor: int
    parts: list[LayoutRows]


class CommandResult(StrictRecord):
    """Whether a command has begun, and if not, why."""

    accepted: bool
    message: str


class PhaseAnswer(StrictRecord):
    """The phase of a bench after a stop: stopped, off or failed once its drive is off."""

    phase: str


class ControlRequest(StrictRecord):
    """Take control, or ask its holder for it."""

    name: PersonName = "a program"


class ControlAnswer(StrictRecord):
    """Keep control, and answer who asks for it; null answers nothing."""

    give: bool | None = None


class ControlState(StrictRecord):
    """Who has control of a bench."""

    yours: bool = Field(description="Whether the lease of the request has control.")
    holder: str | None = Field(description="Who has control; null if nobody has.")
    asked_by: str | None = Field(description="Who asks for it; null if nobody does.")
    lease: str | None = Field(default=None, description="In the answer to POST: the secret for Musclewire-Lease.")


class RecordingSummary(StrictRecord):
    """A recording of the session."""

    name: str
    bytes: int
    modified_s: float = Field(description="When it was last written, in seconds since 1970.")


class RecordingList(StrictRecord):
    """All recordings of the session, the newest first."""

    recordings: list[RecordingSummary]


class ProblemAnswer(StrictRecord):
    """Why a request was not answered, in one line."""

    problem: str


CONTROL_REQUEST: TypeAdapter[ControlRequest] = TypeAdapter(ControlRequest)
CONTROL_ANSWER: TypeAdapter[ControlAnswer] = TypeAdapter(ControlAnswer)


def read_as(adapter: TypeAdapter[Any], data: Any) -> Any:
    """Return decoded JSON as a record. CallerError, in one line, for anything else."""
    try:
        return adapter.validate_python(data)
    except (ValidationError, RecursionError, OverflowError) as error:
        raise CallerError(one_line(error)) from None
