"""Commands to a bench: one record each, checked before it reaches the rig. None names a rig or a path of a file."""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError, field_validator

from musclewire.errors import CallerError

# Nothing a page sends may grow without end:
MAX_POINTS = 10_000  # of a drawn path
MAX_TEXT = 100  # characters of a text
Positive: TypeAlias = Annotated[float, Field(gt=0.0)]
Name: TypeAlias = Annotated[str, Field(min_length=1, max_length=MAX_TEXT)]
Points: TypeAlias = Annotated[list[float], Field(min_length=1, max_length=MAX_POINTS)]


class Record(BaseModel):
    """A record without unknown keys, texts for numbers, and numbers that are not finite."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Steer(Record):
    """A target that is moved while the loop runs; it starts at ``start``, or in the middle of the model's range."""

    kind: Literal["steer"]
    start: float | None = None


class Steps(Record):
    """A staircase up and back, in the unit of the model's quantity (strain as a fraction); None for the paper's."""

    kind: Literal["staircase"]
    start: float | None = None
    stop: float | None = None
    step: Positive | None = None
    hold_s: Positive = 6.0


class Sine(Record):
    """A sine about ``middle``, in the unit of the model's quantity."""

    kind: Literal["sine"]
    middle: float
    amplitude: Positive
    period_s: Positive
    cycles: Annotated[int, Field(ge=1, le=1000)] = 3


class DrawnPath(Record):
    """Points that were drawn or typed; between two points the target goes straight."""

    kind: Literal["path"]
    time_s: Points
    target: Points


Reference: TypeAlias = Annotated[Steer | Steps | Sine | DrawnPath, Field(discriminator="kind")]


class SwitchOn(Record):
    """Open the rig, at 0 V, and begin to sense."""

    do: Literal["switch_on"]


class Stop(Record):
    """Switch the drive off at once and for good; anybody may."""

    do: Literal["stop"]


class Doctor(Record):
    """Check wiring and instruments at the sense voltage and below."""

    do: Literal["doctor"]


class Pulse(Record):
    """Warm the wire for a moment; by default at a part of the rig's amplitude that does no wire harm."""

    do: Literal["pulse"]
    drive_voltage_v: Positive | None = None
    duration_s: Annotated[float, Field(gt=0.0, le=10.0)] = 1.0


class Characterize(Record):
    """Heat and cool the wire slowly, as ``characterize`` does."""

    do: Literal["characterize"]
    amplitude_v: Positive | None = None
    period_s: Annotated[float, Field(gt=0.0, le=3600.0)] = 90.0
    cycles: Annotated[int, Field(ge=1, le=100)] = 2
    minor_loop: bool = True


class Fit(Record):
    """Fit a model to this session's last slow loop."""

    do: Literal["fit"]
    quantity: Literal["strain", "displacement", "force"] = "strain"


class Home(Record):
    """Make a home move and bring the model up to date."""

    do: Literal["home"]


class SweepPretension(Record):
    """Characterize the wire at several pretensions."""

    do: Literal["sweep_pretension"]
    pretensions_n: Annotated[list[Positive], Field(min_length=1, max_length=50)] | None = None


class ChoosePretension(Record):
    """Set the pretension of the cold wire by the rig's stage."""

    do: Literal["choose_pretension"]
    pretension_n: Positive


class Control(Record):
    """Close the loop by the wire's resistance."""

    do: Literal["control"]
    reference: Reference
    controller: Name | None = None
    estimator: Name | None = None
    settings: Annotated[dict[str, Any], Field(max_length=50)] | None = None

    @field_validator("settings")
    @classmethod
    def finite(cls, settings: dict[str, Any] | None) -> dict[str, Any] | None:
        """Refuse numbers that are not finite, however deep they are."""
        try:
            json.dumps(settings, allow_nan=False)
        except RecursionError:
            raise ValueError("'settings' is nested too deeply: send it flatter") from None
        return settings


class SetTarget(Record):
    """Move the target of a steered loop, in the unit of the model's quantity."""

    do: Literal["target"]
    value: float


class End(Record):
    """End the run: what was recorded is kept, and the rig goes to its sense voltage."""

    do: Literal["end"]


class ClockSpeed(Record):
    """Run a simulated rig this many times as fast as the clock."""

    do: Literal["clock_speed"]
    factor: Annotated[float, Field(gt=0.0, le=100.0)]


class LoadModel(Record):
    """Take a model that is in the session's folder."""

    do: Literal["load_model"]
    name: Name


Command: TypeAlias = Annotated[
    SwitchOn
    | Stop
    | Doctor
    | Pulse
    | Characterize
    | Fit
    | Home
    | SweepPretension
    | ChoosePretension
    | Control
    | SetTarget
    | End
    | ClockSpeed
    | LoadModel,
    Field(discriminator="do"),
]
COMMANDS: TypeAdapter[Command] = TypeAdapter(Command)
# What anybody who sees the page may send; everything else is for whoever has control.
NEEDS_NO_CONTROL = frozenset({"stop"})


class Answer(NamedTuple):
    """Whether a command has begun, and if not, why, in one line."""

    accepted: bool
    message: str = ""


def read_command(data: object) -> Command:
    """Return a command from decoded JSON. Raises CallerError for unknown or missing keys and values out of range."""
    try:
        return COMMANDS.validate_python(data)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        place = ".".join(str(part) for part in first["loc"])
        raise CallerError(f"command{': ' + place if place else ''}: {first['msg']}"[:300]) from None
