"""What is on the disk when, as a power cut would find it: by the calls of fsync and what was there at each of them."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from musclewire.errors import RecordingNotWrittenError
from musclewire.signals import RecordingWriter, _open_journal

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="asks /proc which file a descriptor is")
ROW = {"time_s": 0.0, "force_n": 1.0}


@pytest.fixture
def synced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, tuple[str, ...]]]:
    """Which file or folder was brought to the disk, and what was in the folder then."""
    calls: list[tuple[str, tuple[str, ...]]] = []
    fsync = os.fsync

    def noted(descriptor: int) -> None:
        name = Path(f"/proc/self/fd/{descriptor}").readlink().name
        calls.append((name, tuple(sorted(file.name for file in tmp_path.iterdir()))))
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", noted)
    return calls


def test_the_beginning_of_a_journal_and_its_name_are_on_the_disk_before_any_row(
    tmp_path: Path, synced: list[tuple[str, tuple[str, ...]]]
) -> None:
    writer = RecordingWriter(tmp_path / "run.h5", ["time_s", "force_n"])
    assert [name for name, _ in synced] == ["run.h5.journal", tmp_path.name]
    writer.append(ROW)
    writer.close()


def test_a_journal_goes_only_when_the_file_and_its_name_are_on_the_disk(
    tmp_path: Path, synced: list[tuple[str, tuple[str, ...]]]
) -> None:
    writer = RecordingWriter(tmp_path / "run.h5", ["time_s", "force_n"])
    writer.append(ROW)
    synced.clear()
    writer.close()
    *journal, part, folder = synced
    assert {name for name, _ in journal} == {"run.h5.journal"}
    assert part[0].endswith(".part")
    assert "run.h5" not in part[1]
    assert folder == (tmp_path.name, ("run.h5", "run.h5.journal"))
    assert [file.name for file in tmp_path.iterdir()] == ["run.h5"]


def test_what_grows_is_synced_again_and_again_and_what_does_not_is_not(
    tmp_path: Path, synced: list[tuple[str, tuple[str, ...]]], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert _open_journal.SYNCED_EVERY_S <= 1.0
    monkeypatch.setattr(_open_journal, "SYNCED_EVERY_S", 1e-3)
    writer = RecordingWriter(tmp_path / "run.h5", ["time_s", "force_n"])
    synced.clear()
    for times in (1, 2, 3):
        writer.append(ROW)
        while len(synced) < times:
            assert writer._journal.failure is None
    assert [name for name, _ in synced] == ["run.h5.journal"] * 3
    writer.close()


def test_a_disk_that_fails_at_fsync_is_an_error_of_the_next_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def removed(_: int) -> None:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(_open_journal, "SYNCED_EVERY_S", 1e-3)
    writer = RecordingWriter(tmp_path / "run.h5", ["time_s", "force_n"])
    monkeypatch.setattr(os, "fsync", removed)
    writer.append(ROW)
    writer._journal._threads[0].join()
    with pytest.raises(RecordingNotWrittenError, match=r"Input/output error; 1 rows are in .*run\.h5\.journal"):
        writer.append(ROW)
