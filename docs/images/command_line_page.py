"""The page reference/command_line of the site: what is written by hand, and arguments, options and keys from the code.

docs/reference/command_line.md says what ``--help`` does not: what keys of ``--json`` mean, when a command ends with
which code. A command that it says nothing of has its section all the same.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from key_tables import line

from musclewire.app import every_command, json_schema, schema_names

BY_HAND = Path(__file__).resolve().parents[1] / "reference" / "command_line.md"
COMMAND = re.compile(r"^## `musclewire (\w+(?: \w+)?)`\n", re.M)


def page() -> str:
    """Return the whole page. Raises ValueError if a section is about no command."""
    before, *rest = COMMAND.split(BY_HAND.read_text("utf-8"))
    said = dict(zip(rest[::2], rest[1::2], strict=True))
    commands = every_command()
    if wrong := set(said) - set(commands):
        raise ValueError(f"{BY_HAND.name} is about commands that do not exist: {', '.join(sorted(wrong))}")
    return before + "\n".join(about(name, command, said.get(name, "")) for name, command in commands.items())


def about(name: str, command: Any, said: str) -> str:
    """Return the section of a command: how it is typed, arguments, options, keys, and what is said by hand."""
    arguments = [one for one in command.params if one.param_type_name == "argument"]
    keys = ", ".join(f"`{key}`" for key in json_keys(name))
    parts = [
        f"`{' '.join([f'musclewire {name}', *map(typed, arguments)])}`: {with_code(command.help.strip())}",
        "\n".join(f"- `{typed(one)}`: {with_code(one.help)}" for one in arguments),
        "\n".join(option_lines(command)),
        f"JSON keys: {keys}" if keys else "",
        said.strip("\n"),
    ]
    return f"## `musclewire {name}`\n\n" + "\n\n".join(part for part in parts if part) + "\n"


def typed(argument: Any) -> str:
    """Return an argument as ``--help`` shows it: in brackets if it may be left out."""
    name = str(argument.metavar or argument.name.upper()) + ("..." if argument.nargs == -1 else "")
    return name if argument.required or name.startswith("[") else f"[{name}]"


def option_lines(command: Any) -> Iterator[str]:
    """Yield the table of a command's options."""
    yield from (line(["Option", "Default", "Meaning"]), "|---|---|---|")
    for one in command.params:
        if one.param_type_name == "option" and "--help" not in one.opts:
            names = ", ".join(f"`{name}`" for name in (*one.opts, *one.secondary_opts))
            default = "required" if one.required else "" if one.default in (None, False, ()) else f"`{one.default}`"
            yield line([names, default, with_code(one.help)])


def with_code(text: str) -> str:
    """Return a help text with the options that it names as code, so that Markdown leaves their dashes as they are."""
    return re.sub(r"(?<![\w-])--[\w-]+", r"`\g<0>`", text)


def json_keys(name: str) -> list[str]:
    """Return the first keys of what a command prints with ``--json``, of all documents that it may print."""
    schema_name = f"output-{name.replace(' ', '-')}"
    if schema_name not in schema_names():
        return []
    schema = json_schema(schema_name)
    named = [one["$ref"].rpartition("/")[2] for one in schema.get("anyOf", ())]
    documents = [schema["$defs"][kind] for kind in named] or [schema]
    return list(dict.fromkeys(key for document in documents for key in document["properties"]))
