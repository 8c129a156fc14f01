"""The check of docstrings finds what a caller would miss: an argument, a unit, a return value, an error."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from checks.public_docstrings import Public, problems_of, public_objects, resolved, unit_of

from musclewire.errors import CallerError


def complete(voltage_v: float, folder: str) -> float | None:
    """Return half of a voltage.

    Parameters
    ----------
    voltage_v
        The voltage [V].
    folder
        Where nothing is written.

    Returns
    -------
    The half [V].

    Raises
    ------
    CallerError
        If the voltage is negative.
    """
    if voltage_v < 0.0:
        raise CallerError(folder)
    return voltage_v / 2.0


def undescribed(voltage_v: float) -> float:
    """Return half of a voltage."""
    return voltage_v / 2.0


def without_unit(voltage_v: float) -> None:
    """Take a voltage.

    Parameters
    ----------
    voltage_v
        The voltage.
    """


def typed(name: str) -> None:
    """Take a name.

    Parameters
    ----------
    name : str
        The name.
    """


def renamed(name: str) -> None:
    """Take a name.

    Parameters
    ----------
    title
        The name.
    """


def swapped(first: int, second: int) -> None:
    """Take two numbers.

    Parameters
    ----------
    second
        The second.
    first
        The first.
    """


def silent_about_errors() -> None:
    """Raise."""
    raise CallerError("always")


def half_v() -> float:
    """Return half a volt.

    Returns
    -------
    The voltage.
    """
    return 0.5


def of_two_lines() -> None:
    """Do what takes
    two lines to say.
    """


FOUND = [
    (undescribed, ["parameter 'voltage_v' is not described", "no Returns"]),
    (without_unit, ["parameter 'voltage_v' does not state the unit [V]"]),
    (typed, ["parameter 'name' repeats a type ('str'): it is in the annotation"]),
    (renamed, ["parameter 'name' is not described", "there is no parameter 'title'"]),
    (swapped, ["parameters are in another order than in the signature"]),
    (silent_about_errors, ["does not say when it raises CallerError"]),
    (half_v, ["Returns does not state the unit [V]"]),
]


@pytest.mark.parametrize(("function", "expected"), FOUND, ids=lambda item: getattr(item, "__name__", ""))
def test_what_is_missing_is_named(function: Callable[..., Any], expected: list[str]) -> None:
    assert problems_of(Public(f"tests.{function.__name__}", function, "a test")) == expected


def test_a_complete_docstring_has_no_problem() -> None:
    assert problems_of(Public("tests.complete", complete, "a test")) == []


def test_a_summary_of_two_lines_is_found() -> None:
    assert problems_of(Public("tests.of_two_lines", of_two_lines, "a test")) != []


def test_units_are_those_of_the_longest_suffix() -> None:
    assert [unit_of(name) for name in ("drive_voltage_v", "stiffness_n_per_m", "order", "period_s")] == [
        "V", "N/m", None, "s",
    ]  # fmt: skip


def test_what_pages_name_is_found_and_keys_are_not() -> None:
    assert resolved("mw.fit") is resolved("musclewire.fit")
    assert resolved("Recording.save") is not None
    assert resolved("numpy.array") is None
    assert resolved("fit") is None  # the command
    assert resolved("shunt_resistance_ohm") is None  # a key


def test_a_name_after_its_room_or_file_is_found_and_a_field_leads_to_its_class() -> None:
    assert resolved("identify:fit") is resolved("mw.fit")
    assert resolved("sensing:SensingModel.plot") is resolved("SensingModel.plot")
    assert resolved("parameters:Alloy.r_phase_strain") is resolved("musclewire.parameters._parameter_groups.Alloy")
    assert resolved("wire._state:WireState.grains") is resolved("musclewire.wire._state.WireState")
    assert resolved("parameters:Alloy.r_phase_strain") is not None
    assert resolved("wire._state:WireState.grains") is not None
    assert resolved("sensing:Nothing") is None


def test_methods_of_public_classes_and_of_protocols_are_public() -> None:
    names = public_objects()
    assert {"musclewire.signals._recording.Recording.save", "musclewire.rigs._protocol.Rig.exchange"} <= set(names)
    assert "musclewire.physics._heat.nusselt_churchill_chu" in names


def test_a_name_that_only_rooms_use_may_have_a_summary_alone_and_its_sections_are_complete() -> None:
    assert problems_of(Public("tests.undescribed", undescribed, "a test", for_rooms=True)) == []
    assert problems_of(Public("tests.renamed", renamed, "a test", for_rooms=True)) == [
        "parameter 'name' is not described",
        "there is no parameter 'title'",
    ]


def test_what_is_promised_or_on_a_page_is_judged_as_such_although_a_room_lists_it() -> None:
    names = public_objects()
    assert not names["musclewire.identify._sensing_model.fit"].for_rooms
    assert not names["musclewire.wire._constants.WireConstants"].for_rooms  # on the page on the row
    assert names["musclewire.wire._balance.loss_w"].for_rooms


def test_every_public_docstring_is_complete() -> None:
    assert {name: found for name, one in public_objects().items() if (found := problems_of(one))} == {}
