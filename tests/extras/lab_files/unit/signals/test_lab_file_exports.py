"""What is exported is read back number by number, by us and by the libraries of those who use the format."""

import h5py
import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat

from musclewire.errors import CallerError
from musclewire.extras.lab_files import _excel as excel_export
from musclewire.extras.lab_files import _matlab as matlab_export
from musclewire.extras.lab_files._matlab import fill_matlab, fill_matlab_73
from musclewire.files import read_recording
from musclewire.signals import Recording

TIME_S = np.arange(5) * 0.1
RECORDING = Recording(
    {"time_s": TIME_S, "wire_voltage_v": TIME_S + 1.0, "valid": [0.0, 1.0, 1.0, 0.0, 1.0]},
    {"wire": "Flexinol µ", "pretension_n": 1.7, "legs": 2, "loaded": True, "extrapolation": None, "rig.kind": "=1+1"},
)


def test_matlab_5_has_a_column_vector_for_each_column_and_structs_of_units_and_metadata(tmp_path):
    RECORDING.save(tmp_path / "a.mat")
    there = loadmat(tmp_path / "a.mat", simplify_cells=True)
    shapes = loadmat(tmp_path / "a.mat")
    assert shapes["wire_voltage_v"].shape == (5, 1)
    assert np.array_equal(there["wire_voltage_v"], RECORDING["wire_voltage_v"])
    assert there["units"] == {"time_s": "s", "wire_voltage_v": "V", "valid": "1"}
    assert there["metadata"]["wire"] == "Flexinol µ"
    assert there["metadata"]["pretension_n"] == 1.7
    assert there["metadata"]["rig_kind"] == "=1+1"


def test_matlab_7_3_is_hdf5_with_matlabs_header_classes_and_order_of_dimensions(tmp_path):
    path = tmp_path / "a.mat"
    fill_matlab_73(RECORDING.columns, RECORDING.metadata, path)
    assert path.read_bytes().startswith(b"MATLAB 7.3 MAT-file")
    assert path.read_bytes()[124:128] == b"\x00\x02IM"
    with h5py.File(path) as file:
        assert file["wire_voltage_v"].shape == (1, 5)
        assert file["wire_voltage_v"].attrs["MATLAB_class"] == b"double"
        assert file["metadata/loaded"].attrs["MATLAB_class"] == b"logical"
        assert file["metadata/extrapolation"].attrs["MATLAB_empty"] == 1
        assert bytes(file["units/wire_voltage_v"][()]).decode("utf-16-le") == "V"


def test_columns_too_large_for_matlab_5_become_7_3(tmp_path, monkeypatch):
    monkeypatch.setattr(matlab_export, "MAX_COLUMN_BYTES", 39)
    fill_matlab(RECORDING.columns, RECORDING.metadata, tmp_path / "a.mat")
    assert h5py.is_hdf5(tmp_path / "a.mat")
    with pytest.raises(CallerError, match=r"write version 7\.3"):
        matlab_export.fill_matlab_5(RECORDING.columns, RECORDING.metadata, tmp_path / "b.mat")


def test_a_workbook_has_the_columns_that_pandas_reads_and_text_that_is_no_formula(tmp_path):
    RECORDING.save(tmp_path / "a.xlsx")
    frame = pd.read_excel(tmp_path / "a.xlsx", sheet_name="recording")
    # openpyxl writes 16 digits, one more than Excel shows.
    assert frame.to_numpy() == pytest.approx(RECORDING.to_pandas().to_numpy(), rel=1e-15)
    metadata = pd.read_excel(tmp_path / "a.xlsx", sheet_name="metadata", header=None, index_col=0)[1]
    assert metadata["rig.kind"] == "=1+1"


def test_a_matlab_version_is_asked_for_by_its_number(tmp_path):
    RECORDING.save(tmp_path / "a.mat", matlab_version="7.3")
    assert read_recording(tmp_path / "a.mat") == RECORDING
    with pytest.raises(CallerError, match="give 5 or 7"):
        RECORDING.save(tmp_path / "b.mat", matlab_version="6")
    with pytest.raises(CallerError, match=r"end the name in \.mat"):
        RECORDING.save(tmp_path / "b.h5", matlab_version="5")


def test_more_rows_than_a_sheet_holds_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(excel_export, "SHEET_ROWS", 4)
    with pytest.raises(CallerError, match="5 rows are more than the 4"):
        RECORDING.save(tmp_path / "a.xlsx")


def test_xarray_has_the_columns_over_time_with_units_and_metadata():
    data = RECORDING.to_xarray()
    assert data["wire_voltage_v"].dims == ("time_s",)
    assert data["wire_voltage_v"].attrs["units"] == "V"
    assert data["time_s"].attrs["units"] == "s"
    assert float(data["wire_voltage_v"].sel(time_s=0.2, method="nearest")) == RECORDING["wire_voltage_v"][2]
    assert data.attrs["pretension_n"] == 1.7
    assert "extrapolation" not in data.attrs


def test_xarray_of_a_table_without_a_clock_counts_rows():
    table = {"resistance_ohm": [1.0, 2.0], "strain_heating": [0.0, 0.1], "strain_cooling": [0.0, 0.1]}
    assert Recording(table).to_xarray()["strain_heating"].dims == ("row",)
