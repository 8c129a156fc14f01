from __future__ import annotations

import pytest
from tests.tools import require_tool


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
