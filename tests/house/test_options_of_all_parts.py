"""With every part there, the list of options has no option too many."""

from __future__ import annotations

from musclewire.app import OPTIONS, every_command


def test_no_option_is_defined_that_no_command_has() -> None:
    options = [option for command in every_command().values() for option in command.params]
    used = {option.opts[0] for option in options if option.param_type_name == "option"}
    assert set(OPTIONS) == used - {"--help"}
