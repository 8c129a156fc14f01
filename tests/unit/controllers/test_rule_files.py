"""A file of rules that is wrong is refused with the place and the right word."""

from __future__ import annotations

import pytest

from musclewire.controllers._rules import parse_rule_base
from musclewire.errors import CallerError

CONSTANT = """
name = "mine"
title = "t"
source = "s"
licence = "l"
[rules]
inference = "constant"
kp = 0.0
ki = 1.0
kd = 0.25
"""


DERIVED = 'name = "mine"\nderives_from = "{parent}"\n'
LIU_TABLE = '["ZO ZO ZO ZO ZO ZO ZO"' + ', "ZO ZO ZO ZO ZO ZO ZO"' * 6 + "]"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("licence =", "license =", "unknown key 'license'; did you mean 'licence'"),
        ("ki =", "kii =", "rules.*unknown key 'kii'; did you mean 'ki'"),
        ("kp = 0.0", "kp = 1.5", "rules.*kp.*less than or equal to 1"),
        ("[rules]", "[rules", "cannot be read"),
        ('name = "mine"', 'derives_from = "liu"', "unknown rule base 'liu'"),
    ],
)
def test_a_wrong_file_is_refused_in_one_line_that_names_the_place(old: str, new: str, message: str) -> None:
    with pytest.raises(CallerError, match=message) as raised:
        parse_rule_base(CONSTANT.replace(old, new), where="mine.toml")
    assert str(raised.value).startswith("mine.toml")
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (LIU_TABLE.replace('["ZO ZO', '["ZO'), r"kp: must be 7 rows of 7 cells, not 7 rows of \[6, 7\]"),
        (LIU_TABLE.replace('["ZO', '["ZE'), "kp.0.0"),
    ],
)
def test_a_table_that_is_not_seven_by_seven_set_names_is_refused(table: str, message: str) -> None:
    text = DERIVED.format(parent="liu-7x7") + f'[rules]\ninference = "min-max-centroid"\nkp = {table}\n'
    with pytest.raises(CallerError, match=message):
        parse_rule_base(text)


@pytest.mark.parametrize(
    ("sets", "message"),
    [
        ('NB = { shape = "triangle", points = [-1, 0] }', "a triangle needs 3 points, not 2"),
        ('NB = { shape = "z", points = [-3, -1] }', "input_sets lacks NM, NS, ZO, PS, PM, PB"),
    ],
)
def test_input_sets_are_checked(sets: str, message: str) -> None:
    text = DERIVED.format(parent="liu-7x7") + f"[input_sets]\n{sets}\n"
    with pytest.raises(CallerError, match=message):
        parse_rule_base(text)
