"""How a function becomes a command: options that belong together as one object, and options by their old names."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any, get_type_hints

import typer
from typer.core import TyperCommand

from musclewire.app._options import Json, renamed
from musclewire.app._output import Result, run_command


class CommandWithOldNames(TyperCommand):
    """A command that also takes its options by the names they had before (``options.OLD_NAMES``)."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Take the arguments; after "--" there are no options."""
        known = {name for param in self.params for name in (*param.opts, *param.secondary_opts)}
        end = args.index("--") if "--" in args else len(args)
        return super().parse_args(ctx, [*(renamed(argument, known) for argument in args[:end]), *args[end:]])


def add_command(app: typer.Typer, function: Callable[..., Result | None], name: str | None = None) -> None:
    """Add a function as a command. A parameter that is a dataclass becomes one option for each of its fields."""
    app.command(name, cls=CommandWithOldNames)(flat(function))


def flat(function: Callable[..., Result | None]) -> Callable[..., None]:
    """Return the function with the fields of its dataclasses as parameters of their own, as typer reads them.

    One that returns its result has the option --json, too, and the result is printed here.
    """
    signature = inspect.signature(function, eval_str=True)
    answers = signature.return_annotation is Result
    groups: dict[str, Any] = {
        name: one.annotation for name, one in signature.parameters.items() if is_dataclass(one.annotation)
    }

    def run(**values: Any) -> None:
        given = {
            name: groups[name](**{field.name: values[field.name] for field in fields(groups[name])})
            if name in groups
            else values[name]
            for name in signature.parameters
        }
        run_command(function, values.get("json", False), **given)

    run.__name__, run.__doc__, run.__module__ = function.__name__, function.__doc__, function.__module__
    parameters = [
        part
        for name, one in signature.parameters.items()
        for part in (parameters_of(groups[name]) if name in groups else [keyword(name, one.annotation, one.default)])
    ]
    if answers:
        parameters.append(keyword("json", Json, False))
    run.__signature__ = signature.replace(parameters=parameters, return_annotation=None)  # type: ignore[attr-defined]
    return run


def parameters_of(group: type[Any]) -> list[inspect.Parameter]:
    """Return a parameter for each field of a dataclass."""
    hints = get_type_hints(group, include_extras=True)
    return [keyword(field.name, hints[field.name], default_of(field)) for field in fields(group)]


def default_of(field: Field[Any]) -> Any:
    """Return the default of a field, as a parameter would have it."""
    return inspect.Parameter.empty if field.default is MISSING else field.default


def keyword(name: str, annotation: Any, default: Any) -> inspect.Parameter:
    """Return a parameter that is given by name, so that defaults may come in any order."""
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
