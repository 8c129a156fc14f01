import pytest

from musclewire.errors import CallerError
from musclewire.signals._columns import BRANCH_TABLE, COLUMNS, columns_called, key_of_header, known_column


def test_every_column_is_registered_under_its_own_name_and_says_what_it_is():
    assert all(name == column.name and column.description for name, column in COLUMNS.items())


def test_the_last_part_of_a_name_is_its_unit():
    same = {"s": "s", "v": "V", "a": "A", "ohm": "ohm", "m": "m", "n": "N"}
    suffixes = {**same, "pa": "Pa", "k": "K", "w": "W", "j": "J"}
    for name, column in COLUMNS.items():
        assert column.unit == suffixes.get(name.rpartition("_")[2], ""), name


def test_the_columns_of_a_printed_loop_are_of_kind_table():
    assert {name for name, column in COLUMNS.items() if column.kind == "table"} == set(BRANCH_TABLE)


@pytest.mark.parametrize(
    ("header", "name"),
    [
        ("t", "time_s"),
        ("Time", "time_s"),
        ("V_SMA", "wire_voltage_v"),
        ("vsma", "wire_voltage_v"),
        ("V_R", "shunt_voltage_v"),
        ("v shunt", "shunt_voltage_v"),
        ("Current", "wire_current_a"),
        ("I", "wire_current_a"),
        ("DISP", "displacement_m"),
        ("lvdt", "displacement_m"),
        ("Load", "force_n"),
        ("strain", "reference_strain"),
        ("ε", "reference_strain"),
        ("temperature", "wire_temperature_k"),
    ],
)
def test_a_foreign_name_is_recognised_whatever_its_case_and_spacing(header, name):
    assert columns_called(header)[0].name == name


def test_a_name_with_two_meanings_offers_both():
    assert [column.name for column in columns_called("T")] == ["time_s", "wire_temperature_k"]


def test_a_name_nobody_uses_is_no_column():
    assert columns_called("humidity") == ()


def test_case_spaces_and_punctuation_do_not_count_when_headers_are_compared():
    assert key_of_header(" V_SMA-1 ") == key_of_header("vsma 1")


def test_an_unknown_column_is_answered_with_the_nearest():
    with pytest.raises(CallerError, match=r"unknown column 'wire_voltage'; did you mean 'wire_voltage_v'"):
        known_column("wire_voltage")
