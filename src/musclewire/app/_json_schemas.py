"""JSON Schemas of the files that musclewire reads, from the models that check them, and of what its commands print.

A schema says which keys a file may have and of which kind their values are; what depends on several keys, and whether a
unit fits its quantity, is checked when the file is read.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from pydantic import BaseModel, TypeAdapter
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from musclewire.app._core_commands import COMMANDS
from musclewire.errors import CallerError, nearest_hint
from musclewire.manifest import loaded, manifests, offered
from musclewire.parameters import TaggedTable

DIALECT = "https://json-schema.org/draft/2020-12/schema"
OUTPUT = "output-"
RIG = "rig-"
# Keys of the tables of a wire file that the reader adds: they say once for the file what a shipped file says in each.
ADDED_ON_READING = ("name", "description", "alloy")


class FileSchema(GenerateJsonSchema):
    """A schema of what is written in a file, where pydantic would give that of what was read out of it."""

    def function_before_schema(self, schema: core_schema.BeforeValidatorFunctionSchema) -> JsonSchemaValue:
        """Add text with a unit to a number that may have one, and lines of text to a table that may be so written."""
        inner = super().function_before_schema(schema)
        also = written_as(schema["function"]["function"])
        return inner if also is None else {"anyOf": [inner, also]}

    def function_plain_schema(self, schema: core_schema.PlainValidatorFunctionSchema) -> JsonSchemaValue:
        """Return the kinds of a table as alternatives; kinds of other packages are among them once registered."""
        owner = getattr(schema["function"]["function"], "__self__", None)
        if not isinstance(owner, TaggedTable):
            return super().function_plain_schema(schema)
        models = [owner.model_of(name) for name in owner.registry.names()]
        return {"oneOf": [self.generate_inner(model.__pydantic_core_schema__) for model in models if model]}


def written_as(function: Any) -> JsonSchemaValue | None:
    """Return the schema of the text that a validator reads, None if it reads none."""
    unit = getattr(function, "unit", None)
    if unit is None:
        return getattr(function, "written_as", None)
    return {"type": "string", "description": f"a number with a unit that converts to {unit or 'a plain number'}"}


def file_models() -> dict[str, type[BaseModel]]:
    """Return the model of each kind of file, by the schema's name."""
    from musclewire.parameters import FingerFile, Material, PretensionerFile, WireFile
    from musclewire.rigs import DEVICES
    from musclewire.sensing import ModelFile

    rigs = {f"{RIG}{kind}": DEVICES.find(kind).configuration for kind in DEVICES.own_names()}
    return {
        "model": ModelFile,
        "wire": WireFile,
        "finger": FingerFile,
        "pretensioner": PretensionerFile,
        "material": Material,
        **{name: loaded(place) for name, place in offered("schemas").items()},
        **rigs,
    }


@cache
def answers() -> dict[str, str]:
    """Return where the model of what a command prints is, by the schema's name."""
    commands = [*COMMANDS, *(command for manifest in manifests() for command in manifest.commands)]
    return {
        f"{command.group} {command.name}".strip().replace(" ", "-"): command.answer
        for command in commands
        if command.answer
    }


@cache
def schema_names() -> tuple[str, ...]:
    """Return the names of all schemas: files first, then what commands print with ``--json``, as "output-control"."""
    return (*file_models(), *(f"{OUTPUT}{name}" for name in sorted(answers())))


def json_schema(name: str) -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a file, or of what a command prints. Raises CallerError if there is none."""
    if name not in schema_names():
        raise CallerError(f"there is no schema '{name}'{nearest_hint(name, schema_names())}")
    command = name.removeprefix(OUTPUT)
    if command in answers():
        schema = TypeAdapter(loaded(answers()[command])).json_schema(mode="serialization")
        return {"$schema": DIALECT, **schema, "title": f"musclewire {command.replace('-', ' ')} --json"}
    return {"$schema": DIALECT, **of_model(name, file_models()[name])}


def of_model(name: str, model: type[BaseModel]) -> dict[str, Any]:
    """Return the schema of a file from the model that checks it."""
    schema = model.model_json_schema(schema_generator=FileSchema)
    if name == "wire":
        for table in ("Wire", "Alloy"):
            required = schema["$defs"][table]["required"]
            schema["$defs"][table]["required"] = [key for key in required if key not in ADDED_ON_READING]
    return schema
