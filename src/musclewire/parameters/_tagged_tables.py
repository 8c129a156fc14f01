"""A table of a file in which one key names which of the registered kinds it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, GetCoreSchemaHandler, ValidationError
from pydantic_core import CoreSchema, InitErrorDetails, PydanticKnownError, core_schema

from musclewire.errors import CallerError
from musclewire.registry import Registry


@dataclass(frozen=True)
class TaggedTable:
    """Annotation of a field that holds a table: one key names its kind, whose schema checks it.

    Unlike a union of schemas it accepts kinds that were registered later, by a call or by another package.

    Parameters
    ----------
    registry
        Schemas by name; each has the key as a literal of that name.
    key
        The key that names the kind.
    """

    registry: Registry[Any]
    key: str

    def __get_pydantic_core_schema__(self, _source: Any, _handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return a schema by which pydantic calls :meth:`checked`."""
        return core_schema.no_info_plain_validator_function(self.checked)

    def model_of(self, tag: str) -> type[BaseModel] | None:
        """Return the schema of a kind, or None if there is none of that name."""
        try:
            found: type[BaseModel] = self.registry.find(tag)
        except CallerError:
            return None
        return found

    def checked(self, given: Any) -> BaseModel:
        """Return a table as its kind; the location of an error includes the kind's name, as with a union."""
        if isinstance(given, BaseModel):
            return given
        if not isinstance(given, dict):
            raise PydanticKnownError("model_attributes_type")
        if self.key not in given:
            raise PydanticKnownError("union_tag_not_found", {"discriminator": f"'{self.key}'"})
        tag = given[self.key]
        model = self.model_of(tag) if isinstance(tag, str) else None
        if model is None:
            names = ", ".join(f"'{name}'" for name in self.registry.names())
            raise PydanticKnownError(
                "union_tag_invalid", {"discriminator": f"'{self.key}'", "tag": str(tag), "expected_tags": names}
            )
        try:
            return model.model_validate(given)
        except ValidationError as error:
            raise ValidationError.from_exception_data(
                error.title, [placed(tag, item) for item in errors_of(error)]
            ) from None


def errors_of(error: ValidationError) -> list[Any]:
    """Return the single errors of a validation."""
    return error.errors(include_url=False)


def placed(tag: str, problem: Any) -> InitErrorDetails:
    """Return an error with the kind's name at the head of its location."""
    kind: Any = problem["type"]
    return InitErrorDetails(
        type=kind, loc=(tag, *problem["loc"]), input=problem["input"], ctx=dict(problem.get("ctx", {}))
    )
