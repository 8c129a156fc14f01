"""What is saved is read back: every number to the last bit, every fact of the metadata with its type."""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from tests.subjects import subjects_of

from musclewire.errors import CallerError
from musclewire.files import read_recording
from musclewire.signals import COLUMNS, Recording, RecordingWriter, checked_metadata, entry_from_text, value_to_text

TEXT_KEYS = ["wire", "rig", "software_version", "start_time", "ended", "note"]

words = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=30)
tricky_words = st.sampled_from(["1.0", "1.0 ohm", "5 %", "true", "none", '"quoted"', " space ", "a # b", "x\ny", "nan"])
numbers = st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False) | st.booleans()
free_keys = st.from_regex(r"[a-z][a-z0-9_.]{0,12}", fullmatch=True).filter(
    lambda key: (
        key not in {"format", "format_version", "columns", "rows", "operator", "notes", "comment", *TEXT_KEYS}
        and key not in {"title", "sample", "date"}
        and not key.endswith("_")
    )
)
metadata = st.dictionaries(free_keys, words | tricky_words | numbers | st.none(), max_size=5)
text_metadata = st.dictionaries(st.sampled_from(TEXT_KEYS), words | tricky_words | st.none(), max_size=4)


@st.composite
def recordings(draw):
    time_s = draw(st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=12, unique=True).map(sorted))
    names = draw(st.lists(st.sampled_from(sorted(set(COLUMNS) - {"time_s"})), max_size=5, unique=True))
    limit = {name: 1.0 if "strain" in name else 1e300 for name in names}
    columns = {
        name: draw(st.lists(st.floats(-limit[name], limit[name]), min_size=len(time_s), max_size=len(time_s)))
        for name in names
    }
    return Recording({"time_s": time_s, **columns}, {**draw(metadata), **draw(text_metadata)})


@pytest.mark.parametrize("suffix", subjects_of("unit/signals", "*_formats.py", "SAVED"))
@settings(max_examples=60, deadline=None)
@given(recording=recordings())
@example(recording=Recording({"time_s": np.array([0.0, 1.0])}, {"wire": " |"}))  # a quote after a separator
def test_a_saved_recording_reads_back_the_same(suffix, recording):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"run{suffix}"
        recording.save(path)
        read_back = read_recording(path)
        assert [file.name for file in Path(folder).iterdir()] == [path.name]
    # A file says "running" only while a writer holds it; saved so, it was cut off.
    if recording.metadata.get("ended") == "running" and suffix in {".h5", ".hdf5"}:
        recording = recording.with_metadata(ended="cut off")
    assert read_back.metadata == recording.metadata
    assert {key: type(value) for key, value in read_back.metadata.items()} == {
        key: type(value) for key, value in recording.metadata.items()
    }
    assert read_back == recording


@settings(max_examples=30, deadline=None)
@given(recording=recordings(), block_rows=st.integers(1, 15))
def test_a_recording_written_row_by_row_reads_back_the_same(recording, block_rows):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.h5"
        with RecordingWriter(path, recording.names, recording.metadata, block_rows=block_rows) as writer:
            for index in range(len(recording)):
                writer.append({name: recording[name][index] for name in recording.names})
        assert read_recording(path) == recording.with_metadata(ended="done")


@given(free_keys, words | tricky_words | numbers | st.none())
def test_metadata_survive_as_text(key, value):
    assert entry_from_text(key, value_to_text(key, value)) == (key, value)
    assert "\n" not in value_to_text(key, value)


def test_metadata_of_numpy_become_plain_values():
    plain = checked_metadata({"a": np.int32(3), "b": np.float32(0.5), "c": np.bool_(True), "d": np.str_("x")})
    assert [(value, type(value)) for value in plain.values()] == [
        (3, int),
        (0.5, float),
        (True, bool),
        ("x", str),
    ]


def test_an_old_file_stays_when_the_new_one_cannot_be_written(tmp_path, monkeypatch):
    path = tmp_path / "run.csv"
    Recording({"time_s": [0.0, 1.0]}).save(path)

    def full_disk(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("musclewire.signals._csv.fill_csv", full_disk)
    with pytest.raises(CallerError, match="cannot be written: No space left on device"):
        Recording({"time_s": [0.0, 2.0]}).save(path)
    assert read_recording(path)["time_s"][1] == 1.0
    assert [file.name for file in tmp_path.iterdir()] == ["run.csv"]


def test_a_suffix_nobody_writes_is_refused(tmp_path):
    with pytest.raises(CallerError, match=r"cannot save as '\.doc'; end the name in \.h5"):
        Recording({"time_s": [0.0, 1.0]}).save(tmp_path / "run.doc")


def test_importing_the_room_and_that_of_controllers_loads_no_heavy_library():
    heavy = {"h5py", "pint", "pandas", "pyarrow", "numba", "matplotlib"}
    code = f"import sys, musclewire.signals, musclewire.controllers; print({heavy} & set(sys.modules))"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "set()"


@pytest.mark.parametrize("suffix", subjects_of("unit/signals", "*_formats.py", "SAVED_WITHOUT_A_CLOCK"))
def test_isobars_without_a_clock_read_back_the_same(suffix, tmp_path):
    isobars = Recording(
        {"wire_temperature_k": [300.0, 350.1, 301.0], "reference_strain": [0.0, 0.03, 1e-4], "stress_pa": [1e8] * 3}
    )
    isobars.save(tmp_path / f"isobars{suffix}")
    assert read_recording(tmp_path / f"isobars{suffix}") == isobars
