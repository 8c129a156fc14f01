import datetime
import sys

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest

from musclewire.errors import MissingExtraError, RecordingError
from musclewire.files import read_recording
from musclewire.identify import import_recording
from musclewire.signals import Recording


def write(path, columns, metadata=None):
    table = pa.table(columns)
    pyarrow.parquet.write_table(table.replace_schema_metadata(metadata), path)
    return path


def refusal(path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_foreign_parquet_is_understood_by_its_column_names(tmp_path):
    path = write(
        tmp_path / "a.parquet",
        {"Time [ms]": [0, 50], "pos": [1.0, 2.0], "valid": [True, False], "note": ["a", None]},
    )
    recording = read_recording(path, {"displacement_m": "pos:mm"})
    assert recording["time_s"].tolist() == pytest.approx([0.0, 0.05])
    assert recording["displacement_m"].tolist() == pytest.approx([0.001, 0.002])
    assert recording["valid"].tolist() == [1.0, 0.0]
    assert [item.header for item in import_recording(path, columns={"displacement_m": "pos:mm"}).ignored] == ["note"]


def test_our_parquet_says_its_units_to_whoever_reads_it(tmp_path):
    Recording({"time_s": [0.0, 1.0]}).save(tmp_path / "a.parquet")
    assert pyarrow.parquet.read_schema(tmp_path / "a.parquet").field("time_s").metadata == {b"unit": b"s"}


def test_blank_cells_and_words_and_dates_are_found(tmp_path):
    day = datetime.datetime(2026, 1, 1)
    path = tmp_path / "a.parquet"
    blank = refusal(write(path, {"time_s": [0.0, 1.0, 2.0], "force_n": [1.0, None, None]}))
    assert "row 2, column 'force_n': the cell is blank" in blank
    assert "column 'force_n' holds text, not numbers" in refusal(
        write(path, {"time_s": [0.0, 1.0], "force_n": ["1", "2"]})
    )
    assert "the clock does not rise" in refusal(write(path, {"time_s": [day, day]}))


@pytest.mark.parametrize("document", [b"{", b"{}", b'{"metadata": 3}', b'{"metadata": {"Bad Key": 1}}'])
def test_damaged_metadata_are_the_files_fault(tmp_path, document):
    path = write(tmp_path / "a.parquet", {"time_s": [0.0, 1.0]}, {b"musclewire-recording": document})
    assert "metadata" in refusal(path)


def test_where_an_estimator_had_no_answer_nan_is_one(tmp_path):
    run = Recording({"time_s": [0.0, 1.0], "estimated_strain": [np.nan, 0.01], "valid": [0.0, 1.0]})
    run.save(tmp_path / "run.parquet")
    assert read_recording(tmp_path / "run.parquet") == run


def test_without_pyarrow_the_extra_is_named(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    loop = Recording({"time_s": [0.0, 1.0]})
    with pytest.raises(MissingExtraError, match=r'pip install "\.\[parquet\]" in the checkout'):
        loop.save(tmp_path / "loop.parquet")
    assert list(tmp_path.iterdir()) == []
