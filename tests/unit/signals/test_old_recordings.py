"""Recordings of every version of the format that was ever written stay readable: committed files, to the last digit.

``version-1-...`` are plain HDF5, whose runs grew the file itself; ``journal-1-...`` are journals. The run that was cut
off was killed after its last whole block of seven rows, the other reached its end at 50.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

from musclewire.files import read_hdf5, read_recording
from musclewire.signals import recover_recording

OLD = Path(__file__).parent / "old_recordings"
STATED = {
    "wire": "Flexinol",
    "shunt_resistance_ohm": 1.0,
    "legs": 2,
    "new_wire": False,
    "rig": None,
    "note": "µ, 125 um",
    "extra.number": 0.1,
}


@pytest.mark.parametrize("file", sorted(OLD.iterdir()), ids=lambda file: file.name)
def test_every_old_recording_reads_as_it_was_written(file: Path) -> None:
    recording = read_hdf5(file)
    cut_off = "cut-off" in file.name
    row = np.arange(49.0 if cut_off else 50.0)
    assert recording.names == ("time_s", "wire_voltage_v", "shunt_voltage_v", "force_n")
    assert recording["time_s"].tolist() == [0.01 * (index + 1) for index in range(row.size)]
    assert np.array_equal(recording["wire_voltage_v"], row + 0.25)
    assert np.array_equal(recording["shunt_voltage_v"], np.where(row == 3.0, np.nan, row + 0.5), equal_nan=True)
    assert np.array_equal(recording["force_n"], row + 0.75)
    ending = {"ended": "cut off"} if cut_off else {"ended": "done", "deadline_misses": 3}
    assert dict(recording.metadata) == {**STATED, **ending}


def test_an_old_run_that_was_cut_off_ends_at_its_shortest_column(tmp_path: Path) -> None:
    shutil.copy(OLD / "version-1-cut-off.h5", tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5", "r+") as file:
        file["force_n"].resize((27,))
    assert len(read_hdf5(tmp_path / "run.h5")) == 27


def test_rows_beyond_the_last_complete_block_of_an_old_run_are_not_believed(tmp_path: Path) -> None:
    shutil.copy(OLD / "version-1-cut-off.h5", tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5", "r+") as file:
        for name in file:
            file[name].resize((70,))
    assert len(read_hdf5(tmp_path / "run.h5")) == 49


@pytest.mark.parametrize("end", ["cut-off", "finished"])
def test_an_old_journal_is_recovered_as_plain_hdf5(end: str, tmp_path: Path) -> None:
    shutil.copy(OLD / f"journal-1-{end}.h5.journal", tmp_path / "run.h5.journal")
    before = read_hdf5(tmp_path / "run.h5")
    recovered = recover_recording(tmp_path / "run.h5")
    assert [file.name for file in tmp_path.iterdir()] == ["run.h5"]
    assert read_hdf5(tmp_path / "run.h5") == before == recovered
    with h5py.File(tmp_path / "run.h5") as file:
        assert np.array_equal(file["wire_voltage_v"], before["wire_voltage_v"])


def test_shunt_voltages_without_a_reading_are_refused_as_ever() -> None:
    with pytest.raises(ValueError, match="row 4, column 'shunt_voltage_v': the cell is blank or NaN"):
        read_recording(OLD / "version-1-finished.h5")
