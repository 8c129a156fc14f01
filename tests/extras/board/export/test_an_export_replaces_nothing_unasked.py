"""A folder that holds another library is left alone, whole; writing the very same again is no replacing."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.extras.board.export.export_parts import drive_limits, limits_for, usual_model

from musclewire.controllers import FuzzyPidSettings
from musclewire.errors import CallerError
from musclewire.extras.board import CLibrary, write_library

LIMITS = limits_for(usual_model())


def write(folder: Path, *, overwrite: bool = False, **settings: tuple[float, float]) -> CLibrary:
    chosen = FuzzyPidSettings(**settings)
    return write_library(usual_model(), chosen, drive_limits(LIMITS), LIMITS, folder, "wire", overwrite=overwrite)


def contents(library: CLibrary) -> dict[str, bytes]:
    return {name: (library.folder / name).read_bytes() for name in library.files}


def test_the_same_library_may_be_written_again(tmp_path: Path) -> None:
    first = contents(write(tmp_path))
    assert contents(write(tmp_path)) == first


def test_another_library_is_refused_and_nothing_is_changed(tmp_path: Path) -> None:
    library = write(tmp_path)
    before = contents(library)
    with pytest.raises(CallerError, match=r"holds another src/mw_constants\.h.*overwrite=True"):
        write(tmp_path, kp_range=(0.01, 0.09))
    assert contents(library) == before


def test_a_file_that_was_edited_by_hand_is_kept(tmp_path: Path) -> None:
    library = write(tmp_path)
    name = library.files[0]
    (tmp_path / name).write_text("mine", "utf-8")
    with pytest.raises(CallerError, match="holds another"):
        write(tmp_path)
    assert (tmp_path / name).read_text("utf-8") == "mine"


def test_it_is_replaced_where_that_is_asked_for(tmp_path: Path) -> None:
    before = contents(write(tmp_path))
    assert contents(write(tmp_path, overwrite=True, kp_range=(0.01, 0.09))) != before
