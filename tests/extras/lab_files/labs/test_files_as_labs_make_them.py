"""Files as laboratories make them are read as they are, or by the one line that the refusal names; none wrongly.

A line is what follows "try: " in what the import prints. It is run as it stands, in the folder of the files.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from tests.command_line import Answer
from tests.labs.layouts import TIME
from tests.labs.loops import LOOPS, Array, loop
from tests.subjects import subjects_of

import musclewire as mw

Command = Callable[..., Answer]
LAYOUTS = {layout.__name__: layout for layout in subjects_of("labs", "layouts.py", "LAYOUTS")}
# Numbers in the files are rounded to six digits or fewer; joined recordings are read between their samples.
TOLERANCE = 6e-3


def written(files: Mapping[str, str | bytes], folder: Path) -> list[str]:
    """Write files and return their names."""
    for name, content in files.items():
        (folder / name).write_bytes(content.encode("utf-8") if isinstance(content, str) else content)
    return list(files)


def difference(recording: mw.Recording, expected: Mapping[str, Array]) -> str:
    """Return what is wrong with a recording, or ""."""
    for name, values in expected.items():
        if name not in recording:
            return f"no {name} in {recording.names}"
        found = recording[name]
        if TIME in expected and 0 < abs(found.size - values.size) < 0.03 * values.size:
            # Two files have no rows in common where only one of them is.
            values = np.interp(recording[TIME], expected[TIME], values)
        if found.size != values.size:
            return f"{name} has {found.size} rows for {values.size}"
        error = float(np.abs(found - values).max())
        if error > TOLERANCE * float(np.ptp(values)) + 1e-5 * float(np.abs(values).max()):
            return f"{name} is off by {error:g} of {np.ptp(values):g}"
    return ""


def outcome(
    command: Command, names: list[str], given: tuple[str, ...], expected: Mapping[str, Array]
) -> tuple[str, str]:
    """Return how an import ended and what it said: "read", by the "line" it named, "refused", or "wrong"."""
    answer = command("import", *names, *given, "-o", "out.h5", "--overwrite")
    said = answer.out + answer.err
    line = next((text.split("try: ", 1)[1] for text in said.splitlines() if "try: " in text), "")
    if answer.code == 0:
        wrong = difference(mw.read_recording("out.h5"), expected) if expected else "it was read"
        if not (wrong.startswith("no ") and line):
            return ("wrong", wrong + "\n" + said) if wrong else ("read", said)
    assert answer.code in {0, 2}, said
    if not line:
        return "refused", said
    program, *words = shlex.split(line)
    assert program == "musclewire"
    again = command(*words, "-o", "out.h5", "--overwrite")
    said += again.out + again.err
    if again.code:
        return "the line does not work", said
    wrong = difference(mw.read_recording("out.h5"), expected)
    return ("wrong by the line", wrong + "\n" + said) if wrong else ("line", said)


# Each layout with one wire, each wire with every third layout; all with all in the group full.
PAIRS = [
    pytest.param(name, wire, marks=() if number % len(LOOPS) == index else pytest.mark.full)
    for number, name in enumerate(LAYOUTS)
    for index, wire in enumerate(LOOPS)
]


@pytest.mark.parametrize(("name", "wire"), PAIRS)
def test_a_file_as_a_lab_makes_it_is_read_or_the_line_that_reads_it_is_named(
    name: str, wire: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, musclewire: Command
) -> None:
    monkeypatch.chdir(tmp_path)
    table = LAYOUTS[name](loop(wire))
    ended, said = outcome(musclewire, written(table.files, tmp_path), table.given, table.expected)
    assert ended == table.ends, said
