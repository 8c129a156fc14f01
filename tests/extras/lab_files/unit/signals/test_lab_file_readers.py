"""Every reader gives the numbers that were written, and one line for what it refuses."""

import pickle
import subprocess
import sys

import h5py
import lvm_read
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat
from tests.extras.lab_files.corpus.lab_signals import (
    DISPLACEMENT_MM,
    FORCE_N,
    PERIOD_S,
    ROWS,
    SHUNT_VOLTAGE_V,
    TIME_S,
    WIRE_VOLTAGE_V,
)
from tests.extras.lab_files.corpus.test_corpus import READ, mapping_of, name_of, path_of
from tests.places import TESTS

from musclewire.errors import MusclewireError, RecordingError
from musclewire.extras.lab_files._formats import lab_file_reader
from musclewire.extras.lab_files._hdf5_tree import read_hdf5_of_others
from musclewire.files import load_mapping, read_recording, save_mapping
from musclewire.identify import import_recording

CORPUS = TESTS / "extras/lab_files/corpus"


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


# What every file of the corpus holds, in SI, and to how much its program has written it; where one holds another part
# of it, how.
KNOWN = {
    "time_s": TIME_S,
    "wire_voltage_v": WIRE_VOLTAGE_V,
    "shunt_voltage_v": SHUNT_VOLTAGE_V,
    "displacement_m": 1e-3 * DISPLACEMENT_MM,
    "force_n": FORCE_N,
}
COARSE = {"tdms_scaled_integers.tdms": 1e-4, "mat5_integers.mat": 1e-3}
OTHERWISE = {
    "tdms_two_rates.tdms": {"time_s": 0.2 * PERIOD_S * np.arange(5 * ROWS), "force_n": np.repeat(FORCE_N, 5)},
    "lvm_two_clocks.lvm": {"time_s": TIME_S + 0.01},
}


@pytest.mark.parametrize("entry", [entry for entry in READ if entry["beside"] == CORPUS], ids=name_of)
def test_every_number_of_a_file_is_the_one_that_was_written(entry):
    recording = read_recording(path_of(entry), mapping=mapping_of(entry))
    known = {**KNOWN, **OTHERWISE.get(entry["name"], {})}
    for name in recording.names:
        written = known[name][: len(recording)]
        assert recording[name] == pytest.approx(written, abs=COARSE.get(entry["name"], 1.1e-6)), name


def test_a_tdms_file_that_was_cut_off_in_a_run_gives_its_complete_rows_and_says_so(lab_files):
    path = lab_files / "read" / "tdms_cut_off_in_a_run.tdms"
    table = table_of(path)
    assert "cut off" in table.layout
    assert "50 rows" in table.notes[0]
    assert np.array_equal(columns_of(path)["LVDT"], DISPLACEMENT_MM[:50])


def test_groups_of_different_rates_are_chosen_by_name(lab_files):
    path = lab_files / "read" / "tdms_two_rates.tdms"
    assert "group='NAME'" in refusal(path)
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


class Opens:
    """What opens a file when it is unpickled."""

    def __init__(self, path):
        self.path = str(path)

    def __reduce__(self):
        return open, (self.path, "w")


def test_a_pickle_in_a_frame_of_pandas_is_named_and_not_run(tmp_path):
    """Objects of a frame, and the names of columns, are pickles; names are read from the listing of their parts."""
    pickled = np.frombuffer(pickle.dumps(Opens(tmp_path / "opened")), dtype=np.uint8)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        frame = file.create_group("run")
        frame.attrs["pandas_type"] = np.bytes_("frame")
        frame["block0_items"] = np.array([b"note"])
        frame.create_dataset("block0_values", (1,), h5py.vlen_dtype(np.uint8))[0] = pickled
    assert "'note' was left out: it holds no numbers, and nothing is unpickled" in refusal(tmp_path / "a.h5")
    with h5py.File(tmp_path / "b.h5", "w") as file:
        frame = file.create_group("run")
        frame.attrs["pandas_type"] = np.bytes_("frame_table")
        frame["table"] = np.zeros(60, dtype=[("index", "i8"), ("values_block_0", "f8", 2)])
        frame["table"].attrs["values_block_0_kind"] = np.void(pickle.dumps(Opens(tmp_path / "opened")))
        frame.attrs["info"] = np.bytes_(pickle.dumps(Opens(tmp_path / "opened"), protocol=0))
    assert list(columns_of(tmp_path / "b.h5")) == ["values_block_0 1", "values_block_0 2"]
    assert not (tmp_path / "opened").exists()


def test_names_units_and_channels_decide_what_is_one_table(tmp_path):
    """Groups of one channel each are one table if their clocks are one; a matrix has its rows along its longer side."""
    time_s, other_s = np.arange(50) * 0.1, np.arange(50) * 0.2
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name, clock in (("U", time_s), ("I", time_s)):
            file[f"{name}/data"], file[f"{name}/time"] = np.arange(50.0), clock
    assert set(columns_of(tmp_path / "a.h5")) == {"time", "I", "U"}
    with h5py.File(tmp_path / "a.h5", "a") as file:
        file["U/time"][:] = other_s
    assert "holds 2 tables" in refusal(tmp_path / "a.h5")
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file["t"], file["data"], file["note"] = time_s, np.ones((3, 50)), "a text"
    assert list(columns_of(tmp_path / "b.h5")) == ["data 1", "data 2", "data 3", "t"]
    assert table_of(tmp_path / "b.h5").metadata == {"note": "a text"}


def test_names_of_columns_are_found_next_to_a_matrix(tmp_path):
    """As texts in a data set, an attribute of the group or a cell array of MATLAB, in both of its versions."""
    data, names = np.arange(12.0).reshape(4, 3), ["t [s]", "u [V]", "f [N]"]
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["data"], file["names"] = data, names
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file["data"] = data
        file.attrs["columns"] = names
    savemat(tmp_path / "c.mat", {"data": data, "names": np.array(names, dtype=object)})
    with h5py.File(tmp_path / "d.mat", "w", userblock_size=512) as file:
        file["data"] = data.T
        file["data"].attrs["MATLAB_class"] = np.bytes_("double")
        texts = []
        for number, name in enumerate(names):
            file[f"#refs#/{number}"] = np.frombuffer(name.encode("utf-16-le"), "u2")[:, None]
            file[f"#refs#/{number}"].attrs["MATLAB_class"] = np.bytes_("char")
            texts.append(file[f"#refs#/{number}"].ref)
        file["names"] = np.array(texts, dtype=h5py.ref_dtype)[None, :]
        file["names"].attrs["MATLAB_class"] = np.bytes_("cell")
    (tmp_path / "d.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(512) + (tmp_path / "d.mat").read_bytes()[512:])
    for name in ("a.h5", "b.h5", "c.mat", "d.mat"):
        found = columns_of(tmp_path / name)
        assert list(found) == names
        assert np.array_equal(np.column_stack(list(found.values())), data)


def test_a_matrix_wider_than_high_is_read_by_what_rises_in_it(tmp_path):
    """Simulink's signals are rows below the time, in both versions; many channels of few samples are columns."""
    time_s = np.arange(40) * 0.1
    signals = np.vstack([time_s, np.cos(time_s), np.sin(time_s)])
    channels = np.column_stack([time_s[:5], *np.random.default_rng(1).normal(size=(7, 5))])
    savemat(tmp_path / "a.mat", {"ans": signals})
    with h5py.File(tmp_path / "b.mat", "w", userblock_size=512) as file:
        file["ans"] = signals.T
        file["ans"].attrs["MATLAB_class"] = np.bytes_("double")
    (tmp_path / "b.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(512) + (tmp_path / "b.mat").read_bytes()[512:])
    savemat(tmp_path / "c.mat", {"data": channels})
    for name in ("a.mat", "b.mat"):
        assert units_of(tmp_path / name) == {"ans 1": "s", "ans 2": None, "ans 3": None}
        assert np.array_equal(np.vstack(list(columns_of(tmp_path / name).values())), signals)
    assert np.array_equal(np.column_stack(list(columns_of(tmp_path / "c.mat").values())), channels)


def test_whole_numbers_are_unpacked_and_what_hdf5_cannot_translate_is_left_out(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["time_s"], file["stroke"], file["force_n"] = np.arange(4) * 0.1, np.arange(4, dtype="i2"), np.arange(4.0)
        file["stroke"].attrs.update(units="mm", scale_factor=0.5, add_offset=1.0, _FillValue=np.int16(3))
        file["force_n"].attrs["scale_factor"] = 7.0
        opaque = h5py.h5t.create(h5py.h5t.OPAQUE, 3)
        h5py.h5a.create(file["force_n"].id, b"raw", opaque, h5py.h5s.create(h5py.h5s.SCALAR))
    columns = columns_of(tmp_path / "a.h5")
    assert columns["stroke"] == pytest.approx([1.0, 1.5, 2.0, np.nan], nan_ok=True)
    assert np.array_equal(columns["force_n"], np.arange(4.0))


@pytest.mark.slow
def test_nothing_outside_a_hostile_file_is_opened(lab_files):
    """Python reports each file that it opens; what HDF5's own code would open is refused before (see above)."""
    code = """
import sys, pathlib
from musclewire.errors import MusclewireError
from musclewire.extras.lab_files._formats import lab_file_reader
from musclewire.extras.lab_files._hdf5_tree import read_hdf5_of_others
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
    with pytest.raises(RecordingError, match="leave group out"):
        read_recording(lab_files / "read" / "parquet_pandas.parquet", group="a")
    (tmp_path / "a.csv").write_text("time_s,force_n\n0,1\n1,2\n")
    with pytest.raises(RecordingError, match="leave group out"):
        read_recording(tmp_path / "a.csv", group="a")
