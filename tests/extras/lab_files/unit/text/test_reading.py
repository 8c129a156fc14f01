import json

import numpy as np
import pytest

from musclewire.errors import CallerError, RecordingError
from musclewire.files import read_recording
from musclewire.identify import import_recording
from musclewire.signals import Recording

FOREIGN = "Time [ms],V_SMA [mV],V_R [V],pos,T (°C),Humidity\n0,1000,0.5,1,25,40\n50,1100,0.6,2,26,41\n"


@pytest.fixture
def foreign(tmp_path):
    path = tmp_path / "loop.csv"
    path.write_text("# shunt_resistance = 1.0 ohm\n" + FOREIGN, encoding="utf-8")
    return path


def refusal(path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_foreign_file_becomes_a_recording_in_si(foreign):
    recording = read_recording(foreign, columns={"displacement_m": "pos:mm"}, metadata={"wire": "Flexinol"})
    assert recording.names == (
        "time_s",
        "wire_voltage_v",
        "shunt_voltage_v",
        "displacement_m",
        "wire_temperature_k",
    )
    assert recording["time_s"].tolist() == pytest.approx([0.0, 0.05])
    assert recording["wire_voltage_v"].tolist() == pytest.approx([1.0, 1.1])
    assert recording["displacement_m"].tolist() == pytest.approx([0.001, 0.002])
    assert recording["wire_temperature_k"].tolist() == pytest.approx([298.15, 299.15])
    assert dict(recording.metadata) == {"shunt_resistance_ohm": 1.0, "wire": "Flexinol"}


def test_understanding_tells_header_by_header_what_was_made_of_it(foreign):
    found = import_recording(foreign, columns={"displacement_m": "pos:mm"})
    assert [(item.header, item.column, item.unit, item.factor, item.offset, item.how) for item in found.taken] == [
        ("Time [ms]", "time_s", "ms", 0.001, 0.0, "synonym"),
        ("V_SMA [mV]", "wire_voltage_v", "mV", 0.001, 0.0, "synonym"),
        ("V_R [V]", "shunt_voltage_v", "V", 1.0, 0.0, "synonym"),
        ("pos", "displacement_m", "mm", 0.001, 0.0, "mapped"),
        ("T (°C)", "wire_temperature_k", "°C", 1.0, 273.15, "synonym"),
    ]
    assert [(item.header, item.reason) for item in found.ignored] == [("Humidity", "name not known")]
    assert (found.row_count, found.layout) == (2, "text, separated by commas")
    assert "'Time [ms]' -> time_s [ms] x 0.001 (synonym)" in str(found)
    assert "'T (°C)' -> wire_temperature_k [°C] x 1 + 273.15 (synonym)" in str(found)
    assert "'Humidity' ignored: name not known" in str(found)
    assert json.loads(json.dumps(found.as_dict()))["taken"][0]["column"] == "time_s"


@pytest.mark.parametrize("rows", ["0,1\n1,nan\n2,3\n", "0,1\n1,x\n2,3\n", "0,1\n0,2\n", "0,1\n"])
def test_understanding_judges_the_numbers_as_reading_does(tmp_path, rows):
    path = tmp_path / "loop.csv"
    path.write_text("time_s,force_n\n" + rows)
    assert import_recording(path).problem == refusal(path)


def test_understanding_shows_what_reading_refuses_in_a_header(foreign):
    found = import_recording(foreign)
    assert found.problem == refusal(foreign)
    assert "column 'pos' has no unit: write 'pos [m]'" in found.problem
    assert "'pos' undecided: column 'pos' has no unit" in str(found)


def test_a_missing_file_a_folder_and_an_unknown_ending_are_told_apart(tmp_path):
    assert "no such file" in refusal(tmp_path / "none.csv")
    (tmp_path / "folder.csv").mkdir()
    assert "is a folder" in refusal(tmp_path / "folder.csv")
    assert "files ending in '.doc' are not read; export it as .h5" in refusal(tmp_path / "a.doc")


def test_a_printed_loop_needs_no_clock(tmp_path):
    text = "Resistance [Ohm],Strain heating [%],Strain cooling [%]\n3.0,4.0,4.1\n3.5,2.0,1.0\n"
    (tmp_path / "table.csv").write_text(text)
    table = read_recording(tmp_path / "table.csv")
    assert table.is_branch_table
    assert table["strain_heating"].tolist() == pytest.approx([0.04, 0.02])


def test_a_strain_beyond_one_without_a_unit_is_taken_for_percent_and_refused(tmp_path):
    (tmp_path / "a.csv").write_text("time_s,strain\n0,0.5\n1,3.5\n")
    message = refusal(tmp_path / "a.csv")
    assert "line 3, column 'strain': 3.5 is no strain as a fraction: write 'strain [%]'" in message
    assert read_recording(tmp_path / "a.csv", {"reference_strain": "strain:%"})["reference_strain"][1] == 0.035


def test_our_own_hdf5_is_judged_like_every_other_file(tmp_path):
    path = tmp_path / "run.h5"
    Recording({"time_s": [0.0, 1.0, 1.0], "force_n": [1.0, 2.0, 3.0]}).save(path)
    assert "row 3, column time_s: the clock does not rise, 1.0 s is followed by 1.0 s" in refusal(path)
    Recording({"time_s": [0.0, 1.0], "force_n": [1.0, np.nan]}).save(path)
    assert "row 2, column 'force_n': the cell is blank or NaN" in refusal(path)


def test_where_an_estimator_had_no_answer_nan_is_one(tmp_path):
    run = Recording({"time_s": [0.0, 1.0], "estimated_strain": [np.nan, 0.01], "valid": [0.0, 1.0]})
    for name in ("run.h5", "run.csv"):
        run.save(tmp_path / name)
        assert read_recording(tmp_path / name) == run


def test_a_bad_name_in_the_mapping_or_the_metadata_is_the_callers_error(foreign):
    mapping = {"displacement_m": "pos:mm"}
    with pytest.raises(CallerError, match="unknown column 'displacement'"):
        read_recording(foreign, columns={"displacement": "pos:mm"})
    with pytest.raises(CallerError, match="metadata key 'Wire'"):
        read_recording(foreign, columns=mapping, metadata={"Wire": "x"})


MACHINE = "30.6\t1.59\t100\n31.1\t1.58\t100\n32.0\t1.57\t100\n"
BY_NUMBER = {"wire_temperature_k": "#1:degC", "reference_strain": "#2:%", "stress_pa": "#3:MPa"}


def test_isobars_of_a_test_machine_are_read_without_header_and_without_clock(tmp_path):
    path = tmp_path / "machine.txt"
    path.write_text(MACHINE)
    recording = read_recording(path, BY_NUMBER)
    assert recording.is_isobar_table
    assert recording["wire_temperature_k"] == pytest.approx([303.75, 304.25, 305.15])
    assert recording["reference_strain"] == pytest.approx([0.0159, 0.0158, 0.0157])
    assert recording["stress_pa"] == pytest.approx([1e8, 1e8, 1e8])
    assert "isobar table" in repr(recording)


def test_a_column_may_be_mapped_by_its_number_beside_headers(tmp_path):
    path = tmp_path / "machine.csv"
    path.write_text("T [degC],first,second\n30,1.5,100\n31,1.6,100\n")
    recording = read_recording(path, {"reference_strain": "#2:%", "stress_pa": "#3:MPa"})
    assert recording["reference_strain"] == pytest.approx([0.015, 0.016])


@pytest.mark.parametrize(
    ("mapping", "words"),
    [
        ({}, "has no headers; name the columns"),
        ({"wire_temperature_k": "#1:degC"}, "no column is the time"),
        ({**BY_NUMBER, "stress_pa": "#4:MPa"}, "no column '#4', mapped to stress_pa"),
        ({**BY_NUMBER, "stress_pa": "#0:MPa"}, "no column '#0', mapped to stress_pa"),
        ({**BY_NUMBER, "stress_pa": "#3"}, "has no unit"),
        ({**BY_NUMBER, "stress_pa": "#2:MPa", "reference_strain": "#2:%"}, "the mapping uses one header twice"),
    ],
)
def test_what_is_wrong_with_a_mapping_by_number_is_said(tmp_path, mapping, words):
    path = tmp_path / "machine.txt"
    path.write_text(MACHINE)
    assert words in refusal(path, columns=mapping)


def test_all_columns_without_a_unit_are_named_at_once(tmp_path):
    (tmp_path / "a.csv").write_text("Time,Voltage,Current\n0,1.0,0.1\n0.5,1.1,0.11\n1,1.2,0.12\n")
    assert "columns 'Time', 'Voltage', 'Current' have no unit" in refusal(tmp_path / "a.csv")
