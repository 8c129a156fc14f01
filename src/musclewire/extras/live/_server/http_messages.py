"""What the HTTP routes take and answer, each a record; commands and the state of a bench are in ``live.messages``."""

from __future__ import annotations

from pydantic import Field

from musclewire.extras.live._messages import Record
from musclewire.extras.live._server.socket_messages import PersonName


class BenchSummary(Record):
    """A bench in short."""

    bench: str = Field(description="The bench's name in addresses.")
    phase: str = Field(description="What it does: starting, off, ready, busy, ending, stopped or failed.")
    simulated: bool = Field(description="Whether its rig is simulated.")
    holder: str | None = Field(description="Who has control; null if nobody has.")


class BenchList(Record):
    """All benches of the session."""

    benches: list[BenchSummary]


class LayoutRows(Record):
    """Rows of the same columns, oldest first; null for NaN."""

    layout: int
    columns: list[str]
    rows: list[list[float | None]]


class RowsAnswer(Record):
    """Rows since a cursor, at most 100 a second, and the cursor for the next request."""

    cursor: int
    parts: list[LayoutRows]


class CommandResult(Record):
    """Whether a command has begun, and if not, why."""

    accepted: bool
    message: str


class PhaseAnswer(Record):
    """The phase of a bench after a stop: stopped, or failed if its process has ended, once its drive is off."""

    phase: str


class ControlRequest(Record):
    """Take control, or ask its holder for it."""

    name: PersonName = "a program"


class ControlAnswer(Record):
    """Keep control, and answer who asks for it; null answers nothing."""

    give: bool | None = None


class ControlState(Record):
    """Who has control of a bench."""

    yours: bool = Field(description="Whether the lease of the request has control.")
    holder: str | None = Field(description="Who has control; null if nobody has.")
    asked_by: str | None = Field(description="Who asks for it; null if nobody does.")
    lease: str | None = Field(default=None, description="In the answer to POST: the secret for Musclewire-Lease.")


class RecordingSummary(Record):
    """A recording of the session."""

    name: str
    bytes: int
    modified_s: float = Field(description="When it was last written, in seconds since 1970.")


class RecordingList(Record):
    """All recordings of the session, the newest first."""

    recordings: list[RecordingSummary]


class ProblemAnswer(Record):
    """Why a request was not answered, in one line."""

    problem: str
