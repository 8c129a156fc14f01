"""Data from outside, checked before it is used: unknown keys are errors that name the nearest known one."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from musclewire.errors import CallerError, nearest_hint


class StrictModel(BaseModel):
    """A frozen record without unknown keys; errors are reported as ``CallerError``."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)
    # Name of the controller whose settings a record is; "" for one that is none's.
    of_controller: ClassVar[str] = ""

    def __init__(self, **values: Any) -> None:
        """Check and keep ``values``; a ``CallerError`` says in one line which key is wrong and why."""
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise caller_error(type(self).__name__, error) from None

    @model_validator(mode="before")
    @classmethod
    def _unknown_keys_name_the_nearest(cls, values: Any) -> Any:
        # Pydantic would report only "extra inputs are not permitted"; for a typo the nearest key is more useful.
        if isinstance(values, dict):
            for key in values:
                if key not in cls.model_fields:
                    raise ValueError(f"unknown key '{key}'{nearest_hint(str(key), cls.model_fields)}")
        return values


def caller_error(where: str, error: ValidationError) -> CallerError:
    """Return the first of the errors in ``error`` as one line that starts with ``where``."""
    first = error.errors(include_url=False)[0]
    place = ".".join(str(part) for part in first["loc"])
    message = first["msg"].removeprefix("Value error, ")
    more = f" ({error.error_count() - 1} more)" if error.error_count() > 1 else ""
    return CallerError(f"{where}: {place + ': ' if place else ''}{message}{more}")
