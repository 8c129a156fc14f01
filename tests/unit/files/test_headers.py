import numpy as np
import pytest

from musclewire.errors import CallerError, RecordingError
from musclewire.files import ImportMapping, SourceColumn, TableInMemory, split_header
from musclewire.files._headers import match_columns
from musclewire.files._importing import plan_import


def understand_headers(headers, mapping, path):
    """Return what is taken and ignored of headers. Raises the first RecordingError that is left undecided."""
    columns = tuple(SourceColumn(header) for header in headers)
    table = TableInMemory(path, "", columns, tuple(0.1 * np.arange(3.0) for _ in headers))
    match = plan_import(table, ImportMapping(mapping or {})).match
    if match.undecided:
        raise RecordingError(match.undecided[0].message)
    return match.taken, match.ignored


def taken_as(headers, mapping=None):
    taken, _ = understand_headers(headers, mapping, "loop.csv")
    return {item.column: (item.header, item.factor) for item in taken}


def refusal(headers, mapping=None):
    with pytest.raises(RecordingError) as caught:
        understand_headers(headers, mapping, "loop.csv")
    return str(caught.value)


@pytest.mark.parametrize(
    ("header", "parts"),
    [
        ("Force [N]", ("Force", "N")),
        ("Force(N)", ("Force", "N")),
        ("Temp (deg C)", ("Temp", "deg C")),
        ("Voltage (wire) [mV]", ("Voltage (wire)", "mV")),
        ("Force / N", ("Force", "N")),
        ("F/kN", ("F", "kN")),
        ("strain []", ("strain", "")),
        (" Force ", ("Force", None)),
    ],
)
def test_a_header_is_split_into_name_and_unit(header, parts):
    assert split_header(header) == parts


def test_our_own_names_carry_their_unit():
    assert taken_as(["time_s", "Wire_Voltage_V", "reference_strain"]) == {
        "time_s": ("time_s", 1.0),
        "wire_voltage_v": ("Wire_Voltage_V", 1.0),
        "reference_strain": ("reference_strain", 1.0),
    }


def test_our_own_name_may_repeat_its_unit():
    assert taken_as(["time_s [s]"]) == {"time_s": ("time_s [s]", 1.0)}
    assert taken_as(["reference_strain [%]"]) == {"reference_strain": ("reference_strain [%]", 0.01)}


def test_foreign_names_are_recognised_with_their_unit():
    assert taken_as(["Time [ms]", "V_SMA (mV)", "LVDT / mm", "force_mN", "Temp degC"]) == {
        "time_s": ("Time [ms]", 0.001),
        "wire_voltage_v": ("V_SMA (mV)", 0.001),
        "displacement_m": ("LVDT / mm", 0.001),
        "force_n": ("force_mN", 0.001),
        "wire_temperature_k": ("Temp degC", 1.0),
    }


def test_the_unit_decides_what_a_name_with_two_meanings_is():
    headers = ["t [s]", "T [°C]", "Load [MPa]", "Extension [%]"]
    assert list(taken_as(headers)) == ["time_s", "wire_temperature_k", "stress_pa", "reference_strain"]


def test_a_strain_without_a_unit_is_a_fraction():
    assert taken_as(["time_s", "strain"])["reference_strain"] == ("strain", 1.0)


def test_unknown_headers_are_ignored_and_listed():
    _, ignored = understand_headers(["time_s", "Humidity [%]", "n/a", "setpoint_x"], None, "loop.csv")
    assert [(item.header, item.reason) for item in ignored] == [
        ("Humidity [%]", "name not known"),
        ("n/a", "name not known"),
        ("setpoint_x", "name not known"),
    ]


def test_a_mapping_decides_between_two_headers():
    found = taken_as(["time_s", "Voltage [V]", "V_SMA [mV]"], {"wire_voltage_v": "V_SMA [mV]"})
    assert found["wire_voltage_v"] == ("V_SMA [mV]", 0.001)


@pytest.mark.parametrize(
    ("wanted", "factor"),
    [("Vw:mV", 0.001), ("vw:V", 1.0), ("Vw : mV", 0.001), ("a:b [mV]", 0.001), ("a:b", 0.001)],
)
def test_a_mapping_names_a_header_and_perhaps_its_unit(wanted, factor):
    assert taken_as(["time_s", "Vw", "a:b [mV]"], {"wire_voltage_v": wanted})["wire_voltage_v"][1] == factor


def test_a_mapped_header_may_carry_its_unit():
    headers = ["time_s", "pos [mm]"]
    assert taken_as(headers, {"displacement_m": "pos"})["displacement_m"][1] == 0.001
    assert taken_as(headers, {"displacement_m": "pos [mm]"})["displacement_m"][1] == 0.001


@pytest.mark.parametrize(
    ("wanted", "is_said"), [("U [mV]:V", 1), ("U [mV]:mV", 0), ("U [mV]", 0), ("U [mV]:2 mV/V", 0)]
)
def test_a_unit_against_the_one_that_the_file_states_is_refused_with_both_or_trusted(wanted: str, is_said: int) -> None:
    columns = [SourceColumn("U [mV]")]
    trusted = match_columns(columns, {"wire_voltage_v": wanted}, "loop.csv", trust_mapping=True)
    assert len(trusted.taken) == 1
    if is_said:
        assert "states mV, the mapping of wire_voltage_v V" in refusal(["U [mV]"], {"wire_voltage_v": wanted})
    else:
        assert match_columns(columns, {"wire_voltage_v": wanted}, "loop.csv") == trusted


def test_a_mapping_may_take_one_of_our_own_names_for_something_else():
    found = taken_as(["time_s", "drive_voltage_v"], {"wire_voltage_v": "drive_voltage_v"})
    assert found == {"time_s": ("time_s", 1.0), "wire_voltage_v": ("drive_voltage_v", 1.0)}


@pytest.mark.parametrize(
    ("headers", "mapping", "says"),
    [
        (["time_s", "Voltage"], None, "column 'Voltage' has no unit: write 'Voltage [V]' in the header or map it"),
        (["time_s", "Force [mm]"], None, "column 'Force [mm]': mm is a length, force_n needs a force"),
        (["time_s", "Force [Nn]"], None, "column 'Force [Nn]': unknown unit 'Nn'; did you mean 'N'?"),
        (["time_s [ms]"], None, "time_s is in s by its name, not in ms"),
        (["time_s", "Voltage [V]", "V_SMA [V]"], None, "both taken as wire_voltage_v: map the one you mean"),
        (["time_s", "Voltage_1"], {"wire_voltage_v": "Voltage_2:V"}, "no column 'Voltage_2'"),
        (["time_s", "Vw"], {"wire_voltage_v": "Vw"}, "add it to the mapping, as wire_voltage_v=Vw:V"),
        (["time_s", "pos [mm]", "pos [V]"], {"displacement_m": "pos"}, "fits 'pos [mm]', 'pos [V]'"),
        (["time_s", "x"], {"displacement_m": "x:mm", "force_n": "x:N"}, "uses one header twice"),
    ],
)
def test_headers_that_leave_a_doubt_are_refused_with_what_to_do(headers, mapping, says):
    assert says in refusal(headers, mapping)


def test_a_mapping_to_no_column_of_ours_is_the_callers_error():
    with pytest.raises(CallerError, match="unknown column 'wire_volts'"):
        understand_headers(["time_s", "Vw"], {"wire_volts": "Vw:V"}, "loop.csv")


def test_in_a_printed_loop_resistance_is_the_abscissa():
    headers = ["Resistance [Ohm]", "Heating strain [%]", "Cooling strain [%]"]
    assert list(taken_as(headers)) == ["resistance_ohm", "strain_heating", "strain_cooling"]
    assert "wire_resistance_ohm" in taken_as(["time_s", *headers])
