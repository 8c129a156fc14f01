"""JSON Schemas of what commands without a model of their answer print with --json, gathered from real answers.

    python -m checks.output_schemas              writes every stored schema anew, from CALLS and MORE
    python -m checks.output_schemas --only fit   of one command

The calls are those of ``tests/house/docs/test_command_line.py``, which holds the answers to the keys of
``docs/reference/command_line.md`` and to these schemas, and some more, whose answers differ in kind. A key may be null
if an answer had null, or if the reference says so in a sentence with its name. Keys of a document are exact; the
objects in it may have others, as results of another quantity have.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src/musclewire"
FOLDER = PACKAGE / "app/data/outputs"
DIALECT = "https://json-schema.org/draft/2020-12/schema"
Schema = dict[str, Any]
# Further calls, whose answers have what the first ones lack.
MORE: dict[str, list[list[str]]] = {"design pretensioner": [["--list"]]}


def shape(value: Any) -> Schema:
    """Return the schema of one value."""
    if isinstance(value, dict):
        return {"type": ["object"], "properties": {key: shape(one) for key, one in value.items()}, "required": [*value]}
    if isinstance(value, list):
        return {"type": ["array"], **({"items": merged(map(shape, value))} if value else {})}
    kinds = {bool: "boolean", int: "integer", float: "number", str: "string", type(None): "null"}
    return {"type": [kinds[type(value)]]}


def merged(schemas: Iterable[Schema]) -> Schema:
    """Return the schema of values of which each has one of these."""
    found = list(schemas)
    types = {kind for one in found for kind in one["type"]}
    schema: Schema = {"type": sorted(types - ({"integer"} if "number" in types else set()))}
    objects = [one for one in found if "properties" in one]
    if objects:
        keys = dict.fromkeys(key for one in objects for key in one["properties"])
        schema["properties"] = {
            key: merged(one["properties"][key] for one in objects if key in one["properties"]) for key in keys
        }
        schema["required"] = [key for key in keys if all(key in one["required"] for one in objects)]
    items = [one["items"] for one in found if "items" in one]
    return schema | ({"items": merged(items)} if items else {})


def nullable_keys(section: str) -> set[str]:
    """Return the names in sentences of the reference that speak of null."""
    sentences = re.split(r"(?<=[.;])\s", section)
    return {word for one in sentences if "null" in one for word in re.findall(r"`(\w+)`", one)}


def finished(schema: Schema, nullable: set[str], name: str = "") -> Schema:
    """Return a schema as it is written: a type alone is no list, what was only ever null is anything."""
    types = set(schema["type"]) | ({"null"} if name in nullable else set())
    if types == {"null"}:
        return {}
    done: Schema = {"type": next(iter(types)) if len(types) == 1 else sorted(types)}
    if "properties" in schema:
        done["properties"] = {key: finished(one, nullable, key) for key, one in schema["properties"].items()}
    return done | ({"items": finished(schema["items"], nullable)} if "items" in schema else {})


def document_schema(name: str, answers: list[Any], section: str) -> Schema:
    """Return the schema of a command's document."""
    body = finished(merged(map(shape, answers)), nullable_keys(section))
    # With another option, as --list, another document is printed.
    alternatives = [{"required": list(keys)} for keys in dict.fromkeys(tuple(sorted(answer)) for answer in answers)]
    body |= alternatives[0] if len(alternatives) == 1 else {"anyOf": alternatives}
    title = f"musclewire {name} --json"
    return {"$schema": DIALECT, "title": title, **body, "additionalProperties": False}


def schema_file(name: str) -> Path:
    """Return where a schema is: in the part that has one of that name, otherwise with those of the core."""
    of_parts = PACKAGE.glob(f"extras/*/outputs/{name}")
    return next(of_parts, FOLDER / name)


def main() -> None:
    """Run the commands and write the schemas."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--only", action="append", default=[], help="a command, as 'export c'; repeatable")
    only = parser.parse_args().only
    sys.path.insert(0, str(ROOT))
    from tests.house.docs import test_command_line as calls

    with tempfile.TemporaryDirectory(prefix="musclewire-outputs-") as name:
        folder = calls.prepared(Path(name))
        for command, first in calls.CALLS.items():
            target = schema_file(f"{command.replace(' ', '-')}.json")
            if not target.is_file() or (only and command not in only):
                continue
            every = [first, *MORE.get(command, [])]
            answers = [
                json.loads(calls.run(folder, *command.split(), *call, "--json", may_not_hold=True)) for call in every
            ]
            schema = document_schema(command, answers, calls.SECTIONS[command])
            target.write_text(json.dumps(schema, indent=1, ensure_ascii=False) + "\n", "utf-8")
            print(f"{command}: {len(answers)} answers, {len(schema['properties'])} keys", flush=True)


if __name__ == "__main__":
    main()
