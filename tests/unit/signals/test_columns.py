import pytest

from musclewire.errors import CallerError
from musclewire.signals import COLUMNS, known_column


def test_every_column_is_registered_under_its_own_name_and_says_what_it_is():
    assert all(name == column.name and column.description for name, column in COLUMNS.items())


def test_the_last_part_of_a_name_is_its_unit():
    same = {"s": "s", "v": "V", "a": "A", "ohm": "ohm", "m": "m", "n": "N"}
    suffixes = {**same, "pa": "Pa", "k": "K", "w": "W", "j": "J"}
    for name, column in COLUMNS.items():
        assert column.unit == suffixes.get(name.rpartition("_")[2], ""), name


def test_an_unknown_column_is_answered_with_the_nearest():
    with pytest.raises(CallerError, match=r"unknown column 'wire_voltage'; did you mean 'wire_voltage_v'"):
        known_column("wire_voltage")
