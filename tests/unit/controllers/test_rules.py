"""The rule files say what the literature says, and a wrong file is refused with the right word."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.controllers import SET_NAMES, MamdaniRules, ZhaoRules, load_rule_base, rule_base_names
from musclewire.errors import CallerError


def zhao_rules() -> ZhaoRules:
    rules = load_rule_base("zhao-1993").rules
    assert isinstance(rules, ZhaoRules)
    return rules


def liu_rules() -> MamdaniRules:
    rules = load_rule_base("liu-7x7").rules
    assert isinstance(rules, MamdaniRules)
    return rules


def cell(table: tuple[tuple[object, ...], ...], error: str, change: str) -> object:
    return table[SET_NAMES.index(error)][SET_NAMES.index(change)]


def test_the_default_comes_first_and_every_listed_rule_base_loads_with_a_source() -> None:
    assert rule_base_names() == ("zhao-1993", "fixed", "liu-7x7", "liu-7x7-mirrored")
    for name in rule_base_names():
        rule_base = load_rule_base(name)
        assert rule_base.name == name
        assert rule_base.source
        assert rule_base.licence
        assert rule_base.notes
        assert name in str(rule_base)


@pytest.mark.parametrize(
    ("table", "error", "change", "published"),
    [
        ("kp", "NB", "ZO", "B"),
        ("kp", "NM", "NB", "S"),
        ("kp", "NS", "NM", "S"),
        ("kp", "ZO", "ZO", "B"),
        ("kp", "ZO", "PS", "S"),
        ("kp", "PM", "PB", "S"),
        ("kd", "NB", "ZO", "S"),
        ("kd", "NM", "NM", "B"),
        ("kd", "NM", "NS", "S"),
        ("kd", "ZO", "PB", "B"),
        ("kd", "PS", "ZO", "S"),
        ("alpha", "NB", "PB", 2.0),
        ("alpha", "NM", "NM", 3.0),
        ("alpha", "NS", "NB", 4.0),
        ("alpha", "ZO", "NB", 5.0),
        ("alpha", "ZO", "ZO", 3.0),
        ("alpha", "PS", "PB", 4.0),
    ],
)
def test_zhao_cells_equal_the_published(table: str, error: str, change: str, published: object) -> None:
    assert cell(getattr(zhao_rules(), table), error, change) == published


def test_zhao_counts_equal_the_published_and_every_table_is_symmetric() -> None:
    rules = zhao_rules()
    kp, kd = (np.array(table) == "B" for table in (rules.kp, rules.kd))
    alpha = np.array(rules.alpha)
    assert [int(row.sum()) for row in kp] == [7, 5, 3, 1, 3, 5, 7]
    assert [int(row.sum()) for row in kd] == [0, 4, 6, 7, 6, 4, 0]
    assert [int((alpha == value).sum()) for value in (2.0, 3.0, 4.0, 5.0)] == [22, 19, 6, 2]
    for table in (kp, kd, alpha):
        assert (table == table[::-1, ::-1]).all()
        assert (table == table[:, ::-1]).all()


@pytest.mark.parametrize(
    ("table", "error", "change", "published"),
    [
        ("kp", "NB", "NB", "PB"),
        ("kp", "NB", "PB", "ZO"),
        ("kp", "NM", "PS", "PS"),
        ("kp", "ZO", "ZO", "ZO"),
        ("kp", "PM", "NB", "PS"),
        ("kp", "PB", "PS", "NM"),
        ("kp", "PB", "PB", "NB"),
        ("ki", "NB", "NB", "NB"),
        ("ki", "NS", "NM", "NM"),
        ("ki", "ZO", "PM", "PM"),
        ("ki", "PS", "PB", "PB"),
        ("ki", "PB", "NB", "ZO"),
        ("kd", "NB", "NB", "PS"),
        ("kd", "NB", "ZO", "NB"),
        ("kd", "NM", "PB", "ZO"),
        ("kd", "PS", "NS", "ZO"),
        ("kd", "PM", "NM", "PS"),
        ("kd", "PB", "NM", "PM"),
    ],
)
def test_liu_cells_equal_the_published(table: str, error: str, change: str, published: str) -> None:
    assert cell(getattr(liu_rules(), table), error, change) == published


@pytest.mark.parametrize(
    ("table", "counts"),
    [
        ("kp", [3, 10, 7, 9, 8, 8, 4]),
        ("ki", [5, 7, 7, 11, 8, 6, 5]),
        ("kd", [4, 5, 11, 12, 10, 3, 4]),
    ],
)
def test_liu_label_counts_equal_those_of_the_published_matlab_listing(table: str, counts: list[int]) -> None:
    labels = np.array(getattr(liu_rules(), table))
    assert [int((labels == name).sum()) for name in SET_NAMES] == counts


def test_liu_kp_and_ki_are_antisymmetric_in_all_but_a_few_cells_and_never_far_from_it() -> None:
    for table, exceptions in ((liu_rules().kp, 8), (liu_rules().ki, 2)):
        index = np.array([[SET_NAMES.index(name) - 3 for name in row] for row in table])
        residue = index + index[::-1, ::-1]
        assert np.count_nonzero(residue) == exceptions
        assert np.abs(residue).max() == 1


def test_a_rule_base_that_is_not_there_is_named() -> None:
    with pytest.raises(CallerError, match="did you mean 'zhao-1993'"):
        load_rule_base("zhao1993")
    with pytest.raises(CallerError, match=r"there is no rule base /nowhere/mine\.toml"):
        load_rule_base("/nowhere/mine.toml")
