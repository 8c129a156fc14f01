"""Every reader gives the numbers that the format's own library gives, and one line for what it refuses."""

import subprocess
import sys

import h5py
import lvm_read
import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from nptdms import TdmsFile
from scipy.io import loadmat
from tests.extras.lab_files.corpus.lab_signals import DISPLACEMENT_MM, FORCE_N, ROWS, TIME_S, WIRE_VOLTAGE_V

from musclewire.errors import MusclewireError, RecordingError
from musclewire.extras.lab_files._foreign_hdf5 import read_hdf5_of_others
from musclewire.extras.lab_files._formats import lab_file_reader
from musclewire.signals import import_recording, load_mapping, read_recording, save_mapping


def table_of(path, group=None):
    read = lab_file_reader(path) or read_hdf5_of_others
    return read(path, group)


def columns_of(path, group=None):
    """Return header -> cells of a file, all blocks joined."""
    table = table_of(path, group)
    blocks = list(table.blocks(range(len(table.columns))))
    return {
        column.header: np.concatenate([block.values[index] for block in blocks])
        for index, column in enumerate(table.columns)
    }


def units_of(path, group=None):
    return {column.header: column.unit for column in table_of(path, group).columns}


def refusal(path, group=None):
    with pytest.raises(RecordingError) as caught:
        columns_of(path, group)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 2000
    return str(caught.value)


def test_tdms_channels_are_those_that_nptdms_reads(lab_files):
    for name in ("tdms_waveforms", "tdms_many_segments", "tdms_scaled_integers", "tdms_with_text_channel"):
        path = lab_files / "read" / f"{name}.tdms"
        columns, theirs = columns_of(path), TdmsFile.read(path)["Measured"]
        for channel in theirs.channels():
            if channel.name in columns:
                assert np.array_equal(columns[channel.name], channel[:])
        assert columns["time"] == pytest.approx(theirs["Wire voltage"].time_track(), abs=1e-12)


def test_units_of_tdms_channels_are_those_of_their_properties(lab_files):
    units = units_of(lab_files / "read" / "tdms_waveforms.tdms")
    assert units == {"time": "s", "Wire voltage": "V", "Shunt voltage": "mV", "LVDT": "mm"}


def test_a_tdms_file_that_was_cut_off_in_a_run_gives_its_complete_rows_and_says_so(lab_files):
    path = lab_files / "read" / "tdms_cut_off_in_a_run.tdms"
    table = table_of(path)
    assert "cut off" in table.layout
    assert "50 rows" in table.notes[0]
    assert np.array_equal(columns_of(path)["LVDT"], DISPLACEMENT_MM[:50])


def test_groups_of_different_rates_are_chosen_by_name(lab_files):
    path = lab_files / "read" / "tdms_two_rates.tdms"
    assert "--group" in refusal(path)
    assert "did you mean 'Fast'" in refusal(path, "Fasd")
    assert len(columns_of(path, "Fast")["Force"]) == 5 * ROWS
    assert len(columns_of(path, "Measured")["LVDT"]) == ROWS


def test_no_index_file_beside_a_tdms_file_is_opened(lab_files, tmp_path):
    path = tmp_path / "a.tdms"
    path.write_bytes((lab_files / "read" / "tdms_waveforms.tdms").read_bytes())
    (tmp_path / "a.tdms_index").write_bytes(b"not an index")
    assert np.array_equal(columns_of(path)["Wire voltage"], WIRE_VOLTAGE_V)


@pytest.mark.parametrize("name", ["lvm_one_x_column.lvm", "lvm_commas.lvm", "lvm_decimal_comma.lvm"])
def test_lvm_numbers_are_those_that_lvm_read_reads(lab_files, name):
    path = lab_files / "read" / name
    theirs = lvm_read.read(str(path), read_from_pickle=False, dump_file=False)[0]["data"]
    ours = np.column_stack(list(columns_of(path).values()))
    assert ours == pytest.approx(theirs[:, :4], abs=1e-12)


def test_lvm_without_x_column_counts_time_by_its_increment(lab_files):
    columns = columns_of(lab_files / "read" / "lvm_no_x_column.lvm")
    assert columns["time [s]"] == pytest.approx(TIME_S, abs=1e-12)
    assert columns["Wire voltage [V]"] == pytest.approx(WIRE_VOLTAGE_V, abs=1e-6)


def test_packets_of_an_lvm_file_follow_each_other_by_their_times(lab_files):
    assert columns_of(lab_files / "read" / "lvm_three_packets.lvm")["time [s]"] == pytest.approx(TIME_S, abs=1e-6)


def test_equal_x_columns_of_an_lvm_file_are_one_clock_and_others_are_tables_of_their_own(lab_files):
    columns = columns_of(lab_files / "read" / "lvm_multi_x_column.lvm")
    assert list(columns) == ["time [s]", "Wire voltage [V]", "Shunt voltage [V]", "LVDT [mm]"]
    assert "3 tables" in refusal(lab_files / "read" / "lvm_two_clocks.lvm")
    assert columns_of(lab_files / "read" / "lvm_two_clocks.lvm", "LVDT")["LVDT [mm]"] == pytest.approx(DISPLACEMENT_MM)


@pytest.mark.parametrize("name", ["mat4_columns", "mat5_columns", "mat5_rows_and_units", "mat5_compressed"])
def test_matlab_variables_are_those_that_scipy_reads(lab_files, name):
    path = lab_files / "read" / f"{name}.mat"
    theirs = loadmat(path)
    for header, values in columns_of(path).items():
        assert np.array_equal(values, np.ravel(theirs[header]))


def test_matlab_7_3_has_the_numbers_and_units_of_version_5(lab_files):
    for name in ("mat73_columns", "mat73_rows_compressed", "mat73_struct"):
        path = lab_files / "read" / f"{name}.mat"
        five = columns_of(lab_files / "read" / "mat5_rows_and_units.mat")
        assert all(np.array_equal(values, five[header]) for header, values in columns_of(path).items())
        assert units_of(path) == {"t": "s", "U_wire": "V", "U_shunt": "V", "disp": "mm"}


def test_a_matrix_of_matlab_7_3_has_its_columns_as_matlab_shows_them(lab_files):
    columns = columns_of(lab_files / "read" / "mat73_matrix.mat")
    assert np.array_equal(columns["data 2"], WIRE_VOLTAGE_V)


def test_a_structure_with_time_of_simulink_is_a_table(lab_files):
    columns = columns_of(lab_files / "read" / "mat5_simulink_structure_with_time.mat")
    assert np.array_equal(columns["time"], TIME_S)
    assert np.array_equal(columns["wire voltage"], WIRE_VOLTAGE_V)


def test_a_rate_that_a_file_states_takes_the_place_of_a_clock(lab_files):
    table = table_of(lab_files / "read" / "mat5_matrix.mat")
    assert table.sample_period_s == pytest.approx(0.05)
    assert "0.05 s apart" in table.notes[0]


def test_cells_and_timetables_are_refused_with_the_line_to_type_in_matlab(lab_files):
    assert "cell2mat" in refusal(lab_files / "read" / "mat5_with_cell.mat")
    assert "timetable2table" in refusal(lab_files / "read" / "mat73_timetable.mat")


@pytest.mark.parametrize(
    "name", ["xlsx_plain", "xlsx_titles_and_units", "xlsx_units_in_brackets", "xlsx_numbers_as_text"]
)
def test_a_sheet_has_the_numbers_that_pandas_reads(lab_files, name):
    theirs = pd.read_excel(lab_files / "read" / "xlsx_plain.xlsx").to_numpy()
    ours = np.column_stack(list(columns_of(lab_files / "read" / f"{name}.xlsx").values()))
    assert ours == pytest.approx(theirs, abs=1e-12)


def test_titles_parameters_and_units_above_a_sheet_are_understood(lab_files):
    path = lab_files / "read" / "xlsx_titles_and_units.xlsx"
    assert table_of(path).metadata == {"shunt_resistance_ohm": 0.47, "operator": "lab"}
    assert units_of(path) == {"Zeit": "s", "U wire": "V", "U shunt": "V", "Weg": "mm"}


def test_dates_of_a_sheet_are_seconds_since_the_first(lab_files):
    path = lab_files / "read" / "xlsx_dates.xlsx"
    recording = read_recording(path)
    assert recording["time_s"] == pytest.approx(TIME_S, abs=1e-6)
    assert str(recording.metadata["start_time"]).startswith("2024-03-08T10:30:28.5")


def test_formulas_without_values_are_named_with_the_cure(lab_files):
    table = table_of(lab_files / "read" / "xlsx_time_never_calculated.xlsx")
    assert "open the workbook in Excel or LibreOffice and save it" in table.notes[0]
    assert "save it" in refusal(lab_files / "read" / "xlsx_never_calculated.xlsx")


def test_sheets_are_chosen_by_name(lab_files):
    path = lab_files / "read" / "xlsx_two_sheets.xlsx"
    assert "--sheet" in refusal(path)
    assert columns_of(path, "force")["Force [N]"] == pytest.approx(FORCE_N)


def test_hdf5_of_any_layout_has_the_numbers_that_h5py_reads(lab_files):
    path = lab_files / "read" / "hdf5_group_compressed.hdf5"
    with h5py.File(path) as file:
        theirs = {name: dataset[()] for name, dataset in file["run/daq"].items()}
    ours = columns_of(path)
    assert all(np.array_equal(ours[name], theirs[name]) for name in theirs)
    named = columns_of(lab_files / "read" / "hdf5_matrix_with_names.h5")
    assert all(np.array_equal(named[name], theirs[name]) for name in theirs)
    assert np.array_equal(columns_of(lab_files / "read" / "hdf5_records.h5")["force_n"], FORCE_N)


@pytest.mark.parametrize("name", ["parquet_pandas", "parquet_arrow_units"])
def test_parquet_has_the_numbers_that_pandas_reads(lab_files, name):
    path = lab_files / "read" / f"{name}.parquet"
    theirs = pd.read_parquet(path)
    assert all(np.array_equal(values, theirs[header]) for header, values in columns_of(path).items())


def test_times_of_parquet_are_seconds_since_the_first_and_attrs_of_pandas_are_metadata(lab_files):
    path = lab_files / "read" / "parquet_pandas_times.parquet"
    assert read_recording(path)["time_s"] == pytest.approx(TIME_S, abs=1e-9)
    assert table_of(path).metadata["shunt_resistance_ohm"] == 0.47


def test_files_larger_than_a_block_come_in_blocks(tmp_path):
    with h5py.File(tmp_path / "long.h5", "w") as file:
        file["time_s"], file["force_n"] = np.arange(200_000) * 1e-3, np.arange(200_000.0)
    blocks = list(table_of(tmp_path / "long.h5").blocks([0, 1]))
    assert [len(block.values[0]) for block in blocks] == [65_536] * 3 + [3_392]
    assert blocks[1].place(0) == "row 65537"


def test_every_damaged_or_hostile_file_is_refused_in_one_line(lab_files):
    damaged = sorted((lab_files / "damaged").iterdir())
    assert len(damaged) >= 45
    for path in damaged:
        assert refusal(path).startswith(str(path))


@pytest.mark.slow
def test_nothing_outside_a_hostile_file_is_opened(lab_files):
    """Python reports each file that it opens; what HDF5's own code would open is refused before (see above)."""
    code = """
import sys, pathlib
from musclewire.errors import MusclewireError
from musclewire.extras.lab_files._formats import lab_file_reader
from musclewire.extras.lab_files._foreign_hdf5 import read_hdf5_of_others
paths = [pathlib.Path(text) for text in sys.argv[1:]]
def read_all():
    for path in paths:
        try:
            table = (lab_file_reader(path) or read_hdf5_of_others)(path, None)
            for block in table.blocks(range(len(table.columns))):
                pass
        except MusclewireError:
            pass
read_all()
opened = []
sys.addaudithook(lambda event, args: opened.append(str(args[0])) if event in {'open', 'exec', 'os.system'} else None)
read_all()
allowed = {str(path) for path in paths}
print(sorted(name for name in opened if name not in allowed and not name.isdigit()))
"""
    paths = [str(path) for folder in ("read", "damaged") for path in (lab_files / folder).iterdir()]
    done = subprocess.run([sys.executable, "-c", code, *paths], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[]"


def said_about(path):
    """Return what reading a file says: nothing, or the error of ours; any other error passes."""
    try:
        columns_of(path)
    except MusclewireError as problem:
        return str(problem)
    return ""


@pytest.mark.slow
@settings(deadline=None, max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_file_with_changed_bytes_is_read_or_refused_in_one_line(lab_files, tmp_path, data):
    names = sorted(path.name for path in (lab_files / "read").iterdir() if not path.name.endswith((".h5", ".hdf5")))
    name = data.draw(st.sampled_from([name for name in names if "mat73" not in name]))
    content = bytearray((lab_files / "read" / name).read_bytes())
    if data.draw(st.booleans()):
        content = content[: data.draw(st.integers(0, len(content)))]
    for _ in range(data.draw(st.integers(0, 4))):
        if content:
            content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path / name
    path.write_bytes(content)
    assert "\n" not in said_about(path)


def test_a_mapping_remembers_the_group_and_a_mapping_file_keeps_it(lab_files, tmp_path):
    path = lab_files / "read" / "tdms_two_rates.tdms"
    understood = import_recording(path, group="Fast")
    save_mapping(understood.mapping, tmp_path / "fast.toml")
    assert load_mapping(tmp_path / "fast.toml").group == "Fast"
    assert len(read_recording(path, mapping=tmp_path / "fast.toml")) == 5 * ROWS


def test_a_group_of_a_file_without_groups_is_refused(lab_files, tmp_path):
    with pytest.raises(RecordingError, match="leave --group out"):
        read_recording(lab_files / "read" / "parquet_pandas.parquet", group="a")
    (tmp_path / "a.csv").write_text("time_s,force_n\n0,1\n1,2\n")
    with pytest.raises(RecordingError, match="leave --group out"):
        read_recording(tmp_path / "a.csv", group="a")
