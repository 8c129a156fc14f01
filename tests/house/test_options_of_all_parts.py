"""With every part there, the list of options has no option too many, and old names lead to options of the list."""

from __future__ import annotations

from musclewire.app import OLD_NAMES, OPTIONS, every_command


def test_no_option_is_defined_that_no_command_has() -> None:
    options = [option for command in every_command().values() for option in command.params]
    used = {option.opts[0] for option in options if option.param_type_name == "option"}
    assert set(OPTIONS) == used - {"--help"}


def test_old_names_lead_to_names_of_the_list_and_are_no_names_of_it() -> None:
    for old, names in OLD_NAMES.items():
        assert set(names) <= set(OPTIONS), old
    # --stiffness is the wanted one of a part to design; where it was the known one, it still reads.
    assert set(OLD_NAMES) & set(OPTIONS) == {"--stiffness"} & set(OPTIONS)
