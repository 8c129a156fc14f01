"""A mistake in a parameter file is one line that says where it is and what would be right."""

from __future__ import annotations

import copy
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.parameters import Alloy, Bench, Wire, validated
from musclewire.parameters._library import read_named

# What a file may leave out, and what that means: docs/reference/files.md.
OPTIONAL = {"early_fraction": 0.0, "early_width": 1.0}
FILES = [(Wire, "wire", "paper-100um"), (Alloy, "alloy", "flexinol"), (Bench, "bench", "paper")]


def complaint(model: type, data: Any) -> str:
    with pytest.raises(CallerError) as caught:
        validated(model, data, "wire mine")
    message = str(caught.value)
    assert message.startswith("wire mine: ")
    return message


@pytest.fixture
def wire() -> dict[str, Any]:
    return copy.deepcopy(read_named("wire", "paper-100um"))


@pytest.mark.parametrize(("model", "kind", "name"), FILES)
def test_a_file_as_it_comes_is_accepted(model: type, kind: str, name: str) -> None:
    assert validated(model, read_named(kind, name), name).name == name


@pytest.mark.parametrize(("model", "kind", "name"), FILES)
def test_a_superfluous_key_is_named_with_the_nearest_right_one(model: type, kind: str, name: str) -> None:
    data = copy.deepcopy(read_named(kind, name))
    right = next(key for key, value in data.items() if isinstance(value, dict))
    data[right[:-1]] = data[right]
    assert complaint(model, data).endswith(f"unknown key '{right[:-1]}'; did you mean '{right}'?")


def test_a_misspelt_key_is_named_with_the_right_one_at_the_top_and_inside_a_value(wire: dict[str, Any]) -> None:
    """Here the right key is missing as well; what the user must see is what he wrote."""
    wire["diametre_m"] = wire.pop("diameter_m")
    assert "'diametre_m'; did you mean 'diameter_m'" in complaint(Wire, wire)
    wire["diameter_m"] = wire.pop("diametre_m")
    wire["diameter_m"]["sorce"] = wire["diameter_m"].pop("source")
    assert "'diameter_m.sorce'; did you mean 'source'" in complaint(Wire, wire)


@pytest.mark.parametrize(("model", "kind", "name"), FILES)
def test_a_missing_key_is_named(model: type, kind: str, name: str) -> None:
    for key in read_named(kind, name):
        data = copy.deepcopy(read_named(kind, name))
        del data[key]
        if key == "validity":  # an alloy of which nothing states what its data cover
            assert validated(Alloy, data, name).validity is None
        elif key in OPTIONAL:
            assert getattr(validated(model, data, name), key).value == OPTIONAL[key]
        else:
            assert complaint(model, data).endswith(f"the key '{key}' is missing")


@pytest.mark.parametrize("part", ["value", "unit", "kind", "source"])
def test_a_number_without_all_its_parts_is_refused(wire: dict[str, Any], part: str) -> None:
    del wire["diameter_m"][part]
    assert complaint(Wire, wire).endswith(f"the key 'diameter_m.{part}' is missing")


def test_a_bare_number_is_refused(wire: dict[str, Any]) -> None:
    wire["diameter_m"] = 100e-6
    assert complaint(Wire, wire).endswith(
        "diameter_m: must be a table with the keys value, unit, kind, source, note, not 0.0001"
    )


@pytest.mark.parametrize(
    ("part", "given", "words"),
    [
        ("value", "thick", "must be a number, not 'thick'"),
        ("value", float("nan"), "must be a finite number, not nan"),
        ("value", 1e300, "must be 1e+15 or less, not 1e+300"),
        ("value", [1.0], "must be a number, not a list"),
        ("unit", 3, "must be text in quotes, not 3"),
        ("source", "", "must be text of at least 3 characters, not ''"),
        ("kind", "guessed", "must be 'measured', 'datasheet', 'fitted', 'derived' or 'assumed', not 'guessed'"),
    ],
)
def test_what_is_wrong_with_a_value_is_said_in_plain_words(
    wire: dict[str, Any], part: str, given: object, words: str
) -> None:
    wire["diameter_m"][part] = given
    assert f"diameter_m.{part}: {words}" in complaint(Wire, wire)


def test_a_wrong_unit_is_answered_with_the_right_one(wire: dict[str, Any]) -> None:
    wire["diameter_m"]["unit"] = "mm"
    assert complaint(Wire, wire).endswith("diameter_m has the unit 'mm', it must be given in 'm'")


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.text(max_size=4), inner, max_size=2),
    max_leaves=4,
)


@settings(deadline=None, max_examples=150)
@given(key=st.sampled_from([*Wire.model_fields, "other"]), part=st.sampled_from(["", "value", "kind"]), value=VALUES)
def test_any_value_anywhere_is_accepted_or_one_line(key: str, part: str, value: Any) -> None:
    data = copy.deepcopy(read_named("wire", "paper-100um"))
    if part and isinstance(data.get(key), dict):
        data[key][part] = value
    else:
        data[key] = value
    message = ""
    try:
        validated(Wire, data, "wire mine")
    except CallerError as error:
        message = str(error)
    assert "Input should" not in message


def test_a_parameter_cannot_be_changed_afterwards() -> None:
    group = validated(Wire, read_named("wire", "paper-100um"), "wire")
    with pytest.raises(ValueError, match="frozen"):
        group.name = "other"


@pytest.mark.parametrize("value", [-0.1, 1.0])
def test_a_fraction_that_is_none_is_named_with_its_range(value: float) -> None:
    data = copy.deepcopy(read_named("alloy", "flexinol"))
    data["early_fraction"]["value"] = value
    assert complaint(Alloy, data).endswith(f"early_fraction is {value:g}, it must be 0 or more and below 1")
