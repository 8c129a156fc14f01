"""``fit --wire``: its options go together, or are refused before anything is read."""

from __future__ import annotations

import pytest
from tests.command_line import CommandLine


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (("--mark", "cold=0 mm"), "--wire"),
        (("--set", "legs=2"), "--wire"),
        (("--wire", "flexinol-0.10-lt", "--relative-resistance"), "--relative-resistance"),
    ],
)
def test_options_that_do_not_go_together_are_refused(
    options: tuple[str, ...], named: str, musclewire: CommandLine
) -> None:
    answer = musclewire("fit", "no-such-file.h5", *options)
    assert answer.code == 2
    assert named in answer.err
    assert "no-such-file" not in answer.err
