"""The command that prints JSON Schemas of files and of what commands print: schema."""

from __future__ import annotations

from json import dumps
from typing import Annotated, Any

import typer
from pydantic import Field

from musclewire.app._answer import AnswerModel
from musclewire.app._completion import complete_schemas
from musclewire.app._output import Result

SchemaName = Annotated[
    str | None,
    typer.Argument(
        metavar="NAME",
        help="Kind of file or output, as 'model', 'rig-serial' or 'output-control'; without it all names are listed.",
        show_default=False,
        autocompletion=complete_schemas,
    ),
]


class SchemaAnswer(AnswerModel):
    """Of ``schema``: all names, and the schema of the one that was given."""

    names: tuple[str, ...]
    schema_: dict[str, Any] | None = Field(serialization_alias="schema")


def schema(name: SchemaName = None) -> Result:
    """Print the JSON Schema of a kind of file, or of what a command prints with --json."""
    from musclewire.app._json_schemas import json_schema, schema_names

    found = None if name is None else json_schema(name)
    text = "\n".join(schema_names()) if found is None else dumps(found, indent=2)
    return Result(SchemaAnswer(names=schema_names(), schema_=found), text)
