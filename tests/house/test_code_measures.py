"""Functions stay short."""

from __future__ import annotations

from pathlib import Path

import pytest
from checks.code_measures import SOURCES, Measures, functions_of, measure, problems_of


@pytest.fixture(scope="module")
def measures() -> Measures:
    return measure(SOURCES)


def test_the_sources_are_within_the_limits(measures: Measures) -> None:
    assert problems_of(measures) == []


def test_length_counts_code_and_not_docstring_comments_or_blank_lines() -> None:
    text = '''
def add(
    a: int,
    *,
    b: int = 1,
) -> int:
    """Add.

    Twice the words change nothing.
    """
    # neither does this

    text = """two
    lines"""
    return a + b + len(text)
'''
    (found,) = functions_of(Path("room/file.py"), text)
    assert (found.lines, found.name) == (8, "add")


def test_declarations_without_code_do_not_count() -> None:
    text = """
class Rig:
    def off(self) -> bool:
        '''Switch off.'''

    def set(self, drive_v):
        self.drive_v = drive_v
"""
    (found,) = functions_of(Path("room.py"), text)
    assert (found.name, found.lines) == ("set", 2)


def test_what_is_over_is_named_with_its_place_and_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "room").mkdir()
    body = "\n".join(f"    x = {index}" for index in range(50))
    (tmp_path / "room" / "long.py").write_text(f"def f():\n{body}\n")
    problems = problems_of(measure(tmp_path))
    assert [problem.split("; ")[0] for problem in problems[:1]] == [
        "room/long.py:1 f: 51 code lines: over 50 lines",
    ]
    assert problems[1].startswith("the 95th percentile is 51 code lines, over 22")
