"""The commands of the core and of all parts that are there, listed without importing any of them.

A function becomes a command here: options that belong together as one object.
``musclewire --help`` and a shell's completion read plain data: a name, a line of help, a panel. A command's module is
imported when the command is called.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import redirect_stderr
from dataclasses import MISSING, fields, is_dataclass, replace
from functools import partial
from io import StringIO
from typing import TYPE_CHECKING, Any, cast, get_type_hints

import typer
from typer.core import TyperCommand, TyperGroup

from musclewire.app._core_commands import COMMANDS, GROUPS, PANELS
from musclewire.app._options import BeyondCatalogue, Json, Offered
from musclewire.app._output import Result, run_command
from musclewire.errors import MusclewireError, RecordingError
from musclewire.manifest import Command, CommandGroup, absent_part, loaded, manifests, offered, require_packages_of

if TYPE_CHECKING:
    from musclewire.files import ImportMapping

# Commands with one of these parameters have a rig or a wire, whose numbers --beyond-catalogue confirms.
WITH_A_WIRE = {"rig", "wire", "study", "wire_file"}
BEYOND = "beyond_catalogue"


def flat(function: Callable[..., Result | None], called: str) -> Callable[..., None]:
    """Return the function as typer reads it: with its dataclasses' fields as parameters, and --json for a result."""
    signature = inspect.signature(function, eval_str=True)
    answers = signature.return_annotation is Result
    groups = {name: groups_of(one.annotation) for name, one in signature.parameters.items()}

    def run(**values: Any) -> None:
        given: dict[str, Any] = {}
        for name, one in signature.parameters.items():
            kinds = groups[name]
            filled = tuple(kind(**{name: values[name] for name in options_of(kind)}) for kind in kinds or ())
            given[name] = values[name] if kinds is None else filled[0] if is_dataclass(one.annotation) else filled
        rigs = values.get("rig") or ()
        for rig in [rigs] if isinstance(rigs, str) else rigs:
            require_packages_of(rig)
        if reading := given.get("reading"):
            given["reading"] = replace(reading, typed=typed(called, parameters, values, options_of(type(reading))))
        action = explain_refusals(function, values) if reading else function
        if not values.get(BEYOND, False):
            run_command(action, values.get("json", False), **given)
            return
        from musclewire.rigs import beyond_catalogue

        with beyond_catalogue(True):
            run_command(action, values.get("json", False), **given)

    run.__name__, run.__doc__, run.__module__ = function.__name__, function.__doc__, function.__module__
    parameters = [
        part
        for name, one in signature.parameters.items()
        for part in parameters_of(groups[name], keyword(name, one.annotation, one.default))
    ]
    if any(part.name in WITH_A_WIRE for part in parameters):
        parameters.append(keyword(BEYOND, BeyondCatalogue, False))
    if answers:
        parameters.append(keyword("json", Json, False))
    run.__signature__ = signature.replace(parameters=parameters, return_annotation=None)  # type: ignore[attr-defined]
    return run


def typed(
    called: str, parameters: Sequence[inspect.Parameter], values: Mapping[str, Any], without: Collection[str]
) -> tuple[str, ...]:
    """Return the words of a command but for some of its options; what has its default is left out."""
    arguments, options = ["musclewire", *called.split()], list[str]()
    for one in parameters:
        info, value = one.annotation.__metadata__[0], values[one.name]
        if value == one.default or one.name in without:
            continue
        given = value if isinstance(value, list) else [value]
        if isinstance(info, typer.models.OptionInfo):
            name = min(map(str, (info.default, *(info.param_decls or ()))), key=len)
            options += [word for item in given for word in ((name,) if item is True else (name, str(item)))]
        else:
            arguments += map(str, given)
    return (*arguments, *options)


def explain_refusals(function: Callable[..., Result | None], values: Mapping[str, Any]) -> Callable[..., Result | None]:
    """Return a command that says, before it refuses a recording, what it saw in it."""

    def action(**given: Any) -> Result | None:
        try:
            return function(**given)
        except RecordingError as problem:
            files = values.get("files")
            several = files or values.get("recordings")
            tried = None if several else partial(error_with_mapping, function=function, given=given)
            paths = [str(path) for path in several or [values["recording"]]]
            given["reading"].say_what_was_seen(paths, problem, tried, imports=several is files)
            raise

    return action


def error_with_mapping(
    proposal: ImportMapping, function: Callable[..., Result | None], given: Mapping[str, Any]
) -> MusclewireError | None:
    """Return what a command ends with if a recording is read as proposed; nothing is written or said."""
    figure = type(given["figure"])()
    unwritten = {"reading": replace(given["reading"], proposed=proposal), "figure": figure, "output": None}
    try:
        with redirect_stderr(StringIO()):
            result = function(**{**given, **unwritten})
    except MusclewireError as error:
        return error
    return None if result is None else result.error


def groups_of(annotation: Any) -> tuple[type[Any], ...] | None:
    """Return the dataclasses whose fields are options: one, or those that parts offer; None if it is a single value."""
    if is_dataclass(annotation):
        return (cast("type[Any]", annotation),)
    offers = [one for one in getattr(annotation, "__metadata__", ()) if isinstance(one, Offered)]
    return tuple(loaded(place) for place in offered(offers[0].kind).values()) if offers else None


def parameters_of(groups: tuple[type[Any], ...] | None, alone: inspect.Parameter) -> list[inspect.Parameter]:
    """Return a parameter for each field of dataclasses, or the one that stands alone."""
    if groups is None:
        return [alone]
    found = []
    for group in groups:
        # A parameter marks by another object than a field that it has no default.
        known = {field.name: field.default for field in fields(group) if field.default is not MISSING}
        found += [
            keyword(name, hint, known.get(name, inspect.Parameter.empty)) for name, hint in options_of(group).items()
        ]
    return found


def options_of(group: type[Any]) -> dict[str, Any]:
    """Return the annotations of a dataclass's fields that are options."""
    hints = get_type_hints(group, include_extras=True)
    return {name: hint for name, hint in hints.items() if hasattr(hint, "__metadata__")}


def keyword(name: str, annotation: Any, default: Any) -> inspect.Parameter:
    """Return a parameter that is given by name, so that defaults may come in any order."""
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


Listed = Command | CommandGroup


class ListedCommand(TyperCommand):
    """A command that is known by its name and its help alone until it is called."""

    def __init__(self, command: Command) -> None:
        """Take what the list says of it."""
        super().__init__(name=command.name, help=command.help, rich_help_panel=command.panel or None)
        self._command = command

    def loaded(self) -> Any:
        """Return the command with its options; its module is imported now."""
        alone = typer.Typer(add_completion=False)
        alone.command(self._command.name)(flat(loaded(self._command.function), self._command.name))
        found = typer.main.get_command(alone)
        found.rich_help_panel = self._command.panel or None  # type: ignore[attr-defined]
        return found

    def make_context(self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any) -> Any:
        """Return the context of the command itself, whose options the list does not know."""
        return self.loaded().make_context(info_name, args, parent=parent, **extra)


class ListedGroup(TyperGroup):
    """Commands of which some may belong to a part that is not there."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return a command by its name. Raises CallerError for a command whose part is not there."""
        absent = None if args[0] in self.commands else absent_part("commands", args[0])
        if absent is not None:
            raise absent
        return super().resolve_command(ctx, args)


class CommandLine(ListedGroup):
    """The root of the command line: what it is given itself, and every listed command."""

    def __init__(self, **attributes: Any) -> None:
        """List the commands."""
        super().__init__(**attributes)
        self.commands = dict(listed_commands())

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names in the order in which a reader meets them."""
        del ctx
        return list(self.commands)


def listed_commands() -> dict[str, Any]:
    """Return every command and group by name as the list knows it, in the order of the panels."""
    all_commands = [*COMMANDS, *(command for manifest in manifests() for command in manifest.commands)]
    all_groups = [*GROUPS, *(group for manifest in manifests() for group in manifest.groups)]
    members = {group.name: [each for each in all_commands if each.group == group.name] for group in all_groups}
    top: list[Listed] = [command for command in all_commands if not command.group]
    top += [group for group in all_groups if members[group.name]]
    found: dict[str, Any] = {}
    for one in in_order(top):
        found.setdefault(
            one.name, group_of(one, members[one.name]) if isinstance(one, CommandGroup) else ListedCommand(one)
        )
    return found


def group_of(group: CommandGroup, members: Sequence[Command]) -> ListedGroup:
    """Return a group with its commands."""
    return ListedGroup(
        name=group.name,
        help=group.help,
        no_args_is_help=True,
        rich_help_panel=group.panel or None,
        commands={member.name: ListedCommand(member) for member in members},
    )


def in_order(offers: Iterable[Listed]) -> list[Listed]:
    """Return commands and groups panel by panel, each before the one that it names or last of its panel."""
    ordered: list[Listed] = []
    for offer in offers:
        names = [one.name for one in ordered]
        ordered.insert(names.index(offer.before) if offer.before in names else len(ordered), offer)
    panels = [*PANELS, *(one.panel for one in ordered)]
    return sorted(ordered, key=lambda one: panels.index(one.panel))


def every_command() -> dict[str, Any]:
    """Return every command with its options by its words, as "export c", in the list's order; modules are imported."""
    found: dict[str, Any] = {}
    for name, listed in listed_commands().items():
        if isinstance(listed, TyperGroup):
            members: dict[str, Any] = dict(listed.commands)
            found |= {f"{name} {member}": command.loaded() for member, command in members.items()}
        else:
            found[name] = listed.loaded()
    return found
