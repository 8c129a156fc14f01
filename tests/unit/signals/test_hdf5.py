import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from musclewire.errors import CallerError, RecordingError
from musclewire.files import read_hdf5
from musclewire.signals import RecordingWriter

NAMES = ("time_s", "wire_voltage_v", "shunt_voltage_v")


def row(index):
    return {"time_s": 0.05 * index, "wire_voltage_v": 1.0 + index, "shunt_voltage_v": 0.5}


def write_rows(path, count, **options):
    with RecordingWriter(path, NAMES, {"wire": "Flexinol"}, **options) as writer:
        for index in range(count):
            writer.append(row(index))


def test_every_dataset_says_its_unit_and_is_plain_hdf5(tmp_path):
    write_rows(tmp_path / "run.h5", 3)
    with h5py.File(tmp_path / "run.h5") as file:
        assert file["wire_voltage_v"].attrs["unit"] == "V"
        assert file["time_s"].dtype == np.float64
        assert (file.attrs["format"], file.attrs["format_version"]) == ("musclewire-recording", 1)


def test_rows_are_in_the_file_once_their_block_is_full(tmp_path):
    with RecordingWriter(tmp_path / "run.h5", NAMES, {}, block_rows=4) as writer:
        for index in range(10):
            writer.append(row(index))
        assert writer.rows_written == 8
        assert writer.ended == "running"
    assert writer.rows_written == 10
    assert writer.ended == "done"


@pytest.mark.parametrize(
    ("problem", "ended"),
    [
        (KeyboardInterrupt(), "interrupted"),
        (SystemExit(143), "interrupted"),
        (ValueError("the wire\nbroke"), "ValueError: the wire broke"),
        (RuntimeError("odd \ud800 \0 text"), "RuntimeError: odd ? text"),
    ],
)
def test_a_run_that_is_stopped_says_why_and_keeps_its_rows(tmp_path, problem, ended):
    def stopped_run():
        with RecordingWriter(tmp_path / "run.h5", NAMES, {}) as writer:
            for index in range(3):
                writer.append(row(index))
            raise problem

    with pytest.raises(type(problem)):
        stopped_run()
    recording = read_hdf5(tmp_path / "run.h5")
    assert len(recording) == 3
    assert recording.metadata["ended"] == ended


def test_the_caller_may_give_the_cause_and_closing_twice_changes_nothing(tmp_path):
    writer = RecordingWriter(tmp_path / "run.h5", NAMES, {})
    writer.append(row(0))
    writer.close("supply current limit")
    writer.close("done")
    assert read_hdf5(tmp_path / "run.h5").metadata["ended"] == "supply current limit"
    with pytest.raises(CallerError, match="the recording is closed"):
        writer.append(row(1))


@pytest.mark.parametrize(
    ("columns", "metadata", "options", "message"),
    [
        (["time_s", "wire_volts"], {}, {}, "unknown column 'wire_volts'"),
        (["time_s", "time_s"], {}, {}, "column 'time_s' is given twice"),
        (["force_n"], {}, {}, "needs the column time_s"),
        (NAMES, {"Wire": "x"}, {}, "metadata key 'Wire'"),
        (NAMES, {}, {"block_rows": 0}, "block_rows is 0"),
    ],
)
def test_a_writer_that_is_wrong_from_the_start_leaves_no_file(tmp_path, columns, metadata, options, message):
    with pytest.raises(CallerError, match=message):
        RecordingWriter(tmp_path / "run.h5", columns, metadata, **options)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_not_there_is_said(tmp_path):
    with pytest.raises(CallerError, match=r"cannot be written: .*; check the folder"):
        RecordingWriter(tmp_path / "missing" / "run.h5", NAMES, {})


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"time_s": 0.0, "wire_voltage_v": 1.0}, "a row lacks 'shunt_voltage_v'"),
        (row(0) | {"force_n": 1.0}, "a row gives 'force_n', which this recording does not keep"),
        (row(0) | {"wire_voltage_v": None}, "a row gives wire_voltage_v = None; give a number"),
    ],
)
def test_a_wrong_row_is_refused_and_the_recording_goes_on(tmp_path, wrong, message):
    with RecordingWriter(tmp_path / "run.h5", NAMES, {}) as writer:
        writer.append(row(0))
        with pytest.raises(CallerError, match=message):
            writer.append(wrong)
        writer.append(row(1))
    assert len(read_hdf5(tmp_path / "run.h5")) == 2


def test_a_file_that_another_program_writes_is_said_to_be(tmp_path):
    write_rows(tmp_path / "run.h5", 3)
    reader = "import sys; from musclewire.files._reading import read_hdf5; read_hdf5(sys.argv[1])"
    with h5py.File(tmp_path / "run.h5", "r+"):
        command = [sys.executable, "-c", reader, str(tmp_path / "run.h5")]
        answer = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "RecordingError" in answer.stderr
    assert "is still being written by another process; wait until it ends" in answer.stderr


def a_text_file(path):
    path.write_text("time_s,force_n\n0,1\n")


def of_somebody_else(path):
    with h5py.File(path, "w") as file:
        file["time_s"] = [0.0, 1.0]


def of_a_newer_version(path):
    write_rows(path, 3)
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = 2


def without_a_column(path):
    write_rows(path, 3)
    with h5py.File(path, "r+") as file:
        del file["shunt_voltage_v"]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (Path.exists, "no such file"),
        (Path.mkdir, "is a folder"),
        (a_text_file, "is not an HDF5 file"),
        (of_somebody_else, "is HDF5 but no musclewire recording"),
        (of_a_newer_version, "has format_version 2, this musclewire reads 1; update"),
        (without_a_column, "the column 'shunt_voltage_v' is listed but missing"),
    ],
)
def test_what_is_no_recording_of_ours_is_said_in_one_line(tmp_path, make, message):
    make(tmp_path / "run.h5")
    with pytest.raises(RecordingError, match=message) as caught:
        read_hdf5(tmp_path / "run.h5")
    assert "\n" not in str(caught.value)


def test_half_a_file_is_damaged_and_never_a_traceback(tmp_path):
    write_rows(tmp_path / "run.h5", 500)
    whole = (tmp_path / "run.h5").read_bytes()
    for share in (0.1, 0.5, 0.9):
        (tmp_path / "half.h5").write_bytes(whole[: int(len(whole) * share)])
        with pytest.raises(RecordingError) as caught:
            read_hdf5(tmp_path / "half.h5")
        assert "\n" not in str(caught.value)
