"""The options of all commands are one list: a name means one thing."""

from __future__ import annotations

from typing import Any

from musclewire.app import OPTIONS, every_command


def kind_of(option: Any) -> tuple[Any, bool]:
    """What Python type an option becomes, a list of it if repeatable, and whether it is a switch without a value."""
    return option.type_descriptor.annotation, option.is_flag


USES = [
    option
    for command in every_command().values()
    for option in command.params
    if option.param_type_name == "option" and option.opts[0] != "--help"
]


def test_every_option_is_the_one_of_the_list() -> None:
    for use in USES:
        definition = OPTIONS[use.opts[0]]
        assert tuple(use.opts) == definition.names
        if use.opts[0] == "--output":  # says what this command writes
            assert use.help.split()[0] != "File", use.help
        else:
            assert use.help == definition.help
        assert (use.metavar == "QUANTITY") == (definition.quantity is not None)


def test_the_same_name_takes_the_same_kind_of_value_everywhere() -> None:
    kinds: dict[str, set[tuple[Any, bool]]] = {}
    for use in USES:
        kinds.setdefault(use.opts[0], set()).add(kind_of(use))
    assert {name: kind for name, kind in kinds.items() if len(kind) > 1} == {}


def test_times_lengths_and_all_other_quantities_have_a_unit() -> None:
    plain = {use.opts[0] for use in USES if kind_of(use)[0] is float}
    assert plain - {name for name, one in OPTIONS.items() if one.quantity} <= {"--friction", "--clock-speed"}  # ratios
