"""What a run left on disk: found by one name, finished once, and never at the cost of another recording."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from musclewire.errors import CallerError, RecordingError
from musclewire.files import read_hdf5, read_recording
from musclewire.signals import Recording, RecordingWriter, describe_recording, journal_of, recover_recording
from musclewire.signals._journal import encoded_rows, encoded_start

COLUMNS = ("time_s", "force_n")
TABLE = np.arange(20.0).reshape(10, 2)


@pytest.fixture
def cut_off(tmp_path: Path) -> Path:
    """The name of a recording of ten rows that was cut off."""
    path = tmp_path / "run.h5"
    journal_of(path).write_bytes(encoded_start(COLUMNS, {"wire": "x"}) + encoded_rows(TABLE.tobytes()))
    return path


def names_in(folder: Path) -> list[str]:
    return sorted(file.name for file in folder.iterdir())


def test_it_reads_by_its_name_and_by_its_journals(cut_off: Path) -> None:
    recording = read_recording(cut_off)
    assert recording == read_recording(journal_of(cut_off))
    assert np.array_equal(recording["force_n"], TABLE[:, 1])
    assert dict(recording.metadata) == {"wire": "x", "ended": "cut off"}


def test_recovered_under_another_name_the_journal_stays(cut_off: Path, tmp_path: Path) -> None:
    for name in ("other.h5", "other.csv"):
        recording = recover_recording(journal_of(cut_off), tmp_path / name)
        assert read_recording(tmp_path / name) == recording == read_recording(cut_off)
    with pytest.raises(CallerError, match=r"other\.h5 exists"):
        recover_recording(cut_off, tmp_path / "other.h5")
    recover_recording(cut_off, tmp_path / "other.h5", overwrite=True)
    assert names_in(tmp_path) == ["other.csv", "other.h5", "run.h5.journal"]


def test_recovered_it_takes_its_own_name_and_what_a_killed_process_left_goes(cut_off: Path, tmp_path: Path) -> None:
    (tmp_path / ".run.h5.0123abcd.part").write_bytes(b"half a file")
    recover_recording(cut_off)
    assert names_in(tmp_path) == ["run.h5"]
    with pytest.raises(RecordingError, match="is finished, there is no journal next to it"):
        recover_recording(cut_off)
    with pytest.raises(RecordingError, match=r"the run was finished as .*run\.h5"):
        read_recording(journal_of(cut_off))


def test_killed_between_its_last_two_steps_it_is_there_twice_and_once_afterwards(cut_off: Path, tmp_path: Path) -> None:
    journal = journal_of(cut_off).read_bytes()
    recover_recording(cut_off)
    journal_of(cut_off).write_bytes(journal)
    assert len(read_recording(cut_off)) == 10
    recover_recording(cut_off)
    assert names_in(tmp_path) == ["run.h5"]


def test_another_recording_of_the_same_name_is_kept_and_so_is_the_journal(cut_off: Path, tmp_path: Path) -> None:
    other = Recording({"time_s": [0.0, 1.0]})
    other.save(cut_off)
    with pytest.raises(CallerError, match=r"exists and is another recording than .*give another name with -o"):
        recover_recording(cut_off)
    assert read_recording(cut_off) == other
    assert names_in(tmp_path) == ["run.h5", "run.h5.journal"]


def test_a_run_that_goes_on_is_not_recovered(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "run.h5", COLUMNS) as writer:
        writer.append({"time_s": 0.0, "force_n": 1.0})
        with pytest.raises(CallerError, match="its run still goes on; wait until it ends"):
            recover_recording(tmp_path / "run.h5")


def test_without_a_file_and_a_journal_it_is_said(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"none\.h5: no such file, and no journal .*none\.h5\.journal"):
        recover_recording(tmp_path / "none.h5")
    with pytest.raises(RecordingError, match=r"none\.h5\.journal: no such file"):
        read_recording(tmp_path / "none.h5.journal")


def test_damage_after_the_last_row_is_stated_as_how_it_ended(cut_off: Path) -> None:
    data = bytearray(journal_of(cut_off).read_bytes() + encoded_rows(TABLE.tobytes()))
    data[-1] ^= 1
    journal_of(cut_off).write_bytes(data)
    recording = read_recording(cut_off)
    assert len(recording) == 10
    assert recording.metadata["ended"] == "cut off; 169 bytes after the last row are damaged"


def test_a_description_that_finds_the_disk_full_leaves_the_file_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Recording({"time_s": [0.0, 1.0]}, {"wire": "x"}).save(tmp_path / "run.h5")
    before = (tmp_path / "run.h5").read_bytes()

    def full(file: object, data: bytes) -> int:
        file.problem = OSError(28, "No space left on device")  # type: ignore[attr-defined]
        return len(data)

    with monkeypatch.context() as patched:
        patched.setattr("musclewire.signals._hdf5._QuietFile.write", full)
        with pytest.raises(CallerError, match="No space left"):
            describe_recording(tmp_path / "run.h5", {"shows_c": True})
    assert (tmp_path / "run.h5").read_bytes() == before
    describe_recording(tmp_path / "run.h5", {"shows_c": True})
    assert read_hdf5(tmp_path / "run.h5").metadata == {"wire": "x", "shows_c": True}
    assert names_in(tmp_path) == ["run.h5"]
