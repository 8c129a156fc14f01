"""The options of all commands are one list: a name means one thing."""

from __future__ import annotations

import re
from typing import Any

import pytest

from musclewire.app import OPTIONS, every_command


def kind_of(option: Any) -> tuple[Any, bool]:
    """What Python type an option becomes, a list of it if repeatable, and whether it is a switch without a value."""
    return option.type_descriptor.annotation, option.is_flag


COMMANDS = {
    name: [one for one in command.params if one.param_type_name == "option" and one.opts[0] != "--help"]
    for name, command in every_command().items()
}
# A package beside ours may bring a command, which is judged where developers' packages are: README's tests do without.
EACH = [
    pytest.param(name, marks=() if command.callback.__module__.startswith("musclewire.") else pytest.mark.slow)
    for name, command in every_command().items()
    if command.callback is not None
]
USES = [option for options in COMMANDS.values() for option in options]
# A help may name the options of another command as that command's.
OF_ANOTHER = re.compile(r"'musclewire [^']*'")
NAMED = re.compile(r"(?<![\w-])--[a-z][a-z-]+")


def test_every_option_is_one_of_the_list() -> None:
    for use in USES:
        definition = OPTIONS[use.opts[0]]
        assert tuple(use.opts) == definition.names
        assert (use.metavar == "QUANTITY") == (definition.quantity is not None)


def test_what_all_of_its_commands_say_otherwise_is_not_in_the_list() -> None:
    said = {use.help for use in USES} | {OPTIONS["--output"].help}
    here = {use.opts[0] for use in USES}  # a package that is not installed may bring the others' commands
    assert [name for name in OPTIONS if name in here and OPTIONS[name].help not in said] == []


@pytest.mark.parametrize("command", EACH)
def test_a_help_names_options_of_its_own_command(command: str) -> None:
    own = {name for option in COMMANDS[command] for name in option.opts}
    named = {name for option in COMMANDS[command] for name in NAMED.findall(OF_ANOTHER.sub("", option.help))}
    assert named <= own


@pytest.mark.parametrize("command", EACH)
def test_a_default_that_a_help_names_is_no_other_than_the_commands_own(command: str) -> None:
    own = {option.opts[0]: option.default for option in COMMANDS[command] if "Default:" in option.help}
    assert {name: default for name, default in own.items() if default is not None} == {}


def test_the_same_name_takes_the_same_kind_of_value_everywhere() -> None:
    kinds: dict[str, set[tuple[Any, bool]]] = {}
    for use in USES:
        kinds.setdefault(use.opts[0], set()).add(kind_of(use))
    assert {name: kind for name, kind in kinds.items() if len(kind) > 1} == {}


def test_times_lengths_and_all_other_quantities_have_a_unit() -> None:
    plain = {use.opts[0] for use in USES if kind_of(use)[0] is float}
    assert plain - {name for name, one in OPTIONS.items() if one.quantity} <= {"--friction", "--clock-speed"}  # ratios
