from __future__ import annotations

from pathlib import Path

import pytest
from tests.tools import made_once, require_tool


def test_a_program_that_is_there_is_found() -> None:
    assert require_tool("sh", "dash").endswith("/sh")


def test_a_missing_program_is_reported_as_not_run_with_the_apt_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MUSCLEWIRE_REQUIRE_TOOLS", raising=False)
    with pytest.raises(pytest.skip.Exception, match=r"not run: no-such-gcc .* apt-get install .* gcc-no-such"):
        require_tool("no-such-gcc", "gcc-no-such")


def test_a_missing_program_fails_where_all_must_be_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUSCLEWIRE_REQUIRE_TOOLS", "1")
    with pytest.raises(pytest.fail.Exception, match="no-such-gcc is missing"):
        require_tool("no-such-gcc", "gcc-no-such")


def test_what_takes_long_is_made_once_and_again_only_after_a_failure(tmp_path_factory: pytest.TempPathFactory) -> None:
    made: list[Path] = []

    def make(folder: Path) -> None:
        made.append(folder)
        (folder / "part").touch()
        if len(made) == 1:
            raise OSError("the first time it fails")

    with pytest.raises(OSError, match="the first time"):
        made_once(tmp_path_factory, "of a test", make)
    folders = {made_once(tmp_path_factory, "of a test", make) for _ in range(3)}
    assert folders == set(made)
    assert len(made) == 2
