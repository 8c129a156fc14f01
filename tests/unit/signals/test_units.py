import re
from typing import Annotated

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from musclewire.errors import CallerError, RecordingError
from musclewire.signals import conversion_to_si, measured_in, measures, parse_quantity, scale_between

WHERE = "loop.csv: column 'Force'"


@pytest.mark.parametrize(
    ("unit", "column", "value", "expected"),
    [
        ("s", "time_s", 2.0, 2.0),
        ("ms", "time_s", 2.0, 0.002),
        ("min", "time_s", 2.0, 120.0),
        ("Sec", "time_s", 2.0, 2.0),
        ("µs", "time_s", 2.0, 2e-6),
        ("\u03bcs", "time_s", 2.0, 2e-6),
        ("mV", "wire_voltage_v", 5.0, 0.005),
        ("Volts", "wire_voltage_v", 5.0, 5.0),
        ("mA", "wire_current_a", 5.0, 0.005),
        ("Ohm", "wire_resistance_ohm", 5.0, 5.0),
        ("OHM", "wire_resistance_ohm", 5.0, 5.0),
        ("kOhm", "wire_resistance_ohm", 5.0, 5000.0),
        ("Kohm", "wire_resistance_ohm", 5.0, 5000.0),
        ("mOhm", "wire_resistance_ohm", 5.0, 0.005),
        ("\u2126", "wire_resistance_ohm", 5.0, 5.0),
        ("k\u03a9", "wire_resistance_ohm", 5.0, 5000.0),
        ("%", "reference_strain", 4.0, 0.04),
        ("pct", "reference_strain", 4.0, 0.04),
        ("mm/mm", "reference_strain", 4.0, 4.0),
        ("µε", "reference_strain", 4.0, 4e-6),
        ("-", "reference_strain", 4.0, 4.0),
        ("", "valid", 1.0, 1.0),
        ("mm", "displacement_m", 3.0, 0.003),
        ("gf", "force_n", 100.0, 0.980665),
        ("kgf", "force_n", 1.0, 9.80665),
        ("MPa", "stress_pa", 100.0, 1e8),
        ("Mpa", "stress_pa", 100.0, 1e8),
        ("N/mm²", "stress_pa", 100.0, 1e8),
        ("degC", "wire_temperature_k", 25.0, 298.15),
        ("°C", "wire_temperature_k", 25.0, 298.15),
        ("℃", "wire_temperature_k", 25.0, 298.15),
        ("deg C", "wire_temperature_k", 25.0, 298.15),
        ("C", "wire_temperature_k", 25.0, 298.15),
        ("Celsius", "wire_temperature_k", 25.0, 298.15),
        ("°F", "wire_temperature_k", 77.0, 298.15),
        ("K", "wire_temperature_k", 300.0, 300.0),
    ],
)
def test_a_unit_as_people_spell_it_becomes_si(unit, column, value, expected):
    assert conversion_to_si(unit, column, WHERE).apply([value]) == pytest.approx([expected], rel=1e-12)


def test_the_case_of_a_symbol_is_kept_because_it_is_worth_a_thousand_million():
    assert conversion_to_si("MV", "wire_voltage_v", WHERE).apply([1.0])[0] == pytest.approx(1e9 * 1e-3)


@pytest.mark.parametrize(
    ("unit", "column", "message"),
    [
        ("mm", "force_n", "mm is a length, force_n needs a force"),
        ("g", "force_n", "g is a mass (a force would be gf or kgf), force_n needs a force"),
        ("V", "reference_strain", "V is a voltage, reference_strain needs a dimensionless number"),
        ("deg", "reference_strain", "deg is an angle, reference_strain needs a dimensionless number"),
        ("degC", "force_n", "degC is a temperature, force_n needs a force"),
        ("Nn", "force_n", "unknown unit 'Nn'; did you mean 'N'?"),
    ],
)
def test_a_unit_of_something_else_is_refused_with_both_named(unit, column, message):
    with pytest.raises(RecordingError) as caught:
        conversion_to_si(unit, column, WHERE).apply([1.0])
    assert str(caught.value) == f"{WHERE}: {message}"


@pytest.mark.parametrize("unit", ["@@", "9**9**9**9", "mm)", "__import__", "2*mm", "s\ns", "m" * 300])
def test_what_is_no_unit_is_refused_in_one_line(unit):
    for column in ("force_n", "reference_strain"):
        with pytest.raises(RecordingError, match="unknown unit"):
            conversion_to_si(unit, column, WHERE).apply([1.0])
        assert not measures(unit, column)


def test_decibels_are_no_fraction_of_anything():
    with pytest.raises(RecordingError, match="unknown unit 'dB'"):
        conversion_to_si("dB", "reference_strain", WHERE).apply([1.0])


@given(st.text(max_size=12), st.sampled_from(["time_s", "force_n", "reference_strain", "wire_temperature_k"]))
def test_any_text_at_all_is_a_unit_or_a_recording_error(unit, column):
    try:
        values = conversion_to_si(unit, column, WHERE).apply([1.0])
    except RecordingError:
        return
    assert np.isfinite(values).all()


@given(st.floats(-200.0, 2000.0))
def test_a_degree_celsius_is_exactly_one_kelvin_wide(temperature_degc):
    kelvin = conversion_to_si("degC", "wire_temperature_k", WHERE).apply([temperature_degc])[0]
    assert kelvin == temperature_degc + 273.15


@pytest.mark.parametrize(
    ("text", "unit_si", "expected"),
    [
        ("588.6 N/m", "N/m", 588.6),
        ("0.10 mm", "m", 1e-4),
        (".5mm", "m", 5e-4),
        ("1e3 um", "m", 1e-3),
        ("5 %", "", 0.05),
        ("0.05", "", 0.05),
        ("-3 °C", "K", 270.15),
        ("1.0 Ohm", "ohm", 1.0),
    ],
)
def test_a_quantity_in_a_configuration_file_becomes_si(text, unit_si, expected):
    assert parse_quantity(text, unit_si) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("5", "'5' has no unit; write it with one, as '0.5 m'"),
        ("long", "is not a number with a unit"),
        ("5 V", "V is a voltage; a length is needed"),
        ("1e400 m", "is not a number with a unit"),
        ("5 kgff", "unknown unit 'kgff'; did you mean 'kgf'?"),
        ("1e300 m", "'1e300 m' is beyond what any bench has (1000 m): correct it or its unit"),
        ("-5 furlong", "is beyond what any bench has"),
    ],
)
def test_a_quantity_that_cannot_be_read_is_the_callers_error(text, message):
    with pytest.raises(CallerError, match=re.escape(message)):
        parse_quantity(text, "m")


@pytest.mark.parametrize(("unit", "most"), [("s", 1e8), ("N", 1e6), ("K", 1e9), ("", 1e9), ("N/m", 1e9)])
def test_a_number_of_a_file_is_bounded_like_its_text(unit: str, most: float) -> None:
    read = TypeAdapter(Annotated[float, measured_in(unit)]).validate_python
    for amount in (most, -most, f"{most} {unit}"):
        assert abs(read(amount)) == pytest.approx(most)
    for amount in (1.01 * most, -1e300, 10**30, f"{1.01 * most} {unit}"):
        with pytest.raises(ValidationError, match="beyond what any bench has"):
            read(amount)


@pytest.mark.parametrize(
    ("unit", "other", "scale"),
    [
        ("mV", "V", 1e-3),
        ("Volt DC", "V", 1.0),
        ("degC", "degC", 1.0),
        ("degC", "K", None),
        ("degF", "degC", None),
        ("V", "mm", None),
        ("no unit", "V", None),
    ],
)
def test_a_factor_between_units_is_none_where_no_factor_does(unit: str, other: str, scale: float | None) -> None:
    assert scale_between(unit, other) == (None if scale is None else pytest.approx(scale))
