"""What a command prints with --json: models whose fields are the keys, which ``musclewire schema`` shows as well."""

from __future__ import annotations

import typing
from collections.abc import Collection
from math import isfinite
from typing import Annotated, Any, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, GetCoreSchemaHandler, create_model
from pydantic_core import CoreSchema

# What a key has as default that is not there where it would be null.
ABSENT: Any = Field(default=None, exclude_if=lambda value: value is None)

# A number that is null if it is infinite, or not one.
Finite = Annotated[float | None, BeforeValidator(lambda value: value if value is None or isfinite(value) else None)]


class AnswerModel(BaseModel):
    """What a command found: each field is a key of its JSON document, with its unit; None is null."""

    model_config = ConfigDict(extra="forbid", from_attributes=True, json_schema_serialization_defaults_required=True)

    @classmethod
    def read_from(cls, *sources: object, **named: Any) -> Self:
        """Return an answer whose keys are ``named``, or else attributes of the first of the sources that has one."""
        for key in cls.model_fields.keys() - named.keys():
            source = next((one for one in sources if hasattr(one, key)), None)
            if source is not None:
                named[key] = getattr(source, key)
        return cls(**named)


class AnswerRecord:
    """Marks another room's named tuple or dataclass as an object of its fields; ``more`` are further or other keys."""

    def __init__(self, *, without: Collection[str] = (), infinite: Any = None, **more: Any) -> None:
        """Take the fields that are no keys, and what numbers that are not finite are: ... for null, or ABSENT."""
        self._without, self._infinite, self._more = without, infinite, more

    def __get_pydantic_core_schema__(self, kind: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema of an answer with these keys."""
        hints = {name: hint for name, hint in typing.get_type_hints(kind).items() if name not in self._without}
        fields: dict[str, Any] = {name: (hint, ...) for name, hint in {**hints, **self._more}.items()}
        if self._infinite is not None:
            numbers = {name: (Finite, self._infinite) for name, (hint, _) in fields.items() if hint is float}
            fields |= numbers
        return handler.generate_schema(create_model(kind.__name__, __base__=AnswerModel, **fields))
