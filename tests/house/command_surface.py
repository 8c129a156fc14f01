"""What people type and programs read, taken from the live command line and from ``import musclewire``.

    python -m tests.house.command_surface      prints the listing as tests/house/command_surface.toml has it
    python -m tests.house.command_surface -w   writes it there; read the difference before it is committed

It goes through the console script that ``pyproject.toml`` names, ``musclewire schema`` and the public names only, so
that files may move within the package. What no program can list it asks about: the suffix
of a file is tried, those of the listing and those that a message names.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
import tempfile
import tomllib
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import typer
from typer.testing import CliRunner

import musclewire as mw
from musclewire.app import app
from musclewire.manifest import absent_part, manifests_of_others
from musclewire.registry import Registry

ROOT = Path(__file__).resolve().parents[2]
LISTING = Path(__file__).with_name("command_surface.toml")
HEAD = """\
# What people type and programs read: one table for each command, and the names that files and programs use.
# tests/house/test_command_surface.py compares it with the live command line; tests/house/command_surface.py writes it.
# An option: its names, what it takes, "= default" or "required".
# A key of --json: "rows[].name" is the key name of each object of the list rows, "parameters.*.value" that of each
# object of parameters.
"""
# What the Tab key lists for an argument or an option, in a folder without files.
COMPLETED = {
    "rigs": "rig",
    "wires": "--wire",
    "materials": "--material",
    "fingers": "--finger",
    "estimators": "--estimator",
    "controllers": "--controller",
    "rule_bases": "--rules",
    "schemas": "name",
}
REGISTRIES = {
    "rig_kinds": "DEVICES",
    "registered_estimators": "ESTIMATORS",
    "registered_controllers": "CONTROLLERS",
    "load_parts": "LOAD_PARTS",
    "run_kinds": "RUN_KINDS",
}
OUTPUT = "output-"
# Below these keys is a document of any kind, of which the schema has the one that was printed when it was written.
ANY_DOCUMENT = {"schema": "schema."}
Listing = dict[str, Any]


def listing(known: Listing) -> Listing:
    """Return what there is now; ``known`` is the listing whose suffixes are tried."""
    names = {
        "public": [name for name in dir(mw) if name not in of_others("names")],
        "errors": [f"{one.__name__} {one.exit_code}" for one in errors()],
        **{name: own_kinds(getattr(mw, registry)) for name, registry in REGISTRIES.items()},
        **completed_names(),
        "recordings_read": readable(known["names"]["recordings_read"]),
        "recordings_written": writable(known["names"]["recordings_written"]),
    }
    return {
        "names": names,
        "command": {name: command_table(name, command) for name, command in commands().items()},
    }


# A package beside musclewire that README's second command installs: its commands are in the listing.
LISTED_BESIDE = ("design",)


def of_others(kind: str) -> set[str]:
    """Return what packages beside musclewire offer of a kind, by their manifests: it comes and goes with them."""
    others = (manifest for manifest in manifests_of_others() if manifest.name not in LISTED_BESIDE)
    return {getattr(one, "name", one) for manifest in others for one in getattr(manifest, kind)}


def own_kinds(registry: Registry[Any]) -> list[str]:
    """Return the names of musclewire's own kinds."""
    others = of_others(registry.field)
    return [name for name in registry.own_names() if name not in others]


@cache
def commands() -> dict[str, Any]:
    """Return every command of ours that runs something by its full name, 'design finger'; first, the program itself.

    Raises CallerError if a package of the listing is not installed: without it its tables would be lost.
    """
    for package in LISTED_BESIDE:
        if absent := absent_part("commands", package):
            raise absent
    root, others = typer.main.get_command(app), of_others("commands")
    return {"musclewire": root, **{name: command for name, command in leaves(root) if name not in others}}


def leaves(group: Any, before: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the commands below a group with their full names."""
    for name, command in group.commands.items():
        if hasattr(command, "commands"):
            yield from leaves(command, f"{before}{name} ")
        else:
            yield before + name, command.loaded()


@cache
def answer(*arguments: str) -> Any:
    """Return the document that a command prints with ``--json``."""
    printed = CliRunner().invoke(app, [*arguments, "--json"], prog_name="musclewire")
    assert printed.exit_code == 0, printed.output
    return json.loads(printed.stdout)


def command_table(name: str, command: Any) -> Listing:
    """Return the table of one command."""
    options = [one for one in command.params if one.param_type_name == "option"]
    return {
        "arguments": [argument_line(one) for one in command.params if one.param_type_name == "argument"],
        "options": [option_line(one) for one in options if "--help" not in one.opts],
        "json": json_keys(name),
    }


def argument_line(argument: Any) -> str:
    """Return one line about an argument."""
    return f"{argument.metavar or argument.name.upper()} {value_text(argument)}{default_text(argument)}"


def option_line(option: Any) -> str:
    """Return one line about an option."""
    return f"{' '.join([*option.opts, *option.secondary_opts])} {value_text(option)}{default_text(option)}"


def value_text(one: Any) -> str:
    """Return what an argument or an option takes: 'switch', 'quantity', or a Python type with its limits."""
    if getattr(one, "is_flag", False):
        return "switch"
    kind = one.type_descriptor.annotation
    name = str(kind) if hasattr(kind, "__args__") else kind.__name__
    text = "quantity" if one.metavar == "QUANTITY" else name.replace("pathlib.", "")
    limits = [f"{word} {limit}" for word, limit in (("from", one.min), ("to", one.max)) if limit is not None]
    return " ".join([text, *limits])


def default_text(one: Any) -> str:
    """Return how an argument or an option says that it has to be given, or what it is if it is not given."""
    if one.required:
        return ", required"
    return "" if one.default in (None, False, (), []) else f" = {one.default}"


def json_keys(name: str) -> list[str]:
    """Return the keys of what a command prints with ``--json``, those of objects in it with what leads to them."""
    if name == "musclewire":
        return sorted(answer("--version"))
    if OUTPUT + name.replace(" ", "-") not in answer("schema")["names"]:
        return []
    schema = answer("schema", OUTPUT + name.replace(" ", "-"))["schema"]
    return [key for key in keys_of_schema(schema) if not key.startswith(ANY_DOCUMENT.get(name, "\0"))]


def keys_of_schema(schema: Listing, before: str = "", kinds: Listing | None = None) -> Iterator[str]:
    """Yield the keys of a schema; objects by name that all have the same keys have them once, under "*"."""
    kinds = schema.get("$defs", {}) if kinds is None else kinds
    named: dict[str, list[Listing]] = {}
    among, by_any_name = [], []
    for kind in alternatives(schema, kinds):
        for name, one in kind.get("properties", {}).items():
            named.setdefault(name, []).append(one)
        among += [kind["items"]] if "items" in kind else []
        by_any_name += [kind["additionalProperties"]] if isinstance(kind.get("additionalProperties"), dict) else []
    below = {name: list(keys_of_schema({"anyOf": each}, "", kinds)) for name, each in named.items()}
    alike = len(named) > 2 and len({tuple(keys) for keys in below.values()}) == 1
    for name, keys in below.items():
        yield before + name
        yield from () if alike else keys_with(f"{before}{name}.", keys)
    if alike:
        yield from keys_with(f"{before}*.", next(iter(below.values())))
    if by_any_name:
        yield from keys_with(f"{before}*.", keys_of_schema({"anyOf": by_any_name}, "", kinds))
    if among:
        yield from keys_with(f"{before.removesuffix('.')}[].", keys_of_schema({"anyOf": among}, "", kinds))


def keys_with(before: str, keys: Iterable[str]) -> Iterator[str]:
    """Yield keys with what leads to them."""
    for key in keys:
        yield f"{before.removesuffix('.')}{key}" if key.startswith("[") else before + key


def alternatives(schema: Listing, kinds: Listing) -> Iterator[Listing]:
    """Yield the schemas of which a value has one."""
    if "$ref" in schema:
        yield from alternatives(kinds[schema["$ref"].rpartition("/")[2]], kinds)
    for one in (*schema.get("anyOf", ()), *schema.get("oneOf", ())):
        yield from alternatives(one, kinds)
    yield schema


def errors() -> list[Any]:
    """Return the errors of the package's own, each after the one it is a kind of."""
    found: list[Any] = [mw.MusclewireError]
    for one in found:
        found += [kind for kind in one.__subclasses__() if kind not in found and kind.__module__ == one.__module__]
    return found


def completed_names() -> dict[str, list[str]]:
    """Return what the Tab key lists, by kind; a kind that no command takes any more is left out."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            return {kind: found for kind, name in COMPLETED.items() if (found := completed(name))}
        finally:
            os.chdir(before)


def completed(name: str) -> list[str]:
    """Return what the Tab key lists for the first argument or option of a name that lists anything."""
    for command in commands().values():
        for one in command.params:
            if one.name == name or name in one.opts:
                context = command.make_context("musclewire", [], resilient_parsing=True)
                found = [item.value for item in one.shell_complete(context, "")]
                if found:
                    return [value for value in found if not value.startswith(OUTPUT)]
    return []


def suffixes(message: str) -> list[str]:
    """Return the suffixes that a message names."""
    return re.findall(r"(?<![\w/])\.[a-z]\w*", message)


def readable(known: Iterable[str]) -> list[str]:
    """Return the suffixes of recordings that are read, of those that are known and those that a message names."""
    refused = refusal(lambda path: mw.read_recording(path), "recording.unknown")
    tried = dict.fromkeys([*known, *suffixes(refused.partition("export it as")[2])])
    return [one for one in tried if "no such file" in refusal(lambda path: mw.read_recording(path), f"absent{one}")]


def writable(known: Iterable[str]) -> list[str]:
    """Return the suffixes of recordings that are written, of those that are known and those that a message names."""
    columns = {"time_s": [0.0, 0.05], "drive_voltage_v": [0.3, 0.3]}
    recording = mw.Recording(columns, {})  # type: ignore[arg-type]
    refused = refusal(recording.save, "recording.unknown")
    tried = dict.fromkeys([*known, *suffixes(refused.partition("end the name in")[2])])
    return [one for one in tried if refusal(recording.save, f"written{one}") == ""]


def refusal(act: Any, name: str) -> str:
    """Return how an act on a file of a name in an empty folder is refused, "" if it is done."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            act(Path(folder) / name)
        except mw.MusclewireError as error:
            return str(error).replace(folder, "")
    return ""


def text_of(found: Listing) -> str:
    """Return the listing as a TOML file."""
    lines = [HEAD, "[names]"]
    lines += [list_text(name, values) for name, values in found["names"].items()]
    for name, table in found["command"].items():
        lines += ["", f'[command."{name}"]' if " " in name else f"[command.{name}]"]
        lines += [list_text(key, values) for key, values in table.items()]
    return "\n".join(lines) + "\n"


def list_text(name: str, values: list[Any]) -> str:
    """Return a list of the file: one value in each line unless they are few."""
    written = [json.dumps(value, ensure_ascii=False) for value in values]
    line = f"{name} = [{', '.join(written)}]"
    if len(line) <= 100 and name not in ("options", "json"):
        return line
    return f"{name} = [\n" + "".join(f"  {value},\n" for value in written) + "]" if written else line


def main() -> None:
    """Print the listing, or write it."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("-w", "--write", action="store_true", help=f"write {LISTING.name}")
    text = text_of(listing(tomllib.loads(LISTING.read_text("utf-8"))))
    if parser.parse_args().write:
        LISTING.write_text(text, "utf-8")
    else:
        sys.stdout.write(text)


if __name__ == "__main__":
    main()
