"""The minor loop of ``characterize`` as its user meets it: in the file, in a fit's number, and left out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import musclewire as mw

SHORT = ("--period", "30 s", "--cycles", "1")


def test_it_is_in_the_file_and_in_the_law_of_a_fit_and_nowhere_else(
    musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    answers, laws = [], []
    for name, options in (("with.h5", ()), ("without.h5", ("--no-minor-loop",))):
        path = tmp_path / name
        answer = musclewire("characterize", "simulated", "-o", path, *SHORT, *options, "--json")
        assert answer.code == 0, answer.err
        fitted = musclewire("fit", path, "-o", path.with_suffix(".json"), "--json").json
        laws.append(fitted["wire_model"].pop("minor_loops"))
        answers.append((answer.json | {"recording": ""}, fitted | {"model": ""}))
    assert answers[0] == answers[1]
    assert [law["origin"] for law in laws] == [
        "minor loops of this recording",
        "any law is as likely: no minor loop shows it",
    ]
    assert laws[0]["std"] < laws[1]["std"]
    found, left_out = (mw.read_recording(tmp_path / name) for name in ("with.h5", "without.h5"))
    assert found.minor_loop is not None
    assert left_out.minor_loop is None
    assert len(found) == len(left_out) == answers[0][0]["samples"]
