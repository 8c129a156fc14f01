"""The command that prints JSON Schemas of files and of what commands print: schema."""

from __future__ import annotations

from typing import Annotated

import typer

from musclewire.app._completion import complete_schemas
from musclewire.app._options import Json
from musclewire.app._output import emit_json, show

__all__ = ["schema"]

SchemaName = Annotated[
    str | None,
    typer.Argument(
        metavar="NAME",
        help="Kind of file or output, as 'model', 'rig-serial' or 'output-control'; without it all names are listed.",
        show_default=False,
        autocompletion=complete_schemas,
    ),
]


def schema(name: SchemaName = None, json: Json = False) -> None:
    """Print the JSON Schema of a kind of file, or of what a command prints with --json."""
    from musclewire.app._json_schemas import json_schema, schema_names

    found = None if name is None else json_schema(name)
    if json:
        emit_json({"names": schema_names(), "schema": found})
    elif found is None:
        show("\n".join(schema_names()))
    else:
        emit_json(found)
