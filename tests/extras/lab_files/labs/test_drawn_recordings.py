"""Recordings drawn from all layouts, wires and defects at once: none ends in a traceback, and each named line works.

What a laboratory leaves whole is not read wrongly, either. ``pytest tests/labs -m full`` draws 2,000.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from numpy.random import Generator
from tests.extras.lab_files.labs.test_files_as_labs_make_them import LAYOUTS, Command, outcome, written
from tests.labs.loops import DEFECTS, LOOPS, loop

Damage = Callable[[list[str], Generator], list[str]]
NUMBER = re.compile(r"\d+\.\d+(?:[eE][+-]?\d+)?")


def somewhere(lines: list[str], random: Generator) -> int:
    return int(random.integers(0, max(1, len(lines))))


def marks(mark: str) -> Damage:
    """Put a mark in the place of some numbers, as instruments write it that are out of range."""

    def marked(lines: list[str], random: Generator) -> list[str]:
        hit = set(random.integers(0, max(1, len(lines)), 5).tolist())
        return [NUMBER.sub(mark, line, count=1) if number in hit else line for number, line in enumerate(lines)]

    return marked


def cut(lines: list[str], random: Generator) -> list[str]:
    kept = lines[: 1 + somewhere(lines, random)]
    return [*kept[:-1], kept[-1][: int(random.integers(0, len(kept[-1]) + 1))]]


def without_a_line(lines: list[str], random: Generator) -> list[str]:
    place = somewhere(lines, random) if random.random() < 0.5 else 0
    return lines[:place] + lines[place + 1 :]


def with_rows_again(lines: list[str], random: Generator) -> list[str]:
    return [line for line in lines for _ in range(1 + (random.random() < 0.05))]


def below_itself(lines: list[str], random: Generator) -> list[str]:
    return [*lines, *lines[int(random.integers(0, 3)) :]]


def with_blank_lines(lines: list[str], random: Generator) -> list[str]:
    return [each for line in lines for each in ([line, ""] if random.random() < 0.1 else [line])]


def with_other_separators(lines: list[str], random: Generator) -> list[str]:
    sign = str(random.choice([";", "\t", "|", " ", ",,"]))
    return [line.replace(",", sign) for line in lines]


def with_decimal_commas(lines: list[str], _: Generator) -> list[str]:
    return [line.replace(",", ";").replace(".", ",") for line in lines]


def with_titles(lines: list[str], random: Generator) -> list[str]:
    titles = ["SMA wire 3", "Operator: me", "Shunt = 0.47 ohm", "# a comment", "Start,Increment", "a,b,c,d", "t0 = x"]
    return [str(title) for title in random.choice(titles, int(random.integers(1, 4)))] + lines


def with_other_headers(lines: list[str], random: Generator) -> list[str]:
    words = [
        "",
        "1",
        "#2",
        "Time",
        "Time [mm]",
        "voltage_V",
        "R",
        "R",
        "Unit",
        "source",
        "value",
        "heating",
        "[",
        "a:b",
    ]
    count = lines[0].count(",") + 1 if lines else 1
    return [",".join(map(str, random.choice(words, count))), *lines[1:]]


def shuffled(lines: list[str], random: Generator) -> list[str]:
    return [lines[number] for number in random.permutation(len(lines))]


def with_changed_letters(lines: list[str], random: Generator) -> list[str]:
    signs = "".join(chr(code) for code in range(32, 127)) + "äµΩ°\x00\x1b\ufeff"
    changed = list(lines)
    for _ in range(6):
        place = somewhere(changed, random)
        at = int(random.integers(0, len(changed[place]) + 1))
        changed[place] = changed[place][:at] + signs[int(random.integers(len(signs)))] + changed[place][at + 1 :]
    return changed


DAMAGES: tuple[Damage, ...] = (
    marks("9.9E37"), marks("OL"), marks(""), marks("nan"), marks("inf"), marks("-1E+999"), marks("12:30"), marks("1 V"),
    cut, without_a_line, with_rows_again, below_itself, with_blank_lines, with_other_separators, with_decimal_commas,
    with_titles, with_other_headers, shuffled, with_changed_letters,
)  # fmt: skip
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "cp1252", "latin-1")


def damaged(content: str | bytes, random: Generator) -> bytes:
    """Return a file after some of all that happens to files."""
    if isinstance(content, bytes):
        data = bytearray(content)
        for place in random.integers(0, len(data), int(random.integers(0, 20))).tolist():
            data[place] = int(random.integers(256))
        return bytes(data[: int(random.integers(len(data)))] if random.random() < 0.3 else data)
    lines = content.splitlines()
    for damage in random.choice(np.array(DAMAGES, dtype=object), int(random.integers(1, 4)), replace=False):
        lines = damage(lines, random) or [""]
    end = str(random.choice(["\n", "\r\n", "\r"]))
    return end.join(lines).encode(str(random.choice(ENCODINGS)), errors="replace")


def draw(number: int, folder: Path, command: Command) -> None:
    random = np.random.default_rng([46, number])
    found: Mapping[str, np.ndarray] = loop(str(random.choice(LOOPS)))
    for defect in DEFECTS:
        if random.random() < 0.3:
            found = defect(found, random)
    name = str(random.choice(list(LAYOUTS)))
    table = LAYOUTS[name](found)
    if random.random() < 0.2:
        ended, said = outcome(command, written(table.files, folder), table.given, table.expected)
        assert not ended.startswith(("wrong", "the line")), f"{number} {name}: {said}"
        return
    names = written({file: damaged(content, random) for file, content in table.files.items()}, folder)
    output = ("-o", "drawn.h5", "--overwrite") if random.random() < 0.5 else ()
    answer = command("import", *names, *table.given, *output)
    where = f"{number} {name}: {answer}"
    assert answer.code in {0, 2}, where
    assert sum(text.startswith("musclewire: ") for text in answer.err.splitlines()) <= 1, where
    for text in (answer.out + answer.err).splitlines():
        if "  try: " in text and answer.code == 2:
            assert command(*shlex.split(text.split("  try: ", 1)[1])[1:]).code == 0, where


QUARTER = range(25)
HUNDREDS = [pytest.param(range(100 * n, 100 * n + 100), marks=pytest.mark.full) for n in range(20)]


@pytest.mark.parametrize("numbers", [QUARTER, *HUNDREDS], ids=lambda numbers: f"{numbers.start}-{numbers.stop}")
def test_a_drawn_recording_is_read_or_refused_in_one_line_and_each_line_that_is_named_works(
    numbers: range, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, musclewire: Command
) -> None:
    monkeypatch.chdir(tmp_path)
    for number in numbers:
        draw(number, tmp_path, musclewire)
