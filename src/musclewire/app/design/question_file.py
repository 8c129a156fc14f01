"""The question file of a design command: its options in a TOML file, by the names they have on the command line.

stiffness = "1084.4 N/m"
endpoint = "6 mm"
wire = "paper-100um"
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import typer

from musclewire.errors import CallerError, nearest_hint

__all__ = ["QUESTION", "given_options"]

# Where results go is said on the command line: a question can be asked twice.
NOT_IN_A_FILE = {"question", "output", "drawing", "plot", "list_materials", "json"}


def read_question(context: typer.Context, path: Path | None) -> Path | None:
    """Take the values of a question file as defaults of the options; what the command line gives takes precedence.

    Raises CallerError naming file and key.
    """
    if path is None:
        return None
    from musclewire.parameters.toml_file import read_toml

    table = read_toml(path, "question file")
    known = {str(param.name): param for param in context.command.params if param.name not in NOT_IN_A_FILE}
    for key, value in table.items():
        if key not in known:
            raise CallerError(f"question file {path}: unknown key '{key}'{nearest_hint(key, known)}")
        if isinstance(value, (dict, list)):
            raise CallerError(f"question file {path}: '{key}' must be one value")
    context.default_map = {key: found_next_to(value, path) for key, value in table.items()}
    return path


def found_next_to(value: Any, path: Path) -> Any:
    """Return a value; the name of a file that lies next to the question file becomes its path."""
    neighbour = path.parent / value if isinstance(value, str) and value.endswith(".toml") else None
    return str(neighbour) if neighbour is not None and neighbour.exists() else value


def given_options(context: typer.Context) -> list[str]:
    """Return the names of the options that the command line or a question file gave."""
    sources = {name: context.get_parameter_source(name) for name in context.params}
    return [
        name for name, source in sources.items() if source is not None and source.name in {"COMMANDLINE", "DEFAULT_MAP"}
    ]


QUESTION = typer.Argument(
    metavar="[QUESTION]",
    help="TOML file with options by their names, as stiffness = '1084.4 N/m'; the command line takes precedence.",
    is_eager=True,
    callback=read_question,
)
